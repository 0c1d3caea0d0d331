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
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt
from PySide6.QtGui import QDragEnterEvent, QDragMoveEvent, QDropEvent, QImage, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.model import Camera, EvenAngles, Lidar, Rig, Vehicle
from riglens.widgets.gizmo.drag import Handle, along_axis_m, gizmo_axes
from riglens.widgets.gizmo.handles import handle_polyline
from riglens.widgets.heatmap.scale import HeatLook, HeatmapData
from riglens.widgets.viewport.drop_target import MODEL_MIME
from riglens.widgets.viewport.offscreen import OffscreenViewport
from riglens.widgets.viewport.redraw import REST_MS
from riglens.widgets.viewport.viewport import Viewport
from tests.hand_clock import HandTimers
from tests.waiting import TIMEOUT_MS, TIMEOUT_S, wait_for
from tests.widgets.mouse import hover

LIDAR = Lidar(
    name="roof",
    position=(0.2, 0.5, 2.2),
    rpy_deg=(0.0, 0.0, 20.0),
    elevations_deg=EvenAngles(**{"from": -25.0, "to": 25.0, "count": 16}),
)
CAMERA = Camera(name="front", position=(-1.2, -0.5, 1.8), hfov_deg=70.0)
RIG = Rig(sensors=(LIDAR, CAMERA))


class Window(Viewport):
    """The view in a window, with timers driven by hand."""

    def __init__(self) -> None:
        timers = HandTimers()
        super().__init__(timers=timers)
        self.timers, self.is_current = timers, True
        self.drawn.connect(self._on_drawn)
        self._plotter.frameSwapped.connect(self._on_swapped)

    def _on_drawn(self) -> None:
        self.is_current = False

    def _on_swapped(self) -> None:
        self.is_current = True


class Offscreen(OffscreenViewport):
    """The view as a picture, with timers driven by hand."""

    is_current = True

    def __init__(self) -> None:
        timers = HandTimers()
        super().__init__(timers=timers)
        self.timers = timers


View = Window | Offscreen
KINDS = pytest.mark.parametrize("kind", [Window, Offscreen], ids=["window", "offscreen"])


def change(view: View, **fields: Any) -> None:
    """Show another state: these fields are others."""
    view.show_state(replace(view.state, **fields))


def shown(kind: type[View], qtbot, size: tuple[int, int] = (900, 600), **fields: Any) -> View:
    """A view on the screen that has drawn everything."""
    made = kind()
    made.resize(*size)
    change(made, **fields)
    with qtbot.waitExposed(made, timeout=TIMEOUT_MS):
        made.show()
    settle(made)
    return made


@dataclass
class Heard:
    """What a viewport emitted, in order."""

    signals: list[tuple[object, ...]] = field(default_factory=list)
    frames: int = 0

    def story(self) -> list[object]:
        """Names of the signals, repetitions left out: a real pointer may report a place twice."""
        return [name for name, _ in itertools.groupby(signal[0] for signal in self.signals)]


def listen(view: View) -> Heard:
    heard = Heard()
    names = ("sensor_picked", "drag_started", "drag_moved", "drag_finished", "drag_cancelled")
    for name in (*names, "nudged", "placing_changed", "model_dropped"):
        getattr(view, name).connect(lambda *values, name=name: heard.signals.append((name, *values)))

    def count() -> None:
        heard.frames += 1

    view.drawn.connect(count)
    return heard


@pytest.fixture(params=[Window, Offscreen], ids=["window", "offscreen"])
def view(request: pytest.FixtureRequest, qtbot) -> Iterator[View]:
    made = shown(request.param, qtbot, rig=RIG, selected="roof")
    yield made
    made.close()


def test_letters_are_not_enlarged_twice_on_a_dense_screen(qtbot) -> None:
    view = Viewport()
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


def settle(view: View) -> None:
    """Have the last frame drawn, the one with smooth edges, and wait until it is on the screen."""
    QApplication.processEvents()
    view.timers.run_out()
    assert view.is_at_rest
    wait_for(lambda: view.is_current)
    QApplication.processEvents()


def to_point(view: View, pixel: np.ndarray) -> QPoint:
    return QPoint(round(float(pixel[0])), round(float(pixel[1])))


def pixel_at(view: View, position_m: np.ndarray | tuple[float, ...]) -> np.ndarray:
    scene = view._scene
    return scene.state.camera.project(np.array(position_m), scene.size)[0, :2]


def handle_pixel(view: View, handle: Handle) -> np.ndarray:
    """A pixel at which exactly this handle is grasped."""
    scene = view._scene
    line = handle_polyline(handle, scene.under_mouse.gizmo(), scene.state.camera)
    pixels = np.round(scene.state.camera.project(line[~np.isnan(line).any(axis=1)], scene.size)[:, :2])
    pixels = np.concatenate([pixels, (pixels[:-1] + pixels[1:]) // 2])
    return next(pixel for pixel in pixels if scene.under_mouse.handle(tuple(pixel)) == handle)


def drag(view: View, start: np.ndarray, end: np.ndarray, release: bool = True) -> None:
    canvas = view._canvas
    hover(canvas, to_point(view, start))
    QTest.mousePress(canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))
    for share in (0.3, 0.7, 1.0):
        hover(canvas, to_point(view, start + share * (end - start)), Qt.MouseButton.LeftButton)
        view.timers.advance(5)
    if release:
        QTest.mouseRelease(canvas, Qt.MouseButton.LeftButton, pos=to_point(view, end))


@pytest.mark.parametrize("space", ["world", "local"])
def test_dragging_an_arrow_by_a_metre_on_the_screen_moves_the_sensor_by_that_metre(view, space):
    change(view, gizmo_mode="move", gizmo_space=space)
    heard = listen(view)
    for axis in range(3):
        change(view, rig=RIG, selected="roof")
        heard.signals.clear()
        direction, origin = gizmo_axes(LIDAR.pose, space)[:, axis], np.array(LIDAR.position)
        start, camera = handle_pixel(view, Handle("move", axis)), view._scene.state.camera
        grasp_m = along_axis_m(origin, direction, camera.ray(tuple(start), view._scene.size))
        drag(view, start, pixel_at(view, origin + (grasp_m + 1.0) * direction))
        _, name, pose = heard.signals[-2]
        assert heard.story() == ["drag_started", "drag_moved", "drag_finished"]
        assert name == "roof" and pose.rpy_deg == LIDAR.rpy_deg
        assert np.allclose(pose.position_m, origin + direction, atol=0.03)


def test_dragging_a_ring_turns_the_sensor_and_moves_nothing(view):
    change(view, gizmo_mode="rotate", gizmo_space="world")
    heard = listen(view)
    start = handle_pixel(view, Handle("rotate", 2))
    drag(view, start, start + np.array([60.0, 5.0]))
    pose = heard.signals[-2][2]
    assert pose.position_m == LIDAR.position and pose.rpy_deg[:2] == (0.0, 0.0)
    assert abs(pose.rpy_deg[2] - 20.0) > 5.0


def test_the_view_shows_the_dragged_pose_at_once_and_keeps_its_camera(view):
    heard = listen(view)
    camera = view.state.camera
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -50.0]), release=False)
    shown = view.state.rig.sensor("roof").pose
    assert shown == heard.signals[-1][2] and shown.position_m[2] > 2.3
    assert view.state.camera == camera
    QTest.mouseRelease(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))


def test_escape_cancels_a_drag_and_restores_the_start_pose(view):
    heard = listen(view)
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -50.0]), release=False)
    QTest.keyClick(view._canvas, Qt.Key.Key_Escape)
    hover(view._canvas, to_point(view, start + np.array([0.0, -90.0])), Qt.MouseButton.LeftButton)
    QTest.mouseRelease(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))
    assert heard.story()[-1] == "drag_cancelled" and "drag_finished" not in heard.story()
    assert view.state.rig.sensor("roof") == LIDAR


def test_a_sensor_deleted_while_it_is_dragged_ends_the_drag_in_peace(view):
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -20.0]), release=False)
    change(view, rig=Rig(sensors=(CAMERA,)), selected=None)
    hover(view._canvas, to_point(view, start + np.array([0.0, -60.0])), Qt.MouseButton.LeftButton)
    assert view.cancel_drag()
    settle(view)
    assert view.state.rig.sensors == (CAMERA,)


def test_a_click_selects_the_sensor_under_the_mouse_and_a_click_on_nothing_selects_none(view):
    heard = listen(view)
    QTest.mouseClick(
        view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, pixel_at(view, CAMERA.position))
    )
    QTest.mouseClick(view._canvas, Qt.MouseButton.LeftButton, pos=QPoint(15, 15))
    assert heard.signals == [("sensor_picked", "front"), ("sensor_picked", None)]


def test_a_hidden_sensor_cannot_be_picked_and_shows_no_gizmo(view):
    heard = listen(view)
    change(view, hidden=frozenset({"roof"}))
    pixel = to_point(view, pixel_at(view, LIDAR.position))
    QTest.mouseClick(view._canvas, Qt.MouseButton.LeftButton, pos=pixel)
    assert heard.signals == [("sensor_picked", None)]


def test_a_sensor_that_cannot_be_moved_has_no_gizmo_and_a_drag_there_turns_the_view(view):
    heard = listen(view)
    start, camera = handle_pixel(view, Handle("move", 2)), view.state.camera
    change(view, fixed=frozenset({"roof"}))
    assert view._scene.under_mouse.gizmo() is None
    drag(view, start, start + np.array([40.0, -30.0]))
    assert heard.signals == [] and view.state.camera != camera
    change(view, fixed=frozenset())
    assert view._scene.under_mouse.gizmo() is not None


def test_dragging_beside_the_gizmo_turns_the_view_and_selects_nothing(view):
    heard = listen(view)
    before = view.state.camera
    drag(view, np.array([60.0, 500.0]), np.array([160.0, 460.0]))
    after = view.state.camera
    assert heard.signals == []
    assert after.azimuth_deg != before.azimuth_deg and after.elevation_deg < before.elevation_deg
    assert after.focal_m == before.focal_m and after.distance_m == before.distance_m


@pytest.mark.parametrize("button", [Qt.MouseButton.MiddleButton, Qt.MouseButton.LeftButton])
def test_the_middle_button_or_shift_pans(view, button):
    before = view.state.camera
    keys = (
        Qt.KeyboardModifier.ShiftModifier
        if button == Qt.MouseButton.LeftButton
        else Qt.KeyboardModifier.NoModifier
    )
    QTest.mousePress(view._canvas, button, keys, QPoint(60, 500))
    hover(view._canvas, QPoint(120, 450), button)
    QTest.mouseRelease(view._canvas, button, keys, QPoint(120, 450))
    after = view.state.camera
    assert after.focal_m != before.focal_m
    assert (after.azimuth_deg, after.elevation_deg) == (before.azimuth_deg, before.elevation_deg)


def test_dragging_a_plane_moves_the_sensor_in_that_plane_only(view):
    change(view, gizmo_mode="move", gizmo_space="world")
    heard = listen(view)
    start = handle_pixel(view, Handle("plane", 2))
    drag(view, start, start + np.array([60.0, 20.0]))
    pose = heard.signals[-2][2]
    assert pose.position_m[2] == LIDAR.position[2] and pose.rpy_deg == LIDAR.rpy_deg
    assert all(
        abs(new - old) > 0.05 for new, old in zip(pose.position_m[:2], LIDAR.position[:2], strict=True)
    )


def test_with_snapping_a_drag_ends_on_round_numbers_and_ctrl_inverts_it(view):
    change(view, gizmo_mode="move", gizmo_space="world")
    view.set_snap(True)
    heard = listen(view)
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -33.0]), release=False)
    snapped = heard.signals[-1][2].position_m[2]
    QTest.keyPress(view._canvas, Qt.Key.Key_Control)
    free = heard.signals[-1][2].position_m[2]
    QTest.keyRelease(view._canvas, Qt.Key.Key_Control)
    again = heard.signals[-1][2].position_m[2]
    QTest.mouseRelease(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))
    assert snapped == again == round(round(snapped / 0.05) * 0.05, 9)
    assert free != snapped and abs(free - snapped) <= 0.025 + 1e-9


def test_the_numbers_of_a_drag_stand_beside_the_cursor_until_it_ends(view):
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -40.0]), release=False)
    text, pixel = view._scene._words._echo_at
    assert text.startswith("Δz +") and np.allclose(np.subtract(pixel, start), (0.0, -40.0), atol=1.0)
    QTest.mouseRelease(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))
    assert view._scene._words._echo_at[0] == ""


NUDGES = (
    (Qt.Key.Key_PageUp, Qt.KeyboardModifier.NoModifier, 2, 2.21),
    (Qt.Key.Key_PageDown, Qt.KeyboardModifier.ShiftModifier, 2, 2.1),
    (Qt.Key.Key_Left, Qt.KeyboardModifier.ControlModifier, 5, 21.0),
    (Qt.Key.Key_Right, Qt.KeyboardModifier.AltModifier, 5, 19.0),
)


def test_a_key_nudges_the_selected_sensor(view):
    change(view, gizmo_mode="both", gizmo_space="world")
    heard = listen(view)
    for key, modifier, place, value in NUDGES:
        change(view, rig=RIG, selected="roof")
        heard.signals.clear()
        QTest.keyClick(view._canvas, key, modifier)
        [(_, name, pose)] = heard.signals
        assert name == "roof" and (*pose.position_m, *pose.rpy_deg)[place] == pytest.approx(value, abs=1e-12)


def test_without_a_selection_keys_nudge_nothing(view):
    change(view, rig=RIG, selected=None)
    heard = listen(view)
    QTest.keyClick(view._canvas, Qt.Key.Key_Left)
    assert heard.signals == []


ROOF, BESIDE = (-0.5, 0.0, 1.45), (0.0, -8.0, 0.0)


def test_a_placed_sensor_follows_the_mouse_over_the_car_and_a_click_leaves_it_there(view):
    heard = listen(view)
    assert view.begin_placing()
    roof = to_point(view, pixel_at(view, ROOF))
    hover(view._canvas, roof)
    QTest.mouseClick(view._canvas, Qt.MouseButton.LeftButton, pos=roof)
    assert heard.story() == [
        "drag_started",
        "placing_changed",
        "drag_moved",
        "placing_changed",
        "drag_finished",
    ]
    pose = next(signal[2] for signal in reversed(heard.signals) if signal[0] == "drag_moved")
    assert pose.position_m == pytest.approx((-0.5, 0.0, 1.45 + 0.085), abs=0.08)
    assert abs(pose.rpy_deg[0]) < 10.0 and abs(pose.rpy_deg[1]) < 10.0
    assert view.state.rig.sensor("roof").pose == pose


def test_escape_leaves_placing_and_puts_the_sensor_back(view):
    heard = listen(view)
    view.begin_placing()
    hover(view._canvas, to_point(view, pixel_at(view, ROOF)))
    QTest.keyClick(view._canvas, Qt.Key.Key_Escape)
    assert heard.story()[-2:] == ["placing_changed", "drag_cancelled"]
    assert view.state.rig.sensor("roof") == LIDAR


def test_a_click_beside_the_car_places_nothing_and_placing_goes_on(view):
    heard = listen(view)
    view.begin_placing()
    QTest.mouseClick(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, pixel_at(view, BESIDE)))
    assert "drag_finished" not in heard.story() and view._controller.is_placing
    assert view.cancel_drag()


def test_nothing_can_be_placed_without_a_selection(view):
    change(view, rig=RIG, selected=None)
    assert not view.begin_placing()


def model_drag(model: str) -> QMimeData:
    data = QMimeData()
    data.setData(MODEL_MIME, model.encode())
    return data


def drop(view: View, data: QMimeData, point: QPoint) -> list[bool]:
    """Drag something into the view and let it fall; whether each event was accepted."""
    copy, button = Qt.DropAction.CopyAction, Qt.MouseButton.LeftButton
    none = Qt.KeyboardModifier.NoModifier
    events = [
        QDragEnterEvent(point, copy, data, button, none),
        QDragMoveEvent(point, copy, data, button, none),
        QDropEvent(QPointF(point), copy, data, button, none),
    ]
    for event in events:
        event.ignore()
        QApplication.sendEvent(view, event)
    return [event.isAccepted() for event in events]


def test_a_model_dropped_on_the_car_is_reported_with_the_pose_that_place_at_gives(view):
    heard = listen(view)
    point = to_point(view, pixel_at(view, ROOF))
    expected = view.place_at((float(point.x()), float(point.y())), "generic-16")
    assert drop(view, model_drag("generic-16"), point) == [True, True, True]
    assert heard.signals == [("model_dropped", "generic-16", expected)]
    assert expected.position_m[2] > 1.45


def test_a_model_dropped_beside_the_car_a_file_and_an_unknown_model_are_left_alone(view):
    heard = listen(view)
    roof, beside = (to_point(view, pixel_at(view, place)) for place in (ROOF, BESIDE))
    assert drop(view, model_drag("generic-16"), beside)[1:] == [False, False]
    assert not any(drop(view, model_drag("no-such-model"), roof))
    urls = QMimeData()
    urls.setText("file:///tmp/rig.yaml")
    assert not any(drop(view, urls, roof))
    assert heard.signals == []
    assert view.place_at((float(beside.x()), float(beside.y())), "generic-16") is None


def turn_wheel(view: View, pixel: np.ndarray, notches: int) -> None:
    place = QPointF(float(pixel[0]), float(pixel[1]))
    none = Qt.KeyboardModifier.NoModifier
    event = QWheelEvent(
        place, view._canvas.mapToGlobal(place), QPoint(), QPoint(0, 120 * notches),
        Qt.MouseButton.NoButton, none, Qt.ScrollPhase.NoScrollPhase, False,
    )  # fmt: skip
    QApplication.sendEvent(view._canvas, event)


def test_the_wheel_zooms_and_keeps_the_place_under_the_cursor(view):
    before = view.state.camera
    focal_pixel = pixel_at(view, before.focal_m)
    turn_wheel(view, focal_pixel, 2)
    assert view.state.camera.distance_m < 0.8 * before.distance_m
    assert np.allclose(pixel_at(view, before.focal_m), focal_pixel, atol=1e-3)


@dataclass
class Frames:
    """How the frames of a viewport were drawn: coarse or in full, with rough or smooth edges."""

    view: View
    looks: list[str] = field(default_factory=list)

    def note(self) -> None:
        scene = self.view._scene
        coarse = "coarse" if scene._stage.backdrop_size != scene.size else "full"
        self.looks.append(coarse + (" smooth" if scene.is_smooth else ""))


def frames_of(view: View) -> Frames:
    frames = Frames(view)
    view.drawn.connect(frames.note)
    return frames


def one_change(view: View) -> list[str]:
    """How a change is drawn that stands alone: a graphics card draws twice in no time; without one, in parts, once."""
    return ["full", "full smooth"] if isinstance(view, Viewport) else ["full smooth"]


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


def picture(view: View, wait: bool = True) -> np.ndarray:
    if wait:
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
    change(
        view, heatmap=HeatmapData(centres, 0.4, np.ones(len(centres), np.float32), "seen", "share", 0.0, 1.0)
    )
    heat = picture(view)
    change(view, heatmap=None)
    again = picture(view)
    assert (np.abs(heat - empty).max(axis=2) > 60).mean() > 0.01
    assert (np.abs(again - empty).max(axis=2) > 60).mean() < 0.001


def test_an_unknown_car_body_is_refused_and_the_car_stays(view):
    with pytest.raises(InputError, match=r"vehicle\.body"):
        change(view, vehicle=Vehicle(body="hovercraft"))
    assert view.state.vehicle.body == "sedan"


@KINDS
def test_closing_the_view_releases_its_render_window(kind: Callable[[], View], qtbot):
    viewport = kind()
    viewport.resize(300, 200)
    change(viewport, rig=RIG, selected="roof")
    viewport.show()
    settle(viewport)
    window = weakref.ref(viewport._plotter.render_window)
    viewport.close()
    change(viewport, rig=RIG, selected=None)
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
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    assert run.stdout.strip() == "OffscreenViewport 320 True", run.stderr
