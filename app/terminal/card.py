"""The card of a rig as tables in the terminal."""

from __future__ import annotations

from collections.abc import Iterator

from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.terminal.console import results
from riglens.core.shown_text import visible
from riglens.core.targets.card import Card, CardRow
from riglens.core.targets.card_text import HEADINGS, bearing_text, reach_text, stop_text


def print_card(card: Card) -> None:
    """Print the distances of a card, what they mean, and the stopping distances, on standard output."""
    console = results()
    console.print(Text(f"{visible(card.rig.name)}: first distance in metres with too little"), soft_wrap=True)
    console.print(_table(card))
    for line in explanation(card):
        console.print(line, soft_wrap=True)
    console.print(_stops(card))


def explanation(card: Card) -> Iterator[str]:
    """What the figures are."""
    plan = card.plan
    yield (
        f"LiDARs: fewer than {plan.min_points} points, as least-median-most over where the road user falls between the "
        f"beams (gap {card.gap_deg:.2g} deg). Cameras: less than {plan.min_height_px:g} pixels tall. More is better."
    )
    yield (
        f"Alone on flat ground, body {plan.settings.as_dict()['body']}; distance from the middle of the car to that of "
        f"the road user, up to {plan.to_m:g} m."
    )
    yield (
        f"Stops from: speed from which the car stops before it, {plan.reaction_s:g} s of reaction and "
        f"{plan.deceleration_mps2:g} m/s2 (our choice), at the least distance."
    )


def _table(card: Card) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("road user")
    for bearing in card.plan.bearings_deg:
        table.add_column(bearing_text(bearing), justify="right")
    table.add_column("stops from", justify="right")
    rows = list(dict.fromkeys((row.cls, row.heading_deg) for row in card.rows))
    for cls, heading in rows:
        mine = [row for row in card.rows if (row.cls, row.heading_deg) == (cls, heading)]
        for kind in mine[0].reaches:
            table.add_row(f"{cls} {HEADINGS[heading]}, {kind}", *_cells(card, mine, kind))
    return table


def _cells(card: Card, rows: list[CardRow], kind: str) -> Iterator[str]:
    ahead = ""
    for row in rows:
        reach = row.reaches[kind]
        yield reach_text(reach, card.plan.to_m)
        ahead = ahead or stop_text(card.stops_from_kmh(row, reach))
    yield ahead


def _stops(card: Card) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("speed (km/h)")
    for speed in card.plan.speeds_kmh:
        table.add_column(f"{speed:g}", justify="right")
    table.add_row(
        "stops within (m)", *(f"{card.plan.stopping_m(speed):.0f}" for speed in card.plan.speeds_kmh)
    )
    return table
