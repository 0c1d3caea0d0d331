"""Figures of a rig that tolerances spread: what it sees, and what it gets onto road users."""

from __future__ import annotations

from dataclasses import replace

from riglens.core.engine.caster import IsStale, never_stale
from riglens.core.engine.engine import Engine
from riglens.core.geometry import Pose
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import PAPER_SETTINGS, MetricSettings
from riglens.core.review.tolerance import standing
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import USUAL, TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.mesh import BodyMesh

SEEN, ON_TARGET = "seen", "on_target"


class Measures:
    """Measures rigs one after another: `seen CLASS` by any sensor, and `on_target CLASS` in the first `frames` frames
    of the traffic, where there is any. Shares; more is better. For the thread of the parallel kernels."""

    def __init__(
        self,
        field: EntropyField,
        traffic: Traffic | None,
        settings: MetricSettings = PAPER_SETTINGS,
        mesh: BodyMesh | None = None,
        frames: int | None = None,
        threads: int | None = None,
        targets: TargetSettings = USUAL,
    ) -> None:
        self._engine = Engine(field, threads)
        self._targets = None if traffic is None else TargetEngine(traffic, threads)
        self._settings, self._mesh, self._frames = settings, mesh, frames
        self._how = replace(targets, body=settings.body)

    def __call__(self, rig: Rig, stance: Pose, cancel: IsStale = never_stale) -> dict[str, float]:
        """The figures of a rig whose car stands so; Cancelled as soon as `cancel` returns True."""
        moved = standing(rig, stance)
        scores = self._engine.evaluate(moved, self._settings, False, self._mesh, stance, cancel).scores
        found = {f"{SEEN} {name}": scores.classes[name].any_seen for name in CLASSES}
        if self._targets is not None:
            counts = self._targets.evaluate(moved, self._how, self._frames, self._mesh, stance, cancel)
            for name in CLASSES:
                found[f"{ON_TARGET} {name}"] = counts.classes[name].total.on_target.value
        return found
