"""Scores: every change of rig, scene or settings asks for them, and answers are shown in the order of the edits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt

from riglens.app.evaluation.edit_costs import rays_of
from riglens.app.evaluation.requests import Approximation, EvaluationRequest, Result
from riglens.app.window.feature import Feature
from riglens.app.window.features.baseline import Baseline
from riglens.app.window.features.heat import Heat
from riglens.app.window.features.map import Map
from riglens.app.window.features.pick import Pick
from riglens.app.window.features.scene_data import SceneData

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow


class Scores(Feature):
    """Asks the background thread, and shows what it says unless something newer is shown."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.result: Result | None = None
        self._request: EvaluationRequest | None = None
        self._shown_revision = -1
        self._trailed: Result | None = None
        queued = Qt.ConnectionType.QueuedConnection
        window.recompute.evaluated.connect(self.show_result, queued)
        window.recompute.approximated.connect(self.show_approximation, queued)
        window.recompute.failed.connect(window.report_error, queued)
        window.scores.settings_changed.connect(lambda _: window.settings_changed.emit())
        window.theme_changed.connect(self._show_again)
        window.scene_shown.connect(lambda _: window.scores.set_stale())
        for changed in (window.settings_changed, self.document.rig_changed, self.document.file_changed):
            changed.connect(self.request)
        self.document.rig_changed.connect(self._lengthen_trail)
        self.document.opened.connect(self._forget_trail)

    @property
    def is_current(self) -> bool:
        """Whether the result shown answers the last request, on the scene that was loaded last."""
        result = self.result
        return (
            result is not None
            and result.request is self._request
            and result.scene is self.window.feature(SceneData).loaded
        )

    def request(self) -> None:
        """Ask for scores of the rig as it is; nothing happens when that was asked already."""
        document, heat = self.document, self.window.feature(Heat)
        request = EvaluationRequest(
            document.revision, document.rig, self.window.feature(Baseline).rig, self.window.scores.settings,
            heat.mode, heat.class_name, document.is_dragging, self.window.feature(Map).seen_by,
            self.window.feature(Pick).voxel,
        )  # fmt: skip
        if self._request is not None and self._request.asks_same(request):
            return
        self._request = request
        self.window.scores.set_stale()
        self.window.status.set_updating()
        self.window.recompute.evaluate(request)

    def show_result(self, result: Result) -> None:
        """Show an answer unless a newer one is shown; greyed when the rig has moved on meanwhile."""
        if result.request.revision < self._shown_revision:
            return
        self.result, self._shown_revision = result, result.request.revision
        is_asked = result.request is self._request
        self.window.scores.show_scores(result.evaluation.scores, result.baseline_scores)
        if not is_asked:
            self.window.scores.set_stale()
        self.window.status.show_result(result, is_asked)
        self.viewport.set_heatmap(result.heatmap)
        self._lengthen_trail()
        self.window.result_shown.emit(result)

    def _show_again(self) -> None:
        """The same numbers in the colours of another theme."""
        was_stale = self.window.scores.is_stale
        if self.result is not None:
            self.window.scores.show_scores(self.result.evaluation.scores, self.result.baseline_scores)
            if was_stale:
                self.window.scores.set_stale()

    def _forget_trail(self) -> None:
        """Another rig was opened: its way begins here."""
        self._trailed = None
        self.window.scores.clear_trail()

    def _lengthen_trail(self) -> None:
        """One more edit for the sparklines when none is under way; they start anew with traffic or settings."""
        result = self.result
        if result is None or self.document.is_dragging or not self.is_current:
            return
        last, self._trailed = self._trailed, result
        if last is not None and (last.scene, last.request.settings) != (
            result.scene,
            result.request.settings,
        ):
            self.window.scores.clear_trail()
            last = None
        if last is None or _rays(last) != _rays(result):
            self.window.scores.add_to_trail(result.evaluation.scores)

    def show_approximation(self, first: Approximation) -> None:
        """Show coarse scores, marked as such, unless something newer is shown; the heatmap waits for exact ones."""
        if first.request.revision >= self._shown_revision:
            self._shown_revision = first.request.revision
            self.window.scores.show_estimate(first.scores)
            self.window.status.show_approximation(first)
            self.window.approximation_shown.emit(first)


def _rays(result: Result) -> list[object]:
    """What decides the scores of a rig: its sensors that count, without their names."""
    return [rays_of(sensor) for sensor in result.request.rig.sensors if sensor.enabled]
