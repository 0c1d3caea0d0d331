"""A person at the real window: mouse and key events, waiting until all is exact, pictures of the screen."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sized
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMenu, QPushButton, QWidget

from riglens.app.window.dialogs import Dialogs, Unsaved
from riglens.app.window.main_window import MainWindow
from riglens.widgets.gizmo.drag import Handle
from riglens.widgets.gizmo.handles import handle_polyline
from riglens.widgets.panels.sensors.library import LibraryList

LEFT = Qt.MouseButton.LeftButton
PATIENCE_S = 400.0
"""How long to wait for something: a cold cache has kernels compiled first."""
TICK_S = 0.1
"""The most that one look counts for: while this process gets no time on a busy machine, nobody waits in vain."""


class Answers(Dialogs):
    """Dialogs that answer by themselves: every file is `path`."""

    path: Path | None = None

    def save_rig(self, parent: QWidget, suggestion: Path) -> Path | None:
        return self.path

    def save_picture(self, parent: QWidget, suggestion: Path) -> Path | None:
        return self.path

    def export_rig(self, parent: QWidget, suggestion: Path, title: str, is_folder: bool) -> Path | None:
        return self.path

    def unsaved(self, parent: QWidget, rig_name: str) -> Unsaved:
        return "discard"

    def show_text(self, parent: QWidget, title: str, html: str, details: str = "") -> None:
        """Nobody reads here."""


@dataclass
class Person:
    """Uses one window; pictures go to `folder`, times to `notes`."""

    window: MainWindow
    folder: Path
    part: str
    notes: dict[str, Any] = field(default_factory=dict)
    _pictures: int = 0

    @property
    def canvas(self) -> QWidget:
        """The widget of the 3D view that takes the mouse."""
        found: QWidget = self._view._canvas
        return found

    @property
    def _view(self) -> Any:
        return self.window.bench.viewport

    # ------------------------------------------------------------------ looking
    def wait(self, is_true: Callable[[], object], what: str) -> None:
        """Wait until something is so."""
        waited_s, looked_at = 0.0, time.monotonic()
        while not is_true():
            assert waited_s < PATIENCE_S, f"waited in vain: {what}"
            QTest.qWait(10)
            now = time.monotonic()
            waited_s, looked_at = waited_s + min(now - looked_at, TICK_S), now

    def settle(self) -> None:
        """Wait until all figures are exact and the picture of them is drawn in full."""
        self.wait(lambda: self.window.is_exact and self._view.is_at_rest, "exact scores, and their picture")
        QApplication.processEvents()  # what is drawn by now is shown

    def look(self, name: str) -> None:
        """Keep a picture of the whole screen."""
        self.settle()
        self._pictures += 1
        screen = QApplication.primaryScreen().grabWindow(0)
        assert screen.save(str(self.folder / f"{self.part}-{self._pictures:02d}-{name}.png"))

    def seen(self, class_name: str = "car") -> float:
        """The share seen by any sensor in percent, as the table says it."""
        self.settle()
        return float(self.window.bench.panels.scores.table.cell(class_name, "seen").text.removesuffix("%"))

    def pixel(self, position_m: tuple[float, float, float]) -> QPoint:
        """Where a point of the world is on the canvas."""
        scene = self._view._scene
        x, y = scene.state.camera.project(np.array([position_m]), scene.size)[0, :2]
        return QPoint(round(x), round(y))

    # ------------------------------------------------------------------ acting
    def key(self, keys: str) -> None:
        """Press a shortcut."""
        QTest.keySequence(self.window, QKeySequence(keys))
        QTest.qWait(20)

    def raise_dock(self, name: str) -> None:
        """Bring a dock to the front."""
        self.window.bench.docks[name].show()
        self.window.bench.docks[name].raise_()
        QTest.qWait(50)

    def double_click_model(self, model: str) -> None:
        """Double click a model in the library, which adds a sensor."""
        library = self.window.bench.docks["Library"].widget()
        assert isinstance(library, LibraryList)
        models = library.models
        row = next(row for row in models.rows() if model in row.text(0))
        models.scrollToItem(row)
        at = models.visualItemRect(row).center()
        QTest.mouseClick(models.viewport(), LEFT, pos=at)
        QTest.mouseDClick(models.viewport(), LEFT, pos=at)
        QTest.qWait(50)

    def click(self, at: QPoint) -> None:
        """Click into the 3D view."""
        QTest.mouseMove(self.canvas, at)
        QTest.qWait(50)
        QTest.mouseClick(self.canvas, LEFT, pos=at)
        QTest.qWait(50)

    def handle(self, handle: Handle) -> QPoint:
        """A pixel at which exactly this handle of the gizmo is grasped."""
        scene = self._view._scene
        line = handle_polyline(handle, scene.under_mouse.gizmo(), scene.state.camera)
        pixels = np.round(scene.state.camera.project(line[~np.isnan(line).any(axis=1)], scene.size)[:, :2])
        pixels = np.concatenate([pixels, (pixels[:-1] + pixels[1:]) // 2])
        x, y = next(pixel for pixel in pixels if scene.under_mouse.handle(tuple(pixel)) == handle)
        return QPoint(int(x), int(y))

    def drag(self, name: str, start: QPoint, by: QPoint, steps: int = 40) -> list[float]:
        """Drag from a pixel, noting under `name` how long each step takes until it is drawn; the times, ms."""
        drawn: list[float] = []
        connection = self._view.drawn.connect(lambda: drawn.append(time.perf_counter()))
        QTest.mouseMove(self.canvas, start)
        QTest.mousePress(self.canvas, LEFT, pos=start)
        took_ms = []
        for step in range(1, steps + 1):
            before, frames = time.perf_counter(), len(drawn)
            QTest.mouseMove(self.canvas, start + by * step / steps)
            self.wait(partial(_is_longer, drawn, frames), "a frame of the drag")
            took_ms.append(1e3 * (drawn[-1] - before))
        QTest.mouseRelease(self.canvas, LEFT, pos=start + by)
        self._view.drawn.disconnect(connection)
        self.notes[name] = {
            "steps": steps,
            "median_ms": round(statistics.median(took_ms), 1),
            "slowest_ms": round(max(took_ms), 1),
        }
        return took_ms

    def type_into(self, edit: QWidget, text: str) -> None:
        """Replace what stands in a field and press Return."""
        edit.setFocus()
        QTest.keySequence(edit, QKeySequence("Ctrl+A"))
        QTest.keyClicks(edit, text)
        QTest.keyClick(edit, Qt.Key.Key_Return)
        QTest.qWait(20)

    def press(self, button: QPushButton) -> None:
        """Click a button."""
        QTest.mouseClick(button, LEFT)
        QTest.qWait(50)

    def choose(self, menu: QMenu, *path: str) -> None:
        """Choose an entry of a menu by its words."""
        for words in path[:-1]:
            entry = next(action for action in menu.actions() if action.text() == words)
            menu = entry.menu()  # type: ignore[assignment]
        next(action for action in menu.actions() if action.text() == path[-1]).trigger()
        QTest.qWait(50)


def _is_longer(things: Sized, than: int) -> bool:
    return len(things) > than
