"""What the rig loses without each of its sensors: exact scores, computed when nobody edits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt

from riglens.app.background.side_jobs import SideAnswer, SideRequest
from riglens.app.evaluation.requests import Result
from riglens.app.window.feature import Feature
from riglens.app.window.features.scores import Scores as ScoresFeature
from riglens.core.metric.scores import Scores
from riglens.core.rig.edits import with_enabled
from riglens.core.rig.model import Rig
from riglens.widgets.panels.inspector.marginal_view import NOT_COUNTED, WAITING

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow

GROUP = "marginal"


class Marginals(Feature):
    """Asks for the rig without each sensor after every exact answer, and forgets it with the next edit.

    `losses` are the scores without a sensor that are known by now, of the rig in `result`.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.result: Result | None = None
        self.losses: dict[str, Scores] = {}
        queued = Qt.ConnectionType.QueuedConnection
        window.recompute.side_answered.connect(self._take, queued)
        window.result_shown.connect(lambda _: self._start())
        window.rig_shown.connect(self._show_selected)
        window.scene_shown.connect(lambda _: self._forget())
        window.settings_changed.connect(self._drop_if_changed)
        window.theme_changed.connect(lambda _: self._show_all())
        for slot in (self._drop_if_changed, self._start):
            self.document.rig_changed.connect(slot)

    # ------------------------------------------------------------------ asking
    def _start(self) -> None:
        """Ask for everything anew once an edit is over and scored, unless it is known."""
        scores = self.window.feature(ScoresFeature)
        result = scores.result
        if result is None or self.document.is_dragging or not scores.is_current or self._knows(result):
            return
        request = result.request
        self._forget()
        self.result = result
        names = [sensor.name for sensor in request.rig.sensors if sensor.enabled]
        names.sort(key=lambda name: name != self.document.selected)
        self.window.recompute.ask_aside(
            [
                SideRequest(GROUP, name, with_enabled(request.rig, (name,), False), request.settings)
                for name in names
            ]
        )

    def _knows(self, result: Result) -> bool:
        known = self.result
        return (
            known is not None
            and known.scene is result.scene
            and known.request.settings == result.request.settings
            and _same_sensors(known.request.rig, result.request.rig)
        )

    def _drop_if_changed(self) -> None:
        """Give up what belongs to another rig or to other settings."""
        if self.result is not None and (
            not _same_sensors(self.result.request.rig, self.document.rig)
            or self.result.request.settings != self.window.scores.settings
        ):
            self._forget()

    def _forget(self) -> None:
        self.window.recompute.forget_aside(GROUP)
        self.result = None
        self.losses = {}
        self.window.tree.set_losses_stale()
        self.window.inspector.set_loss_stale()

    # ------------------------------------------------------------------ answers
    def _take(self, answer: SideAnswer) -> None:
        request, result = answer.request, self.result
        if request.group != GROUP or result is None or answer.scene is not result.scene:
            return
        is_present = request.settings == result.request.settings
        if not is_present or request.rig != with_enabled(result.request.rig, (request.name,), False):
            return
        self.losses[request.name] = answer.scores
        self._show_all()

    def _show_all(self) -> None:
        """Show what is known in the list, and of the selected sensor in the inspector."""
        if self.result is not None:
            self.window.tree.show_losses(self.result.evaluation.scores, self.losses)
        self._show_selected()

    def _show_selected(self) -> None:
        """Show the loss of the selected sensor in the inspector, or why there is none."""
        name, inspector = self.document.selected, self.window.inspector
        if name is None:
            return
        if not self.document.rig.sensor(name).enabled:
            inspector.show_no_loss(NOT_COUNTED)
        elif self.result is not None and name in self.losses:
            inspector.show_loss(self.result.evaluation.scores, self.losses[name])
        elif name != self._greyed():
            inspector.show_no_loss(WAITING)

    def _greyed(self) -> str | None:
        """The sensor whose numbers of an earlier rig are still shown, greyed."""
        return self.window.inspector.loss_of


def _same_sensors(one: Rig, other: Rig) -> bool:
    return one is other or one.sensors == other.sensors
