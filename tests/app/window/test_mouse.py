"""The whole window with its real 3D views: mouse events on the gizmo move a sensor and its scores."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from riglens.core.rig.model import Rig
from riglens.widgets.viewport.offscreen import OffscreenViewport
from riglens.widgets.viewport.viewport import Viewport
from tests.app.window_bench import CAMERA, LIDAR, Bench, open_bench
from tests.waiting import wait_for
from tests.widgets.mouse import hover

RIG = Rig(name="small", sensors=(LIDAR.replace(position=(0.0, 0.0, 2.0)), CAMERA))
MAKERS: dict[str, Callable[[], QWidget]] = {"window": Viewport, "offscreen": OffscreenViewport}


@pytest.fixture(params=["window", pytest.param("offscreen", marks=pytest.mark.slow)])
def bench(request: pytest.FixtureRequest, qtbot: QtBot, tmp_path: Path) -> Iterator[Bench]:
    with open_bench(qtbot, tmp_path, RIG, MAKERS[request.param]()) as opened:
        yield opened


class Mouse:
    """A hand on the gizmo of the selected sensor."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self._canvas = bench.viewport.findChild(QWidget)
        bench.act("move")
        bench.act("front")
        bench.document.select("roof")
        wait_for(lambda: bench.viewport.is_at_rest)

    def _pixel(self, position_m: tuple[float, float, float]) -> QPointF:
        """Where a point of the world is on the canvas."""
        state = self._bench.viewport.state
        ratio = self._canvas.devicePixelRatioF()
        size = (round(self._canvas.width() * ratio), round(self._canvas.height() * ratio))
        x, y, _ = state.camera.project(np.array([position_m]), size)[0]
        return QPointF(x / ratio, y / ratio)

    def _send(self, action: Callable[..., None], pixel: QPointF) -> None:
        action(self._canvas, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier, pixel.toPoint())
        QApplication.processEvents()

    def press_z_arrow(self) -> None:
        origin = self._bench.document.rig.sensor("roof").position
        start = self._pixel(origin)
        up = self._pixel((origin[0], origin[1], origin[2] + 0.01)) - start
        self._at = start + up * (45.0 / max(1e-9, (up.x() ** 2 + up.y() ** 2) ** 0.5))
        hover(self._canvas, self._at.toPoint())
        self._send(QTest.mousePress, self._at)

    def move_up(self, pixels: float, steps: int = 4) -> None:
        for _ in range(steps):
            self._at += QPointF(0.0, -pixels / steps)
            hover(self._canvas, self._at.toPoint(), Qt.MouseButton.LeftButton)
            QApplication.processEvents()

    def release(self) -> None:
        self._send(QTest.mouseRelease, self._at)

    def press_escape(self) -> None:
        self.press_key(Qt.Key.Key_Escape)

    def press_key(self, key: Qt.Key, modifiers: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier) -> None:
        self._bench.qtbot.keyClick(self._canvas, key, modifiers)

    def click(self, name: str, modifiers: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier) -> None:
        """Click on a sensor, or with an empty name on nothing."""
        at = self._pixel(self._bench.document.rig.sensor(name).position).toPoint() if name else QPoint(15, 15)
        QTest.mouseClick(self._canvas, Qt.MouseButton.LeftButton, modifiers, at)
        QApplication.processEvents()


def test_dragging_the_blue_arrow_lifts_the_sensor_in_one_step_with_exact_scores(bench: Bench) -> None:
    before = bench.panels.scores.table.as_text()
    mouse = Mouse(bench)
    mouse.press_z_arrow()
    assert bench.document.is_dragging
    mouse.move_up(60)
    bench.settle()
    assert bench.panels.scores.table.as_text() != before
    mouse.release()
    x, y, z = bench.document.rig.sensor("roof").position
    assert (x, y) == (0.0, 0.0)
    assert z > 2.05
    bench.settle()
    lidar = bench.fresh_scores(bench.document.rig).classes["car"].lidar.s_mig
    assert repr(lidar) in bench.panels.scores.table.as_text()
    edit = bench.find("z")
    assert edit.property("text") == f"{z:.4f}".rstrip("0").rstrip(".")
    bench.act("undo")
    assert bench.document.rig == RIG
    bench.settle()
    assert bench.panels.scores.table.as_text() == before
    assert bench.viewport.state.rig == RIG


def test_escape_puts_a_dragged_sensor_back(bench: Bench) -> None:
    mouse = Mouse(bench)
    mouse.press_z_arrow()
    mouse.move_up(60)
    assert bench.document.rig != RIG
    mouse.press_escape()
    assert bench.document.rig == RIG
    assert bench.document.undo_label is None
    assert bench.viewport.state.rig == RIG
    mouse.release()


@pytest.mark.slow
def test_undo_by_key_in_the_middle_of_a_drag_puts_the_sensor_back(bench: Bench) -> None:
    mouse = Mouse(bench)
    mouse.press_z_arrow()
    mouse.move_up(60)
    bench.act("undo")
    mouse.move_up(60)
    mouse.release()
    assert bench.document.rig == RIG
    assert bench.viewport.state.rig == RIG


def test_a_click_on_a_sensor_ends_a_selection_of_all_before_del(bench: Bench) -> None:
    mouse = Mouse(bench)
    mouse.click("front")
    mouse.press_key(Qt.Key.Key_A, Qt.KeyboardModifier.ControlModifier)
    assert bench.panels.tree.chosen == ("roof", "front")
    mouse.click("front")
    assert bench.panels.tree.chosen == ("front",)
    mouse.press_key(Qt.Key.Key_Delete)
    assert [sensor.name for sensor in bench.document.rig.sensors] == ["roof"]
    bench.act("undo")
    assert bench.document.rig == RIG


@pytest.mark.parametrize(
    "key",
    [
        Qt.KeyboardModifier.ControlModifier,
        pytest.param(Qt.KeyboardModifier.ShiftModifier, marks=pytest.mark.slow),
    ],
)
def test_a_click_with_a_key_adds_a_sensor_and_a_second_one_takes_it_out(
    bench: Bench, key: Qt.KeyboardModifier
) -> None:
    mouse = Mouse(bench)
    mouse.click("front", key)
    mouse.click("", key)
    assert bench.document.selection == ("roof", "front")
    assert bench.viewport.state.also_selected == {"roof"}
    mouse.click("front", key)
    assert bench.document.selection == ("roof",)
