"""The card of the rig being edited, made by a thread of its own with serial kernels, with progress and an end."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import QObject, Signal

from riglens.app.background.worker import CLOSE_S, Answerer, Unwanted
from riglens.core.rig.model import Rig
from riglens.core.targets.card import Card, CardPlan
from riglens.core.vehicle.mesh import BodyMesh


@dataclass(frozen=True)
class CardRequest:
    """A rig, what its card is to say, and the mesh of the vehicle's file, if it has one."""

    rig: Rig
    plan: CardPlan
    mesh: BodyMesh | None = None


@dataclass(frozen=True)
class CardAnswer:
    """The card of a request."""

    request: CardRequest
    card: Card


class CardMaker(Answerer[CardRequest]):
    """Answers with a CardAnswer; a newer wish ends the work for an older one."""

    progressed = Signal(object, float)
    """A CardRequest, and the share of it that is done."""

    def __init__(self, parent: QObject | None = None, close_s: float = CLOSE_S) -> None:
        super().__init__("card", parent, close_s)
        self._given_up: CardRequest | None = None

    def give_up(self, request: CardRequest) -> None:
        """Want a card no more that was asked for."""
        self._given_up = request

    # ------------------------------------------------------------------ the thread
    def _work(self, wish: CardRequest) -> None:
        from riglens.core.targets.card_making import card_of  # loads the compiler: not while the window opens

        def progress(share: float) -> None:
            if self._given_up is wish or self._thread.inbox.is_stale():
                raise Unwanted
            self.progressed.emit(wish, share)

        self._tell(
            CardAnswer(wish, card_of(wish.rig, wish.plan, is_serial=True, progress=progress, mesh=wish.mesh))
        )
