"""Rigs to score when nobody waits for the rig being edited: what a sensor is worth, rigs to compare."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from riglens.app.evaluation.requests import LoadedScene
from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.rig.model import Rig

if TYPE_CHECKING:  # made by the engine's thread, which loads the compiler
    from riglens.core.engine.audit import RigAudit
    from riglens.core.review.tolerance import ToleranceProfile, ToleranceResult
    from riglens.core.targets.settings import TargetSettings
    from riglens.core.targets.traffic import Traffic
    from riglens.core.vehicle.mesh import BodyMesh

SIDE_REST_S = 0.25
"""Side jobs begin when nothing was asked for so long, so that they never run between two moves of a drag."""


@dataclass(frozen=True)
class SideRequest:
    """One rig to score; `group` says who asks, and `name` which of its rigs this is."""

    group: str
    name: str
    rig: Rig
    settings: MetricSettings

    @property
    def key(self) -> tuple[str, str]:
        """What makes a newer request take the place of this one."""
        return self.group, self.name


@dataclass(frozen=True)
class SideAnswer:
    """The exact scores of one rig on a scene."""

    request: SideRequest
    scene: LoadedScene
    scores: Scores
    elapsed_ms: float


@dataclass(frozen=True)
class AuditRequest:
    """A rig whose rays are to be followed on the scene; a newer one takes its place."""

    rig: Rig
    settings: MetricSettings
    scene: LoadedScene
    mesh: BodyMesh | None = None
    group: str = "audit"

    @property
    def key(self) -> tuple[str, str]:
        """What makes a newer request take the place of this one."""
        return self.group, ""


@dataclass(frozen=True)
class AuditAnswer:
    """Where the rays of the rig go; None where they could not be followed."""

    request: AuditRequest
    found: RigAudit | None


@dataclass(frozen=True)
class ToleranceRequest:
    """A rig whose figures are to be measured under drawn errors, a step at a time; a newer one takes its place.

    Road users are counted in the first frames of `traffic`, where there is any.
    """

    rig: Rig
    profile: ToleranceProfile
    draws: int
    settings: MetricSettings
    targets: TargetSettings
    scene: LoadedScene
    traffic: Traffic | None = None
    mesh: BodyMesh | None = None
    group: str = "tolerance"

    @property
    def key(self) -> tuple[str, str]:
        """What makes a newer request take the place of this one."""
        return self.group, ""

    def asks_same(self, other: ToleranceRequest) -> bool:
        """Whether the answer to both is the same."""
        is_same = self.scene is other.scene and self.traffic is other.traffic and self.mesh is other.mesh
        wanted = (self.rig, self.profile, self.draws, self.settings, self.targets)
        return is_same and wanted == (other.rig, other.profile, other.draws, other.settings, other.targets)


@dataclass(frozen=True)
class ToleranceAnswer:
    """What is known of one request after `done` of `steps` measurements; None before there is a draw."""

    request: ToleranceRequest
    done: int
    steps: int
    result: ToleranceResult | None

    @property
    def is_whole(self) -> bool:
        """Whether every measurement was made."""
        return self.done == self.steps


SideJob = SideRequest | AuditRequest | ToleranceRequest


class SideQueue:
    """Requests in the order of asking, due when nothing was asked for `SIDE_REST_S` by the clock.

    Not safe by itself: its owner holds a lock around every call.
    """

    def __init__(self, now_s: Callable[[], float]) -> None:
        self._now_s = now_s
        self._waiting: dict[tuple[str, str], SideJob] = {}
        self._asked_s = now_s()

    def ask(self, request: SideJob) -> None:
        """Add a request; one of the same key is dropped."""
        self._waiting.pop(request.key, None)
        self._waiting[request.key] = request

    def forget(self, group: str) -> None:
        """Drop every request of a group."""
        self._waiting = {key: request for key, request in self._waiting.items() if request.group != group}

    def postpone(self) -> None:
        """Somebody edits: start the rest anew."""
        self._asked_s = self._now_s()

    def first_due(self) -> SideJob | None:
        """The request to answer now, None while there is none; it stays in the queue until `done`."""
        due_s = self.due_s()
        return next(iter(self._waiting.values())) if due_s is not None and due_s <= self._now_s() else None

    def wants(self, request: SideJob) -> bool:
        """Whether this very request is still wanted."""
        return self._waiting.get(request.key) is request

    def put_off(self, request: SideJob) -> None:
        """Let all others go first, if the request is still wanted."""
        if self.wants(request):
            self.ask(request)

    def done(self, request: SideJob) -> None:
        """The request was answered."""
        if self.wants(request):
            del self._waiting[request.key]

    def due_s(self) -> float | None:
        """When the first request is due, by the clock; None if there is none."""
        return self._asked_s + SIDE_REST_S if self._waiting else None
