"""The 3D view as a person uses it: the mouse drags, turns, selects and zooms; closing releases everything.

Every statement holds for the window on a display and for the picture drawn without one.
"""

import gc
import itertools
import os
import subprocess
import sys
import weakref
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QImage, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from core.errors import InputError
from core.geometry import Pose
from core.rig.model import Camera, EvenAngles, Lidar, Rig, Vehicle
from widgets.gizmo.drag import Handle, along_axis_m, gizmo_axes
from widgets.gizmo.handles import handle_polyline
from widgets.viewport.heat_scale import HeatmapData
from widgets.viewport.offscreen import OffscreenViewport
from widgets.viewport.viewport import Viewport
from widgets.viewport.viewport_base import ViewportBase

LIDAR = Lidar(
    name="roof",
    position=(0.2, 0.5, 2.2),
    rpy_deg=(0.0, 0.0, 20.0),
    elevations_deg=EvenAngles(**{"from": -25.0, "to": 25.0, "count": 16}),
)
CAMERA = Camera(name="front", position=(-1.2, -0.5, 1.8), hfov_deg=70.0)
RIG = Rig(sensors=(LIDAR, CAMERA))


@dataclass
class Heard:
    """What a viewport emitted, in order."""

    signals: list[tuple[object, ...]] = field(default_factory=list)
    frames: int = 0

    def story(self) -> list[object]:
        """Names of the signals, repetitions left out: a real pointer may report a place twice."""
        return [name for name, _ in itertools.groupby(signal[0] for signal in self.signals)]


def listen(view: ViewportBase) -> Heard:
    heard = Heard()
    for name in ("sensor_picked", "drag_started", "drag_moved", "drag_finished", "drag_cancelled"):
        getattr(view, name).connect(lambda *values, name=name: heard.signals.append((name, *values)))

    def count() -> None:
        heard.frames += 1

    view.drawn.connect(count)
    return heard


@pytest.fixture(params=[Viewport, OffscreenViewport], ids=["window", "offscreen"])
def view(request: pytest.FixtureRequest, qtbot) -> Iterator[ViewportBase]:
    viewport = request.param()
    viewport.resize(900, 600)
    viewport.set_rig(RIG, frozenset(), "roof")
    viewport.show()
    qtbot.waitExposed(viewport)
    settle(viewport)
    yield viewport
    viewport.close()


def settle(view: ViewportBase) -> None:
    QTest.qWait(220)


def to_point(view: ViewportBase, pixel: np.ndarray) -> QPoint:
    return QPoint(round(float(pixel[0])), round(float(pixel[1])))


def pixel_at(view: ViewportBase, position_m: np.ndarray | tuple[float, ...]) -> np.ndarray:
    scene = view._scene
    return scene.state.camera.project(np.array(position_m), scene.size)[0, :2]


def handle_pixel(view: ViewportBase, handle: Handle) -> np.ndarray:
    """A pixel at which exactly this handle is grasped."""
    scene = view._scene
    line = handle_polyline(handle, scene.gizmo_place(), scene.state.camera)
    pixels = np.round(scene.state.camera.project(line[~np.isnan(line).any(axis=1)], scene.size)[:, :2])
    pixels = np.concatenate([pixels, (pixels[:-1] + pixels[1:]) // 2])
    return next(pixel for pixel in pixels if scene.handle_at(tuple(pixel)) == handle)


def drag(view: ViewportBase, start: np.ndarray, end: np.ndarray, release: bool = True) -> None:
    canvas = view._canvas
    QTest.mouseMove(canvas, to_point(view, start))
    QTest.mousePress(canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))
    for share in (0.3, 0.7, 1.0):
        QTest.mouseMove(canvas, to_point(view, start + share * (end - start)))
        QTest.qWait(5)
    if release:
        QTest.mouseRelease(canvas, Qt.MouseButton.LeftButton, pos=to_point(view, end))


@pytest.mark.parametrize("space", ["world", "local"])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_dragging_an_arrow_by_a_metre_on_the_screen_moves_the_sensor_by_that_metre(view, axis, space):
    view.set_gizmo("move", space)
    heard = listen(view)
    direction, origin = gizmo_axes(LIDAR.pose, space)[:, axis], np.array(LIDAR.position)
    start = handle_pixel(view, Handle("move", axis))
    grasp_m = along_axis_m(origin, direction, view._scene.state.camera.ray(tuple(start), view._scene.size))
    drag(view, start, pixel_at(view, origin + (grasp_m + 1.0) * direction))
    _, name, pose = heard.signals[-2]
    assert heard.story() == ["drag_started", "drag_moved", "drag_finished"]
    assert name == "roof" and pose.rpy_deg == LIDAR.rpy_deg
    assert np.allclose(pose.position_m, origin + direction, atol=0.03)


def test_dragging_a_ring_turns_the_sensor_and_moves_nothing(view):
    view.set_gizmo("rotate", "world")
    heard = listen(view)
    start = handle_pixel(view, Handle("rotate", 2))
    drag(view, start, start + np.array([60.0, 5.0]))
    pose = heard.signals[-2][2]
    assert pose.position_m == LIDAR.position and pose.rpy_deg[:2] == (0.0, 0.0)
    assert abs(pose.rpy_deg[2] - 20.0) > 5.0


def test_the_view_shows_the_dragged_pose_at_once_and_keeps_its_camera(view):
    heard = listen(view)
    camera = view.scene_state.camera
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -50.0]), release=False)
    shown = view.scene_state.rig.sensor("roof").pose
    assert shown == heard.signals[-1][2] and shown.position_m[2] > 2.3
    assert view.scene_state.camera == camera
    QTest.mouseRelease(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))


def test_escape_cancels_a_drag_and_restores_the_start_pose(view):
    heard = listen(view)
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -50.0]), release=False)
    QTest.keyClick(view._canvas, Qt.Key.Key_Escape)
    QTest.mouseMove(view._canvas, to_point(view, start + np.array([0.0, -90.0])))
    QTest.mouseRelease(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))
    assert heard.story()[-1] == "drag_cancelled" and "drag_finished" not in heard.story()
    assert view.scene_state.rig.sensor("roof") == LIDAR


def test_a_sensor_deleted_while_it_is_dragged_ends_the_drag_in_peace(view):
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -20.0]), release=False)
    view.set_rig(Rig(sensors=(CAMERA,)), frozenset(), None)
    QTest.mouseMove(view._canvas, to_point(view, start + np.array([0.0, -60.0])))
    assert view.cancel_drag()
    settle(view)
    assert view.scene_state.rig.sensors == (CAMERA,)


def test_a_click_selects_the_sensor_under_the_mouse_and_a_click_on_nothing_selects_none(view):
    heard = listen(view)
    QTest.mouseClick(
        view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, pixel_at(view, CAMERA.position))
    )
    QTest.mouseClick(view._canvas, Qt.MouseButton.LeftButton, pos=QPoint(15, 15))
    assert heard.signals == [("sensor_picked", "front"), ("sensor_picked", None)]


def test_a_hidden_sensor_cannot_be_picked_and_shows_no_gizmo(view):
    heard = listen(view)
    view.set_rig(RIG, frozenset({"roof"}), "roof")
    pixel = to_point(view, pixel_at(view, LIDAR.position))
    QTest.mouseClick(view._canvas, Qt.MouseButton.LeftButton, pos=pixel)
    assert heard.signals == [("sensor_picked", None)]


def test_dragging_beside_the_gizmo_turns_the_view_and_selects_nothing(view):
    heard = listen(view)
    before = view.scene_state.camera
    drag(view, np.array([60.0, 500.0]), np.array([160.0, 460.0]))
    after = view.scene_state.camera
    assert heard.signals == []
    assert after.azimuth_deg != before.azimuth_deg and after.elevation_deg < before.elevation_deg
    assert after.focal_m == before.focal_m and after.distance_m == before.distance_m


@pytest.mark.parametrize("button", [Qt.MouseButton.MiddleButton, Qt.MouseButton.LeftButton])
def test_the_middle_button_or_shift_pans(view, button):
    before = view.scene_state.camera
    keys = (
        Qt.KeyboardModifier.ShiftModifier
        if button == Qt.MouseButton.LeftButton
        else Qt.KeyboardModifier.NoModifier
    )
    QTest.mousePress(view._canvas, button, keys, QPoint(60, 500))
    QTest.mouseMove(view._canvas, QPoint(120, 450))
    QTest.mouseRelease(view._canvas, button, keys, QPoint(120, 450))
    after = view.scene_state.camera
    assert after.focal_m != before.focal_m
    assert (after.azimuth_deg, after.elevation_deg) == (before.azimuth_deg, before.elevation_deg)


def turn_wheel(view: ViewportBase, pixel: np.ndarray, notches: int) -> None:
    place = QPointF(float(pixel[0]), float(pixel[1]))
    none = Qt.KeyboardModifier.NoModifier
    event = QWheelEvent(
        place, view._canvas.mapToGlobal(place), QPoint(), QPoint(0, 120 * notches),
        Qt.MouseButton.NoButton, none, Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    QApplication.sendEvent(view._canvas, event)


def test_the_wheel_zooms_and_keeps_the_place_under_the_cursor(view):
    before = view.scene_state.camera
    focal_pixel = pixel_at(view, before.focal_m)
    turn_wheel(view, focal_pixel, 2)
    assert view.scene_state.camera.distance_m < 0.8 * before.distance_m
    assert np.allclose(pixel_at(view, before.focal_m), focal_pixel, atol=1e-3)


def test_any_number_of_changes_in_one_go_makes_one_frame(view):
    heard = listen(view)
    for x in (0.1, 0.2, 0.3):
        moved = LIDAR.with_pose(Pose((x, 0.5, 2.2), LIDAR.rpy_deg))
        view.set_rig(RIG.with_sensor("roof", moved), frozenset(), "roof")
    view.set_gizmo("move", "world")
    view.set_view("top")
    QTest.qWait(60)
    assert heard.frames == 1


def test_an_idle_view_draws_nothing(view):
    heard = listen(view)
    QTest.qWait(300)
    assert heard.frames == 0


def picture(view: ViewportBase) -> np.ndarray:
    settle(view)
    image = view.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    if isinstance(view, Viewport):
        screen = QApplication.primaryScreen()
        shot = screen.grabWindow(view._canvas.winId()).toImage()
        image = shot.convertToFormat(QImage.Format.Format_RGB888)
    rows = np.frombuffer(image.constBits(), dtype=np.uint8).reshape(image.height(), image.bytesPerLine())
    return rows[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(int)


def test_the_picture_on_the_screen_changes_with_what_is_shown(view):
    empty = picture(view)
    x, y = np.meshgrid(np.arange(-4, 4, 0.4), np.arange(-6, -2, 0.4))
    centres = np.stack([x.ravel(), y.ravel(), np.full(x.size, 0.4)], axis=1).astype(np.float32)
    view.set_heatmap(HeatmapData(centres, 0.4, np.ones(len(centres), np.float32), "seen", "share", 0.0, 1.0))
    heat = picture(view)
    view.set_heatmap(None)
    again = picture(view)
    assert (np.abs(heat - empty).max(axis=2) > 60).mean() > 0.01
    assert (np.abs(again - empty).max(axis=2) > 60).mean() < 0.001


def test_an_unknown_car_body_is_refused_and_the_car_stays(view):
    with pytest.raises(InputError, match=r"vehicle\.body"):
        view.set_vehicle(Vehicle(body="hovercraft"))
    assert view.scene_state.vehicle.body == "sedan"


@pytest.mark.parametrize("kind", [Viewport, OffscreenViewport])
def test_closing_the_view_releases_its_render_window(kind: Callable[[], ViewportBase], qtbot):
    viewport = kind()
    viewport.resize(300, 200)
    viewport.set_rig(RIG, frozenset(), "roof")
    viewport.show()
    settle(viewport)
    window = weakref.ref(viewport._plotter.render_window)
    viewport.close()
    viewport.set_rig(RIG, frozenset(), None)
    viewport.request_render()
    settle(viewport)
    del viewport
    gc.collect()
    QApplication.processEvents()
    assert window() is None


NO_DISPLAY = """
import sys
from PySide6.QtWidgets import QApplication
from PySide6.QtTest import QTest
from widgets.viewport.backend import create_viewport
app = QApplication([])
view = create_viewport()
view.resize(320, 200)
view.show()
QTest.qWait(300)
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
        text=True,
        timeout=120,
        check=False,
    )
    assert run.stdout.strip() == "OffscreenViewport 320 True", run.stderr
