"""Which test objects beside the car a rig sees, found by a thread of its own with serial kernels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from riglens.app.background.worker import CLOSE_S, Answerer
from riglens.core.metric.scores import Body
from riglens.core.rig.model import Rig
from riglens.core.vehicle.mesh import BodyMesh

if TYPE_CHECKING:  # loads the compiler, which a window that opens does not need
    from riglens.core.review.verdicts import ProfileVerdict


@dataclass(frozen=True)
class OnlookRequest:
    """A rig, whether its car is in the way, and the mesh of the car's file, if it has one."""

    rig: Rig
    body: Body
    mesh: BodyMesh | None


@dataclass(frozen=True)
class OnlookAnswer:
    """What the rig of a request makes of every profile that ships with the program."""

    request: OnlookRequest
    profiles: tuple[ProfileVerdict, ...]


class ObjectsJudge(Answerer[OnlookRequest]):
    """Answers with an OnlookAnswer."""

    def __init__(self, parent: QObject | None = None, close_s: float = CLOSE_S) -> None:
        super().__init__("test objects", parent, close_s)

    def _work(self, request: OnlookRequest) -> None:
        self._tell(OnlookAnswer(request, self._judge(request)))

    def _judge(self, request: OnlookRequest) -> tuple[ProfileVerdict, ...]:
        from riglens.core.review.profiles import bundled_profiles
        from riglens.core.review.verdicts import Onlooker

        onlooker, found = Onlooker(request.rig, request.body, request.mesh), []
        for profile in bundled_profiles():
            self._thread.stop_if_closing()
            found.append(onlooker.verdict(profile))
        return tuple(found)
