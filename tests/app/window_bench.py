"""A window on a test bench: small rig and scene, a viewport without graphics, dialogs that answer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from PySide6.QtCore import QByteArray, QSize, Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QLineEdit, QWidget
from pytestqt.qtbot import QtBot

from riglens.app.background.counting import Counter, CountRequest, OtherCount
from riglens.app.background.recompute import Recompute
from riglens.app.session.document import Document
from riglens.app.session.session import HeatChoice, Session
from riglens.app.window.build import Features
from riglens.app.window.dialogs import Dialogs, Unsaved
from riglens.app.window.main_window import MainWindow
from riglens.app.window.settings import Settings
from riglens.app.window.workbench import Panels, Workbench
from riglens.core.engine.engine import Engine
from riglens.core.figures.coverage import VoxelFigure
from riglens.core.figures.values import compared_scores
from riglens.core.geometry import Pose
from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.settings import TargetSettings
from riglens.evaluation.options import SceneOptions
from riglens.evaluation.requests import FRAME_MS, LoadedScene
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.panels.help.shortcut_sheet import Group
from riglens.widgets.viewport.scene_state import SceneState
from riglens.widgets.viewport.view import Tool, View
from tests.hand_clock import HandClock
from tests.waiting import TIMEOUT_MS

BOXES = """seq,frame,cls,x,y,z,length,width,height,yaw
s,0,car,6,0,0.8,4.5,1.9,1.6,0.3
s,0,bicycle,3,-4,0.9,1.8,0.6,1.7,0
s,1,car,-6,3,0.8,4.5,1.9,1.6,0
s,2,pedestrian,2,5,0.9,0.6,0.6,1.8,0
"""
LIDAR = Lidar(
    name="roof",
    position=(0.1, 0.2, 1.9),
    elevations_deg=LinearAngles(from_=-20.0, to=10.0, count=8),
    azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=36),
)
CAMERA = Camera(name="front", position=(1.0, 0.0, 1.4), image=(160, 90), hfov_deg=90.0, cast=(32, 18))
RIG = Rig(name="small", sensors=(LIDAR, CAMERA))


def scene_options(folder: Path, **changes: Any) -> SceneOptions:
    """A box table of three frames on a coarse grid."""
    boxes = folder / "boxes.csv"
    if not boxes.exists():
        boxes.write_text(BOXES, encoding="utf-8")
    fields: dict[str, Any] = {"boxes": boxes, "voxel_m": 0.5, "roi_m": (20.0, 20.0, 4.0)}
    return SceneOptions(**(fields | changes))


class FakeCounter(Counter):
    """Takes note of what it is asked, and answers nothing: a test sends its signals."""

    def __init__(self) -> None:
        super().__init__("counting", lambda request, context: None)
        self.requests: list[CountRequest] = []
        self.others: list[OtherCount] = []

    def ask(self, request: CountRequest | OtherCount) -> None:
        assert isinstance(request, CountRequest)
        self.requests.append(request)

    def ask_in_background(self, requests: Sequence[CountRequest | OtherCount]) -> None:
        self.others.extend(request for request in requests if isinstance(request, OtherCount))

    def drop_group(self, group: str) -> None:
        self.others = [request for request in self.others if request.group != group]


class FakeViewport(View):
    """A view without graphics: keeps every state that it was to show; tests send its signals as a drag would."""

    def __init__(self) -> None:
        super().__init__()
        self.states = [SceneState()]
        self.told: list[tuple[Any, ...]] = []
        self.dragged: str | None = None
        self.footprint_updates = 0
        QTimer.singleShot(0, self, self.shown.emit)

    @property
    def state(self) -> SceneState:
        return self.states[-1]

    def show_state(self, state: SceneState) -> None:
        self.states.append(state)
        if self.dragged is None:
            self.footprints_lacking.emit()

    def update_footprints(self) -> None:
        self.footprint_updates += 1

    def values(self, *names: str) -> list[tuple[Any, ...]]:
        """What was shown of some fields of the state, one after the other; what did not change counts once."""
        found = [tuple(getattr(state, name) for name in names) for state in self.states]
        return [now for before, now in zip([None, *found], found, strict=False) if now != before]

    @property
    def picture_size(self) -> tuple[int, int]:
        return 320, 200

    def show_inset(self, is_on: bool) -> None:
        self.has_inset = is_on

    def chosen_camera(self) -> OrbitCamera | None:
        return None if self.state.camera == SceneState().camera else self.state.camera

    def set_view(self, name: str, wide: bool = False) -> None:
        self.told.append(("view", name))

    def frame_sensors(self, names: tuple[str, ...]) -> None:
        self.told.append(("frame", *names))

    def look_at(self, x_m: float, y_m: float) -> None:
        self.told.append(("look", x_m, y_m))

    def set_tool(self, tool: Tool, is_on: bool) -> None:
        self.told.append((tool, is_on))

    def begin_placing(self) -> bool:
        self.told.append(("place",))
        self.placing_changed.emit(True)
        return True

    def cancel_drag(self) -> bool:
        name, self.dragged = self.dragged, None
        if name is not None:
            self.drag_cancelled.emit()
        return name is not None

    def close_viewport(self) -> None:
        self.told.append(("closed",))

    def forget(self) -> None:
        """Keep the last state alone, and nothing of what it was told."""
        self.dragged = None
        del self.states[:-1]
        self.told.clear()

    # what a person does
    def press(self, name: str) -> None:
        self.dragged = name
        self.drag_started.emit((name,))

    def drag_to(self, name: str, pose: Pose) -> None:
        self.drag_moved.emit({name: pose})

    def release(self, name: str) -> None:
        self.dragged = None
        self.drag_finished.emit()


@dataclass
class FakeDialogs(Dialogs):
    """Answers prepared by the test; `shown` are the texts that were shown, `asked` counts the questions."""

    path: Path | None = None
    answer: Unsaved = "cancel"
    name: str | None = None
    suggested: Path | None = None
    asked: int = 0
    shown: list[str] = field(default_factory=list)
    details: list[str] = field(default_factory=list)

    def open_rig(self, parent: QWidget, folder: Path | None) -> Path | None:
        return self.path

    def save_rig(self, parent: QWidget, suggestion: Path) -> Path | None:
        self.suggested = suggestion
        return self.path

    def export_rig(self, parent: QWidget, suggestion: Path, title: str, is_folder: bool) -> Path | None:
        self.suggested = suggestion
        return self.path

    def save_picture(self, parent: QWidget, suggestion: Path) -> Path | None:
        self.suggested = suggestion
        return self.path

    def save_table(self, parent: QWidget, suggestion: Path) -> Path | None:
        self.suggested = suggestion
        return self.path

    def save_report(self, parent: QWidget, suggestion: Path) -> Path | None:
        self.suggested = suggestion
        return self.path

    def requirements_file(self, parent: QWidget, folder: Path | None) -> Path | None:
        return self.path

    def mesh_file(self, parent: QWidget, folder: Path | None) -> Path | None:
        return self.path

    def box_file(self, parent: QWidget) -> Path | None:
        return self.path

    def box_folder(self, parent: QWidget) -> Path | None:
        return self.path

    def unsaved(self, parent: QWidget, rig_name: str) -> Unsaved:
        self.asked += 1
        return self.answer

    def view_name(self, parent: QWidget, known: Sequence[str]) -> str | None:
        return self.name

    def show_sheet(self, parent: QWidget, title: str, groups: Sequence[Group]) -> None:
        self.shown.append("\n".join(f"{keys}: {what}" for group in groups for keys, what in group.rows))

    def show_guide(self, parent: QWidget, page: Path) -> None:
        self.shown.append(str(page))

    def show_text(self, parent: QWidget, title: str, html: str, details: str = "") -> None:
        self.shown.append(html)
        self.details.append(details)


@dataclass
class Hands:
    """What a person does and sees on a workbench, with a window around it or without."""

    workbench: Workbench
    viewport: Any
    dialogs: FakeDialogs
    qtbot: QtBot
    layout: tuple[QSize, QByteArray] | None = field(default=None, init=False)
    """The size of the window and where its docks are at first."""

    def start_over(self, features: Features, rig: Rig = RIG) -> None:
        """Open a rig and put back what a test may have chosen, so that the next one can go on in the same window."""
        window, session = self.workbench.window, self.session
        if (popup := QApplication.activePopupWidget()) is not None:
            popup.close()
        self.viewport.cancel_drag()
        session.pin(None)
        session.pick(None)
        session.set_body(None)
        session.set_settings(MetricSettings())
        session.set_targets(TargetSettings())
        session.set_heat(HeatChoice())
        self.document.show(rig)
        vars(self.dialogs).update(vars(FakeDialogs()))
        self.workbench.kept._memory.clear()
        for feature in features:
            feature.restore(self.workbench.kept)
        features.views.look(SceneState().camera)
        self.workbench.errors.clear()
        self.workbench.notes.clear()
        self.workbench.status.clearMessage()
        size, state = self.layout = self.layout or (window.size(), window.saveState())
        window.resize(size)
        if window.saveState() != state:
            window.restoreState(state)
        QApplication.processEvents()
        self.viewport.forget()

    @property
    def session(self) -> Session:
        return self.workbench.session

    @property
    def document(self) -> Document:
        return self.workbench.session.document

    @property
    def panels(self) -> Panels:
        return self.workbench.panels

    def act(self, key: str) -> None:
        """Choose an action of a menu or the toolbar."""
        self.workbench.actions[key].trigger()

    def clipboard(self) -> str:
        """The text on the clipboard."""
        return QApplication.clipboard().text()

    def find(self, name: str) -> QWidget:
        """A field of the inspector by its name."""
        found = self.panels.inspector.form.findChild(QWidget, name)
        assert found is not None, name
        return found

    def type(self, name: str, text: str) -> None:
        """Replace what stands in a field and press Return."""
        edit = self.find(name)
        assert isinstance(edit, QLineEdit)
        type_into(self.qtbot, edit, text)

    def choose(self, name: str, text: str) -> None:
        """Choose an item of a list in the inspector."""
        combo = self.find(name)
        assert isinstance(combo, QComboBox)
        choose_item(combo, text)

    def drag(self, name: str, *positions: tuple[float, float, float]) -> None:
        """Drag a sensor through some positions and let go."""
        self.viewport.press(name)
        for position in positions:
            self.viewport.drag_to(name, Pose(position, self.document.rig.sensor(name).rpy_deg))
        self.viewport.release(name)


@dataclass
class Bench(Hands):
    """The window with everything a test needs to use it as a person would."""

    window: MainWindow
    scenes: list[LoadedScene]
    options: SceneOptions
    """The scene that the window loads first."""
    clock: HandClock
    """What the background thread's rests are measured by: they take no time unless a test says so."""

    @property
    def features(self) -> Features:
        return self.window.features

    def settle(self) -> None:
        """Wait until everything shown is up to date, and everybody has been told."""
        self.qtbot.waitUntil(lambda: self.window.is_exact, timeout=TIMEOUT_MS)
        assert self.workbench.recompute.wait_until_idle()
        QApplication.processEvents()

    def fresh_scores(self, rig: Rig) -> Scores:
        """What a new engine says about a rig on the scene and with the settings in use."""
        evaluation = Engine(self.scenes[-1].field).evaluate(rig, self.session.settings)
        return evaluation.scores

    def exact_numbers(self) -> list[list[float]]:
        """Every digit of voxels that the score table shows."""
        table = self.panels.scores.table
        return [
            [float(table.cell(name, key).values[0] or 0.0) for key in self.voxel_columns()]
            for name in CLASSES
        ]

    def voxel_columns(self) -> list[str]:
        """The columns of figures of voxels, each followed by its change."""
        keys = [one.key for one in self.panels.scores.table.shown if isinstance(one, VoxelFigure)]
        return [column for key in keys for column in (key, f"{key} change")]

    def fresh_numbers(self) -> list[list[float]]:
        """The same of a new engine, with the changes since the last save."""
        now, saved = self.fresh_scores(self.document.rig), self.fresh_scores(self.document.saved_rig)
        found = compared_scores(now, saved)
        return [
            [
                (found[key].change if change else found[key].value)[name].value
                for key, _, change in (column.partition(" ") for column in self.voxel_columns())
            ]
            for name in CLASSES
        ]

    def shown(self, class_name: str, column: str) -> str:
        """The text of a cell of the score table."""
        return self.panels.scores.table.cell(class_name, column).text


def type_into(qtbot: QtBot, edit: QLineEdit, text: str) -> None:
    """Replace the text of a field by key presses and press Return."""
    edit.setFocus()
    edit.selectAll()
    QTest.keyClick(edit, Qt.Key.Key_Delete)
    QTest.keyClicks(edit, text)
    QTest.keyClick(edit, Qt.Key.Key_Return)


def choose_item(combo: QComboBox, text: str) -> None:
    """Choose an item as a click on it does."""
    index = combo.findText(text)
    assert index >= 0, text
    combo.setCurrentIndex(index)
    combo.activated.emit(index)


@contextmanager
def open_bench(
    qtbot: QtBot,
    folder: Path,
    rig: Rig = RIG,
    viewport: View | None = None,
    wait: bool = True,
    data: bool = True,
    coarse_above_ms: float = FRAME_MS,
    kept: Settings | None = None,
    counter: Counter | None = None,
    **scene: Any,
) -> Iterator[Bench]:
    """A window on a small scene, with fields of its options changed; closed without questions at the end.

    Road users are counted only by a `counter` that is handed in. Without `data` none are loaded, and there are no
    scores: for what needs keys, the mouse or the layout alone."""
    view = FakeViewport() if viewport is None else viewport
    dialogs = FakeDialogs()
    clock = HandClock(leaps=True)
    recompute = Recompute(threads=1, coarse_above_ms=coarse_above_ms, clock=clock)
    recompute._is_warm = True  # kernels are compiled when they are needed: no time is measured here
    if not data:
        recompute.load = lambda request: None  # type: ignore[method-assign]
    scenes: list[LoadedScene] = []
    recompute.scene_loaded.connect(scenes.append, Qt.ConnectionType.QueuedConnection)
    options = scene_options(folder, **scene)
    document = Document(
        rig, clock=lambda: 0.0
    )  # edits follow one another at once, however slow the computer is
    window = MainWindow(
        document, view, recompute, counter or FakeCounter(), options, MetricSettings(), dialogs, kept
    )
    qtbot.addWidget(window)
    window.show()
    window.activateWindow()  # shortcuts belong to the active window
    qtbot.waitUntil(window.isActiveWindow, timeout=TIMEOUT_MS)
    window.features.footprints.begin()  # as once figures are there: its thread belongs to the window, not to a test
    bench = Bench(window.bench, view, dialogs, qtbot, window, scenes, options, clock)
    try:
        if wait and data:
            bench.settle()
        yield bench
    finally:
        dialogs.answer = "discard"
        window.close()
        QApplication.processEvents()
