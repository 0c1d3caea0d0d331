"""A restless user at the real window, and what memory it costs: `make restless`, or `python -m tests.restless`.

Random actions, mouse and key events over menus, docks, fields, lists, dialogs and the 3D view, from a seed. Memory is
written down every EVERY actions. The code is 1 where something failed unexpectedly, or where memory is not `is_steady`.
`--rig "60 sensors" --minutes 60` keeps one large rig open for an hour. The slowest actions are printed at the end.
"""

from __future__ import annotations

import argparse
import gc
import math
import os
import random
import statistics
import sys
import tempfile
import threading
import time
import traceback
import tracemalloc
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

import psutil
from PySide6.QtCore import QObject, QPoint, Qt, QTimer
from PySide6.QtGui import QCursor
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDialog,
    QDockWidget,
    QLineEdit,
    QTabBar,
    QWidget,
)  # fmt: skip

from riglens.app.background.memory import FreedMemory, trim
from riglens.app.window.dialogs import Dialogs, Unsaved
from riglens.app.window.main_window import MainWindow
from riglens.app.window.start import open_window
from riglens.core.formats.opening import open_rig
from riglens.core.formats.report import OpenedRig
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import PRESETS
from riglens.evaluation.options import SceneOptions, ScoreOptions
from tests.bench.peak import MEGABYTE
from tests.bench.scenes import car
from tests.calls import function_of

EVERY = 100
LIMIT_MB, LARGE_MB, GROWTH = 1400, 2600, 1.05
"""Most memory at the end, also with a large rig, and the largest ratio of the mean of the last quarter to that of the
one before."""
LONGEST_S = 30.0
"""The most that figures are waited for before memory is written down."""
LEFT, ENABLED = Qt.MouseButton.LeftButton, Qt.ItemFlag.ItemIsEnabled
SHUNNED = {"quit", "report", "open", "save_as"}
"""Actions that end the window, or occupy the computer for half a minute; files are opened and saved by others."""
LARGE, FEWEST_SENSORS = "60 sensors", 50
"""A rig that is opened in place of presets, and again when it has fewer sensors than this."""
SLOW_S, LOOK_S, TOLD = 0.3, 0.05, 20
"""Time after which an action is slow, interval between samples of what the interface does, and number of actions that
are printed."""
KEYS = ("W", "E", "L", "O", "S", "R", "H", "C", "P", "F", "V", "M", "G", "T", "Q", "A", "1", "3", "7", "Ctrl+Z",
    "Ctrl+Y", "Ctrl+D", "Ctrl+C", "Ctrl+V", "Esc", "Tab", "Space", "Del")  # fmt: skip
EDGES_M = ("0.2", "0.25", "0.4", "auto")


class Answers(Dialogs):
    """Dialogs that answer by themselves with files of one folder; texts and pages are shown."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def open_rig(self, parent: QWidget, folder: Path | None) -> Path | None:
        return next(iter(sorted(self._folder.glob("*.yaml"))), None)

    def save_rig(self, parent: QWidget, suggestion: Path) -> Path | None:
        return self._folder / "rig.yaml"

    def export_rig(self, parent: QWidget, suggestion: Path, title: str, is_folder: bool) -> Path | None:
        return self._folder / suggestion.name

    save_picture = save_table = save_report = save_rig

    def requirements_file(self, parent: QWidget, folder: Path | None) -> Path | None:
        return None

    def mesh_file(self, parent: QWidget, folder: Path | None) -> Path | None:
        return None

    def box_file(self, parent: QWidget) -> Path | None:
        return None

    box_folder = box_file

    def unsaved(self, parent: QWidget, rig_name: str) -> Unsaved:
        return "discard"

    def view_name(self, parent: QWidget, known: Sequence[str]) -> str | None:
        return "View 1"


class Restless:
    """Does one thing after another to a window."""

    def __init__(self, window: MainWindow, seed: int, large: Rig | None = None) -> None:
        self._window, self._chance, self._large = window, random.Random(seed), large
        self._shunned = SHUNNED | ({"new"} if large else set())
        self.pause_ms = 0
        """Pause after the last action, which is not part of it."""
        self._ways: dict[Callable[[], object], int] = {
            self._choose_action: 25, self._use_widget: 30, self._bring_up: 8, self._drop_dock: 1, self._move_sensor: 12,
            self._select: 8, self._use_mouse: 10, self._press_key: 6, self._open_preset: 1, self._undo: 3,
            self._close_dialog: 6,
        }  # fmt: skip

    def act(self) -> str:
        """Do something; its name."""
        [way] = self._chance.choices(list(self._ways), list(self._ways.values()))
        if self._large and len(self._window.session.document.rig.sensors) < FEWEST_SENSORS:
            way = self._open_preset
        done = way()
        self.pause_ms = self._chance.choice((0, 5, 60))
        QTest.qWait(self.pause_ms)
        return f"{way.__name__}: {done}"

    def _choose_action(self) -> str:
        able = [
            a for a in self._window.bench.actions if a.isEnabled() and a.objectName() not in self._shunned
        ]
        action = self._chance.choice(able)
        action.trigger()
        return action.objectName()

    def _bring_up(self) -> str:
        dock = self._chance.choice(list(self._window.bench.docks))
        self._window.bench.docks.bring_up(dock.objectName())
        return dock.objectName()

    def _drop_dock(self) -> str:
        dock = self._chance.choice(list(self._window.bench.docks))
        if self._chance.random() < 0.5:
            dock.close()
        else:
            dock.setFloating(not dock.isFloating())
        return dock.objectName()

    def _use_widget(self) -> str:
        """Use a control that is in sight, of a dock or a dialog."""
        around = [*self._window.findChildren(QDockWidget), *_dialogs()]
        shown = [widget for widget in around if widget.isVisible() and not widget.visibleRegion().isEmpty()]
        usable: list[QWidget] = []
        if shown:
            place = self._chance.choice(shown)
            found = place.findChildren(QWidget)
            usable = [w for w in found if w.isVisible() and w.isEnabled() and isinstance(w, USED)]
        if not usable:
            return "nothing"
        widget = self._chance.choice(usable)
        self._use(widget)
        return f"{type(widget).__name__} {widget.objectName()}"

    def _use(self, widget: QWidget) -> None:
        chance = self._chance
        if isinstance(widget, QAbstractButton):
            widget.click()
        elif isinstance(widget, QComboBox):
            self._choose_item(widget)
        elif isinstance(widget, QAbstractSpinBox):
            widget.stepBy(chance.choice((-1, 1)))
        elif isinstance(widget, QLineEdit):
            self._type(widget)
        elif isinstance(widget, QTabBar):
            widget.setCurrentIndex(chance.randrange(max(widget.count(), 1)))
        elif isinstance(widget, QAbstractSlider):
            widget.setValue(
                chance.randint(widget.minimum(), max(widget.minimum(), min(widget.maximum(), 500)))
            )
        elif isinstance(widget, QAbstractItemView):
            port = widget.viewport()
            at = QPoint(chance.randrange(max(port.width(), 1)), chance.randrange(max(port.height(), 1)))
            QTest.mouseClick(port, LEFT, pos=at)

    def _choose_item(self, combo: QComboBox) -> None:
        if combo.objectName() == "voxel_m":
            combo.setCurrentText(self._chance.choice(EDGES_M))
        elif able := [i for i in range(combo.count()) if combo.model().index(i, 0).flags() & ENABLED]:
            index = self._chance.choice(able)  # no separator, which no user can choose
            combo.setCurrentIndex(index)
            combo.activated.emit(index)

    def _type(self, edit: QLineEdit) -> None:
        if isinstance(edit.parent(), QComboBox) or edit.isReadOnly():
            return
        edit.setFocus()
        edit.selectAll()
        if self._chance.random() < 0.2:
            text = self._chance.choice(("", "x", "camera", "front", "-1", "1e9", "two words"))
        else:
            text = f"{self._chance.uniform(-3.0, 30.0):.2f}"
        QTest.keyClicks(edit, text)
        QTest.keyClick(edit, Qt.Key.Key_Return)

    def _move_sensor(self) -> str:
        document = self._window.session.document
        if not document.rig.sensors:
            return "nothing"
        sensor = self._chance.choice(document.rig.sensors)
        x, y, z = (v + self._chance.gauss(0.0, 0.1) for v in sensor.position)
        rpy = tuple(a + self._chance.gauss(0.0, 3.0) for a in sensor.rpy_deg)
        moved = sensor.replace(position=(x, y, z), rpy_deg=rpy)
        self._window.bench.guarded(
            lambda: document.apply(document.rig.with_sensor(sensor.name, moved), "move")
        )()
        return sensor.name

    def _select(self) -> str:
        names = [sensor.name for sensor in self._window.session.document.rig.sensors]
        if names:
            self._window.session.document.select(self._chance.choice(names))
        return "a sensor"

    def _use_mouse(self) -> str:
        """Hover, click, drag or turn the wheel somewhere in the 3D view."""
        canvas: QWidget = self._window.bench.viewport._canvas  # type: ignore[attr-defined]
        at, to = (
            QPoint(self._chance.randrange(canvas.width()), self._chance.randrange(canvas.height()))
            for _ in "ab"
        )
        QTest.mouseMove(canvas, at)
        what = self._chance.choice(("hover", "click", "drag", "drag"))
        if what == "click":
            QTest.mouseClick(canvas, LEFT, pos=at)
        elif what == "drag":
            QTest.mousePress(canvas, LEFT, pos=at)
            for step in range(1, 6):
                QTest.mouseMove(canvas, at + (to - at) * step / 20)
                QTest.qWait(1)
            QTest.mouseRelease(canvas, LEFT, pos=at + (to - at) / 4)
        return what

    def _press_key(self) -> str:
        key = self._chance.choice(KEYS)
        QTest.keySequence(self._window, key)
        return key

    def _open_preset(self) -> str:
        if self._large:
            self._window.session.document.show(self._large)
            return self._large.name
        name = self._chance.choice(list(PRESETS))
        self._window.features.files.open_preset(name)
        return name

    def _undo(self) -> str:
        actions = self._window.bench.actions
        steps = self._chance.randint(1, 8)
        for _ in range(steps):
            actions[self._chance.choice(("undo", "undo", "redo"))].trigger()
        return f"{steps} steps"

    def _close_dialog(self) -> str:
        for dialog in _dialogs():
            dialog.close()
        return "all"


USED = (QAbstractButton, QComboBox, QAbstractSpinBox, QLineEdit, QTabBar, QAbstractSlider, QAbstractItemView)


def _dialogs() -> list[QDialog]:
    return [w for w in QApplication.topLevelWidgets() if isinstance(w, QDialog) and w.isVisible()]


def _end_questions() -> None:
    """Close whatever would stop everything else until it is answered."""
    waiting = QApplication.activePopupWidget() or QApplication.activeModalWidget()
    if waiting is not None:
        waiting.close()


class Slowest:
    """The actions that took longest, how much of it the interface itself was at work, and where."""

    def __init__(self) -> None:
        self._took: list[tuple[float, float, str, Counter[str]]] = []
        self._began_s, self._own_s, self._places = math.inf, 0.0, Counter[str]()
        self._interface = threading.get_ident()
        threading.Thread(target=self._look, daemon=True).start()

    def _look(self) -> None:
        while True:
            time.sleep(LOOK_S)
            if time.monotonic() - self._began_s > SLOW_S:
                self._places[self._place()] += 1

    def _place(self) -> str:
        """Return where the interface is; no frame outlives this call, with a painter that its widget has done with."""
        frame, inner = sys._current_frames().get(self._interface), list[str]()
        while frame is not None and len(inner) < 4:
            if place := function_of(frame.f_code):
                inner.append(f"{place}:{frame.f_lineno}")
            frame = frame.f_back
        return " < ".join(inner) or "events"

    def begin(self) -> None:
        """Begin an action."""
        self._places = Counter()
        self._began_s, self._own_s = time.monotonic(), time.thread_time()

    def end(self, name: str, pause_ms: int) -> None:
        """End an action, of which a pause counts for nothing."""
        took_s = time.monotonic() - self._began_s - pause_ms / 1000.0
        self._began_s = math.inf
        own_s = time.thread_time() - self._own_s
        self._took.append((took_s, own_s, name, self._places if took_s > SLOW_S else Counter()))

    def tell(self) -> None:
        """Print the slowest."""
        for which, seconds in (
            ("", [one[0] for one in self._took]),
            (" at work", [one[1] for one in self._took]),
        ):
            over = ", ".join(f"{sum(s > limit for s in seconds)} over {limit} s" for limit in (0.3, 0.5, 1.0))
            print(f"{len(seconds)} actions{which}: {over}, longest {max(seconds, default=0.0):.2f} s")
        for took_s, own_s, name, places in sorted(self._took, key=lambda one: -one[0])[:TOLD]:
            print(f"{took_s:6.2f} s, {own_s:5.2f} s at work: {name}")
            print(*(f"    {n} {at}" for at, n in places.most_common(3)), sep="\n")


def settle(window: MainWindow) -> None:
    """Wait until figures are exact and objects are counted, or for LONGEST_S."""
    until, counter = time.monotonic() + LONGEST_S, window.bench.counter
    while not (window.is_exact and counter.wait_until_idle(0.0)) and time.monotonic() < until:
        QTest.qWait(1)  # which sleeps with Python's lock held: the workers run between


def measured(window: MainWindow) -> tuple[int, int, float]:
    """Memory at rest in MB, objects of Qt in the window, and millions of voxels that the user chose."""
    settle(window)
    freed = window.findChild(FreedMemory)
    assert freed is not None
    freed.resting.emit()  # as the window does after five seconds
    gc.collect()
    trim()
    shown = window.session.scene
    voxels = 0.0 if shown is None else math.prod(shown.field.grid.shape) / 1e6
    return int(psutil.Process().memory_info().rss // MEGABYTE), len(window.findChildren(QObject)), voxels


def is_steady(megabytes: Sequence[float], limit_mb: float) -> bool:
    """Return whether memory is below the limit in the end, and no longer grows over the last half."""
    quarter = max(len(megabytes) // 4, 1)
    third, last = megabytes[-2 * quarter : -quarter], megabytes[-quarter:]
    return last[-1] <= limit_mb and statistics.mean(last) <= GROWTH * statistics.mean(third or last)


def campaign(window: MainWindow, options: argparse.Namespace, folder: Path) -> list[float]:
    """Act `count` times or for some minutes; memory in MB at the beginning and after every EVERY actions."""
    window.bench.dialogs = Answers(folder)
    guard = QTimer(interval=300)
    guard.timeout.connect(_end_questions)
    guard.start()
    large = car(LARGE) if options.rig == LARGE else None
    user, slowest, before = Restless(window, options.seed, large), Slowest(), None
    held, number, began_s = list[float](), 0, time.monotonic()
    while True:
        minutes = (time.monotonic() - began_s) / 60.0
        is_last = minutes > options.minutes if options.minutes else number == options.count
        if number % EVERY == 0 or is_last:
            busy_mb = psutil.Process().memory_info().rss // MEGABYTE
            mb, objects, voxels = measured(window)
            held.append(float(mb))
            sensors = len(window.session.document.rig.sensors)
            print(
                f"{number:6d} {minutes:5.1f} min {mb:5d} MB, {busy_mb} before rest, {objects:6d} objects of Qt,"
                f" {voxels:5.1f} M voxels, {sensors} sensors",
                flush=True,
            )
        if options.trace and (is_last or number == options.count // 2):
            before = _told_growth(before)
        if is_last:
            break
        QCursor.setPos(window.mapToGlobal(QPoint(5, 5)))
        slowest.begin()
        done = user.act()
        slowest.end(f"{number} {done}", user.pause_ms)
        if os.environ.get("RESTLESS_SAYS"):
            print(number, done, flush=True)
        number += 1
    guard.stop()
    slowest.tell()
    return held


def _told_growth(before: tracemalloc.Snapshot | None) -> tracemalloc.Snapshot:
    """Print what Python holds most of, or where it grew since `before`."""
    now = tracemalloc.take_snapshot()
    found = now.compare_to(before, "traceback") if before else now.statistics("traceback")
    for line in found[:25]:
        print(line, *(f"    {frame}" for frame in list(line.traceback)[-6:]), sep="\n")
    return now


def main(arguments: Sequence[str]) -> int:
    """Open the window as the command line does and have it used; the process ends by its own hand."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rig", default="nuScenes car", help=f"also '{LARGE}', which stays open")
    parser.add_argument("--minutes", type=float, help="how long, instead of how many actions")
    parser.add_argument("--trace", action="store_true", help="say which lines of Python hold memory")
    options = parser.parse_args(arguments)
    sys.modules["mypy"] = None  # type: ignore[assignment]  # users have none, and pyvista loads it where it is
    folder = Path(tempfile.mkdtemp(prefix="riglens-restless-"))
    os.environ["RIGLENS_CONFIG_DIR"], os.environ["RIGLENS_STATE_DIR"] = str(folder / "c"), str(folder / "s")
    if options.trace:
        tracemalloc.start(8)
    app = QApplication(["riglens"])

    def use() -> None:
        window = next(widget for widget in app.topLevelWidgets() if isinstance(widget, MainWindow))
        try:
            held = campaign(window, options, folder)
            log = folder / "s" / "riglens.log"
            failures = log.read_text(encoding="utf-8").count("unexpected failure") if log.exists() else 0
            print(
                f"{held[0]:.0f} to {held[-1]:.0f} MB, at most {max(held):.0f}; {failures} unexpected failures"
            )
            limit_mb = LARGE_MB if options.rig == LARGE else LIMIT_MB
            code = 0 if is_steady(held, limit_mb) and not failures else 1
        except BaseException:
            traceback.print_exc()
            code = 1
        sys.stdout.flush()
        os._exit(code)

    QTimer.singleShot(0, use)
    opened = OpenedRig(car(LARGE)) if options.rig == LARGE else open_rig(options.rig)
    return open_window(opened, SceneOptions(), ScoreOptions())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
