"""The score table, with the state of its results and the baseline of changes."""

from __future__ import annotations

from PySide6.QtCore import Qt

from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.core.figures.values import compared_scores, values_of_scores
from riglens.evaluation.requests import Approximation, Result
from riglens.widgets.panels.scores.text import FIGURES_HELP, FIGURES_TITLE
from riglens.widgets.timers import Timers, single_shot

PATIENCE_MS = 1500
"""Time for which figures of an earlier rig stay greyed."""
BUSY = "Computing scores: the first use of a sensor compiles code"


class ScoresShown(Feature):
    """Show the results in the score table, and their state in the status bar."""

    def __init__(self, bench: Workbench, timers: Timers = single_shot) -> None:
        super().__init__(bench)
        self._patience = timers(self, PATIENCE_MS, self._show_busy)
        self._busy = bench.status.add_busy(BUSY)
        self.panel, self.answers = bench.panels.scores, bench.answers
        bench.recompute.failed.connect(bench.report_error, Qt.ConnectionType.QueuedConnection)
        self.answers.asked.connect(self._show_waiting)
        self.answers.answered.connect(self._show)
        self.answers.approximated.connect(self._show_approximation)
        self.answers.forgotten.connect(self._show_busy)
        self.panel.settings_wanted.connect(self.session.set_settings)
        self.panel.help_wanted.connect(
            lambda: bench.dialogs.show_text(bench.window, FIGURES_TITLE, FIGURES_HELP)
        )
        self.session.settings_changed.connect(lambda: self.panel.show_settings(self.session.settings))
        self.session.scene_changed.connect(lambda _: self.panel.set_stale())
        bench.theme_changed.connect(self._show_again)
        self.session.baseline_changed.connect(self._show_baseline)
        self.remember("scores/details", lambda: self.panel.has_details, self.panel.set_details)
        self._show_baseline()

    def _show_baseline(self) -> None:
        pinned = self.session.pinned
        self.panel.set_baseline(pinned.name if pinned is not None else None)

    def _show_waiting(self) -> None:
        self.panel.set_stale()
        if not self._patience.isActive():
            self._patience.start()
        self.bench.status.set_updating()

    def _show_busy(self) -> None:
        """Show no figures of an earlier rig while an answer takes long, as where a kernel is compiled for it."""
        if self.answers.result is not None:
            self.panel.show_pending()
            self._busy.begin()

    def _end_busy(self) -> None:
        self._patience.stop()
        self._busy.end()

    def _show(self, result: Result) -> None:
        """Show an answer; greyed when the rig has moved on meanwhile."""
        self._end_busy()
        is_asked = self.answers.is_last_asked(result)
        self._show_figures(result)
        if not is_asked:
            self.panel.set_stale()
        self.bench.status.show_result(result, is_asked)

    def _show_figures(self, result: Result) -> None:
        self.panel.show_figures("voxels", compared_scores(result.evaluation.scores, result.baseline_scores))

    def _show_approximation(self, first: Approximation) -> None:
        """Show coarse scores, marked as such; the heatmap waits for exact ones."""
        self._end_busy()
        self.panel.show_estimate(values_of_scores(first.scores))
        self.bench.status.show_approximation(first)

    def _show_again(self) -> None:
        """Show the same numbers in the colours of another theme."""
        was_stale, result = self.panel.is_stale, self.answers.result
        if result is not None:
            self._show_figures(result)
            if was_stale:
                self.panel.set_stale()
