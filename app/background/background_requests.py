"""Background computations of the engine's thread: scores of other rigs, ray audits, tolerances, and the base of
coarse answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from riglens.app.background.queue import BackgroundRequest
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Rig
from riglens.evaluation.requests import LoadedScene

if TYPE_CHECKING:  # made by the engine's thread, which loads the compiler
    from riglens.core.review.tolerance import ToleranceProfile, ToleranceResult
    from riglens.core.targets.settings import TargetSettings
    from riglens.core.targets.traffic import Traffic

LEARN = BackgroundRequest("coarse answers", "")
"""Base coarse answers on exact ones from now on, also on the last one; without an answer."""
EMIT_EVERY = 4
"""Steps between two progress reports of a tolerance."""


@dataclass(frozen=True)
class RigInScene(BackgroundRequest):
    """A rig on a scene, with the settings of the metric."""

    rig: Rig
    settings: MetricSettings
    scene: LoadedScene


class ScoreRequest(RigInScene):
    """Request for the exact Scores; None if the scene is no longer in use."""


@dataclass(frozen=True)
class AuditRequest(RigInScene):
    """Answered by the RigAudit: where the rays end."""


@dataclass(frozen=True, kw_only=True)
class ToleranceRequest(RigInScene):
    """Request for a tolerance analysis, answered step by step by ToleranceProgress; objects are counted in the first
    frames of `traffic`, if any."""

    profile: ToleranceProfile
    draws: int
    targets: TargetSettings
    traffic: Traffic | None = None


@dataclass(frozen=True)
class ToleranceProgress:
    """Progress of a tolerance: `done` of `steps` measurements; `result` is None before the first draw."""

    done: int
    steps: int
    result: ToleranceResult | None

    @property
    def is_whole(self) -> bool:
        """Return whether every measurement is complete."""
        return self.done == self.steps

    @property
    def is_due(self) -> bool:
        """Return whether to emit this progress: at intervals, and at the end."""
        return self.is_whole or self.done % EMIT_EVERY == 0
