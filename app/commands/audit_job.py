"""What `riglens audit` does: follow the rays of a rig and say where they go, as a table, as JSON or as both."""

from __future__ import annotations

import sys

from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.terminal.console import progress_bar, results
from riglens.app.terminal.figures import percent
from riglens.app.terminal.scores import load_with_progress, mesh_called, rig_called
from riglens.core.engine.audit import FATES, RigAudit, audit_document
from riglens.core.engine.audit import audit as audit_rig
from riglens.core.engine.evaluation_json import to_text
from riglens.core.files import atomic_write, require_writable
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_text import visible

TITLES = (
    "hits\nthe car",
    "never\nenters",
    "ends at\nground",
    "meets\nnothing",
    "seen by\nothers",
    "brings\nnew",
)


def audit(name: str, scene: SceneOptions, score: ScoreOptions, json_target: str | None) -> None:
    """Print where the rays of a rig go, also written to a JSON file; with "-" as JSON alone."""
    rig = rig_called(name)
    mesh = mesh_called(name, rig)
    if json_target not in (None, "-"):
        require_writable(json_target, (name, *scene.files))
    _, field = load_with_progress(scene.for_rigs([rig], score))
    with progress_bar("Following rays"):
        found = audit_rig(field, rig, "blocks", mesh, score.threads)
    text = to_text(audit_document(found))
    if json_target == "-":
        sys.stdout.write(text)
        return
    if json_target is not None:
        with atomic_write(json_target, "w") as stream:
            stream.write(text)
    print_audit(found)


def print_audit(found: RigAudit) -> None:
    """Print the table, and what is to be said about places, on standard output."""
    console = results()
    console.print(f"Shares of rays; body {found.body}", soft_wrap=True)
    console.print(_shares_table(found))
    console.print(_lost_table(found))
    console.print("Lost = entropy that a sensor on its own would see but for the car's body, in % of H(Ω).")
    for sensor in found.sensors:
        if sensor.stand.problem:
            console.print(Text(f"{visible(sensor.name)}: {sensor.stand.problem}"), soft_wrap=True)


def _shares_table(found: RigAudit) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column(visible(found.rig.name), no_wrap=True, overflow="ellipsis", max_width=28)
    for title in ("rays", *TITLES):
        table.add_column(title, justify="right", no_wrap=True)
    for sensor in found.sensors:
        shares = (percent(sensor.shares[fate]) for fate in FATES)
        table.add_row(Text(visible(sensor.name)), f"{sensor.rays:,}", *shares)
    return table


def _lost_table(found: RigAudit) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("lost to the body", no_wrap=True, overflow="ellipsis", max_width=28)
    for name in CLASSES:
        table.add_column(name, justify="right", no_wrap=True)
    for sensor in found.sensors:
        table.add_row(Text(visible(sensor.name)), *(percent(sensor.lost_share[name]) for name in CLASSES))
    return table
