"""The card of a rig in its report: first distances at which too little gets onto a road user in the open."""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterator
from functools import partial
from html import escape
from typing import TYPE_CHECKING, Any

from riglens.app.studies.card_chart import card_figure
from riglens.app.studies.pictures import picture
from riglens.core.targets.card_text import HEADINGS, bearing_text

if TYPE_CHECKING:
    from riglens.app.studies.report_figures import Report

NEVER = "never"


def card_section(report: Report, number: int, table_of: Callable[[str, list[str]], Any]) -> Iterator[str]:
    """Heading, chart, table and stopping distances of one rig; `table_of` begins a table by caption and head."""
    found = report.figures["rigs"][number]["card"]
    rows = found["rigs"][0]["rows"]
    bearings = list(dict.fromkeys(row["bearing_deg"] for row in rows))
    yield "<h3>First distances</h3>"
    yield (
        '<p class="quiet">One road user alone in the open: the first distance at which fewer than '
        f"{found['min_points']} LiDAR points, or less than {found['min_height_px']:g} pixels of height, get "
        "onto it; least, median and most over its places between the beams. More is better. Own body "
        f"{found['body']}; traffic and weather are left out.</p>"
    )
    encoded = base64.b64encode(picture(card_figure(report.cards[number]))).decode("ascii")
    yield f'<figure><img alt="Chart of first distances by direction" src="data:image/png;base64,{encoded}"></figure>'
    table = table_of("First distance with too little, m", ["", *map(bearing_text, bearings)])
    write = partial(first_text, to_m=found["to_m"])
    for cls, heading in dict.fromkeys((row["class"], row["heading_deg"]) for row in rows):
        for kind, words in (("lidar", "LiDARs"), ("camera", "cameras")):
            places = [
                f"rigs/{number}/card/rigs/0/rows/{place}/{kind}/first_below_m"
                for place, row in enumerate(rows)
                if (row["class"], row["heading_deg"]) == (cls, heading)
            ]
            table.row(f"{cls} {HEADINGS[heading]}, {words}", *((place, write) for place in places))
    yield table.html()
    stopping = found["stopping"]
    ways = ", ".join(
        f"{at['distance_m']:.0f} m from {at['speed_kmh']:g} km/h" for at in stopping["distances"]
    )
    yield (
        f'<p class="quiet">To compare, the way to a stop: {escape(ways)} (reaction {stopping["reaction_s"]:g} s, '
        f"{stopping['deceleration_mps2']:g} m/s²: our choice).</p>"
    )


def first_text(first_m: Any, to_m: float) -> str:
    """Least, median and most, once where they are the same; > the farthest distance tried, never where never enough."""
    if first_m["max"] == 0.0:
        return NEVER
    texts = [
        f">{to_m:g}" if first_m[key] is None else f"{first_m[key]:.0f}" for key in ("min", "median", "max")
    ]
    return texts[0] if len(set(texts)) == 1 else "-".join(texts)
