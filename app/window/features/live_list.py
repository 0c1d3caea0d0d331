"""A dialog with a list that follows the rig while it is in sight, and costs nothing otherwise."""

from __future__ import annotations

from typing import Generic, TypeVar

from PySide6.QtCore import Qt

from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.widgets.panels.controls.list_dialog import ListDialog

Shown = TypeVar("Shown", bound=ListDialog)
Request = TypeVar("Request")
Answer = TypeVar("Answer")


class LiveList(Feature, Generic[Shown, Request, Answer]):
    """Asks a thread with every change while the dialog is in sight; the same is not asked twice."""

    def __init__(self, bench: Workbench, worker: BackgroundWorker[Request, Answer]) -> None:
        super().__init__(bench)
        self.dialog: Shown | None = None
        self._worker = worker
        self._asked: Request | None = None
        queued = Qt.ConnectionType.QueuedConnection
        worker.answered.connect(self._take, queued)
        worker.failed.connect(bench.report_error, queued)
        bench.closing.connect(worker.close)

    def open(self) -> None:
        """Show the list, and keep it up to date until it is put away."""
        if self.dialog is None:
            self.dialog = self._make_dialog()
            self.dialog.put_away.connect(self._rest)
        if not self.dialog.isVisible():
            self.session.asked_changed.connect(self._ask)
        self.dialog.show()
        self.dialog.raise_()
        self._ask()

    def _rest(self) -> None:
        self.session.asked_changed.disconnect(self._ask)
        self._asked = None

    def _ask(self) -> None:
        """Ask, unless the same was asked, or the mesh of the car's file is not there yet."""
        if self.document.rig.vehicle.has_mesh_file and self.session.mesh is None:
            return
        request = self._request()
        if request != self._asked:
            self._asked = request
            self._worker.ask(request)

    def _take(self, _: Request, answer: Answer) -> None:
        """Show an answer; one to an earlier pose too, until the next is there."""
        if self.dialog is not None and self._asked is not None:
            self._show(answer)

    # ---- what a list is of

    def _make_dialog(self) -> Shown:
        raise NotImplementedError

    def _request(self) -> Request:
        """What is asked of the rig of now."""
        raise NotImplementedError

    def _show(self, answer: Answer) -> None:
        raise NotImplementedError
