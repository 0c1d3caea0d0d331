"""Measure the figures of a rig that tolerances spread: its coverage, and its hits on objects."""

from __future__ import annotations

from dataclasses import replace

from riglens.core.engine.engine import Engine
from riglens.core.errors import IsStale, never_stale
from riglens.core.geometry import Pose
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import PAPER_SETTINGS, MetricSettings
from riglens.core.review.tolerance import standing
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.scores import Estimate, Groups, TargetScores
from riglens.core.targets.settings import USUAL, TargetSettings
from riglens.core.targets.traffic import Traffic

SEEN, ON_TARGET = "seen", "on_target"


class Measures:
    """Measurement of rigs one after another: `seen CLASS` by any sensor and, where there is traffic, `on_target CLASS`.

    With `designed`, objects are counted in the first `frames` frames and in all of them for that rig alone: `on_target`
    is then its figure plus the change that the sample shows, so that the rig as designed has one figure everywhere.
    Shares; more is better. For the thread of the parallel kernels.
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
        self._engine = Engine(field, threads)
        self._targets = None if traffic is None else TargetEngine(traffic, threads)
        self._settings, self._frames = settings, frames
        self._how = replace(targets, body=settings.body)
        self._designed = designed
        self._base: tuple[TargetScores, TargetScores] | None = None

    @property
    def frames(self) -> tuple[int, int]:
        """Return the number of frames in which objects are counted, and the total."""
        most = 0 if self._targets is None else self._targets.traffic.frames
        return (most if self._frames is None else min(self._frames, most)), most

    def __call__(self, rig: Rig, stance: Pose, cancel: IsStale = never_stale) -> dict[str, float]:
        """Return the figures of a rig with a stance of its car; Cancelled as soon as `cancel` returns True."""
        moved = standing(rig, stance)
        scores = self._engine.evaluate(moved, self._settings, False, stance, cancel).scores
        found = {f"{SEEN} {name}": scores.classes[name].any_seen for name in CLASSES}
        counted = self.on_target(rig, stance, cancel)
        return found | {name: estimate.value for name, estimate in counted.items()}

    def on_target(self, rig: Rig, stance: Pose, cancel: IsStale = never_stale) -> dict[str, Estimate]:
        """Return `on_target CLASS` and the standard error that the sample adds to it; nothing without traffic."""
        if self._targets is None:
            return {}
        used, most = self.frames
        whole = sample = None
        if self._designed is not None and used < most:
            whole, sample = self._base = self._base or self._counts_as_designed(self._designed, cancel)
        moved = standing(rig, stance).with_lidars_alone()  # pixels take most of the time and play no part
        counts = self._targets.evaluate(moved, self._how, self._frames, stance, cancel)
        totals = {name: counts.classes[name].total.on_target for name in CLASSES}
        if whole is not None and sample is not None:
            change = counts.objects.on_target - sample.objects.on_target
            for name, added in Groups(self._targets.traffic, used).means_by_class(change).items():
                own = whole.classes[name].total.on_target
                totals[name] = Estimate(min(1.0, max(0.0, own.value + added.value)), added.se)
        return {f"{ON_TARGET} {name}": total for name, total in totals.items()}

    def _counts_as_designed(self, rig: Rig, cancel: IsStale) -> tuple[TargetScores, TargetScores]:
        """Count for the rig as designed in all frames, and in the sample."""
        assert self._targets is not None
        whole, sample = (
            self._targets.evaluate(rig.with_lidars_alone(), self._how, frames, cancel=cancel)
            for frames in (None, self._frames)
        )
        return whole, sample
