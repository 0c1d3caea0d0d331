"""Audit of the rays of each sensor: part of `riglens review`."""

from __future__ import annotations

from rich.table import Table
from rich.text import Text

from riglens.app.terminal.console import results
from riglens.app.terminal.tables import table
from riglens.core.engine.audit import RAY_OUTCOMES, RigAudit
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_text import visible
from riglens.core.shown_values import percent

TITLES = (
    "hits\nthe car",
    "misses\nthe region",
    "ends at\nground",
    "hits\nnothing",
    "seen by\nothers",
    "unique",
)


def print_audit(found: RigAudit) -> None:
    """Print the table, and remarks on mounts, on standard output."""
    console = results()
    console.print(f"Shares of rays; body {found.body}", soft_wrap=True)
    console.print(_shares_table(found))
    console.print(_lost_table(found))
    console.print("Lost = entropy that a sensor on its own loses to the car's body, in % of H(Ω).")
    for sensor in found.sensors:
        if sensor.status.problem:
            console.print(Text(f"{visible(sensor.name)}: {sensor.status.problem}"), soft_wrap=True)


def _shares_table(found: RigAudit) -> Table:
    made = table(visible(found.rig.name), "rays", *TITLES, widest=28)
    for sensor in found.sensors:
        shares = (percent(sensor.shares[fate]) for fate in RAY_OUTCOMES)
        made.add_row(Text(visible(sensor.name)), f"{sensor.rays:,}", *shares)
    return made


def _lost_table(found: RigAudit) -> Table:
    made = table("lost to the body", *CLASSES, widest=28)
    for sensor in found.sensors:
        made.add_row(Text(visible(sensor.name)), *(percent(sensor.lost_share[name]) for name in CLASSES))
    return made
