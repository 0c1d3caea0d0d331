"""Show what the rig loses without each sensor: scores and figures of objects; in the list and the inspector."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QPoint, Qt, QTimer
from PySide6.QtGui import QActionGroup
from PySide6.QtWidgets import QMenu

from riglens.app.background.background_requests import ScoreRequest
from riglens.app.background.counting import CountRequest, OtherCount
from riglens.app.background.queue import BackgroundRequest
from riglens.app.window.feature import Feature
from riglens.app.window.features.checks import add_check, check_spec
from riglens.app.window.features.targets import Targets
from riglens.app.window.workbench import Workbench
from riglens.core.figures.values import Values, values_of_scores
from riglens.core.metric.scores import Scores
from riglens.core.rig.edits import with_enabled
from riglens.core.rig.model import Rig
from riglens.core.shown_values import NONE
from riglens.core.view.outlook import looks_into
from riglens.evaluation.requests import Result
from riglens.widgets.maps.map_items import NO_BOXES
from riglens.widgets.panels.checks.redundancy import RedundancyPanel
from riglens.widgets.panels.controls.menus import add_entry
from riglens.widgets.panels.inspector.marginal_view import FAILED, NOT_COUNTED, WAITING
from riglens.widgets.panels.sensors.losses import (
    Loss,
    Losses,
    losses_of,
    meaning,
    measure_for,
    measures,
    usual_measure,
)
from riglens.widgets.panels.sensors.tree import NO_BOXES_TIP

GROUP = "marginal"
TOGETHER_MS = 100
"""Answers that come within this time are shown together: a rig of 60 sensors has 120."""


class Marginals(Feature):
    """Requests for the rig without each sensor after every exact result, discarded with the next edit.

    `losses` are the scores without a sensor known so far, of the rig in `result`; `figures` those of objects
    of such rigs, of the rig in `counted`. `measure` is what the list shows.
    """

    specs = (check_spec("redundancy", "Redundancy", "Show what the rig loses when each sensor fails."),)

    def __init__(self, bench: Workbench, targets: Targets) -> None:
        super().__init__(bench)
        self.panel = RedundancyPanel()
        add_check(bench, "redundancy", self.panel)
        self.panel.table.chosen.connect(self.document.select)
        self.answers, self._targets = bench.answers, targets
        self.result: Result | None = None
        self.losses: dict[str, Scores] = {}
        self.counted: CountRequest | None = None
        self.figures: dict[str, Values] = {}
        self._now: Values = {}
        self._found: dict[str, tuple[tuple[object, ...], Losses]] = {}
        self.measure = usual_measure()
        self._soon = QTimer(self, singleShot=True, interval=TOGETHER_MS)
        self._soon.timeout.connect(self._show_all)
        queued = Qt.ConnectionType.QueuedConnection
        bench.recompute.answered_in_background.connect(self._take, queued)
        bench.counter.answered_in_background.connect(self._take_count, queued)
        self.answers.answered.connect(lambda _: self._start())
        targets.counted.connect(self._start_count)
        self.answers.forgotten.connect(self._forget_rig)
        self.session.settings_changed.connect(self._drop_if_changed)
        bench.theme_changed.connect(lambda _: self._show_all())
        self.document.rig_changed.connect(self._on_rig)
        self.document.failed_changed.connect(self._on_rig)
        self.document.selection_changed.connect(self._show_selected)
        bench.panels.tree.measure_menu_wanted.connect(self._open_menu)
        self.remember("list/loss", lambda: self.measure.key, self.choose)
        self._show_selected()

    def _on_rig(self) -> None:
        """Discard the results of before an edit, and request new ones once it is over."""
        self._drop_if_changed()
        self._start()
        self._show_selected()

    # ------------------------------------------------------------------ asking
    def _start(self) -> None:
        """Request all results once an edit is over and scored, unless they are known."""
        result = self.answers.result
        if result is None or self.document.is_dragging or not self.answers.is_current:
            return
        if self.result is not None:  # of this rig: any other edit has dropped it
            return
        request = result.request
        self._forget_scores()
        self.result = result
        self.bench.recompute.ask_in_background(
            [
                ScoreRequest(
                    GROUP, name, with_enabled(request.rig, (name,), False), request.settings, result.scene
                )
                for name in self._names(request.rig)
            ]
        )

    def _start_count(self) -> None:
        """Request the counts of the rig without each sensor, once all frames are counted."""
        answer = self._targets.answer
        if answer is None or not self._targets.is_current or self.document.is_dragging:
            return
        asked = answer.request
        if self.counted == asked:
            return
        self._forget_figures()
        self.counted, self._now = asked, answer.figures
        self.bench.counter.ask_in_background(
            [
                OtherCount(
                    GROUP, name, with_enabled(asked.rig, (name,), False), asked.settings, asked.options
                )
                for name in self._names(asked.rig)
            ]
        )
        self._show_all()

    def _names(self, rig: Rig) -> list[str]:
        """Return the names of the sensors that count, the selected one first."""
        names = [sensor.name for sensor in rig.sensors if sensor.enabled]
        return sorted(names, key=lambda name: name != self.document.selected)

    def _drop_if_changed(self) -> None:
        """Discard results of another rig or of other settings."""
        rig = self.document.working_rig
        if self.result is not None and (
            not _same_sensors(self.result.request.rig, rig)
            or self.result.request.settings != self.session.settings
        ):
            self._forget_scores()
        if self.counted is not None and (
            not _same_sensors(self.counted.rig, rig)
            or self.counted.settings.body != self.session.settings.body
        ):
            self._forget_figures()

    def forget_scene(self) -> None:
        """Forget the losses on earlier traffic."""
        self._forget_scores()
        self._forget_figures()

    def _forget_rig(self) -> None:
        """Forget the losses of the rig that was open before, and show none."""
        self.forget_scene()
        self.bench.panels.tree.show_measure(self.measure)
        self.panel.show_losses({})

    def _forget_scores(self) -> None:
        self.bench.recompute.drop_group(GROUP)
        self.result, self.losses = None, {}
        self._grey()

    def _forget_figures(self) -> None:
        self.bench.counter.drop_group(GROUP)
        self.counted, self._now, self.figures = None, {}, {}
        self._grey()

    def _grey(self) -> None:
        self._soon.stop()
        self.bench.panels.tree.set_losses_stale()
        self.panel.grey()
        self.bench.panels.inspector.set_loss_stale()

    # ------------------------------------------------------------------ answers
    def _take(self, request: BackgroundRequest, scores: Scores | None) -> None:
        result = self.result
        if not isinstance(request, ScoreRequest) or request.group != GROUP or scores is None:
            return
        if result is None or request.scene is not result.scene:
            return
        is_present = request.settings == result.request.settings
        if not is_present or request.rig != with_enabled(result.request.rig, (request.name,), False):
            return
        self.losses[request.name] = scores
        self._show_soon(request.name)

    def _take_count(self, request: OtherCount, figures: Values | None) -> None:
        asked = self.counted
        if request.group != GROUP or asked is None or figures is None:
            return
        if request.options is not asked.options or request.settings != asked.settings:
            return
        if request.rig == with_enabled(asked.rig, (request.name,), False):
            self.figures[request.name] = figures
            self._show_soon(request.name)

    # ------------------------------------------------------------------ showing
    def _known_now(self) -> Values:
        scores = None if self.result is None else self.result.evaluation.scores
        return _known(scores, self._now)

    def _known_without(self, name: str) -> Values:
        return _known(self.losses.get(name), self.figures.get(name, {}))

    def _losses_without(self, name: str) -> Losses:
        """Return the losses without a sensor; one answer changes those of one sensor alone."""
        evaluated = None if self.result is None else self.result.evaluation
        of = evaluated, self._now, self.losses.get(name), self.figures.get(name)
        before = self._found.get(name)
        if before is None or any(old is not new for old, new in zip(before[0], of, strict=True)):
            kind = self.document.rig.sensor(name).kind
            before = of, losses_of(self._known_now(), self._known_without(name), kind)
            self._found[name] = before
        return before[1]

    def _show_soon(self, name: str) -> None:
        if name == self.document.selected:
            self._show_selected()
        if not self._soon.isActive():
            self._soon.start()

    def _show_all(self) -> None:
        """Show the known results in the list, and those of the selected sensor in the inspector."""
        elsewhere, names = self._looking_elsewhere(), self._names(self.document.working_rig)
        found = {name: self._losses_without(name) for name in names}
        self._found = {name: self._found[name] for name in names}
        for name in elsewhere.intersection(found):
            found[name] = dict.fromkeys(found[name], Loss(None, NONE, NO_BOXES_TIP))
        rig, measure = self.document.working_rig, self.measure
        if self.result is not None and self.result.scene.options.pog is not None:
            measure = next(one for one in measures().values() if one.needs == "voxels")
        key_of = {one.name: measure_for(one.kind, measure).key for one in rig.sensors}
        self.bench.panels.tree.show_losses(
            {name: one[key_of[name]] for name, one in found.items() if key_of[name] in one}
        )
        self.panel.show_losses(found)
        self._show_selected()

    def _looking_elsewhere(self) -> frozenset[str]:
        """Return the sensors that face directions without boxes in the data: their worth cannot be measured."""
        gap = self.result.scene.gap if self.result is not None else None
        if self.result is None or gap is None:
            return frozenset()
        return frozenset(s.name for s in self.result.request.rig.sensors if looks_into(s, gap))

    def _show_selected(self) -> None:
        """Show the loss of the selected sensor in the inspector, or why there is none."""
        name, inspector = self.document.selected, self.bench.panels.inspector
        if name is None:
            return
        if name in self.document.failed:
            inspector.show_no_loss(FAILED)
        elif not self.document.rig.sensor(name).enabled:
            inspector.show_no_loss(NOT_COUNTED)
        elif name in self._looking_elsewhere():
            inspector.show_no_loss(NO_BOXES)
        elif name in self.losses or name in self.figures:
            inspector.show_loss(self._known_now(), self._known_without(name))
        elif name != inspector.loss_of:  # its numbers of an earlier rig are still shown, greyed
            inspector.show_no_loss(WAITING)

    # ------------------------------------------------------------------ the choice of the measure
    def choose(self, key: str) -> None:
        """Show losses in another measure; ignore an unknown one."""
        measure = measures().get(key)
        if measure is not None:
            self.measure = measure
            self.bench.panels.tree.show_measure(measure)
            self._show_all()

    def measure_menu(self) -> QMenu:
        """Return a menu of the measures."""
        menu = QMenu(self.bench.panels.tree)
        group = QActionGroup(menu)
        for key, measure in measures().items():
            action = add_entry(menu, f"Loss in {measure.title}", partial(self.choose, key))
            action.setCheckable(True)
            action.setChecked(key == self.measure.key)
            action.setToolTip(meaning(measure))
            group.addAction(action)
        menu.setToolTipsVisible(True)
        return menu

    def _open_menu(self, place: QPoint) -> None:
        menu = self.measure_menu()
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(place)


def _known(scores: Scores | None, counted: Values) -> Values:
    """Return the figures of a rig known so far: those of voxels, and those of objects."""
    return {**(values_of_scores(scores) if scores is not None else {}), **counted}


def _same_sensors(one: Rig, other: Rig) -> bool:
    same = one.sensors == other.sensors and one.self_occlusion == other.self_occlusion
    return one is other or same
