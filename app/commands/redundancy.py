"""Overlapping coverage and the losses by failures: part of `riglens review`."""

from __future__ import annotations

from rich.table import Table
from rich.text import Text

from riglens.app.terminal.console import results
from riglens.app.terminal.tables import table
from riglens.core.review.redundancy import (
    COVERED,
    NO_EVIDENCE,
    Coverage,
    What,
    lost_share,
    share,
)
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS
from riglens.core.shown_text import visible
from riglens.core.shown_values import percent
from riglens.jobs.reviewing import Redundancy

SHOWN = 5
"""Pairs and half-blocked sensors that the terminal names, the worst first; the JSON has all."""
HEADINGS: dict[What, str] = {
    "sensor": "each sensor",
    "pair": f"worst {SHOWN} pairs",
    "group": "groups",
    "half": f"worst {SHOWN} half-blocked",
}


def print_redundancy(found: Redundancy) -> None:
    """Print coverage by number of sensors and the losses by failures on standard output."""
    console = results()
    console.print(Text(f"{visible(found.rig.name)}: redundancy, body {found.body}"), soft_wrap=True)
    for title, part in (("entropy, in % of H(Ω)", found.voxels), ("objects, in % of all", found.targets)):
        if part is not None:
            console.print(_covered_table(part, title))
            console.print(_failures_table(part, title))
    console.print(
        "Covered: more is better; two kinds: by sensors of two kinds. Lost when it fails: less is better; worst "
        "sector: the 45° in which the largest share is lost.",
        soft_wrap=True,
    )
    if found.targets is not None:
        console.print(
            "Objects: 1 = detected by the rig; 2, 3 = by that many sensors, each on its own.",
            soft_wrap=True,
        )
    console.print(f"This is {NO_EVIDENCE}.", soft_wrap=True)


def _covered_table(found: Coverage, title: str) -> Table:
    titles = (name if name == "two kinds" else f"by {name}" for name in COVERED)
    made = table(f"covered: {title}", *titles, dense=True, widest=36)
    for cls, name in enumerate(CLASSES):
        total = int(found.total[:, cls].sum())
        cells = (percent(share(int(found.covered[:, k, cls].sum()), total)) for k in range(len(COVERED)))
        made.add_row(name, *cells)
    return made


def _failures_table(found: Coverage, title: str) -> Table:
    titles = (cell for name in CLASSES for cell in (name, "worst\nsector"))
    made = table(f"lost: {title}", *titles, dense=True, widest=36)
    for what, heading in HEADINGS.items():
        mine = [failure for failure in found.failures if failure.what == what]
        if what in ("pair", "half"):
            mine = sorted(mine, key=lambda failure: -int(failure.lost.sum()))[:SHOWN]
        if not mine:
            continue
        made.add_row(Text(heading, "bold"))
        for failure in mine:
            cells = []
            for cls in range(len(CLASSES)):
                by_sector = [lost_share(found, failure, cls, s) for s in range(len(SECTORS))]
                worst = max(range(len(SECTORS)), key=lambda s: by_sector[s])
                where = f"{SECTORS[worst]} {100.0 * by_sector[worst]:.0f} %" if by_sector[worst] else "-"
                cells += [percent(lost_share(found, failure, cls)), where]
            made.add_row(Text(f"  {visible(failure.name)}"), *cells)
        made.add_section()
    return made
