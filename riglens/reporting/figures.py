"""The figures of a report as plain data: the documents of the commands, and all that is needed to make them again."""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

from pydantic import AfterValidator, Field

from riglens.core.blind.zones import BlindMap
from riglens.core.engine.audit import audit, audit_document
from riglens.core.figures.documents import estimate_document, evaluation_document
from riglens.core.figures.evaluated import Evaluated, EvaluationSettings, Evaluator
from riglens.core.figures.hits import MISSED
from riglens.core.figures.registry import figure_named
from riglens.core.figures.sentence import changes_of, sentence
from riglens.core.footprint.document import footprints_document, footprints_of
from riglens.core.footprint.ground import Footprint
from riglens.core.kernels.runtime import jit
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Body, Method, Reading
from riglens.core.monitor import SILENT, Monitor
from riglens.core.plain import Frozen
from riglens.core.review.checking import Check, Subject
from riglens.core.review.documents import (
    blind_document,
    check_document,
    coverage_document,
    mounts_document,
    places_document,
    settings_document,
    tolerance_document,
)
from riglens.core.review.measures import Measures
from riglens.core.review.mounts import USUAL_LIMITS, mounts_of, violations
from riglens.core.review.profiles import Profile, bundled_profiles
from riglens.core.review.redundancy import NO_EVIDENCE, coverage_of, target_coverage
from riglens.core.review.requirements import Requirements
from riglens.core.review.tolerance import MAX_DRAWS, SAMPLE_FRAMES, profile_called, tolerance
from riglens.core.review.verdicts import verdicts
from riglens.core.rig.history import differences_in_words
from riglens.core.rig.model import FORMAT_VERSION, MAX_SENSORS, Rig
from riglens.core.rig.yaml.file import dumps
from riglens.core.rig.yaml.nodes import shortened
from riglens.core.scene.boxes import Progress
from riglens.core.shown_text import numbered
from riglens.core.targets.detection_range import USUAL_PLAN
from riglens.core.targets.detection_range_making import detection_range_of
from riglens.core.targets.detection_range_table import range_document
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import WITHIN_M
from riglens.evaluation.loading import note_data
from riglens.evaluation.options import MOST_LETTERS, SceneOptions, ScoreOptions
from riglens.evaluation.scenario import load_scenario, settings_of
from riglens.evaluation.traffic import load_traffic
from riglens.version import installed_version

Stage = Callable[[float, str], None]
"""Callback for the share done and the current stage."""
_SECONDS = {
    "Reading the data": 2.0, "Scoring": 0.5, "Counting points on objects": 2.0, "Finding blind zones": 1.0,
    "Finding detection ranges": 2.0, "Tracing rays": 2.0, "Counting redundancy": 0.5, "Sampling mount errors": 0.3,
    "Checking requirements": 2.0,
}  # fmt: skip
"""Stages, and roughly what each takes on two cores: the errors for each draw, the others for each rig."""


class Stages:
    """Progress of a report: its stages and the share that is done, by what each stage usually takes."""

    def __init__(self, tell: Stage, plan: ReportPlan) -> None:
        self._tell, self._rigs, self._draws = tell, len(plan.rigs), plan.draws
        each = sum(_SECONDS.values()) - _SECONDS["Reading the data"] - _SECONDS["Sampling mount errors"]
        if plan.requirements is None:
            each -= _SECONDS["Checking requirements"]
        self._whole = _SECONDS["Reading the data"] + self._rigs * (
            each + plan.draws * _SECONDS["Sampling mount errors"]
        )
        self._begun = self._length = 0.0

    def begin(self, title: str, of: str = "") -> Progress:
        """End the stage before, begin this one `of` a rig, and return what takes its own share."""
        self._begun += self._length
        self._length = _SECONDS[title] * (self._draws if title == "Sampling mount errors" else 1)
        words = f"{title}: {of}" if of and self._rigs > 1 else title

        def progress(share: float) -> None:
            self._tell(min(1.0, (self._begun + share * self._length) / self._whole), words)

        progress(0.0)
        return progress


class Labels(Frozen):
    """Words of the reader's own in the header: project, revision, author, reviewer."""

    project: str | None = Field(default=None, max_length=MOST_LETTERS)
    revision: str | None = Field(default=None, max_length=MOST_LETTERS)
    author: str | None = Field(default=None, max_length=MOST_LETTERS)
    reviewer: str | None = Field(default=None, max_length=MOST_LETTERS)

    @property
    def words(self) -> tuple[str, ...]:
        """Return the given labels, each with its caption."""
        return tuple(f"{name.capitalize()}: {text}" for name, text in self.model_dump().items() if text)


NO_LABELS = Labels()


class KeptGain(Frozen):
    """Gain of a proposal in one case of the guard, in the unit of the figure."""

    case: str = Field(max_length=MOST_LETTERS)
    gain: float
    se: float
    share: float


def _known_figure(key: str) -> str:
    if figure_named(key) is None:
        raise ValueError("is no key of a figure")
    return key


class WhyHere(Frozen):
    """Reasons for the places of sensors: the search that proposed a rig of a report, as it was found then, with the key
    of the figure that it was to improve."""

    figure: Annotated[str, AfterValidator(_known_figure)]
    sensors: list[str] = Field(max_length=MAX_SENSORS)
    sentence: str = Field(max_length=10 * MOST_LETTERS)
    reference: str = Field(max_length=2 * MOST_LETTERS)
    verdict: str = Field(max_length=MOST_LETTERS)
    checks: list[KeptGain] = Field(max_length=100)


@dataclass(frozen=True)
class ReportPlan:
    """Plan of a report: rigs with the meshes of their bodies, a scene, score options, draws of the tolerance (0: none)
    and their seed, requirements with their text, if any, labels, and the search behind one of the rigs, if any.

    names: of the rigs in the report, which differ; by default those of the rigs, numbered where they are equal.
    """

    rigs: tuple[Rig, ...]
    scene: SceneOptions
    score: ScoreOptions
    draws: int
    seed: int
    requirements: Requirements | None = None
    requirements_text: str | None = None
    labels: Labels = NO_LABELS
    why: WhyHere | None = None
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if len(set(self.names)) != len(self.rigs):
            object.__setattr__(self, "names", numbered([rig.name for rig in self.rigs]))


class Inputs(Frozen):
    """Inputs of a report's figures, as attached to it: enough to recompute them, except for box data."""

    rigs: list[str]
    voxel_m: float
    roi_m: list[float] = Field(min_length=3, max_length=3)
    method: Method
    reading: Reading
    camera_weight: float = Field(alias="lambda")
    body: Body | None
    """None: as set in each rig."""
    draws: int = Field(ge=0, le=MAX_DRAWS)
    seed: int = Field(ge=0, lt=1 << 63)
    boxes: str | None
    requirements: str | None
    labels: Labels = Labels()
    why: WhyHere | None = None
    names: list[str] = Field(default=[], max_length=MAX_SENSORS)


@dataclass(frozen=True)
class Report:
    """The figures, and what drawings are made from, rig by rig: maps of blind zones, and footprints."""

    figures: dict[str, Any]
    maps: tuple[BlindMap, ...]
    footprints: tuple[tuple[Footprint, ...], ...]


def report_of(plan: ReportPlan, tell: Stage, monitor: Monitor = SILENT) -> Report:
    """Make every figure of a report. For the thread of the parallel kernels."""
    stages, score = Stages(tell, plan), plan.score
    stages.begin("Reading the data")
    field = load_scenario(plan.scene.for_rigs(plan.rigs, score), lambda _: None).field
    note_data(field.data, monitor)
    traffic = None if plan.scene.pog is not None else load_traffic(plan.scene, WITHIN_M)
    settings = EvaluationSettings(settings_of(score), TargetSettings(body=score.body))
    evaluate = Evaluator(field, traffic, settings, score.threads)
    evaluated: list[Evaluated] = []
    parts, maps, footprints = [], [], []
    for rig in plan.rigs:
        stages.begin("Scoring", rig.name)
        voxels = evaluate(rig, ("voxels",)).voxels
        stages.begin("Counting points on objects", rig.name)
        objects = evaluate(rig, ("objects",)).objects
        stages.begin("Finding blind zones", rig.name)
        found = evaluate.ground_of(rig, settings.blind).evaluate(rig)
        maps.append(found)
        assert voxels is not None
        voxels = replace(voxels, elapsed_ms=0.0)
        objects = None if objects is None else replace(objects, elapsed_ms=0.0)
        evaluated.append(Evaluated(rig, settings, field, voxels, objects, found))
        progress = stages.begin("Finding detection ranges", rig.name)
        ranges = detection_range_of(rig, USUAL_PLAN, score.threads, progress=progress)
        footprints.append(footprints_of(rig))
        parts.append(_parts(plan, evaluated[-1], evaluate, stages))
        parts[-1] |= {
            "range": range_document(ranges),
            "footprint": _footprint(rig, footprints[-1]),
            "missed": None if objects is None else _missed(evaluated[-1], evaluated[0]),
            "against": None if len(evaluated) == 1 else _against(evaluated[-1], evaluated[0], plan.names[0]),
        }
    figures = _figures(plan, field, evaluated, parts, score)
    return Report(figures, tuple(maps), tuple(footprints))


def _footprint(rig: Rig, found: Sequence[Footprint]) -> dict[str, Any]:
    """Return the footprints of a rig without their outlines, which the drawings have."""
    document = footprints_document(rig, found)
    for band in (band for sensor in document["sensors"] for band in sensor["bands"]):
        del band["outlines_m"]
    return document


def _missed(now: Evaluated, first: Evaluated) -> dict[str, Any]:
    assert now.objects is not None
    return places_document(MISSED, now.objects, first.objects)


def _against(now: Evaluated, first: Evaluated, called: str) -> dict[str, Any]:
    """Return how a rig compares with the first one: in a sentence, figure by figure, and what differs in the rigs."""
    changes = changes_of(now, first)
    return {
        "sentence": sentence(changes, called),
        "edits": list(differences_in_words(first.rig, now.rig)),
        "changes": {
            key: {who: estimate_document(change) for who, change in of_figure.items()}
            for key, of_figure in changes.items()
        },
    }


def report_profiles() -> tuple[tuple[Profile, ...], list[str]]:
    """Return the profiles of test objects that a report shows, and the names of the others."""
    every = bundled_profiles()
    return (
        tuple(profile for profile in every if not profile.from_memory),
        [profile.name for profile in every if profile.from_memory],
    )


def _parts(
    plan: ReportPlan,
    evaluated: Evaluated,
    evaluate: Evaluator,
    stages: Stages,
) -> dict[str, Any]:
    """Return the figures of one rig on its own."""
    rig, found, counts = evaluated.rig, evaluated.ground, evaluated.objects
    assert found is not None
    body, profiles = plan.score.body_of(rig), report_profiles()[0]
    judged = verdicts(rig, profiles, "blocks", jit.use_threads(evaluate.threads))
    mounted = mounts_document(rig, mounts_of(rig), violations(rig, USUAL_LIMITS))
    stages.begin("Tracing rays", rig.name)
    audited = audit_document(audit(evaluate.voxels, rig))
    stages.begin("Counting redundancy", rig.name)
    voxels = coverage_of(evaluate, rig, "voxels")
    users = None if counts is None else target_coverage(counts)
    spread = None
    if plan.draws:
        progress = stages.begin("Sampling mount errors", rig.name)
        measure, assembly = Measures(evaluate, SAMPLE_FRAMES, rig), profile_called("assembly")
        drawn = tolerance(rig, assembly, measure, plan.draws, plan.seed, False, progress, measure.frames)
        spread = tolerance_document(drawn, body)
    checked = None
    if plan.requirements is not None:
        progress = stages.begin("Checking requirements", rig.name)
        sources = settings_document(plan.requirements.settings, evaluate.field, evaluate.traffic)
        every = Check(Subject(rig, evaluate, profiles), plan.requirements).verdicts(progress)
        checked = check_document(rig, body, every, sources)
    return {
        "blind": blind_document(found, judged),
        "mounts": mounted,
        "audit": audited,
        "redundancy": {
            "note": NO_EVIDENCE,
            "voxels": coverage_document(voxels, "nat"),
            "objects": None if users is None else coverage_document(users, "objects"),
        },
        "tolerance": spread,
        "check": checked,
    }


def _figures(
    plan: ReportPlan,
    field: EntropyField,
    evaluated: Sequence[Evaluated],
    parts: Sequence[dict[str, Any]],
    score: ScoreOptions,
) -> dict[str, Any]:
    grid = field.grid
    evaluation = evaluation_document(field, settings_of(score), evaluated)
    return {
        "riglens_report": FORMAT_VERSION,
        "version": installed_version(),
        "inputs": Inputs(
            rigs=[dumps(rig) for rig in plan.rigs],
            voxel_m=grid.voxel_m,
            roi_m=list(grid.roi_m),
            method=score.method,
            reading=score.reading,
            camera_weight=score.camera_weight,
            body=score.body,
            draws=plan.draws,
            seed=plan.seed,
            boxes=None if plan.scene.boxes is None else plan.scene.boxes.name,
            requirements=plan.requirements_text,
            labels=plan.labels,
            why=plan.why,
            names=list(plan.names),
        ).model_dump(by_alias=True, exclude={"why"} if plan.why is None else None),
        "left_out": report_profiles()[1],
        "targets": evaluation.pop("targets", None),
        "evaluation": evaluation,
        "rigs": list(parts),
    }


def differences(attached: Any, again: Any, where: str = "") -> list[str]:
    """Return the differences between two documents, one line each: the path, the attached and the recomputed value."""
    if isinstance(attached, dict) and isinstance(again, dict):
        keys = list(dict.fromkeys([*attached, *again]))
        parts = [
            differences(attached.get(key), again.get(key), f"{where}.{key}" if where else str(key))
            for key in keys
        ]
        return [line for part in parts for line in part]
    if isinstance(attached, list) and isinstance(again, list | tuple) and len(attached) == len(again):
        pairs = enumerate(zip(attached, again, strict=True))
        return [line for n, (one, other) in pairs for line in differences(one, other, f"{where}[{n}]")]
    return [] if attached == again else [f"{where}: attached {_short(attached)}, recomputed {_short(again)}"]


def _short(value: Any) -> str:
    return shortened(" ".join(reprlib.repr(value).split()), 80)
