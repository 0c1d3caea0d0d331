"""What the 3D view draws, and when; closing it releases everything.

Every statement holds for the window on a display and for the picture drawn without one.
"""

import math
import os
import subprocess
import sys
from collections.abc import Generator
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

from riglens.core.geometry import Pose
from riglens.core.rig.model import Vehicle
from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.gizmo.drag import Handle
from riglens.widgets.heatmap.scale import HeatLook
from riglens.widgets.viewport.redraw import REST_MS
from riglens.widgets.viewport.viewport import Viewport
from tests.waiting import TIMEOUT_MS, TIMEOUT_S, wait_for
from tests.widgets.mouse import hover
from tests.widgets.viewport.views import (
    BOTH,
    KINDS,
    LIDAR,
    RIG,
    AnyView,
    Offscreen,
    Window,
    change,
    drag,
    frames_of,
    handle_pixel,
    listen,
    one_change,
    picture,
    settle,
    shown,
    to_point,
)

REPOSITORY = Path(__file__).resolve().parents[3]


@pytest.fixture(params=BOTH)
def view(request: pytest.FixtureRequest, qtbot: QtBot) -> AnyView:
    """A view of its own, whose first frames count."""
    return shown(request.param, qtbot, rig=RIG, selected="roof")


def test_letters_are_not_enlarged_twice_on_a_dense_screen(qtbot) -> None:
    view = Viewport()
    qtbot.addWidget(view)
    view.resize(200, 150)
    with qtbot.waitSignal(view.shown, timeout=TIMEOUT_MS):
        view.show()
    window = view._plotter.render_window
    window.SetDPI(144)  # what the widget does on a screen of double density
    view.set_view("top")
    wait_for(lambda: window.GetDPI() == 72)
    view.close_viewport()


def test_the_first_picture_on_the_screen_is_the_one_that_stays(qtbot) -> None:
    view = Window()
    qtbot.addWidget(view)
    window, pictures = view._plotter.render_window, []

    def keep(*_: object) -> None:
        width, height = window.GetSize()
        pixels = vtkUnsignedCharArray()
        window.GetPixelData(0, 0, width - 1, height - 1, 0, pixels, 0)
        pictures.append(vtk_to_numpy(pixels).reshape(height, width, 3).astype(int))

    tag = window.AddObserver("EndEvent", keep)
    view.resize(900, 600)
    change(view, rig=RIG, selected="roof")
    with qtbot.waitSignal(view.shown, timeout=TIMEOUT_MS):
        view.show()
    settle(view)
    window.RemoveObserver(tag)
    assert len(pictures) > 1  # the last one has smooth edges
    assert pictures[0].std() > 10.0
    difference = float(np.abs(pictures[0] - pictures[-1]).mean())
    assert difference < 6.0, difference  # of the smooth edges alone
    view.close()


def test_edges_are_smooth_once_nothing_moves(view):
    frames = frames_of(view)
    view.set_view("top")
    settle(view)
    assert frames.looks == one_change(view)


def test_a_drag_is_drawn_coarsely_until_it_rests_and_then_once_in_full(view):
    frames = frames_of(view)
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -50.0]), release=False)
    view.timers.advance(400)
    assert set(frames.looks[1:]) == {"coarse"}, "a held sensor may move on at any moment"
    QTest.mouseRelease(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))
    settle(view)
    assert set(frames.looks[1:-1]) == {"coarse"} and frames.looks[-1] == "full smooth"


def test_a_drag_and_its_rest_make_nothing_anew(view):
    def everything() -> list[str]:
        renderers = view._plotter.render_window.GetRenderers()
        return [prop.GetAddressAsString("") for renderer in renderers for prop in renderer.GetViewProps()]

    before = everything()
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -50.0]), release=False)
    assert everything() == before
    QTest.mouseRelease(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))
    settle(view)
    assert everything() == before


def heat(values: float) -> HeatmapData:
    x, y = np.meshgrid(np.arange(-4, 4, 0.4), np.arange(-6, -2, 0.4))
    centres = np.stack([x.ravel(), y.ravel(), np.full(x.size, 0.4)], axis=1).astype(np.float32)
    return HeatmapData(centres, 0.4, np.full(x.size, values, np.float32), "seen", "share", vmin=0.0, vmax=1.0)


def test_a_heatmap_that_comes_while_a_sensor_is_held_is_drawn_in_turns_of_its_own(qtbot):
    view = shown(Offscreen, qtbot, rig=RIG, selected="roof", gizmo_mode="move", heatmap=heat(0.2))
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -50.0]), release=False)
    view.timers.advance(REST_MS)
    heard, before = listen(view), picture(view, wait=False)
    turns = []
    draw_haze, draw_moving = view._scene.draw_haze, view._scene.draw_moving
    view._scene.draw_haze = lambda: noted(turns, draw_haze())
    view._scene.draw_moving = lambda: (turns.append("frame"), draw_moving())
    view._scene._standing._haze_due_s = math.inf
    change(view, heatmap=heat(0.9))
    view.timers.advance(REST_MS - 1)
    assert turns == ["frame"], "what comes soon after another one waits"
    view._scene._standing._haze_due_s = 0.0
    view.timers.advance(1)
    assert turns == ["frame", "part", "part", "part", "frame"] and heard.frames == 2
    assert not np.array_equal(picture(view, wait=False), before)
    view.timers.run_out()
    assert view.is_at_rest and len(turns) == 5, "nothing is drawn over and over while it is held"
    QTest.mouseRelease(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))
    settle(view)
    view.close()


def test_frames_and_parts_of_a_heatmap_take_turns_while_the_mouse_goes_on(qtbot):
    view = shown(Offscreen, qtbot, rig=RIG, selected="roof", gizmo_mode="move", heatmap=heat(0.2))
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -50.0]), release=False)
    view.timers.advance(REST_MS)
    turns = []
    draw_haze, draw_moving = view._scene.draw_haze, view._scene.draw_moving
    view._scene.draw_haze = lambda: noted(turns, draw_haze())
    view._scene.draw_moving = lambda: (turns.append("frame"), draw_moving())
    view._scene._standing._haze_due_s = 0.0
    change(view, heatmap=heat(0.9))
    while turns.count("part") < 3:
        view.request_render()  # another step of the mouse before every turn
        assert view.timers.run_next()
    assert turns == ["frame", "frame", "part"] * 3, "no step waits for more than a part, and parts come on"
    view.timers.run_out()
    view.close()


def noted(turns: list[str], parts: Generator[None, None, bool]) -> Generator[None, None, bool]:
    """The same parts, each noted."""
    while True:
        turns.append("part")
        try:
            next(parts)
        except StopIteration as end:
            return bool(end.value)
        yield


def test_a_view_that_is_closed_between_two_parts_of_a_heatmap_draws_no_more(qtbot):
    view = shown(Offscreen, qtbot, rig=RIG, selected="roof", gizmo_mode="move", heatmap=heat(0.2))
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -50.0]), release=False)
    view.timers.advance(REST_MS)
    view._scene._standing._haze_due_s = 0.0
    change(view, heatmap=heat(0.9))
    while view._haze is None:
        assert view.timers.run_next()
    view.timers.run_next()
    heard = listen(view)
    view.close()
    view.timers.run_out()
    assert heard.frames == 0


def test_changes_right_after_one_another_are_drawn_coarsely_and_a_single_one_in_full(view):
    frames = frames_of(view)
    for opacity in (0.4, 0.45, 0.5, 0.55):
        change(view, heat_look=HeatLook(opacity=opacity))
        view.timers.run_next()  # the picture of the first one has begun when the second one comes
    settle(view)
    assert "coarse" in frames.looks[:2] and frames.looks[-1] == "full smooth"
    assert set(frames.looks[1:-1]) == {"coarse"}
    frames.looks.clear()
    change(view, heat_look=HeatLook(log=True))
    settle(view)
    assert frames.looks == one_change(view)


def test_the_frame_at_rest_waits_while_the_mouse_is_on_its_way(view):
    change(view, heat_look=HeatLook(opacity=0.4))
    view.timers.run_next()
    change(view, heat_look=HeatLook(opacity=0.5))
    frames = frames_of(view)
    view.timers.advance(REST_MS - 1)
    for step in range(3):
        hover(view._canvas, QPoint(20 + 3 * step, 20))
        view.timers.advance(REST_MS - 1)
    assert frames.looks == ["coarse"]
    view.timers.advance(1)
    assert frames.looks == ["coarse", "full smooth"]


@KINDS
def test_a_picture_at_rest_has_shades_between_the_car_and_what_is_behind_it(kind, qtbot):
    viewport = shown(kind, qtbot, (320, 200))
    smooth = picture(viewport)
    viewport._draw_now()
    wait_for(lambda: viewport.is_current)
    rough = picture(viewport, wait=False)
    viewport.close()
    assert len(np.unique(smooth.reshape(-1, 3), axis=0)) > 1.2 * len(np.unique(rough.reshape(-1, 3), axis=0))


def test_any_number_of_changes_in_one_go_makes_one_frame(view):
    heard = listen(view)
    for x in (0.1, 0.2, 0.3):
        moved = LIDAR.with_pose(Pose((x, 0.5, 2.2), LIDAR.rpy_deg))
        change(view, rig=RIG.with_sensor("roof", moved), selected="roof")
    change(view, gizmo_mode="move", gizmo_space="world")
    view.set_view("top")
    view.timers.advance(REST_MS - 1)
    assert heard.frames == 1


def test_an_idle_view_draws_nothing(view):
    heard = listen(view)
    view.timers.advance(60_000)
    QApplication.processEvents()
    assert heard.frames == 0


def test_the_picture_on_the_screen_changes_with_what_is_shown(view):
    empty = picture(view)
    x, y = np.meshgrid(np.arange(-4, 4, 0.4), np.arange(-6, -2, 0.4))
    centres = np.stack([x.ravel(), y.ravel(), np.full(x.size, 0.4)], axis=1).astype(np.float32)
    change(
        view, heatmap=HeatmapData(centres, 0.4, np.ones(len(centres), np.float32), "seen", "share", 0.0, 1.0)
    )
    heat = picture(view)
    change(view, heatmap=None)
    again = picture(view)
    assert (np.abs(heat - empty).max(axis=2) > 60).mean() > 0.01
    assert (np.abs(again - empty).max(axis=2) > 60).mean() < 0.001


def test_a_box_stands_in_for_a_body_that_is_not_at_hand(view):
    car = picture(view)
    change(view, vehicle=Vehicle(body="meshes/hovercraft.glb"))
    box = picture(view)
    assert view.state.vehicle.body == "meshes/hovercraft.glb"
    assert (np.abs(box - car).max(axis=2) > 60).mean() > 0.01


CLOSED = """
import gc, sys, weakref
from PySide6.QtCore import QCoreApplication, QEvent
from PySide6.QtWidgets import QApplication
from tests.widgets.viewport import views
app = QApplication([])
view = getattr(views, sys.argv[1])()
view.resize(300, 200)
views.change(view, rig=views.RIG, selected="roof")
view.show()
views.settle(view)
window = weakref.ref(view._plotter.render_window)
view.close()
views.change(view, rig=views.RIG, selected=None)
view.request_render()
views.settle(view)
view.deleteLater()
QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
del view
gc.collect()
app.processEvents()
print("released" if window() is None else "kept")
"""


@KINDS
def test_closing_the_view_releases_its_render_window(kind: type[AnyView], xvfb: str):
    """In a process of its own: garbage of other tests is not for this one to collect."""
    run = subprocess.run(
        [sys.executable, "-c", CLOSED, kind.__name__],
        env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
        capture_output=True,
        encoding="utf-8",
        timeout=TIMEOUT_S,
        check=False,
    )
    assert (run.returncode, run.stdout.strip()) == (0, "released"), run.stderr


NO_DISPLAY = """
import sys
from pathlib import Path
from PySide6.QtWidgets import QApplication
from PySide6.QtTest import QTest
from riglens.widgets.viewport.backend import create_viewport
app = QApplication([])
view = create_viewport()
view.resize(320, 200)
view.show()
while view.image.isNull() or not view.is_at_rest:
    QTest.qWait(1)
print(type(view).__name__, view.image.width(), len({view.image.pixel(x, 120) for x in range(320)}) > 20)
view.close()
"""


def test_without_any_display_the_view_is_drawn_into_a_picture():
    environment = {
        name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")
    }
    environment |= {"QT_QPA_PLATFORM": "offscreen", "VTK_DEFAULT_OPENGL_WINDOW": "vtkEGLRenderWindow"}
    run = subprocess.run(
        [sys.executable, "-c", NO_DISPLAY],
        env=environment,
        capture_output=True,
        encoding="utf-8",
        timeout=TIMEOUT_S,
        check=False,
    )
    assert run.stdout.strip() == "OffscreenViewport 320 True", run.stderr


@pytest.mark.parametrize("x_m, y_m", [(30.0, 0.0), (-8.0, 6.0)])
def test_a_place_is_looked_at_over_the_car(view, x_m, y_m):
    view.look_at(x_m, y_m)
    camera = view.state.camera
    assert camera.focal_m[:2] == (x_m, y_m) and camera.elevation_deg >= 30.0
    towards = camera.axes()[2][:2]
    assert towards @ np.array([x_m, y_m]) == pytest.approx(np.hypot(*towards) * np.hypot(x_m, y_m))
