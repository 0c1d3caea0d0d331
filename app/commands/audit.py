"""Audit of the rays of each sensor: part of `riglens review`, alone as `riglens audit`."""

from __future__ import annotations

from rich.table import Table
from rich.text import Text

from riglens.app.commands.options import (
    JsonFigures,
    RigArguments,
    RigName,
    SceneArguments,
    SolidBody,
    ThreadArguments,
    command,
)
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.terminal.console import progress_bar, results
from riglens.app.terminal.loading import load_rigs, load_scene
from riglens.app.terminal.tables import table
from riglens.core.engine.audit import RAY_OUTCOMES, RigAudit, audit_document
from riglens.core.engine.audit import audit as audit_rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_text import visible
from riglens.core.shown_values import percent
from riglens.evaluation.options import SceneOptions, ScoreOptions

TITLES = (
    "hits\nthe car",
    "never\nenters",
    "ends at\nground",
    "meets\nnothing",
    "seen by\nothers",
    "brings\nnew",
)


@command
def audit(
    rig: RigName,
    /,
    *,
    scene: SceneArguments = SceneOptions(),
    body: SolidBody = None,
    score: ThreadArguments = ScoreOptions(),
    reading: RigArguments = RigArguments(),
    json: JsonFigures = None,
) -> None:
    """Trace every ray of each sensor: to the solid car, past the region, to the ground, or into uncertain space."""
    score = score.solid(body)
    (opened,) = load_rigs([rig], score, reading.libraries, reading.housings)
    require_outputs((rig, *scene.files), json)
    _, field = load_scene(scene, [opened], score)
    with progress_bar("Tracing rays"):
        found = audit_rig(field, opened, "blocks", score.threads)
    deliver(audit_document(found), json, lambda: print_audit(found))


def print_audit(found: RigAudit) -> None:
    """Print the table, and remarks on mounts, on standard output."""
    console = results()
    console.print(f"Shares of rays; body {found.body}", soft_wrap=True)
    console.print(_shares_table(found))
    console.print(_lost_table(found))
    console.print("Lost = entropy that a sensor on its own loses to the car's body, in % of H(Ω).")
    for sensor in found.sensors:
        if sensor.stand.problem:
            console.print(Text(f"{visible(sensor.name)}: {sensor.stand.problem}"), soft_wrap=True)


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
