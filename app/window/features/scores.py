"""The score table, the baseline that its changes count from, and what the rig loses without each sensor."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QMenu

from riglens.app.background.side_jobs import SideAnswer, SideRequest
from riglens.app.evaluation.requests import Approximation, LoadedScene, Result
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.files import Exchange
from riglens.app.window.workbench import Workbench
from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.rig.edits import with_enabled
from riglens.core.rig.model import Rig, rays_of
from riglens.core.rig.presets import PRESETS, preset
from riglens.core.view.outlook import looks_into
from riglens.widgets.maps.map_items import NO_BOXES
from riglens.widgets.panels.inspector.marginal_view import NOT_COUNTED, WAITING
from riglens.widgets.panels.menus import add_entry
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
        self._trailed: Result | None = None
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
        self.document.rig_settled.connect(self._lengthen_trail)
        self.document.opened.connect(self._forget_trail)

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
        self._lengthen_trail()

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

    def _forget_trail(self) -> None:
        """Another rig was opened: its trail begins here."""
        self._trailed = None
        self.panel.clear_trail()

    def _lengthen_trail(self) -> None:
        """Add an edit to the sparklines when none is under way; they start anew with traffic or settings."""
        result = self.answers.result
        if result is None or self.document.is_dragging or not self.answers.is_current:
            return
        last, self._trailed = self._trailed, result
        if last is not None and _traffic(last) != _traffic(result):
            self.panel.clear_trail()
            last = None
        if last is None or _rays(last) != _rays(result):
            self.panel.add_to_trail(result.evaluation.scores)


def _traffic(result: Result) -> tuple[LoadedScene, MetricSettings]:
    """What scores must have in common to be of one trail."""
    return result.scene, result.request.settings


def _rays(result: Result) -> list[object]:
    """What decides the scores of a rig: its sensors that count, without their names."""
    return [rays_of(sensor) for sensor in result.request.rig.sensors if sensor.enabled]


GROUP = "marginal"


class Marginals(Feature):
    """Asks for the rig without each sensor after every exact answer, and forgets it with the next edit.

    `losses` are the scores without a sensor that are known by now, of the rig in `result`.
    """

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.answers = bench.answers
        self.result: Result | None = None
        self.losses: dict[str, Scores] = {}
        queued = Qt.ConnectionType.QueuedConnection
        bench.recompute.side_answered.connect(self._take, queued)
        self.answers.answered.connect(lambda _: self._start())
        self.session.scene_changed.connect(lambda _: self._forget())
        self.session.settings_changed.connect(self._drop_if_changed)
        bench.theme_changed.connect(lambda _: self._show_all())
        self.document.rig_changed.connect(self._on_rig)
        self.document.selection_changed.connect(self._show_selected)
        self._show_selected()

    def _on_rig(self) -> None:
        """Give up what was known before an edit, and ask anew once it is over."""
        self._drop_if_changed()
        self._start()
        self._show_selected()

    # ------------------------------------------------------------------ asking
    def _start(self) -> None:
        """Ask for everything anew once an edit is over and scored, unless it is known."""
        result = self.answers.result
        if result is None or self.document.is_dragging or not self.answers.is_current:
            return
        if self._knows(result):
            return
        request = result.request
        self._forget()
        self.result = result
        names = [sensor.name for sensor in request.rig.sensors if sensor.enabled]
        names.sort(key=lambda name: name != self.document.selected)
        self.bench.recompute.ask_aside(
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
            or self.result.request.settings != self.session.settings
        ):
            self._forget()

    def _forget(self) -> None:
        self.bench.recompute.forget_aside(GROUP)
        self.result = None
        self.losses = {}
        self.bench.panels.tree.set_losses_stale()
        self.bench.panels.inspector.set_loss_stale()

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
            tree, elsewhere = self.bench.panels.tree, self._looking_elsewhere()
            tree.show_losses(self.result.evaluation.scores, self.losses, elsewhere)
        self._show_selected()

    def _looking_elsewhere(self) -> frozenset[str]:
        """The sensors that look where the data hold no boxes: what they are worth cannot be told from these."""
        gap = self.result.scene.gap if self.result is not None else None
        if self.result is None or gap is None:
            return frozenset()
        return frozenset(s.name for s in self.result.request.rig.sensors if looks_into(s, gap))

    def _show_selected(self) -> None:
        """Show the loss of the selected sensor in the inspector, or why there is none."""
        name, inspector = self.document.selected, self.bench.panels.inspector
        if name is None:
            return
        if not self.document.rig.sensor(name).enabled:
            inspector.show_no_loss(NOT_COUNTED)
        elif name in self._looking_elsewhere():
            inspector.show_no_loss(NO_BOXES)
        elif self.result is not None and name in self.losses:
            inspector.show_loss(self.result.evaluation.scores, self.losses[name])
        elif name != self._greyed():
            inspector.show_no_loss(WAITING)

    def _greyed(self) -> str | None:
        """The sensor whose numbers of an earlier rig are still shown, greyed."""
        return self.bench.panels.inspector.loss_of


def _same_sensors(one: Rig, other: Rig) -> bool:
    return one is other or one.sensors == other.sensors
