"""Measure the figures of a rig that tolerances spread."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

from riglens.core.errors import IsStale, never_stale
from riglens.core.figures.evaluated import Evaluated, EvaluationSettings, Evaluator
from riglens.core.figures.figure import Estimate, Figure
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.registry import tolerated_figures
from riglens.core.geometry import Pose
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import PAPER_SETTINGS, MetricSettings
from riglens.core.review.tolerance import standing
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.settings import USUAL, TargetSettings
from riglens.core.targets.traffic import Traffic


def measured_name(figure: Figure, cls: str) -> str:
    """Return the name of a figure of a class among those measured."""
    return f"{figure.key} {cls}"


class Measures:
    """Measurement of rigs one after another: `KEY CLASS` of the leading figures, those of objects where there is
    traffic.

    With `designed`, objects are counted in the first `frames` frames and in all of them for that rig alone: a figure
    of objects is then its own plus the change that the sample shows, so that the rig as designed has one figure
    everywhere.
    For the thread of the parallel kernels.
    """

    def __init__(
        self,
        field: EntropyField,
        traffic: Traffic | None,
        settings: MetricSettings = PAPER_SETTINGS,
        frames: int | None = None,
        threads: int | None = None,
        targets: TargetSettings = USUAL,
        designed: Rig | None = None,
    ) -> None:
        how = EvaluationSettings(settings, replace(targets, body=settings.body))
        self._evaluate = Evaluator(field, traffic, how, threads)
        self._frames, self._designed = frames, designed
        wanted = tolerated_figures()
        self._of_voxels = tuple(one for one in wanted if one.needs == "voxels")
        self._of_objects = tuple(one for one in wanted if isinstance(one, ObjectFigure))

    @property
    def frames(self) -> tuple[int, int]:
        """Return the number of frames in which objects are counted, and the total."""
        traffic = self._evaluate.traffic
        most = 0 if traffic is None else traffic.frames
        return (most if self._frames is None else min(self._frames, most)), most

    def __call__(self, rig: Rig, stance: Pose, cancel: IsStale = never_stale) -> dict[str, float]:
        """Return the figures of a rig with a stance of its car; Cancelled as soon as `cancel` returns True."""
        evaluated = self._evaluate(standing(rig, stance), ("voxels",), None, stance, cancel)
        found = {
            measured_name(one, cls): one.of(evaluated, cls).value
            for one in self._of_voxels
            for cls in CLASSES
        }
        counted = self.of_objects(rig, stance, cancel)
        return found | {name: estimate.value for name, estimate in counted.items()}

    def of_objects(self, rig: Rig, stance: Pose, cancel: IsStale = never_stale) -> dict[str, Estimate]:
        """Return the figures of objects with the standard errors that the sample adds; nothing without traffic."""
        used, most = self.frames
        if not most:
            return {}
        sample = self._counted(standing(rig, stance), self._frames, stance, cancel)
        found = {}
        for figure in self._of_objects:
            for cls in CLASSES:
                estimate = figure.of(sample, cls)
                if self._designed is not None and used < most:
                    whole, designed = self._as_designed
                    own, added = figure.of(whole, cls), figure.change(sample, designed, cls)
                    estimate = Estimate(min(1.0, max(0.0, own.value + added.value)), added.sample_se)
                found[measured_name(figure, cls)] = estimate
        return found

    @cached_property
    def _as_designed(self) -> tuple[Evaluated, Evaluated]:
        """Count for the rig as designed in all frames, and in the sample."""
        assert self._designed is not None
        return self._counted(self._designed, None), self._counted(self._designed, self._frames)

    def _counted(
        self, rig: Rig, frames: int | None, stance: Pose = Pose(), cancel: IsStale = never_stale
    ) -> Evaluated:
        """Count with the sensors that make the figures: the others would take their time and play no part."""
        kinds = {kind for one in self._of_objects for kind in one.kinds}
        if all(one.kinds for one in self._of_objects):
            rig = rig.only(one for one in rig.sensors if one.enabled and one.kind in kinds)
        return self._evaluate(rig, ("objects",), frames, stance, cancel)
