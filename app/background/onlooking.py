"""Which test objects beside the car a rig sees, found by a thread of its own with serial kernels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from riglens.app.background.inbox import unexpected
from riglens.app.background.worker import CLOSE_S, LatestThread, Unwanted
from riglens.core.errors import InputError
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


class ObjectsJudge(QObject):
    """Owner of the thread, which starts with the first request; every method is called by the interface thread."""

    judged = Signal(object)
    """An OnlookAnswer."""
    failed = Signal(str)

    def __init__(self, parent: QObject | None = None, close_s: float = CLOSE_S) -> None:
        super().__init__(parent)
        self._thread = LatestThread[OnlookRequest]("onlooking", self._answer, close_s)

    def ask(self, request: OnlookRequest) -> None:
        """Ask what a rig sees; takes the place of a request that still waits."""
        self._thread.ask(request)

    def close(self) -> None:
        """End the thread, or leave it to itself when it takes too long."""
        self._thread.close()

    def wait_until_idle(self, timeout_s: float = 60.0) -> bool:
        """Block until nothing waits or runs; False on timeout. Answers may still be queued as Qt events."""
        return self._thread.wait_until_idle(timeout_s)

    # ------------------------------------------------------------------ the thread
    def _answer(self, request: OnlookRequest) -> None:
        try:
            found = self._judge(request)
        except InputError as error:
            self._fail(str(error))
        except Unwanted:
            raise
        except Exception as error:
            self._fail(unexpected("test objects", error))
        else:
            self._thread.stop_if_closing()
            self.judged.emit(OnlookAnswer(request, found))

    def _judge(self, request: OnlookRequest) -> tuple[ProfileVerdict, ...]:
        from riglens.core.review.profiles import bundled_profiles
        from riglens.core.review.verdicts import Onlooker

        onlooker, found = Onlooker(request.rig, request.body, request.mesh), []
        for profile in bundled_profiles():
            self._thread.stop_if_closing()
            found.append(onlooker.verdict(profile))
        return tuple(found)

    def _fail(self, reason: str) -> None:
        if not self._thread.inbox.is_closing():  # nobody hears it any more, and the signals may be gone
            self.failed.emit(reason)
