"""Dragging a handle: what a view ray means for the pose, also in views where it means little."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from riglens.core.geometry import Pose, rotation_from_rpy_deg
from riglens.widgets.drawing.camera import ViewRay
from riglens.widgets.gizmo.drag import (
    Handle,
    along_axis_m,
    begin_drag,
    gizmo_axes,
    moved,
    on_plane_m,
    rotation_about,
    signed_angle_rad,
    turned,
)

metres = st.floats(-5.0, 5.0)
angles = st.floats(-179.0, 179.0)
pitches = st.floats(-85.0, 85.0)
poses = st.builds(
    lambda x, y, z, roll, pitch, yaw: Pose((x, y, z), (roll, pitch, yaw)),
    metres, metres, metres, angles, pitches, angles,
)  # fmt: skip
eyes = st.tuples(st.floats(6.0, 30.0), st.floats(-180.0, 180.0), st.floats(-80.0, 80.0))
axes = st.integers(0, 2)
spaces = st.sampled_from(["local", "world"])


def eye_at(pose: Pose, eye: tuple[float, float, float]) -> np.ndarray:
    distance, azimuth, elevation = eye[0], math.radians(eye[1]), math.radians(eye[2])
    flat = distance * math.cos(elevation)
    offset = [flat * math.cos(azimuth), flat * math.sin(azimuth), distance * math.sin(elevation)]
    return np.array(pose.position_m) + offset


def ray_through(eye: np.ndarray, point: np.ndarray) -> ViewRay:
    direction = point - eye
    return ViewRay(eye, direction / np.linalg.norm(direction))


@given(poses, eyes, axes, spaces, st.floats(0.3, 1.0), st.floats(-3.0, 3.0))
def test_the_grasped_point_of_an_arrow_follows_the_mouse(pose, eye, axis, space, grasp_m, distance_m):
    direction = gizmo_axes(pose, space)[:, axis]
    viewer = eye_at(pose, eye)
    grasp = np.array(pose.position_m) + grasp_m * direction
    start, end = ray_through(viewer, grasp), ray_through(viewer, grasp + distance_m * direction)
    assume(abs(start.direction @ direction) < 0.98 and abs(end.direction @ direction) < 0.98)
    drag = begin_drag(Handle("move", axis), space, pose, start, 0.7)
    expected = np.array(pose.position_m) + distance_m * direction
    assert np.allclose(drag.pose(end).position_m, expected, atol=1e-6)
    assert drag.pose(end).rpy_deg == pose.rpy_deg


@given(poses, eyes, axes, st.floats(-3.0, 3.0))
def test_a_move_along_a_world_axis_leaves_all_other_numbers_bit_for_bit(pose, eye, axis, distance_m):
    after = moved(pose, np.eye(3)[axis], distance_m)
    others = [i for i in range(3) if i != axis]
    assert [after.position_m[i] for i in others] == [pose.position_m[i] for i in others]
    assert after.rpy_deg == pose.rpy_deg


@given(poses, eyes, axes, spaces, st.floats(-170.0, 170.0))
def test_the_grasped_point_of_a_ring_follows_the_mouse(pose, eye, axis, space, angle_deg):
    frame = gizmo_axes(pose, space)
    normal, radial = frame[:, axis], frame[:, (axis + 1) % 3]
    viewer = eye_at(pose, eye)
    assume(abs(normal @ (viewer - pose.position_m)) > 0.3 * eye[0])
    turn = rotation_about(normal, math.radians(angle_deg))
    centre = np.array(pose.position_m)
    start, end = ray_through(viewer, centre + 0.7 * radial), ray_through(viewer, centre + 0.7 * turn @ radial)
    drag = begin_drag(Handle("rotate", axis), space, pose, start, 0.7)
    assert np.allclose(drag.pose(end).rotation(), turn @ pose.rotation(), atol=1e-7)
    assert drag.pose(end).position_m == pose.position_m


@given(metres, metres, metres, angles, st.floats(-170.0, 170.0))
def test_turning_a_level_sensor_about_the_vertical_changes_its_yaw_only(x, y, z, yaw, angle_deg):
    before = Pose((x, y, z), (0.0, 0.0, yaw))
    after = turned(before, np.array([0.0, 0.0, 1.0]), math.radians(angle_deg))
    assert after.position_m == before.position_m
    assert after.rpy_deg[:2] == (0.0, 0.0)
    assert math.isclose(math.remainder(after.rpy_deg[2] - yaw - angle_deg, 360.0), 0.0, abs_tol=1e-9)


@given(poses, st.floats(-170.0, 170.0))
def test_turning_any_sensor_about_the_vertical_keeps_roll_and_pitch_bit_for_bit(pose, angle_deg):
    after = turned(pose, np.array([0.0, 0.0, 1.0]), math.radians(angle_deg))
    assert after.rpy_deg[:2] == pose.rpy_deg[:2]


@given(poses, st.floats(-60.0, 60.0))
def test_turning_about_the_own_forward_axis_is_roll(pose, angle_deg):
    after = turned(pose, pose.rotation()[:, 0], math.radians(angle_deg))
    assert after.rpy_deg[1:] == pose.rpy_deg[1:]
    assert math.isclose(
        math.remainder(after.rpy_deg[0] - pose.rpy_deg[0] - angle_deg, 360.0), 0.0, abs_tol=1e-8
    )


@given(poses, axes, spaces, st.floats(-170.0, 170.0))
def test_turning_forth_and_back_ends_where_it_began(pose, axis, space, angle_deg):
    direction = gizmo_axes(pose, space)[:, axis].copy()
    there = turned(pose, direction, math.radians(angle_deg))
    back = turned(there, direction, -math.radians(angle_deg))
    assert np.allclose(back.rotation(), pose.rotation(), atol=1e-9)


@given(poses, eyes, axes, spaces)
def test_a_drag_that_comes_back_to_where_it_began_gives_the_start_pose_itself(pose, eye, axis, space):
    direction = gizmo_axes(pose, space)[:, axis]
    viewer = eye_at(pose, eye)
    ray = ray_through(viewer, np.array(pose.position_m) + 0.8 * direction)
    drag = begin_drag(Handle("move", axis), space, pose, ray, 0.7)
    assume(drag is not None)
    drag.pose(ray_through(viewer, np.array(pose.position_m) + 1.5 * direction))
    assert drag.pose(ray) == pose


def test_an_arrow_seen_end_on_cannot_be_dragged():
    pose = Pose((1.0, 0.0, 2.0))
    assert (
        begin_drag(
            Handle("move", 0), "world", pose, ViewRay(np.array([9.0, 0.0, 2.0]), np.array([-1.0, 0, 0])), 0.7
        )
        is None
    )


def test_a_view_ray_towards_the_vanishing_point_says_nothing_instead_of_jumping():
    origin, axis = np.zeros(3), np.array([1.0, 0.0, 0.0])
    viewer = np.array([-5.0, -5.0, 0.0])
    beyond = np.array([math.cos(math.radians(-1.5)), math.sin(math.radians(-1.5)), 0.0])
    assert along_axis_m(origin, axis, ViewRay(viewer, axis)) is None
    assert along_axis_m(origin, axis, ViewRay(viewer, beyond)) is None


def test_a_plane_behind_the_viewer_or_seen_edge_on_is_not_met():
    up = np.array([0.0, 0.0, 1.0])
    assert on_plane_m(np.zeros(3), up, ViewRay(np.array([0.0, 0.0, 3.0]), np.array([0.0, 0.0, 1.0]))) is None
    assert on_plane_m(np.zeros(3), up, ViewRay(np.array([0.0, -3.0, 0.0]), np.array([0.0, 1.0, 0.0]))) is None


@pytest.mark.parametrize("sideways_m", [-0.4, 0.25, 0.5])
def test_a_ring_seen_edge_on_turns_along_its_tangent(sideways_m):
    pose, viewer = Pose((0.0, 0.0, 2.0)), np.array([0.0, -10.0, 2.0])
    start = ray_through(viewer, np.array([0.0, -0.7, 2.0]))
    end = ray_through(viewer, np.array([sideways_m, -0.7, 2.0]))
    drag = begin_drag(Handle("rotate", 2), "world", pose, start, 0.7)
    assert math.isclose(drag.pose(end).rpy_deg[2], math.degrees(sideways_m / 0.7), rel_tol=1e-9)


def test_the_angle_is_positive_to_the_left_about_the_axis():
    x, y, z = np.eye(3)
    assert signed_angle_rad(x, y, z) == pytest.approx(math.pi / 2)
    assert signed_angle_rad(x, y, -z) == pytest.approx(-math.pi / 2)


def test_local_axes_are_the_sensors_and_world_axes_the_cars():
    pose = Pose((0.0, 0.0, 2.0), (10.0, 20.0, 30.0))
    assert np.array_equal(gizmo_axes(pose, "local"), rotation_from_rpy_deg((10.0, 20.0, 30.0)))
    assert np.array_equal(gizmo_axes(pose, "world"), np.eye(3))
