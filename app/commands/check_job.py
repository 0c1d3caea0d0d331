"""What `riglens check` does: load what requirements ask for, check, and say what holds."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import NamedTuple

from rich import box
from rich.table import Table
from rich.text import Text

from riglens.app.commands.blind_job import profiles_of
from riglens.app.commands.scores_job import missing_rays
from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.evaluation.traffic import load_traffic
from riglens.app.studies.files import write_text
from riglens.app.terminal.console import note, progress_bar, results
from riglens.app.terminal.scores import load_with_progress, mesh_called, rig_called
from riglens.core.engine.evaluation_json import to_text
from riglens.core.files import require_writable
from riglens.core.metric.scores import Body
from riglens.core.review.check_json import check_document
from riglens.core.review.checking import Check, Subject
from riglens.core.review.requirements import Requirements, Verdict, read_requirements
from riglens.core.rig.model import Rig
from riglens.core.shown_text import visible
from riglens.core.targets.traffic import WITHIN_M


class Asked(NamedTuple):
    """The file of requirements, profiles of one's own, and where JSON goes; "-" is standard output."""

    requirements: Path
    profiles: tuple[Path, ...]
    json: str | None


def check(name: str, scene: SceneOptions, score: ScoreOptions, asked: Asked) -> int:
    """Print a verdict on each requirement; 0 when all are met, else 1."""
    required = read_requirements(asked.requirements)
    profiles = profiles_of(asked.profiles)
    rig = rig_called(name)
    score = score.as_required(required.body, asked.requirements)
    if asked.json not in (None, "-"):
        require_writable(asked.json, (name, asked.requirements, *asked.profiles, *scene.files))
    for line in missing_rays(rig):
        note(line)
    body = score.body_of(rig)
    field = load_with_progress(scene.for_rigs([rig], score))[1] if required.needs_scene else None
    traffic = None
    if required.needs_road_users and scene.pog is None:
        with progress_bar("Reading boxes") as progress:
            traffic = load_traffic(scene, WITHIN_M, progress)
    with progress_bar("Checking"):
        subject = Subject(rig, body, mesh_called(name, rig), field, traffic, profiles, score.threads)
        verdicts = Check(subject, required).verdicts()
    return _tell(rig, body, required, verdicts, asked.json)


def _tell(
    rig: Rig, body: Body, required: Requirements, verdicts: tuple[Verdict, ...], json: str | None
) -> int:
    text = to_text(check_document(rig, body, verdicts))
    failed = sum(not verdict.passes for verdict in verdicts)
    if json == "-":
        sys.stdout.write(text)
        return int(failed > 0)
    if json is not None:
        write_text(Path(json), text)
    console = results()
    console.print(Text(f"{visible(rig.name)}: {len(verdicts)} requirements, {failed} not met; body {body}"))
    console.print(verdict_table(verdicts))
    if required.losses or required.covered:
        console.print("Redundancy is a count of views, no evidence of a safety integrity level (ASIL).")
    if required.blind_objects:
        console.print("Objects: geometry only, no approval.")
    return int(failed > 0)


def verdict_table(verdicts: tuple[Verdict, ...]) -> Table:
    """Requirements as rows: what was found, what is accepted, and whether it holds."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for title in ("", "requirement"):
        table.add_column(title)
    for title in ("found", "accepted"):
        table.add_column(title, justify="right", no_wrap=True)
    for verdict in verdicts:
        mark = Text("met", "green") if verdict.passes else Text("NOT MET", "bold red")
        table.add_row(
            mark,
            Text(visible(verdict.text)),
            amount(verdict.found, verdict.unit),
            f"{verdict.relation} {amount(verdict.limit, verdict.unit)}",
        )
    return table


def amount(value: float, unit: str) -> str:
    """A number with its unit; shares in percent."""
    if unit == "share":
        return f"{100.0 * value:.2f} %"
    return f"{value:.2f} {unit}" if unit == "m²" else f"{value:g} {unit}"
