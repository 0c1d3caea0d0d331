"""What the engine's thread computes while nobody edits: scores of other rigs, ray audits, tolerances."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from riglens.app.background.queue import BackgroundRequest
from riglens.app.evaluation.requests import LoadedScene
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Rig

if TYPE_CHECKING:  # made by the engine's thread, which loads the compiler
    from riglens.core.review.tolerance import ToleranceProfile, ToleranceResult
    from riglens.core.targets.settings import TargetSettings
    from riglens.core.targets.traffic import Traffic
    from riglens.core.vehicle.mesh import BodyMesh

EMIT_EVERY = 4
"""Progress of tolerances is emitted after so many steps."""


@dataclass(frozen=True)
class RigInScene(BackgroundRequest):
    """A rig on a scene, with the settings of the metric."""

    rig: Rig
    settings: MetricSettings
    scene: LoadedScene


class ScoreRequest(RigInScene):
    """Answered by the exact Scores; None if the scene is no longer the one in use."""


@dataclass(frozen=True)
class AuditRequest(RigInScene):
    """Answered by the RigAudit: where the rays end. `mesh` is that of the vehicle's file, if it has one."""

    mesh: BodyMesh | None = None


@dataclass(frozen=True, kw_only=True)
class ToleranceRequest(RigInScene):
    """Answered step by step by ToleranceProgress; objects are counted in the first frames of `traffic`, if any."""

    profile: ToleranceProfile
    draws: int
    targets: TargetSettings
    traffic: Traffic | None = None
    mesh: BodyMesh | None = None

    def asks_same(self, other: ToleranceRequest) -> bool:
        """Whether the answer to both is the same."""
        is_same = self.scene is other.scene and self.traffic is other.traffic and self.mesh is other.mesh
        wanted = (self.rig, self.profile, self.draws, self.settings, self.targets)
        return is_same and wanted == (other.rig, other.profile, other.draws, other.settings, other.targets)


@dataclass(frozen=True)
class ToleranceProgress:
    """What is known after `done` of `steps` measurements; `result` is None before there is a draw."""

    done: int
    steps: int
    result: ToleranceResult | None

    @property
    def is_whole(self) -> bool:
        """Whether every measurement was made."""
        return self.done == self.steps

    @property
    def is_due(self) -> bool:
        """Whether this is to be emitted: now and then, and at the end."""
        return self.is_whole or self.done % EMIT_EVERY == 0
