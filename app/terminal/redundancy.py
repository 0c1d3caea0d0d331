"""Redundancy as tables in the terminal."""

from __future__ import annotations

from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.terminal.console import results
from riglens.app.terminal.figures import percent
from riglens.core.review.outline import SECTORS
from riglens.core.review.redundancy import COVERED, NO_EVIDENCE, Coverage, What
from riglens.core.review.redundancy_json import lost_share, share
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_text import visible

SHOWN = 5
"""Pairs that the terminal names, the worst first; the JSON has all."""
HEADINGS: dict[What, str] = {"sensor": "each sensor", "pair": f"worst {SHOWN} pairs", "group": "groups"}


def print_redundancy(rig: Rig, body: str, voxels: Coverage, targets: Coverage | None) -> None:
    """Print what is covered how often and what failures cost, on standard output."""
    console = results()
    console.print(Text(f"{visible(rig.name)}: redundancy, body {body}"), soft_wrap=True)
    for title, found in (("entropy, in % of H(Ω)", voxels), ("road users, in % of all", targets)):
        if found is not None:
            console.print(_covered_table(found, title))
            console.print(_failures_table(found, title))
    console.print(
        "Covered: more is better; two kinds: by cameras and LiDARs. Lost when it fails: less is better; worst sector: "
        "that of 45° in which most of what is there is lost.",
        soft_wrap=True,
    )
    if targets is not None:
        console.print(
            "Road users: 1 = detected by the rig; 2, 3 = by so many sensors, each on its own.", soft_wrap=True
        )
    console.print(f"This is {NO_EVIDENCE}.", soft_wrap=True)


def _table(first: str, *columns: str) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column(first, no_wrap=True, overflow="ellipsis", max_width=36)
    for title in columns:
        table.add_column(title, justify="right", no_wrap=True)
    return table


def _covered_table(found: Coverage, title: str) -> Table:
    table = _table(f"covered: {title}", *(name if name == "two kinds" else f"by {name}" for name in COVERED))
    for cls, name in enumerate(CLASSES):
        total = int(found.total[:, cls].sum())
        cells = (percent(share(int(found.covered[:, k, cls].sum()), total)) for k in range(len(COVERED)))
        table.add_row(name, *cells)
    return table


def _failures_table(found: Coverage, title: str) -> Table:
    table = _table(f"lost: {title}", *(cell for name in CLASSES for cell in (name, "worst\nsector")))
    for what, heading in HEADINGS.items():
        mine = [failure for failure in found.failures if failure.what == what]
        if what == "pair":
            mine = sorted(mine, key=lambda failure: -int(failure.lost.sum()))[:SHOWN]
        if not mine:
            continue
        table.add_row(Text(heading, "bold"))
        for failure in mine:
            cells = []
            for cls in range(len(CLASSES)):
                by_sector = [lost_share(found, failure, cls, s) for s in range(len(SECTORS))]
                worst = max(range(len(SECTORS)), key=lambda s: by_sector[s])
                where = f"{SECTORS[worst]} {100.0 * by_sector[worst]:.0f} %" if by_sector[worst] else "-"
                cells += [percent(lost_share(found, failure, cls)), where]
            table.add_row(Text(f"  {visible(failure.name)}"), *cells)
        table.add_section()
    return table
