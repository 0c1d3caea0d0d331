"""What `riglens check` does: load what requirements ask for, check each rig, and say what holds."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import Any, NamedTuple

from rich.text import Text

from riglens.app.commands.blind_job import profiles_of
from riglens.app.commands.scores_job import missing_rays
from riglens.app.evaluation.options import SceneOptions, ScoreOptions
from riglens.app.evaluation.traffic import load_traffic
from riglens.app.studies.files import write_text
from riglens.app.terminal.checks import github_lines, verdict_table
from riglens.app.terminal.console import note, progress_bar, results
from riglens.app.terminal.scores import load_with_progress, mesh_called, rig_called
from riglens.assets import asset_path
from riglens.core.engine.evaluation_json import to_text
from riglens.core.errors import InputError
from riglens.core.files import atomic_write, require_writable
from riglens.core.metric.entropy import EntropyField
from riglens.core.review.check_json import check_document
from riglens.core.review.check_junit import RigCheck, junit_xml
from riglens.core.review.checked_yaml import line_of
from riglens.core.review.checking import NO_ROAD_USERS, Check, Subject
from riglens.core.review.profiles import Profile
from riglens.core.review.requirements import ACCEPTED, Requirements, requirements_in
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.nodes import read_text, shown_path
from riglens.core.shown_text import visible
from riglens.core.targets.traffic import WITHIN_M, Traffic
from riglens.core.vehicle.mesh import BodyMesh
from riglens.version import installed_version


class Asked(NamedTuple):
    """The file of requirements, profiles of one's own, where JSON and JUnit XML go ("-" is standard output), whether
    annotations are printed, and the day as of which waivers hold."""

    requirements: Path
    profiles: tuple[Path, ...]
    json: str | None
    junit: Path | None
    github: bool
    day: date


class Scene(NamedTuple):
    """What is needed of the traffic."""

    field: EntropyField | None
    traffic: Traffic | None


def check(names: Sequence[str], scene: SceneOptions, score: ScoreOptions, asked: Asked) -> int:
    """Print a verdict on each requirement of each rig; 0 when all are met, else 1."""
    if asked.github and asked.json == "-":
        raise InputError("--github and --json - both write to standard output; name a file with --json")
    profiles = profiles_of(asked.profiles)
    rigs = [rig_called(name) for name in names]
    text = read_text(asked.requirements, ACCEPTED)
    required = requirements_in(text, shown_path(asked.requirements), rigs, profiles)
    score = score.as_required(required.body, asked.requirements)
    meshes = [mesh_called(name, rig) for name, rig in zip(names, rigs, strict=True)]
    for path in (None if asked.json == "-" else asked.json, asked.junit):
        if path is not None:
            require_writable(path, (*names, asked.requirements, *asked.profiles, *scene.files))
    for line in (line for rig in rigs for line in missing_rays(rig)):
        note(line)
    loaded = _scene(scene, rigs, score, required)
    checks = [
        _checked(rig, mesh, score, loaded, required, profiles) for rig, mesh in zip(rigs, meshes, strict=True)
    ]
    sources = [_sources(asked, text, required, loaded, mesh) for mesh in meshes]
    return _tell(checks, sources, required, text, asked)


def _scene(scene: SceneOptions, rigs: Sequence[Rig], score: ScoreOptions, required: Requirements) -> Scene:
    field = traffic = None
    if required.needs_road_users and scene.pog is not None:
        raise InputError(NO_ROAD_USERS)
    if required.needs_scene:
        field = load_with_progress(scene.for_rigs(rigs, score))[1]
    if required.needs_road_users:
        with progress_bar("Reading boxes") as progress:
            traffic = load_traffic(scene, WITHIN_M, progress)
    return Scene(field, traffic)


def _checked(
    rig: Rig,
    mesh: BodyMesh | None,
    score: ScoreOptions,
    scene: Scene,
    required: Requirements,
    profiles: tuple[Profile, ...],
) -> RigCheck:
    body = score.body_of(rig)
    with progress_bar(f"Checking {visible(rig.name)}") as progress:
        subject = Subject(rig, body, mesh, scene.field, scene.traffic, profiles, score.threads)
        return RigCheck(rig, body, Check(subject, required).verdicts(progress))


def _sources(
    asked: Asked, text: str, required: Requirements, scene: Scene, mesh: BodyMesh | None
) -> dict[str, Any]:
    """What verdicts depend on besides the rig, with hashes."""
    files = asked.profiles or (asset_path("review/blind.yaml"),)
    field = scene.field
    return {
        "version": installed_version(),
        "mesh_sha256": None if mesh is None else mesh.sha256,
        "requirements": {"file": asked.requirements.name, "sha256": _sha256(text.encode("utf-8"))},
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


def _document(checks: Sequence[RigCheck], sources: Sequence[dict[str, Any]], day: date) -> dict[str, Any]:
    """The verdicts on a rig; of several rigs those of each in a list."""
    documents = [
        check_document(check.rig, check.body, check.verdicts, source, day)
        for check, source in zip(checks, sources, strict=True)
    ]
    if len(documents) == 1:
        return documents[0]
    passes = all(document["passes"] for document in documents)
    return {"riglens": FORMAT_VERSION, "passes": passes, "rigs": documents}


def _tell(
    checks: Sequence[RigCheck],
    sources: Sequence[dict[str, Any]],
    required: Requirements,
    text: str,
    asked: Asked,
) -> int:
    document = to_text(_document(checks, sources, asked.day))
    lines = {item.id: line_of(text, item.place) for item in required.items()}
    file = str(asked.requirements)
    if asked.junit is not None:
        properties = {
            "version": sources[0]["version"],
            "requirements sha256": sources[0]["requirements"]["sha256"],
            "data sha256": (sources[0]["data"] or {}).get("sha256", ""),
            "seed": str(required.seed),
        }
        with atomic_write(asked.junit) as stream:
            stream.write(junit_xml(checks, file, lines, properties, asked.day))
    if asked.json == "-":
        sys.stdout.write(document)
    else:
        if asked.json is not None:
            write_text(Path(asked.json), document)
        _print(checks, required, asked.day)
    if asked.github:
        for line in github_lines(checks, file, lines, asked.day):
            sys.stdout.write(f"{line}\n")
    return int(any(check.unmet(asked.day) for check in checks))


def _print(checks: Sequence[RigCheck], required: Requirements, day: date) -> None:
    console = results()
    for check in checks:
        unmet, waived = len(check.unmet(day)), sum(one.is_waived_on(day) for one in check.verdicts)
        counts = f"{len(check.verdicts)} requirements, {unmet} not met" + f", {waived} waived" * bool(waived)
        console.print(Text(f"{visible(check.rig.name)}: {counts}; body {check.body}"))
        console.print(verdict_table(check.verdicts, day))
    if required.losses or required.covered:
        console.print("Redundancy is a count of views, no evidence of a safety integrity level (ASIL).")
    if required.blind_objects:
        console.print("Objects: geometry only, no approval.")
