"""Check rigs against a file of requirements."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any, NamedTuple, Self

from riglens.assets import asset_path
from riglens.core.errors import InputError
from riglens.core.figures.evaluated import EvaluationSettings, Evaluator
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import MetricSettings
from riglens.core.monitor import Monitor
from riglens.core.review.check_junit import RigCheck
from riglens.core.review.checking import NO_ROAD_USERS, Check, Subject
from riglens.core.review.documents import check_document, settings_document
from riglens.core.review.profiles import Profile, profiles_in
from riglens.core.review.requirements import ACCEPTED, Requirements, requirements_in
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.nodes import read_text, shown_path
from riglens.core.shown_text import numbered, visible
from riglens.core.targets.traffic import WITHIN_M, Traffic
from riglens.evaluation.loading import load_scene, load_traffic
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.version import installed_version


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
        judged, text = profiles_in(profiles), read_text(file, ACCEPTED)
        return cls(
            file, text, requirements_in(text, shown_path(file), rigs, judged), profiles, judged, date.today()
        )


class CheckData(NamedTuple):
    """Parts of the traffic that requirements need."""

    field: EntropyField | None
    traffic: Traffic | None


@dataclass(frozen=True)
class Checked:
    """Verdicts on rigs."""

    checks: Sequence[RigCheck]
    asked: CheckInputs

    def document(self) -> dict[str, Any]:
        """Return the verdicts on a rig; of several rigs those of each in a list."""
        documents = [
            {"title": check.title}
            | check_document(check.rig, check.body, check.verdicts, check.sources, self.asked.day)
            for check in self.checks
        ]
        if len(documents) == 1:
            return documents[0]
        passes = all(document["passes"] for document in documents)
        return {"riglens": FORMAT_VERSION, "passes": passes, "rigs": documents}


def checked(
    rigs: Sequence[Rig], score: ScoreOptions, scene: CheckData, asked: CheckInputs, monitor: Monitor
) -> Checked:
    """Check each rig against the requirements."""
    checks, evaluate = [], _evaluator(scene, score)
    for rig, title in zip(rigs, numbered([rig.name for rig in rigs]), strict=True):
        body = score.body_of(rig)
        with monitor.stage(f"Checking {visible(title)}") as progress:
            verdicts = Check(Subject(rig, evaluate, asked.judged), asked.required).verdicts(progress)
        checks.append(RigCheck(rig, body, verdicts, title, _sources(asked, scene, rig)))
    return Checked(checks, asked)


def _evaluator(scene: CheckData, score: ScoreOptions) -> Evaluator:
    settings = EvaluationSettings(MetricSettings(body=score.body))
    return Evaluator(scene.field, scene.traffic, settings, score.threads)


def scene_for(
    scene: SceneOptions, rigs: Sequence[Rig], score: ScoreOptions, asked: CheckInputs, monitor: Monitor
) -> CheckData:
    """Load what requirements need, with their grid; raise InputError where an option contradicts them."""
    field, traffic, required = None, None, asked.required
    scene = scene.as_required(required.settings, asked.file)
    if required.needs_objects and scene.pog is not None:
        raise InputError(NO_ROAD_USERS)
    if required.needs_scene:
        field = load_scene(scene, monitor, rigs, score)[1]
    if required.needs_objects:
        traffic = load_traffic(scene, WITHIN_M, monitor)
    return CheckData(field, traffic)


def unmet_by(rig: Rig, score: ScoreOptions, scene: CheckData, asked: CheckInputs) -> tuple[str, ...]:
    """Return the requirements that a rig does not meet, by their ids."""
    verdicts = Check(Subject(rig, _evaluator(scene, score), asked.judged), asked.required).verdicts()
    return tuple(one.item.id for one in verdicts if not one.holds_on(asked.day))


def _sources(asked: CheckInputs, scene: CheckData, rig: Rig) -> dict[str, Any]:
    """Return the inputs of verdicts besides the rig, with their SHA-256."""
    files = asked.profiles or (asset_path("review/blind.yaml"),)
    mesh = rig.vehicle.body_mesh
    return {
        "version": installed_version(),
        "mesh_sha256": None if mesh is None else mesh.sha256,
        "requirements": {"file": asked.file.name, "sha256": _sha256(asked.text.encode("utf-8"))},
        "profiles": [{"file": path.name, "sha256": _sha256(path.read_bytes())} for path in files],
        **settings_document(asked.required.settings, scene.field, scene.traffic),
        "waivers_on": asked.day.isoformat(),
    }


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
