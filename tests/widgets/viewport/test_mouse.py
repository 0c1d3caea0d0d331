"""The 3D view as a person uses it: the mouse drags, turns, selects, places and zooms; keys nudge.

Every statement holds for the window on a display and for the picture drawn without one.
"""

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QMimeData, QPoint, QPointF, Qt
from PySide6.QtGui import QDragEnterEvent, QDragMoveEvent, QDropEvent, QHelpEvent, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QToolTip

from riglens.core.geometry import Pose
from riglens.core.rig.edits import linked
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Rig
from riglens.core.vehicle.placing import PlacingRules
from riglens.core.vehicle.profile import reference_vehicle
from riglens.widgets.gizmo.drag import Handle, along_axis_m, gizmo_axes
from riglens.widgets.panels.sensors.library import MODEL_MIME
from tests.widgets.mouse import hover
from tests.widgets.viewport.views import (
    CAMERA,
    LIDAR,
    RIG,
    AnyView,
    change,
    drag,
    handle_pixel,
    listen,
    picture,
    pixel_at,
    settle,
    to_point,
)


def place_at(view: AnyView, pixel, model: str) -> Pose | None:
    """Return the position of a library sensor dropped on a pixel, None off the car."""
    return view._scene.pose_on_body(pixel, sensor_from_model(model, model, Pose()), view.snaps)


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
        pose = heard.pose()
        assert heard.story() == ["drag_started", "drag_moved", "drag_finished"]
        assert pose.rpy_deg == LIDAR.rpy_deg
        assert np.allclose(pose.position_m, origin + direction, atol=0.03)


def test_dragging_a_ring_turns_the_sensor_and_moves_nothing(view):
    change(view, gizmo_mode="rotate", gizmo_space="world")
    heard = listen(view)
    start = handle_pixel(view, Handle("rotate", 2))
    drag(view, start, start + np.array([60.0, 5.0]))
    pose = heard.pose()
    assert pose.position_m == LIDAR.position and pose.rpy_deg[:2] == (0.0, 0.0)
    assert abs(pose.rpy_deg[2] - 20.0) > 5.0


def test_the_view_shows_the_dragged_pose_at_once_and_keeps_its_camera(view):
    heard = listen(view)
    camera = view.state.camera
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -50.0]), release=False)
    shown = view.state.rig.sensor("roof").pose
    assert shown == heard.pose() and shown.position_m[2] > 2.3
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


def test_a_number_typed_during_a_drag_says_how_far_whatever_the_mouse_does(view):
    change(view, gizmo_mode="move", gizmo_space="world")
    heard = listen(view)
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -50.0]), release=False)
    x, y, z = LIDAR.position
    for typed, dz in (("-", None), ("0", 0.0), (",", 0.0), ("2", -0.2), ("59", -0.259)):
        QTest.keyClicks(view._canvas, typed)
        if dz is not None:
            assert heard.pose().position_m == (x, y, z + dz)
    QTest.keyClick(view._canvas, Qt.Key.Key_Backspace)
    hover(view._canvas, to_point(view, start + np.array([0.0, -90.0])), Qt.MouseButton.LeftButton)
    assert heard.pose().position_m == (x, y, z - 0.25)
    QTest.keyClick(view._canvas, Qt.Key.Key_Return)
    assert heard.story()[-1] == "drag_finished"
    QTest.mouseRelease(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))
    assert heard.story()[-1] == "drag_finished" and heard.pose().position_m == (x, y, z - 0.25)


def test_a_number_typed_while_a_ring_is_dragged_is_in_degrees(view):
    change(view, gizmo_mode="rotate", gizmo_space="world")
    heard = listen(view)
    start = handle_pixel(view, Handle("rotate", 2))
    drag(view, start, start + np.array([60.0, 5.0]), release=False)
    QTest.keyClicks(view._canvas, "30x")
    QTest.mouseRelease(view._canvas, Qt.MouseButton.LeftButton, pos=to_point(view, start))
    assert np.allclose(heard.pose().rpy_deg, np.add(LIDAR.rpy_deg, (0.0, 0.0, 30.0)))


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
    heard.signals.clear()
    x, y = pixel_at(view, CAMERA.position).round().astype(int).tolist()
    sweep(view, LEFT, (x, y), (x + 1, y - 1))
    assert heard.signals == [("sensor_picked", "front")], "a hand that trembles clicks"


@pytest.mark.parametrize("key", [Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier])
def test_a_click_with_ctrl_or_shift_asks_for_one_sensor_more_and_for_none_on_nothing(view, key):
    heard = listen(view)
    for place in (pixel_at(view, CAMERA.position), np.array([15.0, 15.0])):
        QTest.mouseClick(view._canvas, Qt.MouseButton.LeftButton, key, to_point(view, place))
    assert heard.signals == [("sensor_toggled", "front")]


def test_every_selected_sensor_stands_out(view):
    before = picture(view)
    change(view, also_selected=frozenset({"front"}))
    x, y = pixel_at(view, CAMERA.position).round().astype(int)
    near = (slice(y - 12, y + 12), slice(x - 12, x + 12))
    assert (picture(view)[near] != before[near]).any()
    change(view, also_selected=frozenset())
    assert (picture(view)[near] == before[near]).all()


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


NO_KEY, SHIFT = Qt.KeyboardModifier.NoModifier, Qt.KeyboardModifier.ShiftModifier
CTRL = Qt.KeyboardModifier.ControlModifier
LEFT, MIDDLE, RIGHT = Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton


def sweep(view, button, start, end, keys=NO_KEY, release=True):
    """Drag with any button and keys."""
    QTest.mousePress(view._canvas, button, keys, QPoint(*start))
    for share in (0.5, 1.0):
        x, y = np.round(np.array(start) + share * (np.array(end) - start)).astype(int).tolist()
        hover(view._canvas, QPoint(x, y), button)
    if release:
        QTest.mouseRelease(view._canvas, button, keys, QPoint(*end))


def box_around(view, *places):
    """Two corners of a box around points, in pixels."""
    pixels = np.array([pixel_at(view, place) for place in places])
    return (pixels.min(axis=0) - 20).round().astype(int), (pixels.max(axis=0) + 20).round().astype(int)


def test_the_middle_button_pans(view):
    before = view.state.camera
    sweep(view, MIDDLE, (60, 500), (120, 450))
    after = view.state.camera
    assert after.focal_m != before.focal_m
    assert (after.azimuth_deg, after.elevation_deg) == (before.azimuth_deg, before.elevation_deg)


def test_a_drag_with_shift_draws_a_box_around_sensors_and_leaves_the_view(view):
    heard = listen(view)
    camera = view.state.camera
    low, high = box_around(view, LIDAR.position, CAMERA.position)
    sweep(view, LEFT, low, high, SHIFT, release=False)
    assert view._box.isVisible() and view._box.width() >= abs(high[0] - low[0])
    QTest.mouseRelease(view._canvas, LEFT, SHIFT, QPoint(*high))
    assert not view._box.isVisible() and view.state.camera == camera
    assert heard.signals == [("sensors_boxed", ("roof", "front"), False)]


def test_a_box_from_any_corner_holds_what_is_in_it_alone_and_with_ctrl_takes_it_out(view):
    heard = listen(view)
    low, high = box_around(view, CAMERA.position)
    sweep(view, LEFT, high, low, SHIFT)
    sweep(view, LEFT, low, high, SHIFT | CTRL)
    sweep(view, LEFT, (5, 5), (40, 40), SHIFT)
    assert [signal[1:] for signal in heard.signals] == [(("front",), False), (("front",), True), ((), False)]


def test_a_box_over_a_handle_grasps_nothing_and_escape_gives_it_up(view):
    heard = listen(view)
    start = handle_pixel(view, Handle("move", 2)).astype(int)
    end = start + np.array([80, 80])
    sweep(view, LEFT, start, end, SHIFT, release=False)
    QTest.keyClick(view._canvas, Qt.Key.Key_Escape)
    assert not view._box.isVisible()
    QTest.mouseRelease(view._canvas, LEFT, SHIFT, QPoint(*end))
    assert heard.signals == [] and view.state.rig == RIG


def test_a_hidden_sensor_is_in_no_box(view):
    heard = listen(view)
    change(view, hidden=frozenset({"roof"}))
    sweep(view, LEFT, (2, 2), (898, 598), SHIFT)
    assert heard.signals == [("sensors_boxed", ("front",), False)]


def test_the_right_button_zooms_when_dragged_up_or_down_and_asks_for_no_menu(view):
    heard = listen(view)
    before = view.state.camera
    sweep(view, RIGHT, (450, 300), (450, 200))
    nearer = view.state.camera
    sweep(view, RIGHT, (450, 200), (450, 300))
    assert nearer.distance_m < 0.8 * before.distance_m
    assert view.state.camera.distance_m == pytest.approx(before.distance_m)
    assert heard.signals == []


def test_a_right_click_asks_for_the_menu_of_the_sensor_there_or_of_none(view):
    heard = listen(view)
    for place in (pixel_at(view, CAMERA.position), np.array([15.0, 15.0])):
        QTest.mouseClick(view._canvas, RIGHT, NO_KEY, to_point(view, place))
    assert [signal[:2] for signal in heard.signals] == [("menu_wanted", "front"), ("menu_wanted", None)]
    place = view._canvas.mapFromGlobal(heard.signals[1][2])
    assert (place.x(), place.y()) == (15, 15)


PAIR = linked(Rig(sensors=(LIDAR, CAMERA, CAMERA.replace(name="other"))), "front", "other")


def tooltip(view, place) -> str:
    """What the tooltip says at a place."""
    point = to_point(view, pixel_at(view, place))
    QApplication.sendEvent(
        view._canvas, QHelpEvent(QEvent.Type.ToolTip, point, view._canvas.mapToGlobal(point))
    )
    return QToolTip.text()


def test_the_tooltip_of_a_sensor_names_it_and_the_other_of_its_pair(view):
    change(view, rig=PAIR)
    assert "roof" in tooltip(view, LIDAR.position) and "pair" not in tooltip(view, LIDAR.position)
    assert "Mirror pair with other" in tooltip(view, CAMERA.position)
    assert view._controller.words(tuple(pixel_at(view, (0.0, -8.0, 0.0)))) == ""
    change(view, rig=PAIR.with_sensor("roof", LIDAR.replace(name="<b>x</b>")))
    assert "&lt;b&gt;" in tooltip(view, LIDAR.position)


def test_the_partner_of_what_is_selected_stands_out_and_a_line_leads_to_it(view):
    change(view, rig=PAIR, selected="roof")
    before = picture(view)
    change(view, selected="front", show_gizmo=False)
    after = picture(view)
    places = [np.array(PAIR.sensor(name).position) for name in ("front", "other")]
    for place in (places[0] + 0.3 * (places[1] - places[0]), places[0] + 0.6 * (places[1] - places[0])):
        x, y = pixel_at(view, place).round().astype(int)
        assert (after[y - 6 : y + 6, x - 6 : x + 6] != before[y - 6 : y + 6, x - 6 : x + 6]).any()


def test_a_right_click_while_a_sensor_is_being_placed_asks_for_nothing(view):
    view.begin_placing()
    heard = listen(view)
    QTest.mouseClick(view._canvas, RIGHT, NO_KEY, QPoint(15, 15))
    assert "menu_wanted" not in heard.story() and view._controller.is_placing
    assert view.cancel_drag()


BOTH = {"selected": "roof", "also_selected": frozenset({"front"})}


def test_the_gizmo_of_several_stands_at_their_centre_and_moves_all_by_the_same(view):
    change(view, gizmo_mode="move", gizmo_space="world", **BOTH)
    heard = listen(view)
    centre = np.mean([LIDAR.position, CAMERA.position], axis=0)
    assert np.allclose(view.state.gizmo_pose.position_m, centre)
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -50.0]))
    assert heard.signals[0] == ("drag_started", ("front", "roof"))
    steps_m = [np.subtract(heard.pose(s.name).position_m, s.position) for s in (LIDAR, CAMERA)]
    assert steps_m[0][2] > 0.1 and np.allclose(*steps_m, atol=1e-9)
    assert (steps_m[0][:2] == 0.0).all() and heard.pose("front").rpy_deg == CAMERA.rpy_deg
    assert {name: view.state.rig.sensor(name).pose for name in ("roof", "front")} == heard.signals[-2][1]


@pytest.mark.parametrize("space", ["world", "local"])
def test_a_ring_of_several_turns_them_about_their_centre_as_one_body(view, space):
    change(view, gizmo_mode="rotate", gizmo_space=space, **BOTH)
    heard = listen(view)
    start = handle_pixel(view, Handle("rotate", 2))
    drag(view, start, start + np.array([60.0, 5.0]))
    after = [heard.pose(sensor.name) for sensor in (LIDAR, CAMERA)]
    before = [LIDAR.pose, CAMERA.pose]
    places = np.array([pose.position_m for pose in before]), np.array([pose.position_m for pose in after])
    assert np.allclose(places[0].mean(axis=0), places[1].mean(axis=0))
    assert not np.allclose(places[0], places[1], atol=0.002)
    parts = [pose.inverse().compose(other) for pose, other in (before, after)]
    assert np.allclose(parts[0].vehicle_SE3_sensor(), parts[1].vehicle_SE3_sensor(), atol=1e-7)


def test_a_group_snaps_by_how_far_it_goes_so_round_places_stay_round(view):
    change(view, gizmo_mode="move", gizmo_space="world", **BOTH)
    change(view, snap=True)
    heard = listen(view)
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -40.0]))
    for sensor in (LIDAR, CAMERA):
        z_m = heard.pose(sensor.name).position_m[2]
        assert z_m > sensor.position[2] and z_m == round(round(z_m / 0.05) * 0.05, 9)


def test_a_group_with_a_sensor_that_cannot_be_moved_has_no_gizmo(view):
    change(view, fixed=frozenset({"front"}), **BOTH)
    assert view.state.gizmo_pose is None


def test_escape_puts_a_dragged_group_back(view):
    change(view, gizmo_mode="move", gizmo_space="world", **BOTH)
    heard = listen(view)
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -50.0]), release=False)
    QTest.keyClick(view._canvas, Qt.Key.Key_Escape)
    assert heard.story()[-1] == "drag_cancelled" and view.state.rig == RIG


def test_a_key_nudges_all_that_is_selected(view):
    change(view, gizmo_space="world", **BOTH)
    heard = listen(view)
    QTest.keyClick(view._canvas, Qt.Key.Key_PageUp)
    assert [heard.pose(sensor.name).position_m[2] for sensor in (LIDAR, CAMERA)] == [2.21, 1.31]


def test_dragging_a_plane_moves_the_sensor_in_that_plane_only(view):
    change(view, gizmo_mode="move", gizmo_space="world")
    heard = listen(view)
    start = handle_pixel(view, Handle("plane", 2))
    drag(view, start, start + np.array([60.0, 20.0]))
    pose = heard.pose()
    assert pose.position_m[2] == LIDAR.position[2] and pose.rpy_deg == LIDAR.rpy_deg
    assert all(
        abs(new - old) > 0.05 for new, old in zip(pose.position_m[:2], LIDAR.position[:2], strict=True)
    )


def test_with_snapping_a_drag_ends_on_round_numbers_and_ctrl_inverts_it(view):
    change(view, gizmo_mode="move", gizmo_space="world")
    change(view, snap=True)
    heard = listen(view)
    start = handle_pixel(view, Handle("move", 2))
    drag(view, start, start + np.array([0.0, -33.0]), release=False)
    snapped = heard.pose().position_m[2]
    QTest.keyPress(view._canvas, Qt.Key.Key_Control)
    free = heard.pose().position_m[2]
    QTest.keyRelease(view._canvas, Qt.Key.Key_Control)
    again = heard.pose().position_m[2]
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
        pose = heard.pose()
        assert heard.story() == ["nudged"] and (*pose.position_m, *pose.rpy_deg)[place] == pytest.approx(
            value, abs=1e-12
        )


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
    pose = heard.pose()
    assert pose.position_m == pytest.approx((-0.5, 0.0, 1.45 + 0.085), abs=0.08)
    assert abs(pose.rpy_deg[0]) < 10.0 and abs(pose.rpy_deg[1]) < 10.0
    assert view.state.rig.sensor("roof").pose == pose


def test_escape_leaves_placing_and_puts_the_sensor_back(view):
    heard = listen(view)
    view._canvas.clearFocus()
    view.begin_placing()
    assert view.focusWidget() is view._canvas  # which hears the key
    hover(view._canvas, to_point(view, pixel_at(view, ROOF)))
    QTest.keyClick(view._canvas, Qt.Key.Key_Escape)
    assert heard.story()[-2:] == ["placing_changed", "drag_cancelled"]
    assert view.state.rig.sensor("roof") == LIDAR


def place(view, position_m, key=NO_KEY) -> None:
    """Point at a place of the car and click, with a key held."""
    assert view.begin_placing()
    point = to_point(view, pixel_at(view, position_m))
    if key == CTRL:
        QTest.keyPress(view._canvas, Qt.Key.Key_Control)
    hover(view._canvas, point)
    QTest.mouseMove(view._canvas, point)
    view._controller.move((float(point.x()), float(point.y())), key == CTRL)
    QTest.mouseClick(view._canvas, LEFT, key, point)
    if key == CTRL:
        QTest.keyRelease(view._canvas, Qt.Key.Key_Control)


def test_placing_snaps_to_the_grid_and_the_middle_line_and_ctrl_inverts_it(view):
    heard = listen(view)
    change(view, snap=True)
    place(view, (-0.512, 0.021, 1.45))
    x_m, y_m, _ = heard.pose().position_m
    assert y_m == 0.0 and x_m == round(round(x_m / 0.05) * 0.05, 9)
    change(view, snap=False)
    place(view, (-0.512, 0.321, 1.45), CTRL)
    x_m, y_m, _ = heard.pose().position_m
    assert all(value == round(round(value / 0.05) * 0.05, 9) for value in (x_m, y_m)) and y_m != 0.0
    place(view, (-0.512, 0.321, 1.45))
    assert heard.pose().position_m[:2] != (x_m, y_m)


def test_placing_can_keep_sensors_upright(view):
    heard = listen(view)
    slope = (1.5, -0.2, 0.85)
    place(view, slope)
    assert abs(heard.pose().rpy_deg[1]) > 3.0
    change(view, placing=PlacingRules(upright=True))
    place(view, slope)
    assert heard.pose().rpy_deg == (0.0, 0.0, 0.0)


def test_placing_can_ignore_the_rails_on_the_roof_and_so_does_a_drop(view):
    change(view, vehicle=reference_vehicle("suv"))
    view.set_view("top")
    settle(view)
    rail = tuple(pixel_at(view, (-1.0, 0.5875, 1.78)))
    on_rail = place_at(view, rail, "generic-16")
    change(view, placing=PlacingRules(below_rails=True))
    on_roof = place_at(view, rail, "generic-16")
    assert abs(on_rail.rpy_deg[0]) > 30.0  # the rail is round
    assert abs(on_roof.rpy_deg[0]) < 20.0 and abs(on_roof.position_m[1] - 0.5875) < 0.06
    assert on_roof.position_m[2] < 1.80


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


def drop(view: AnyView, data: QMimeData, point: QPoint) -> list[bool]:
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
    expected = place_at(view, (float(point.x()), float(point.y())), "generic-16")
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
    assert place_at(view, (float(beside.x()), float(beside.y())), "generic-16") is None


def turn_wheel(view: AnyView, pixel: np.ndarray, notches: int) -> None:
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


def test_a_mouse_that_leaves_the_view_points_at_nothing_and_one_that_stays_does(view):
    before = picture(view)
    hover(view._canvas, to_point(view, pixel_at(view, np.array(LIDAR.position))))
    settle(view)
    pointed = picture(view)
    assert not np.array_equal(pointed, before)
    for event in (QEvent(QEvent.Type.Enter), QEvent(QEvent.Type.ToolTipChange)):
        QApplication.sendEvent(view._canvas, event)
    settle(view)
    assert np.array_equal(picture(view), pointed)
    QApplication.sendEvent(view._canvas, QEvent(QEvent.Type.Leave))
    settle(view)
    assert np.array_equal(picture(view), before)
