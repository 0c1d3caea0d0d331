"""The score table, and the baseline that its changes count from."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMenu

from riglens.app.evaluation.requests import Approximation, Result
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.files import Exchange
from riglens.app.window.settings import Settings
from riglens.app.window.workbench import Workbench
from riglens.core.rig.presets import PRESETS, preset
from riglens.widgets.panels.controls.menus import add_entry
from riglens.widgets.panels.scores.text import FIGURES_HELP, FIGURES_TITLE


class Baseline(Feature):
    """Pins rigs: the baseline of the session is the last saved rig unless another is pinned."""

    specs = (
        Spec(
            "pin", "Pin as baseline", "Count all changes of the scores from the rig as it is now", "Ctrl+B", "pin",
            "study/rigs",
        ),
        Spec("pin_file", "Baseline from file…", "Count all changes from a rig file", "Ctrl+Alt+B", menu="study/rigs"),
        Spec(
            "unpin", "Unpin the baseline", "Count all changes from the rig as last saved again",
            "Ctrl+Shift+B", "", "study/rigs",
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench, exchange: Exchange) -> None:
        super().__init__(bench)
        self._exchange = exchange
        self.bind(pin=self.pin, pin_file=self._choose_file, unpin=self.unpin)
        presets = self._preset_menu()
        bench.places.add_to_menu("study/rigs", presets)
        menu = QMenu(bench.panels.scores)
        for entry in (self.actions["pin"], self.actions["pin_file"], self.actions["unpin"]):
            menu.addAction(entry)
        menu.addMenu(presets)
        bench.panels.scores.set_pin_menu(menu)
        bench.panels.scores.pin_wanted.connect(lambda wanted: self.pin() if wanted else self.unpin())
        self.session.baseline_changed.connect(self._show)
        self._show()

    def pin(self) -> None:
        """Make the rig being edited the baseline."""
        self.session.pin(self.document.rig)

    def unpin(self) -> None:
        """Make the last saved rig the baseline again."""
        self.session.pin(None)

    def _show(self) -> None:
        pinned = self.session.pinned
        self.bench.panels.scores.set_baseline(pinned.name if pinned is not None else None)
        self.actions["unpin"].setEnabled(pinned is not None)

    def _choose_file(self) -> None:
        folder = self.document.path.parent if self.document.path is not None else None
        path = self.bench.dialogs.open_rig(self.bench.window, folder)
        if path is not None:
            self.bench.guarded(lambda: self.session.pin(self._exchange.rig_of(path)))()

    def _preset_menu(self) -> QMenu:
        menu = QMenu("Baseline from preset", self.bench.window)
        for name, found in PRESETS.items():
            add_entry(menu, found.title, partial(self._pin_preset, name))
        return menu

    def _pin_preset(self, name: str) -> None:
        self.session.pin(preset(name))


class ScoresShown(Feature):
    """Shows the answers in the score table, and says in the status bar how far they are."""

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.panel, self.answers = bench.panels.scores, bench.answers
        bench.recompute.failed.connect(bench.report_error, Qt.ConnectionType.QueuedConnection)
        self.answers.asked.connect(self._show_waiting)
        self.answers.answered.connect(self._show)
        self.answers.approximated.connect(self._show_approximation)
        self.panel.settings_wanted.connect(self.session.set_settings)
        self.panel.help_wanted.connect(
            lambda: bench.dialogs.show_text(bench.window, FIGURES_TITLE, FIGURES_HELP)
        )
        self.session.settings_changed.connect(lambda: self.panel.show_settings(self.session.settings))
        self.session.scene_changed.connect(lambda _: self.panel.set_stale())
        bench.theme_changed.connect(self._show_again)

    def _show_waiting(self) -> None:
        self.panel.set_stale()
        self.bench.status.set_updating()

    def _show(self, result: Result) -> None:
        """Show an answer; greyed when the rig has moved on meanwhile."""
        is_asked = self.answers.is_last_asked(result)
        self.panel.show_scores(result.evaluation.scores, result.baseline_scores)
        if not is_asked:
            self.panel.set_stale()
        self.bench.status.show_result(result, is_asked)

    def _show_approximation(self, first: Approximation) -> None:
        """Show coarse scores, marked as such; the heatmap waits for exact ones."""
        self.panel.show_estimate(first.scores)
        self.bench.status.show_approximation(first)

    def _show_again(self) -> None:
        """Show the same numbers in the colours of another theme."""
        was_stale, result = self.panel.is_stale, self.answers.result
        if result is not None:
            self.panel.show_scores(result.evaluation.scores, result.baseline_scores)
            if was_stale:
                self.panel.set_stale()

    def restore(self, settings: Settings) -> None:
        self.panel.set_details(settings.read("scores/details", False))

    def keep(self, settings: Settings) -> None:
        settings.write("scores/details", self.panel.has_details)
