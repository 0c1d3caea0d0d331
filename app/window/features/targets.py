"""Show figures of objects in a panel and next to the scores: of a sample during a drag, of all frames at rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from PySide6.QtCore import Qt, Signal

from riglens.app.background.background_requests import LEARN
from riglens.app.background.counting import CountAnswer, CountRequest
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.core.figures.figure import ALL
from riglens.core.figures.predicted import FOUND
from riglens.core.figures.registry import leading_figures
from riglens.core.figures.sentence import sentence
from riglens.core.figures.text import estimate_text
from riglens.core.figures.values import FigureCells, Values
from riglens.evaluation.options import SceneOptions
from riglens.widgets.panels.controls.scrolled import scrolled
from riglens.widgets.panels.targets.panel import MOST_POINTS, TargetsPanel
from riglens.widgets.timers import Timers, single_shot

LAST_SAVED = "the last saved rig"
COUNTING = "Counting objects"
PAUSE_MS = 200
"""Least time between updates during a drag: the tables cost as much as a picture."""


class Targets(Feature):
    """Requests for counts after every change of rig, baseline, settings or traffic, and the display of the results."""

    counted = Signal()
    """There is another answer, or none any more."""

    def __init__(self, bench: Workbench, timers: Timers = single_shot) -> None:
        super().__init__(bench)
        self._pause, self._is_behind = timers(self, PAUSE_MS, self._catch_up), False
        self.panel, self.counter = TargetsPanel(self.session.targets), bench.counter
        self.answer: CountAnswer | None = None
        """The last answer that was shown."""
        self._exact: tuple[CountRequest, Mapping[str, FigureCells]] | None = None
        """The last request answered from all frames, with its figures next to the scores."""
        self._asked: CountRequest | None = None
        self._ahead: SceneOptions | None = None
        """The boxes of the first load, if they may be counted meanwhile."""
        self._with_losses = False
        self._least_revision = 0
        """Answers on earlier revisions are about a rig that is no longer open."""
        self.dock = bench.docks.add(
            "Targets", scrolled(self.panel), Qt.DockWidgetArea.BottomDockWidgetArea, beside="Scores"
        )
        queued = Qt.ConnectionType.QueuedConnection
        self.counter.answered.connect(self._take, queued)
        self.counter.failed.connect(self._show_none, queued)
        self.counter.failed.connect(self._leave_processors, queued)
        self.panel.settings_wanted.connect(self.session.set_targets)
        self.session.targets_changed.connect(self._on_settings)
        self.session.settings_changed.connect(self._ask)
        document = self.document
        for changed in (
            document.rig_changed, document.rig_settled, document.failed_changed, self.session.baseline_changed,
        ):  # fmt: skip
            changed.connect(self._ask)
        bench.recompute.boxes_named.connect(self._count_ahead, queued)
        bench.recompute.load_ended.connect(self._end_load, queued)
        # once all have forgotten the scene before
        self.session.scene_changed.connect(self._tell_again, queued)
        bench.answers.answered.connect(lambda _: self._ask())
        bench.answers.forgotten.connect(self._forget)
        bench.theme_changed.connect(lambda _: self._show())
        self.remember("targets/quantity", lambda: self.panel.figure.key, self.panel.choose)
        self.remember(
            "targets/min_points", lambda: str(self.session.targets.min_points), self._take_min_points
        )

    @property
    def is_current(self) -> bool:
        """Return whether the shown results answer the last request from all frames."""
        answer = self.answer
        return answer is not None and answer.is_whole and answer.request is self._asked

    @property
    def answer_on_scene(self) -> CountAnswer | None:
        """Return the last answer that was shown; None if it is about other traffic than that of the scene."""
        answer, scene = self.answer, self.session.scene
        return answer if answer and scene and answer.request.options is scene.options else None

    def want_losses(self, wanted: bool) -> None:
        """Also request what hides objects from cameras, or no longer."""
        if wanted != self._with_losses:
            self._with_losses = wanted
            if wanted:
                self._ask()

    def _take_min_points(self, number: str) -> None:
        if number.isdecimal() and len(number) <= 4 and 1 <= int(number) <= MOST_POINTS:
            self.session.set_targets(replace(self.session.targets, min_points=int(number)))

    def _on_settings(self) -> None:
        self.panel.show_settings(self.session.targets)
        self._ask()

    def _count_ahead(self, options: SceneOptions) -> None:
        """Count the objects of the first load while it is under way."""
        self._ahead = options
        self._ask()

    def _end_load(self, problem: str, options: SceneOptions) -> None:
        if problem and options is self._ahead:
            self._ahead = self._asked = None
            self.counter.drop()
            self._show_none(problem)

    def forget_scene(self) -> None:
        """Count no objects of an earlier load."""
        scene = self.session.scene
        if scene is not None and self._ahead is not scene.options:
            self._ahead = None

    def _boxes(self) -> SceneOptions | None:
        """Return the boxes whose objects to count: scores come first where both would compile at once."""
        scene, scored = self.session.scene, self.bench.answers.result
        return scene.options if scene and scored and scored.scene is scene else self._ahead

    def _ask(self) -> None:
        """Request the counts of the current rig, unless that was done already."""
        session, document, options = self.session, self.document, self._boxes()
        if options is None:
            return
        settings = replace(session.targets, body=session.settings.body)
        request = CountRequest(
            document.revision, session.working_rig, session.with_mesh(session.baseline), settings, options,
            document.is_dragging, self._with_losses,
        )  # fmt: skip
        if self._asked is not None and self._asked.is_as(request):
            return
        self._asked = request
        self._grey()
        self.counter.ask(request)

    def _tell_again(self) -> None:
        if self.answer_on_scene is not None:
            self.counted.emit()

    def _take(self, _: CountRequest, answer: CountAnswer) -> None:
        """Show an answer, during a drag perhaps later; not one of other traffic or of a rig before the one shown."""
        shown, scene = self.answer, self.session.scene
        if answer.request.options is not (self._ahead if scene is None else scene.options):
            return
        if answer.request.revision < (self._least_revision if shown is None else shown.request.revision):
            return
        self.answer = answer
        if answer.is_whole:
            self._exact = answer.request, answer.cells
            self._leave_processors()
        if self.document.is_dragging and self._pause.isActive():
            self._is_behind = True
        else:
            self._tell()

    def _leave_processors(self) -> None:
        """Allow what waits until the figures are exact, or until it is clear that there are none."""
        self.bench.recompute.ask_in_background([LEARN])

    def _tell(self) -> None:
        self._is_behind = False
        self._pause.start()
        self._show()
        if self.session.scene is not None:  # before, there is nothing that others could do with it
            self.counted.emit()

    def _catch_up(self) -> None:
        if self._is_behind:
            self._tell()

    def _show(self) -> None:
        if self.answer is not None:
            pinned = self.session.pinned
            baseline = LAST_SAVED if pinned is None else pinned.name
            answer = self.answer
            self.panel.show_counts(answer.counted, answer.baseline, baseline)
            scores, cells = self.bench.panels.scores, self._cells(answer)
            compared = {key: found.compared() for key, found in cells.items()}
            scores.show_figures("objects", compared)
            name = f"{answer.request.baseline_rig.name} (saved)" if pinned is None else pinned.name
            scores.show_judgement(sentence({key: one.change for key, one in compared.items()}, name))
            scores.show_found(cells[FOUND.key])
            self.bench.status.show_figure(*_in_status({key: one.value for key, one in compared.items()}))
            if answer.request is not self._asked:
                self._grey()

    def _cells(self, answer: CountAnswer) -> Mapping[str, FigureCells]:
        """Return the figures next to the scores, by key: of a sample, the last exact value plus the change in the same
        frames."""
        exact, asked = self._exact, answer.request
        if exact is None or answer.is_whole or exact[0].options is not asked.options:
            return answer.cells
        known, cells = exact
        if (known.settings, known.baseline_rig) != (asked.settings, asked.baseline_rig):
            return answer.cells
        return {key: found.anchored(cells[key]) for key, found in answer.cells.items()}

    def _grey(self) -> None:
        self.panel.set_stale()
        self.bench.panels.scores.grey_counted()
        self.bench.status.figure.setEnabled(False)

    def _forget(self) -> None:
        """Show no figures of the rig that was open before."""
        self._least_revision = self.document.revision + 1  # opening counts as the next
        self._show_none(COUNTING)

    def _show_none(self, reason: str) -> None:
        self.answer = self._exact = None
        self.panel.show_problem(reason)
        self.bench.panels.scores.forget_counted(reason)
        self.bench.status.show_figure("")
        self.counted.emit()


def _in_status(figures: Values) -> tuple[str, str]:
    """Return the leading figures, all classes together, and their tooltip: they stay in sight behind every panel."""
    shown = [one for one in leading_figures() if one.key in figures]
    texts = [f"{one.short} {estimate_text(one, figures[one.key][ALL])}" for one in shown]
    return "  ·  ".join(texts), "\n".join(
        ["Means of the classes.", *(f"{one.title}: {one.tip}" for one in shown)]
    )
