"""What is wrong with the mounts of a rig, found by a thread of its own with serial kernels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from riglens.app.background.worker import CLOSE_S, Answerer
from riglens.core.rig.model import Rig
from riglens.core.vehicle.mesh import BodyMesh

if TYPE_CHECKING:  # loads the compiler, which a window that opens does not need
    from riglens.core.review.mounts import Footings, MountLimits, Violation


@dataclass(frozen=True)
class MountRequest:
    """A rig, the mesh of the car's file, if it has one, and what is asked of mounts; None for what usually is."""

    rig: Rig
    mesh: BodyMesh | None
    limits: MountLimits | None


@dataclass(frozen=True)
class MountAnswer:
    """What violates the limits of a request, one line each."""

    request: MountRequest
    violations: tuple[Violation, ...]


class MountChecker(Answerer[MountRequest]):
    """Answers with a MountAnswer; of a rig in which one sensor moves, only that one is looked at anew."""

    def __init__(self, parent: QObject | None = None, close_s: float = CLOSE_S) -> None:
        super().__init__("mounts", parent, close_s)
        self._footings: Footings | None = None

    def _work(self, request: MountRequest) -> None:
        from riglens.core.review.mounts import USUAL_LIMITS, Footings, violations

        self._footings = self._footings or Footings()
        found = violations(request.rig, request.limits or USUAL_LIMITS, request.mesh, self._footings)
        self._tell(MountAnswer(request, found))
