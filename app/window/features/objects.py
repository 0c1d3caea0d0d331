"""Study > Test objects: which objects beside the car the rig sees, while it is edited; a click looks at one."""

from __future__ import annotations

from PySide6.QtCore import Qt

from riglens.app.background.onlooking import ObjectsJudge, OnlookAnswer, OnlookRequest
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.widgets.panels.objects_dialog import ObjectsDialog


class Objects(Feature):
    """Asks with every change while the list is in sight, and not otherwise."""

    specs = (
        Spec(
            "test_objects", "Test objects…",
            "Which objects of UN R158, FMVSS 111 and the turn assist beside the car the rig sees: geometry only",
            menu="study/rigs",
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench, judge: ObjectsJudge | None = None) -> None:
        super().__init__(bench)
        self.judge = judge or ObjectsJudge(self)
        self.dialog: ObjectsDialog | None = None
        self._asked: OnlookRequest | None = None
        queued = Qt.ConnectionType.QueuedConnection
        self.judge.made.connect(self._take, queued)
        self.judge.failed.connect(bench.report_error, queued)
        bench.closing.connect(self.judge.close)
        self.bind(test_objects=self.open)

    def open(self) -> None:
        """Show the list, and keep it up to date until it is put away."""
        if self.dialog is None:
            self.dialog = ObjectsDialog(self.bench.window)
            self.dialog.chosen.connect(self.viewport.look_at)
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
        rig, mesh = self.document.working_rig, self.session.mesh
        if rig.vehicle.has_mesh_file and mesh is None:
            return
        request = OnlookRequest(rig, self.session.body, mesh)
        if request != self._asked:
            self._asked = request
            self.judge.ask(request)

    def _take(self, answer: OnlookAnswer) -> None:
        """Show an answer; one to an earlier pose too, until the next is there."""
        if self.dialog is not None and self._asked is not None:
            self.dialog.show_verdicts(answer.profiles)
