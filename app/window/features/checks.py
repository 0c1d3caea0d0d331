"""Pages of the Checks dock: each has an action that brings it up, and costs nothing while it is out of sight."""

from __future__ import annotations

from typing import Generic, TypeVar

from PySide6.QtWidgets import QWidget

from riglens.app.background.worker import BackgroundWorker
from riglens.app.window.actions import Spec
from riglens.app.window.docks import InSight
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench

DOCK = "Checks"
Page = TypeVar("Page", bound=QWidget)
Request = TypeVar("Request")
Answer = TypeVar("Answer")


def check_spec(key: str, title: str, tip: str) -> Spec:
    """Make the action that shows the page of a check."""
    return Spec(key, title, tip, menu="study/checks")


def add_check(bench: Workbench, key: str, page: QWidget) -> InSight:
    """Add the page of a check to the dock, under the title of its action."""
    checks, action = bench.panels.checks, bench.actions[key]
    checks.add(action.text(), page)

    def show() -> None:
        checks.choose(page)
        bench.docks.bring_up(DOCK)

    bench.actions.bind(**{key: show})
    return InSight(bench.docks[DOCK], page).turn_with(checks.page_changed)


class LiveCheck(Feature, Generic[Page, Request, Answer]):
    """Check in a background thread after every change while its page is visible; the same is not requested twice."""

    def __init__(
        self, bench: Workbench, key: str, page: Page, worker: BackgroundWorker[Request, Answer]
    ) -> None:
        super().__init__(bench)
        self.page = page
        self._worker = worker
        self._asked: Request | None = None
        self.serve(worker, self._take)
        self.in_sight = add_check(bench, key, page)
        self.in_sight.follow(self._ask, self.session.request_changed)
        self.in_sight.changed.connect(self._turn)

    def _turn(self, is_seen: bool) -> None:
        if not is_seen:
            self._asked = None

    def _ask(self) -> None:
        """Submit the request, unless the page is hidden, the request is the same, or the mesh of the car's file is
        missing."""
        if not self.in_sight or self.session.rig.vehicle.lacks_mesh:
            return
        request = self._request()
        if request != self._asked:
            self._asked = request
            self._worker.ask(request)

    def _take(self, _: Request, answer: Answer) -> None:
        """Show a result; also one for an earlier pose, until the next arrives."""
        if self._asked is not None:
            self._show(answer)

    # ---- what a check is of

    def _request(self) -> Request:
        """Return the request for the current rig."""
        raise NotImplementedError

    def _show(self, answer: Answer) -> None:
        raise NotImplementedError
