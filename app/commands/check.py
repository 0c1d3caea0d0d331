"""`riglens check`: whether rigs meet the requirements of a file; exit code 1 when one does not."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from datetime import date
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.table import Table
from rich.text import Text

from riglens.app.commands.options import (
    AnyRigs,
    Json,
    Profiles,
    RigArguments,
    RunArguments,
    SceneArguments,
    command,
)
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.terminal.console import TERMINAL, results
from riglens.app.terminal.tables import table
from riglens.core.errors import InputError
from riglens.core.files import write_file
from riglens.core.review.check_junit import RigCheck, junit_xml
from riglens.core.review.findings import Status, Verdict
from riglens.core.review.requirements import Requirements
from riglens.core.rig.yaml.checked import line_of
from riglens.core.shown_text import counted, visible
from riglens.evaluation.loading import load_rigs, note_mounts
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.jobs.checking import Checked, CheckInputs, checked, scene_for

MARKS: dict[Status, tuple[str, str]] = {
    "met": ("met", "green"),
    "not met": ("NOT MET", "bold red"),
    "not shown": ("NOT SHOWN", "bold red"),
    "not applicable": ("NOT APPLICABLE", "bold red"),
}


@command
def check(
    rigs: AnyRigs,
    /,
    *,
    requirements: Annotated[Path, Parameter(metavar="FILE")],
    profiles: Profiles = (),
    scene: SceneArguments = SceneOptions(),
    score: RunArguments = ScoreOptions(),
    reading: RigArguments = RigArguments(),
    json: Json = None,
    junit: Annotated[Path | None, Parameter(metavar="FILE")] = None,
    github: bool = False,
) -> int:
    """Check rigs against requirements: coverage, blind zones, redundancy, tolerance, mounts.

    Exit code 0 when all are met, 1 when one is not, is not shown or not applicable, 2 for bad input, 3 for a failure of
    the program. Blind zones, test objects and mounts always have a solid car.

    Parameters
    ----------
    requirements
        File of requirements.
    json
        Also write the verdicts as JSON to a file; with - to standard output, instead of the table.
    junit
        Also write the verdicts as JUnit XML, which pipelines show as test results.
    github
        Also print unmet requirements as annotations of GitHub Actions.
    """
    if github and json == "-":
        raise InputError("cannot share standard output: name a file with", "github", "json")
    loaded = load_rigs(rigs, score.solid(), TERMINAL, reading.libraries, reading.housings)
    asked = CheckInputs.of(requirements, profiles, loaded)
    required = asked.required
    score = score.as_required(required.settings.body, requirements)
    require_outputs((*rigs, requirements, *profiles, *scene.files), json, junit)
    traffic = scene_for(scene, loaded, score, asked, TERMINAL)
    if required.mounts is None:  # which has verdicts on them
        note_mounts(loaded, TERMINAL)
    found = checked(loaded, score, traffic, asked, TERMINAL)
    if junit is not None:
        _write_junit(junit, found)
    deliver(found.document(), json, lambda: _print(found.checks, required, asked.day))
    if github:
        for line in _github_lines(found.checks, asked):
            sys.stdout.write(f"{line}\n")
    return int(any(one.unmet(asked.day) for one in found.checks))


def _write_junit(path: Path, found: Checked) -> None:
    asked = found.asked
    write_file(path, junit_xml(found.checks, str(asked.file), _lines(asked), asked.day))


def _lines(asked: CheckInputs) -> dict[str, int]:
    """Return the line of each requirement in its file."""
    return {item.id: line_of(asked.text, item.place) for item in asked.required.items()}


def _print(checks: Sequence[RigCheck], required: Requirements, day: date) -> None:
    console = results()
    for check in checks:
        unmet, waived = len(check.unmet(day)), sum(one.is_waived_on(day) for one in check.verdicts)
        counts = f"{counted(len(check.verdicts), 'requirement')}, {unmet} not met"
        counts += f", {waived} waived" * bool(waived)
        console.print(Text(f"{visible(check.title)}: {counts}; body {check.body}"))
        console.print(Text(f"Settings: {check.settings_text}"), style="dim", soft_wrap=True)
        console.print(_table(check.verdicts, day))
    if required.losses or required.covered:
        console.print("Redundancy is a count of views, not evidence of a safety integrity level (ASIL).")
    if required.blind_objects:
        console.print("Objects: geometry only, not a type approval.")


def _table(verdicts: Sequence[Verdict], day: date | None) -> Table:
    """Requirements as rows: the figure and the limit, and whether it holds; below them what explains it."""
    made = table("", "requirement", "found", "accepted", words={0, 1}, wraps={0, 1}, dense=True)
    for verdict in verdicts:
        made.add_row(_mark(verdict, day), _words(verdict, day), verdict.found_text, verdict.accepted_text)
    return made


def _mark(verdict: Verdict, day: date | None) -> Text:
    word, style = MARKS[verdict.status]
    if verdict.is_waived_on(day):
        return Text(f"{word} (waived)", "yellow")
    return Text("not applicable", "dim") if verdict.passes and verdict.status != "met" else Text(word, style)


def _words(verdict: Verdict, day: date | None) -> Text:
    one = verdict.item.requirement
    named = " ".join(word for word in (one.id, one.label) if word is not None)
    words = Text(visible(f"{named}: {verdict.text}" if named else verdict.text))
    for line in verdict.lines(day):
        words.append(f"\n  {visible(line)}", "dim")
    return words


def _github_lines(checks: Sequence[RigCheck], asked: CheckInputs) -> Iterator[str]:
    """Yield workflow commands of GitHub: an error for each unmet requirement, a warning for each waived one."""
    lines, day = _lines(asked), asked.day
    for check in checks:
        for verdict in check.verdicts:
            if verdict.holds_on(day) and not verdict.is_waived_on(day):
                continue
            level = "warning" if verdict.is_waived_on(day) else "error"
            title = f"{check.title}: {verdict.item.id} {verdict.status}"
            said = f"{verdict.text}: {verdict.found_text}, {verdict.accepted_text}"
            message = "\n".join(visible(line) for line in (said, *verdict.lines(day), check.settings_text))
            place = (
                f"file={_property(str(asked.file))},line={lines[verdict.item.id]},title={_property(title)}"
            )
            yield f"::{level} {place}::{_escaped(message)}"


def _escaped(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _escaped(visible(text)).replace(":", "%3A").replace(",", "%2C")
