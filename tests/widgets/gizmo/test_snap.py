"""Snapping, planes, arrow keys and the numbers beside the cursor."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from riglens.core.geometry import Pose
from riglens.widgets.drawing.camera import OrbitCamera, ViewRay
from riglens.widgets.gizmo.drag import (
    SNAP_DEG,
    SNAP_M,
    Handle,
    begin_drag,
    gizmo_axes,
    moved,
    moved_snapped,
    turned,
    turned_snapped,
)
from riglens.widgets.gizmo.echo import drag_echo
from riglens.widgets.gizmo.nudge import nudge_turned, nudged, view_axes
from tests.widgets.gizmo.test_drag import axes, eye_at, eyes, metres, poses, ray_through, spaces


def is_multiple(value: float, step: float) -> bool:
    return math.isclose(value / step, round(value / step), abs_tol=1e-6)


@given(poses, eyes, axes, spaces, st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))
def test_the_grasped_point_of_a_plane_follows_the_mouse_within_the_plane(pose, eye, axis, space, u, v):
    frame = gizmo_axes(pose, space)
    first, second, normal = frame[:, (axis + 1) % 3], frame[:, (axis + 2) % 3], frame[:, axis]
    viewer, origin = eye_at(pose, eye), np.array(pose.position_m)
    assume(abs(normal @ (viewer - origin)) > 0.3 * eye[0])
    start = ray_through(viewer, origin + 0.3 * first + 0.3 * second)
    end = ray_through(viewer, origin + (0.3 + u) * first + (0.3 + v) * second)
    after = begin_drag(Handle("plane", axis), space, pose, start, 0.7).pose(end)
    assert np.allclose(after.position_m, origin + u * first + v * second, atol=1e-6)
    assert after.rpy_deg == pose.rpy_deg
    if space == "world":
        assert after.position_m[axis] == pose.position_m[axis]


def test_a_plane_seen_edge_on_cannot_be_dragged():
    ray = ViewRay(np.array([0.0, -9.0, 2.0]), np.array([0.0, 1.0, 0.0]))
    assert begin_drag(Handle("plane", 2), "world", Pose((0.0, 0.0, 2.0)), ray, 0.7) is None


@given(poses, axes, metres)
def test_a_snapped_move_along_an_axis_of_the_car_ends_on_a_round_coordinate(pose, axis, distance_m):
    after = moved_snapped(pose, np.eye(3)[axis], distance_m)
    free = moved(pose, np.eye(3)[axis], distance_m)
    assert is_multiple(after.position_m[axis], SNAP_M)
    assert abs(after.position_m[axis] - free.position_m[axis]) <= SNAP_M / 2 + 1e-9
    assert len(repr(after.position_m[axis])) <= 6
    others = [i for i in range(3) if i != axis]
    assert [after.position_m[i] for i in others] == [pose.position_m[i] for i in others]


@given(poses, axes, metres)
def test_a_snapped_move_along_a_tilted_axis_has_a_round_length(pose, axis, distance_m):
    direction = pose.rotation()[:, axis]
    assume(np.count_nonzero(direction) > 1)
    after = moved_snapped(pose, direction, distance_m)
    length_m = float(np.linalg.norm(np.subtract(after.position_m, pose.position_m)))
    assert is_multiple(length_m, SNAP_M) and abs(length_m - abs(distance_m)) <= SNAP_M / 2 + 1e-9


@given(poses, st.floats(-170.0, 170.0))
def test_a_snapped_turn_about_the_vertical_ends_on_a_round_yaw(pose, angle_deg):
    up = np.array([0.0, 0.0, 1.0])
    after = turned_snapped(pose, up, math.radians(angle_deg))
    free = turned(pose, up, math.radians(angle_deg))
    assert after.rpy_deg[:2] == pose.rpy_deg[:2]
    if after.rpy_deg[2] != pose.rpy_deg[2]:
        assert is_multiple(after.rpy_deg[2], SNAP_DEG)
        assert abs(after.rpy_deg[2] - free.rpy_deg[2]) <= SNAP_DEG / 2 + 1e-6


@given(poses, axes, spaces, st.floats(-170.0, 170.0))
def test_any_snapped_turn_is_within_half_a_step_of_the_free_one(pose, axis, space, angle_deg):
    direction = gizmo_axes(pose, space)[:, axis].copy()
    after = turned_snapped(pose, direction, math.radians(angle_deg))
    free = turned(pose, direction, math.radians(angle_deg))
    cosine = (np.trace(after.rotation().T @ free.rotation()) - 1.0) / 2.0
    assert math.degrees(math.acos(min(1.0, max(-1.0, cosine)))) <= SNAP_DEG / 2 + 1e-3


CAMERA = OrbitCamera(azimuth_deg=-60.0, elevation_deg=25.0)


@given(poses, spaces, st.floats(-180.0, 180.0), st.floats(-60.0, 90.0))
def test_arrow_keys_go_along_the_axes_that_look_like_them(pose, space, azimuth, elevation):
    frame = gizmo_axes(pose, space)
    right, forward, up = view_axes(frame, OrbitCamera(azimuth_deg=azimuth, elevation_deg=elevation))
    assert np.allclose(np.abs(np.stack([right, forward, up]) @ frame).sum(axis=0), 1.0, atol=1e-9)
    assert up[2] >= 0.0
    if space == "world":
        assert right @ OrbitCamera(azimuth_deg=azimuth).axes()[0] >= math.sqrt(0.5) - 1e-9


def test_a_key_moves_one_number_by_a_centimetre_and_with_shift_by_ten():
    pose = Pose((0.0, 0.5, 2.2), (0.0, 0.0, 20.0))
    assert nudged(pose, "up", "world", CAMERA).position_m == (0.0, 0.5, 2.21)
    assert nudged(pose, "down", "world", CAMERA, coarse=True).position_m == (0.0, 0.5, 2.1)
    assert nudged(nudged(pose, "left", "world", CAMERA), "right", "world", CAMERA) == pose


def test_a_key_turns_by_a_degree_and_with_shift_by_ten():
    pose = Pose((0.0, 0.5, 2.2), (0.0, 0.0, 20.0))
    assert nudge_turned(pose, "left", "world").rpy_deg == (0.0, 0.0, 21.0)
    assert nudge_turned(pose, "right", "world", coarse=True).rpy_deg == (0.0, 0.0, 10.0)
    assert nudge_turned(pose, "forward", "local").rpy_deg == pytest.approx((0.0, 1.0, 20.0))
    assert nudge_turned(pose, "up", "local").rpy_deg == pytest.approx((1.0, 0.0, 20.0))


@pytest.mark.parametrize(
    ("after", "said"),
    [
        (Pose((1.35, 0.2, 2.0)), "Δx +0.350 m\nx 1.350 m"),
        (Pose((1.0, 0.1, 2.25)), "Δy -0.100   Δz +0.250 m\ny 0.100   z 2.250 m"),
        (Pose((1.0, 0.2, 2.0), (0.0, 0.0, 175.0)), "Δyaw +175.0°\nyaw 175.0°"),
        (Pose((1.0, 0.2, 2.0), (0.0, 0.0, -175.0)), "Δyaw -175.0°\nyaw -175.0°"),
        (
            Pose((0.0, 0.2, 1.5), (0.0, 1.0, 0.0)),
            "x 0.000   y 0.200   z 1.500 m\nroll 0.0°   pitch 1.0°   yaw 0.0°",
        ),
        (Pose((1.0, 0.2, 2.0), (0.0, 30.0, 40.0)), "turned 49.6°\npitch 30.0°   yaw 40.0°"),
    ],
)
def test_the_numbers_beside_the_cursor_say_the_change_and_the_new_value(after, said):
    assert drag_echo(Pose((1.0, 0.2, 2.0)), after) == said


def test_a_drag_that_has_not_moved_yet_says_where_the_sensor_is():
    pose = Pose((1.0, 0.2, 2.0))
    assert drag_echo(pose, pose) == "Δx +0.000   Δy +0.000   Δz +0.000 m\nx 1.000   y 0.200   z 2.000 m"
