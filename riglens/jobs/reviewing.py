"""Parts of a review of a rig: blind zones, detection range, redundancy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from riglens.core.blind.zones import (
    BlindEngine,
    BlindMap,
    BlindSettings,
)
from riglens.core.figures.evaluated import EvaluationSettings, Evaluator
from riglens.core.kernels.runtime import jit
from riglens.core.metric.entropy import EntropyField
from riglens.core.monitor import Monitor
from riglens.core.review.documents import coverage_document, tolerance_document
from riglens.core.review.measures import Measures
from riglens.core.review.profiles import Profile
from riglens.core.review.redundancy import NO_EVIDENCE, Coverage, coverage_of
from riglens.core.review.tolerance import ToleranceOptions, ToleranceResult, profile_called, tolerance
from riglens.core.review.verdicts import ProfileVerdict, verdicts
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.file import identity_of
from riglens.core.scene.boxes import Progress
from riglens.core.targets.detection_range import DetectionRange, RangePlan
from riglens.core.targets.detection_range_making import detection_range_of
from riglens.core.targets.engine import warm_up
from riglens.core.targets.settings import USUAL, TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.evaluation.options import ScoreOptions
from riglens.evaluation.scenario import settings_of


def evaluator_of(field: EntropyField, traffic: Traffic | None, score: ScoreOptions) -> Evaluator:
    """Return what evaluates rigs for all parts of a review in a scene."""
    settings = EvaluationSettings(settings_of(score), replace(USUAL, body=score.body))
    return Evaluator(field, traffic, settings, score.threads)


def blind_zones(
    rig: Rig, settings: BlindSettings, profiles: Sequence[Profile], threads: int | None, monitor: Monitor
) -> tuple[BlindMap, tuple[ProfileVerdict, ...]]:
    """Find blind zones of a rig and judge test objects."""
    with monitor.stage("Casting rays") as progress:
        found = BlindEngine(rig.vehicle, settings, threads).evaluate(rig)
        progress(0.5)
        return found, verdicts(rig, profiles, settings.body, jit.use_threads(threads))


def detection_range(rig: Rig, plan: RangePlan, threads: int | None) -> DetectionRange:
    """Find the detection ranges of a rig."""
    warm_up(threads)
    return detection_range_of(rig, plan, threads)


@dataclass(frozen=True)
class Redundancy:
    """Coverage of voxels, and of objects where they were counted."""

    rig: Rig
    body: str
    field: EntropyField
    voxels: Coverage
    targets: Coverage | None
    min_points: int

    def document(self) -> dict[str, Any]:
        """Return the figures as plain data."""
        return {
            "riglens": FORMAT_VERSION,
            "body": self.body,
            "note": NO_EVIDENCE,
            "rig": identity_of(self.rig),
            "data": {"source": self.field.data.short_source, "sha256": self.field.data.sha256},
            "voxel_m": self.field.grid.voxel_m,
            "min_points": self.min_points,
            "voxels": coverage_document(self.voxels, "nat"),
            "objects": None if self.targets is None else coverage_document(self.targets, "objects"),
        }


def redundancy_of(
    evaluate: Evaluator,
    rig: Rig,
    counting: TargetSettings,
    with_objects: bool,
    halves: bool,
    monitor: Monitor,
) -> Redundancy:
    """Return a rig's coverage of voxels and, if requested and where there is traffic, of objects; with `halves` also
    the losses by half-blocked sensors."""
    metric, targets = evaluate.settings.metric, None
    evaluate = evaluate.by(replace(evaluate.settings, targets=replace(counting, body=metric.body)))
    assert evaluate.field is not None
    with monitor.stage("Casting rays"):
        voxels = coverage_of(evaluate, rig, "voxels", halves)
    if with_objects and evaluate.traffic is not None:
        with monitor.stage("Counting objects"):
            targets = coverage_of(evaluate, rig, "objects", halves)
    return Redundancy(rig, metric.body or rig.body, evaluate.field, voxels, targets, counting.min_points)


def drawn(
    evaluate: Evaluator, rig: Rig, options: ToleranceOptions, progress: Progress | None = None
) -> tuple[ToleranceResult, dict[str, Any]]:
    """Draw errors of a rig; return how its figures spread, also as plain data."""
    measure, profile = Measures(evaluate, options.sample, rig), profile_called(options.errors)
    found = tolerance(
        rig, profile, measure, options.draws, options.seed, options.sensitivities, progress, measure.frames
    )
    return found, tolerance_document(found, evaluate.settings.metric.body or rig.body)
