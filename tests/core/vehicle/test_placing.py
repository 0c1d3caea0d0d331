"""Sensors put on a surface: they touch it from outside and look where a person would have them look."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from riglens.core.vehicle.placing import placed_on

BOX = np.array([[-0.13, -0.065, -0.05], [0.06, 0.065, 0.067]])
metres = st.floats(-3.0, 3.0)
points = st.tuples(metres, metres, metres).map(np.array)
ROUNDING_M = 1e-3  # poses are rounded to 0.1 mm and 0.01 degrees


@st.composite
def normals(draw: st.DrawFn) -> np.ndarray:
    azimuth, elevation = draw(st.floats(-math.pi, math.pi)), draw(st.floats(-1.5, 1.5))
    flat = math.cos(elevation)
    return np.array([flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation)])


@pytest.mark.parametrize("kind", ["lidar", "camera"])
@given(point=points, normal=normals())
def test_the_body_touches_the_surface_and_nothing_of_it_is_inside(kind, point, normal):
    pose = placed_on(point, normal, kind, BOX)
    corners = np.stack(np.meshgrid(*BOX.T), axis=-1).reshape(-1, 3)
    heights = (corners @ pose.rotation().T + pose.position_m - point) @ normal
    assert heights.min() == pytest.approx(0.0, abs=ROUNDING_M)


@given(points, normals())
def test_a_lidar_stands_upright_on_the_surface(point, normal):
    up = placed_on(point, normal, "lidar", BOX).rotation()[:, 2]
    assert up @ normal > 1.0 - 1e-6


@given(points, normals())
def test_a_lidar_looks_ahead_as_far_as_the_surface_lets_it(point, normal):
    assume(abs(normal[0]) < 0.9)
    forward = placed_on(point, normal, "lidar", BOX).rotation()[:, 0]
    best = np.array([1.0, 0.0, 0.0]) - normal[0] * normal
    assert forward @ best / np.linalg.norm(best) > 1.0 - 1e-6


@given(points, normals())
def test_a_camera_keeps_its_horizon_level(point, normal):
    pose = placed_on(point, normal, "camera", BOX)
    assert pose.rpy_deg[0] == 0.0 and abs(pose.rotation()[2, 1]) < 1e-9


@given(points, normals())
def test_a_camera_on_a_side_looks_straight_away_from_it(point, normal):
    assume(abs(normal[2]) < 0.7)
    assert placed_on(point, normal, "camera", BOX).rotation()[:, 0] @ normal > 1.0 - 1e-6


@pytest.mark.parametrize(
    ("normal", "yaw_deg"), [((0, 0, 1), 0.0), ((0.5, 0, 0.866), 0.0), ((-0.5, 0, 0.866), 180.0)]
)
def test_a_camera_on_a_roof_or_windscreen_looks_level_not_into_the_sky(normal, yaw_deg):
    pose = placed_on(np.zeros(3), np.array(normal), "camera", BOX)
    assert pose.rpy_deg[:2] == (0.0, 0.0) and abs(pose.rpy_deg[2]) == yaw_deg
