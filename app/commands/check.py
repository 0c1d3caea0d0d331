"""`riglens check`: whether rigs meet the requirements of a file; exit code 1 when one does not."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Annotated, Any, NamedTuple, Self

from cyclopts import Parameter
from rich.table import Table
from rich.text import Text

from riglens.app.commands.blind import profiles_of
from riglens.app.commands.evaluate import wrong_places
from riglens.app.commands.options import Json, Profiles, RigArguments, RunArguments, SceneArguments
from riglens.app.commands.output import deliver, require_outputs
from riglens.app.terminal.console import note, progress_bar, results
from riglens.app.terminal.loading import load_rigs, load_scene, load_traffic
from riglens.app.terminal.tables import table
from riglens.assets import asset_path
from riglens.core.errors import InputError
from riglens.core.files import write_file
from riglens.core.metric.entropy import EntropyField
from riglens.core.review.check_junit import RigCheck, junit_xml
from riglens.core.review.checking import NO_ROAD_USERS, Check, Subject
from riglens.core.review.documents import check_document
from riglens.core.review.findings import Status, Verdict
from riglens.core.review.profiles import Profile
from riglens.core.review.requirements import ACCEPTED, Requirements, requirements_in
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.checked import line_of
from riglens.core.rig.yaml.nodes import read_text, shown_path
from riglens.core.shown_text import visible
from riglens.core.targets.traffic import WITHIN_M, Traffic
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.version import installed_version

MARKS: dict[Status, tuple[str, str]] = {
    "met": ("met", "green"),
    "not met": ("NOT MET", "bold red"),
    "not shown": ("NOT SHOWN", "bold red"),
    "not applicable": ("NOT APPLICABLE", "bold red"),
}


class CheckInputs(NamedTuple):
    """The file of requirements, its text and what it says, files of your own profiles and the profiles that count,
    and the day of the waivers."""

    file: Path
    text: str
    required: Requirements
    profiles: tuple[Path, ...]
    judged: tuple[Profile, ...]
    day: date

    @classmethod
    def of(cls, file: Path, profiles: tuple[Path, ...], rigs: Sequence[Rig]) -> Self:
        """Read requirements for some rigs; raise InputError for unknown names of sensors, groups or profiles."""
        judged, text = profiles_of(profiles), read_text(file, ACCEPTED)
        return cls(
            file, text, requirements_in(text, shown_path(file), rigs, judged), profiles, judged, date.today()
        )


class Scene(NamedTuple):
    """Parts of the traffic that requirements need."""

    field: EntropyField | None
    traffic: Traffic | None


def check(
    rigs: Annotated[tuple[str, ...], Parameter(name="RIG", negative=())],
    /,
    *,
    requirements: Annotated[Path, Parameter(metavar="FILE")],
    profiles: Profiles = (),
    scene: SceneArguments = SceneArguments(),
    score: RunArguments = RunArguments(),
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
    rigs
        Rig files or preset names.
    requirements
        File of requirements.
    profiles
        File of your own blind zone profiles, instead of the bundled ones; may be repeated.
    json
        Also write the verdicts as JSON to a file; with - to standard output, instead of the table.
    junit
        Also write the verdicts as JUnit XML, which pipelines show as test results.
    github
        Also print unmet requirements as annotations of GitHub Actions.
    """
    if github and json == "-":
        raise InputError("cannot share standard output: name a file with", "github", "json")
    loaded = load_rigs(rigs, score.solid(), reading.libraries, reading.housings)
    asked = CheckInputs.of(requirements, profiles, loaded)
    required = asked.required
    score = score.as_required(required.body, requirements)
    require_outputs((*rigs, requirements, *profiles, *scene.files), json, junit)
    traffic = scene_for(scene, loaded, score, required)
    if required.mounts is None:  # which has verdicts on them
        for line in wrong_places(loaded):
            note(line)
    found = checked(loaded, score, traffic, asked)
    if junit is not None:
        _write_junit(junit, found)
    deliver(found.document(), json, lambda: _print(found.checks, required, asked.day))
    if github:
        for line in _github_lines(found.checks, asked):
            sys.stdout.write(f"{line}\n")
    return int(any(one.unmet(asked.day) for one in found.checks))


@dataclass(frozen=True)
class Checked:
    """Verdicts on rigs, and the inputs of each besides the rig."""

    checks: Sequence[RigCheck]
    sources: Sequence[dict[str, Any]]
    asked: CheckInputs

    def document(self) -> dict[str, Any]:
        """Return the verdicts on a rig; of several rigs those of each in a list."""
        documents = [
            check_document(check.rig, check.body, check.verdicts, source, self.asked.day)
            for check, source in zip(self.checks, self.sources, strict=True)
        ]
        if len(documents) == 1:
            return documents[0]
        passes = all(document["passes"] for document in documents)
        return {"riglens": FORMAT_VERSION, "passes": passes, "rigs": documents}


def checked(rigs: Sequence[Rig], score: ScoreOptions, scene: Scene, asked: CheckInputs) -> Checked:
    """Check each rig against the requirements."""
    checks, sources = [], []
    for rig in rigs:
        body = score.body_of(rig)
        with progress_bar(f"Checking {visible(rig.name)}") as progress:
            subject = Subject(rig, body, scene.field, scene.traffic, asked.judged, score.threads)
            checks.append(RigCheck(rig, body, Check(subject, asked.required).verdicts(progress)))
        sources.append(_sources(asked, scene, rig))
    return Checked(checks, sources, asked)


def scene_for(scene: SceneOptions, rigs: Sequence[Rig], score: ScoreOptions, required: Requirements) -> Scene:
    """Load what requirements need."""
    field = traffic = None
    if required.needs_objects and scene.pog is not None:
        raise InputError(NO_ROAD_USERS)
    if required.needs_scene:
        field = load_scene(scene, rigs, score)[1]
    if required.needs_objects:
        traffic = load_traffic(scene, WITHIN_M)
    return Scene(field, traffic)


def unmet_by(rig: Rig, score: ScoreOptions, scene: Scene, asked: CheckInputs) -> tuple[str, ...]:
    """Return the requirements that a rig does not meet, by their ids."""
    subject = Subject(rig, score.body_of(rig), scene.field, scene.traffic, asked.judged, score.threads)
    verdicts = Check(subject, asked.required).verdicts()
    return tuple(one.item.id for one in verdicts if not one.holds_on(asked.day))


def _sources(asked: CheckInputs, scene: Scene, rig: Rig) -> dict[str, Any]:
    """Return the inputs of verdicts besides the rig, with their SHA-256."""
    files = asked.profiles or (asset_path("review/blind.yaml"),)
    field, required, mesh = scene.field, asked.required, rig.vehicle.body_mesh
    return {
        "version": installed_version(),
        "mesh_sha256": None if mesh is None else mesh.sha256,
        "requirements": {"file": asked.file.name, "sha256": _sha256(asked.text.encode("utf-8"))},
        "profiles": [{"file": path.name, "sha256": _sha256(path.read_bytes())} for path in files],
        "data": None
        if field is None
        else {"source": field.data.short_source, "sha256": field.data.sha256, "frames": field.data.frames},
        "voxel_m": None if field is None else field.grid.voxel_m,
        "roi_m": None if field is None else list(field.grid.roi_m),
        "blind_voxel_m": required.blind_voxel_m,
        "seed": required.seed,
        "waivers_on": asked.day.isoformat(),
    }


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _write_junit(path: Path, found: Checked) -> None:
    source, asked = found.sources[0], found.asked
    properties = {
        "version": source["version"],
        "requirements sha256": source["requirements"]["sha256"],
        "data sha256": (source["data"] or {}).get("sha256", ""),
        "seed": str(asked.required.seed),
    }
    write_file(path, junit_xml(found.checks, str(asked.file), _lines(asked), properties, asked.day))


def _lines(asked: CheckInputs) -> dict[str, int]:
    """Return the line of each requirement in its file."""
    return {item.id: line_of(asked.text, item.place) for item in asked.required.items()}


def _print(checks: Sequence[RigCheck], required: Requirements, day: date) -> None:
    console = results()
    for check in checks:
        unmet, waived = len(check.unmet(day)), sum(one.is_waived_on(day) for one in check.verdicts)
        counts = f"{len(check.verdicts)} requirements, {unmet} not met" + f", {waived} waived" * bool(waived)
        console.print(Text(f"{visible(check.rig.name)}: {counts}; body {check.body}"))
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
            title = f"{check.rig.name}: {verdict.item.id} {verdict.status}"
            said = f"{verdict.text}: {verdict.found_text}, {verdict.accepted_text}"
            message = "\n".join(visible(line) for line in (said, *verdict.lines(day)))
            place = (
                f"file={_property(str(asked.file))},line={lines[verdict.item.id]},title={_property(title)}"
            )
            yield f"::{level} {place}::{_escaped(message)}"


def _escaped(text: str) -> str:
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _escaped(visible(text)).replace(":", "%3A").replace(",", "%2C")
