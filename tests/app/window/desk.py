"""A desk to try one feature of the window on: a real workbench without main window, graphics, thread or traffic."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from PySide6.QtCore import QObject
from PySide6.QtWidgets import QMainWindow, QToolBar
from pytestqt.qtbot import QtBot

from riglens.app.background.background_requests import LEARN, AuditRequest, ScoreRequest, ToleranceRequest
from riglens.app.background.queue import BackgroundRequest
from riglens.app.background.recompute import Recompute
from riglens.app.background.worker import BackgroundWorker
from riglens.app.session.document import Document
from riglens.app.session.session import Session
from riglens.app.window.build import Features, add_panels
from riglens.app.window.features.scene_data import choice_of
from riglens.app.window.places import Places
from riglens.app.window.settings import Settings
from riglens.app.window.status import StatusBar
from riglens.app.window.workbench import Bars, Panels, Workbench
from riglens.core.metric.scores import ClassScores, KindScore, MetricSettings, Scores
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import VoxelGrid
from riglens.core.view.heatmap_data import HeatmapData
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.requests import Approximation, EvaluationRequest, Result
from riglens.widgets.panels.checks.panel import ChecksPanel
from riglens.widgets.panels.controls.messages import MessageBar
from riglens.widgets.panels.inspector.panel import Inspector
from riglens.widgets.panels.scene.scene_panel import ScenePanel
from riglens.widgets.panels.scores.panel import ScoresPanel
from riglens.widgets.panels.sensors.tree import SensorTree
from tests.app.window_bench import RIG, FakeCounter, FakeDialogs, FakeViewport, Hands
from tests.waiting import TIMEOUT_MS

GRID = VoxelGrid(0.5, (20.0, 20.0, 4.0))


class FakeRecompute(Recompute):
    """Takes note of what it is asked, and answers nothing: a test sends its signals."""

    def __init__(self) -> None:
        QObject.__init__(self)
        self.requests: list[EvaluationRequest] = []
        self.loads: list[SceneOptions] = []
        self.others: list[ScoreRequest] = []
        self.audits: list[AuditRequest] = []
        self.tolerances: list[ToleranceRequest] = []
        self.learnt = 0

    def compiling(self) -> None:
        """Report that no process compiles kernels."""

    @property
    def threads(self) -> int | None:
        return 1

    def evaluate(self, request: EvaluationRequest) -> None:
        self.requests.append(request)

    def ask_in_background(self, requests: Sequence[BackgroundRequest]) -> None:
        for request in requests:
            if isinstance(request, AuditRequest):
                self.audits.append(request)
            elif isinstance(request, ToleranceRequest):
                self.tolerances.append(request)
            elif isinstance(request, ScoreRequest):
                self.others.append(request)
            self.learnt += request is LEARN

    def drop_group(self, group: str) -> None:
        self.others = [request for request in self.others if request.group != group]

    def load(self, request: SceneOptions) -> None:
        self.loads.append(request)

    def cancel_load(self) -> None:
        self.loads.clear()


class FakeWorker(BackgroundWorker[Any, Any]):
    """Takes note of what it is asked, and answers nothing: a test sends its signals."""

    def __init__(self) -> None:
        super().__init__("fake", lambda request, context: None)
        self.requests: list[Any] = []
        self.dropped: list[Any] = []

    def ask(self, request: Any) -> None:
        self.requests.append(request)

    def drop(self) -> None:
        self.dropped += self.requests[-1:]


@dataclass
class Desk(Hands):
    """A workbench and the fakes behind it."""

    recompute: FakeRecompute
    counter: FakeCounter

    def is_enabled(self, key: str) -> bool:
        """Whether an action can be chosen."""
        return self.workbench.actions[key].isEnabled()

    def open_page(self, key: str, feature: Any) -> None:
        """Bring a page up by its action and wait until it is in sight."""
        self.workbench.window.show()
        self.act(key)
        self.qtbot.waitUntil(lambda: bool(feature.in_sight), timeout=TIMEOUT_MS)

    def put_away(self, feature: Any) -> None:
        """Bring up another panel in the place of a feature's page."""
        self.workbench.docks.bring_up("Scores")
        self.qtbot.waitUntil(lambda: not feature.in_sight, timeout=TIMEOUT_MS)

    def load(self, grid: VoxelGrid = GRID) -> Any:
        """Have traffic on a grid loaded."""
        scene: Any = loaded(grid)
        self.session.show_scene(scene)
        return scene

    def answer(self, seen: float = 0.5, **fields: Any) -> Result:
        """Answer the last request exactly."""
        result = self.result(seen, **fields)
        self.workbench.answers.take(result)
        return result

    def result(self, seen: float = 0.5, **fields: Any) -> Result:
        """An exact answer to the last request, on the traffic that is loaded."""
        request = self.recompute.requests[-1]
        evaluation: Any = SimpleNamespace(
            scores=scores(seen), settings=request.settings, threads=1, elapsed_ms=1.0
        )
        scene: Any = self.session.scene
        known: dict[str, Any] = {"heatmap": None, "baseline_scores": scores(0.25)}
        return Result(request, scene, evaluation, **(known | fields))

    def approximate(self, seen: float) -> None:
        """Answer the last request roughly."""
        first = Approximation(self.recompute.requests[-1], scores(seen), 1.0, 1.0, is_measured=True)
        self.workbench.answers.take_approximation(first)


class StandIn(SimpleNamespace):
    """Something like a LoadedScene, equal only to itself."""

    __eq__ = object.__eq__
    __hash__ = object.__hash__  # type: ignore[assignment]


def loaded(grid: VoxelGrid = GRID) -> Any:
    """A scene with a grid, and what is drawn of it."""
    display = SimpleNamespace(cell_m=grid.voxel_m, pog=SimpleNamespace(grid=grid))
    data = SimpleNamespace(frames=3)
    return StandIn(
        options=SceneOptions(),
        field=SimpleNamespace(grid=grid, data=data),
        heatmaps=SimpleNamespace(display=display),
        choice=None,
        gap=None,
    )


def scores(seen: float) -> Scores:
    """Scores of all classes that see one share."""
    kind = KindScore(-100.0 * seen, seen)
    of_class = ClassScores(100.0, {"camera": kind, "lidar": kind}, seen, -110.0 * seen)
    return Scores(dict.fromkeys(CLASSES, of_class), {"camera": 1, "lidar": 1, "any": 1})


def heatmap(title: str) -> HeatmapData:
    """A heatmap of two cells."""
    centres_m = np.array([[0.0, 0.0, 0.5], [1.0, 0.0, 0.5]], np.float32)
    return HeatmapData(centres_m, 0.5, np.array([0.0, 1.0], np.float32), title, "nat", 0.0, 1.0)


def open_desk(qtbot: QtBot, rig: Rig = RIG, path: Path | None = None, kept: Settings | None = None) -> Desk:
    """A desk with a rig on it, and the panels in their docks."""
    window = QMainWindow()
    qtbot.addWidget(window)
    toolbar = QToolBar("toolbar", window)
    toolbar.setObjectName("toolbar")
    window.addToolBar(toolbar)
    panels = Panels(
        SensorTree(),
        Inspector(),
        ScenePanel(choice_of(SceneOptions())),
        ScoresPanel(MetricSettings()),
        ChecksPanel(),
    )
    bars = Bars(StatusBar(), MessageBar(is_error=False), MessageBar())
    viewport, dialogs = FakeViewport(), FakeDialogs()
    for widget in (viewport, bars.status, bars.notes, bars.errors):
        qtbot.addWidget(widget)
    recompute, counter = FakeRecompute(), FakeCounter()
    workbench = Workbench(
        window,
        Session(Document(rig, None, path), MetricSettings()),
        recompute,
        counter,
        viewport,
        Places(window.menuBar(), toolbar),
        panels,
        bars,
        dialogs,
        kept or Settings(),
    )
    add_panels(workbench)
    return Desk(workbench, viewport, dialogs, qtbot, recompute, counter)


@dataclass
class FullDesk(Desk):
    """A desk with all features on it: what the window does, without the window."""

    features: Features


@contextmanager
def full_desk(qtbot: QtBot, rig: Rig = RIG, kept: Settings | None = None) -> Iterator[FullDesk]:
    """A desk with all features, for what needs no scores and no keys."""
    desk = open_desk(qtbot, rig, kept=kept)
    features = Features(desk.workbench)
    for feature in features:
        feature.restore(desk.workbench.kept)
    features.follow.show_all()
    features.footprints.begin()  # as once figures are there: its thread belongs to the desk, not to a test
    desk.workbench.answers.ask()
    yield FullDesk(desk.workbench, desk.viewport, desk.dialogs, qtbot, desk.recompute, desk.counter, features)
    desk.workbench.closing.emit()
