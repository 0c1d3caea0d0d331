"""Poses: roll, pitch and yaw mean what REP-103 says and survive the way through a rotation matrix."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from riglens.core.geometry import Pose, Vec3, is_rotation, rotation_from_rpy_deg, rpy_deg_from_rotation
from tests.core.oracle import rotation

angles = st.floats(-180.0, 180.0)
rpy = st.tuples(angles, st.floats(-90.0, 90.0), angles)


@given(rpy)
def test_the_rotation_is_yaw_times_pitch_times_roll(rpy_deg: tuple[float, float, float]) -> None:
    roll, pitch, yaw = rpy_deg
    expected = Rotation.from_euler("ZYX", [yaw, pitch, roll], degrees=True).as_matrix()
    found = rotation_from_rpy_deg(rpy_deg)
    assert np.abs(found - expected).max() < 1e-12
    assert np.array_equal(found, rotation(rpy_deg))


@given(rpy)
def test_a_rotation_is_orthonormal_and_right_handed(rpy_deg: tuple[float, float, float]) -> None:
    matrix = rotation_from_rpy_deg(rpy_deg)
    assert np.abs(matrix @ matrix.T - np.eye(3)).max() < 1e-14
    assert np.linalg.det(matrix) == pytest.approx(1.0)


@given(rpy)
@example((30.0, 90.0, 20.0))
@example((-75.0, -90.0, 10.0))
@example((10.0, 89.9999999, 5.0))
@example((0.0, 90.0, 0.0))
@example((180.0, 0.0, 180.0))
@example((33.0, 89.9999999999, -120.0))
@example((-100.0, -89.99999999, 77.0))
def test_angles_from_a_rotation_give_that_rotation(rpy_deg: tuple[float, float, float]) -> None:
    matrix = rotation_from_rpy_deg(rpy_deg)
    back = rpy_deg_from_rotation(matrix)
    assert np.abs(rotation_from_rpy_deg(back) - matrix).max() < 1e-11
    assert abs(back[1]) <= 90.0


@given(st.tuples(angles, st.floats(-89.0, 89.0), angles))
def test_angles_away_from_straight_up_and_down_come_back(rpy_deg: tuple[float, float, float]) -> None:
    back = np.array(rpy_deg_from_rotation(rotation_from_rpy_deg(rpy_deg)))
    difference = (back - np.array(rpy_deg) + 180.0) % 360.0 - 180.0
    assert np.abs(difference).max() < 1e-9


def test_straight_up_and_down_have_no_roll() -> None:
    assert rpy_deg_from_rotation(rotation_from_rpy_deg((30.0, 90.0, 20.0))) == pytest.approx(
        (0.0, 90.0, -10.0)
    )
    assert rpy_deg_from_rotation(rotation_from_rpy_deg((30.0, -90.0, 20.0))) == pytest.approx(
        (0.0, -90.0, 50.0)
    )


def test_positive_angles_turn_left_look_down_and_lift_the_left_side() -> None:
    forward, left = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    assert rotation_from_rpy_deg((0.0, 0.0, 90.0)) @ forward == pytest.approx(left)
    assert (rotation_from_rpy_deg((0.0, 10.0, 0.0)) @ forward)[2] < 0.0
    assert (rotation_from_rpy_deg((10.0, 0.0, 0.0)) @ left)[2] > 0.0


def test_no_rotation_is_the_identity_to_the_last_bit() -> None:
    assert np.array_equal(rotation_from_rpy_deg((0.0, 0.0, 0.0)), np.eye(3))


def test_a_pose_takes_points_of_the_sensor_to_the_vehicle() -> None:
    pose = Pose((1.0, 2.0, 3.0), (0.0, 0.0, 90.0))
    assert pose.vehicle_SE3_sensor() @ [5.0, 0.0, 0.0, 1.0] == pytest.approx([1.0, 7.0, 3.0, 1.0])
    assert np.array_equal(pose.vehicle_SE3_sensor()[:3, :3], pose.rotation())


coordinates = st.floats(-100.0, 100.0)
positions = st.tuples(coordinates, coordinates, coordinates)
poses = st.builds(Pose, positions, rpy)


@given(poses, poses, positions)
def test_composed_poses_transform_one_after_the_other(a: Pose, b: Pose, point_m: Vec3) -> None:
    assert a.compose(b).transform(point_m) == pytest.approx(a.transform(b.transform(point_m)), abs=1e-9)
    product = a.vehicle_SE3_sensor() @ b.vehicle_SE3_sensor()
    assert np.abs(a.compose(b).vehicle_SE3_sensor() - product).max() < 1e-9


@given(poses, positions)
@example(Pose((1.0, 2.0, 3.0), (40.0, 90.0, -20.0)), (5.0, 6.0, 7.0))
def test_the_inverse_of_a_pose_takes_points_back(pose: Pose, point_m: Vec3) -> None:
    assert pose.inverse().transform(pose.transform(point_m)) == pytest.approx(np.array(point_m), abs=1e-9)
    assert pose.inverse().inverse().vehicle_SE3_sensor() == pytest.approx(pose.vehicle_SE3_sensor(), abs=1e-9)
    for found in (pose.compose(pose.inverse()), pose.inverse().compose(pose)):
        assert np.abs(found.vehicle_SE3_sensor() - np.eye(4)).max() < 1e-9


@given(poses, st.lists(positions, min_size=1, max_size=5))
def test_many_points_are_transformed_as_each_of_them(pose: Pose, points_m: list[Vec3]) -> None:
    found = pose.transform(points_m)
    assert found.shape == (len(points_m), 3)
    for point_m, one in zip(points_m, found, strict=True):
        homogeneous = pose.vehicle_SE3_sensor() @ [*point_m, 1.0]
        assert one == pytest.approx(homogeneous[:3], abs=1e-9)
        assert one == pytest.approx(pose.transform(point_m), abs=1e-12)


@given(rpy, st.floats(-1.7e308, 1.7e308))
@example((0.0, 0.0, 0.0), 1e308)
@example((0.0, 0.0, 0.0), -1.0)
def test_only_a_rotation_is_one_however_large_the_numbers(rpy_deg: Vec3, scale: float) -> None:
    matrix = rotation_from_rpy_deg(rpy_deg)
    assert is_rotation(matrix)
    with np.errstate(all="raise", under="ignore"):
        assert is_rotation(scale * matrix) == (abs(scale - 1.0) < 4e-4) or abs(abs(scale - 1.0) - 5e-4) < 2e-4
