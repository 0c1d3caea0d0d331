"""The result that is shown: requests scores after every change of the session and drops stale answers."""

from __future__ import annotations

from PySide6.QtCore import QObject, Qt, Signal

from riglens.app.background.recompute import Recompute
from riglens.app.session.session import Session
from riglens.evaluation.requests import Approximation, EvaluationRequest, Result


class ResultStore(QObject):
    """Store that requests scores after every change of the session and keeps the last result, in the order of the
    edits.

    Nothing is requested before `ask` was called once.
    """

    asked = Signal()
    """Something new was requested: the result that is shown is out of date."""
    answered = Signal(object)
    """An exact Result; it may belong to an earlier rig while the mouse moves on."""
    approximated = Signal(object)
    """An Approximation to show until the exact Result arrives."""
    forgotten = Signal()
    """Another rig was opened: nothing that is shown is about it, and answers on the one before are dropped."""

    def __init__(self, session: Session, recompute: Recompute) -> None:
        super().__init__()
        self._session = session
        self._recompute = recompute
        self._request: EvaluationRequest | None = None
        self._shown_revision = -1
        self.result: Result | None = None
        """The last exact result that was emitted."""
        queued = Qt.ConnectionType.QueuedConnection
        recompute.evaluated.connect(self.take, queued)
        recompute.approximated.connect(self.take_approximation, queued)
        session.request_changed.connect(self._ask_again)
        session.document.opened.connect(self._forget)

    @property
    def is_current(self) -> bool:
        """Return whether the result answers the last request, on the scene that was loaded last."""
        result = self.result
        return result is not None and self.is_last_asked(result) and result.scene is self._session.scene

    def is_last_asked(self, result: Result) -> bool:
        """Return whether a result answers the last request."""
        return result.request is self._request

    def ask(self) -> None:
        """Submit the session's request, unless that was done already."""
        request = self._session.request()
        if request == self._request:
            return
        self._request = request
        self.asked.emit()
        self._recompute.evaluate(request)

    def _ask_again(self) -> None:
        if self._request is not None:
            self.ask()

    def _forget(self) -> None:
        """Drop what is known of the rig before, unless the one opened has the same answer."""
        if self._request is not None and self._session.request() != self._request:
            self._shown_revision = self._session.document.revision + 1  # opening counts as the next
            self.forgotten.emit()

    def take(self, result: Result) -> None:
        """Emit a result unless it is stale."""
        if result.request.revision >= self._shown_revision:
            self.result, self._shown_revision = result, result.request.revision
            self.answered.emit(result)

    def take_approximation(self, first: Approximation) -> None:
        """Emit a coarse result unless it is stale."""
        if first.request.revision >= self._shown_revision:
            self._shown_revision = first.request.revision
            self.approximated.emit(first)
