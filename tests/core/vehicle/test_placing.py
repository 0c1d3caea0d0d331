"""Sensors put on a surface: they touch it from outside and look where a person would have them look."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from riglens.core.geometry import Pose
from riglens.core.sensors.mounting import upright_rpy_deg
from riglens.core.vehicle.placing import FAR_M, FREE, PlacingRules, placed, placed_on

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
def test_the_body_touches_the_surface_or_is_let_into_it_so_as_to_need_no_bracket(kind, point, normal):
    pose = placed_on(point, normal, kind, BOX)
    off_m = (np.array(pose.position_m) - point) @ normal
    assert 0.0 < off_m <= FAR_M
    corners = np.stack(np.meshgrid(*BOX.T), axis=-1).reshape(-1, 3)
    heights = (corners @ pose.rotation().T + pose.position_m - point) @ normal
    is_let_in = off_m > FAR_M - 0.006
    assert heights.min() == pytest.approx(0.0, abs=ROUNDING_M) or (is_let_in and heights.min() < 0.0)


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


@pytest.mark.parametrize("x", [1.0, -1.0])
def test_upright_on_the_very_front_ahead_is_down_and_on_the_rear_up(x):
    turn = Pose((0.0, 0.0, 0.0), upright_rpy_deg(np.array([x, 0.0, 0.0]))).rotation()
    assert turn[:, 2] == pytest.approx([x, 0.0, 0.0]) and turn[:, 0] == pytest.approx([0.0, 0.0, -x])


# ---------------------------------------------------------------------- rules: grid, middle line, upright, rails
RAIL_Y, RAIL_TOP = (0.50, 0.55), 1.58


def roof(origin, direction, slope=0.1, with_rail=True, width=0.6):
    """What a ray meets on a roof that falls ahead from z = 1.5, with a rail along x on the left."""
    normal = np.array([slope, 0.0, 1.0]) / math.hypot(slope, 1.0)
    origin, direction = np.asarray(origin), np.asarray(direction)
    onto_rail = origin + (RAIL_TOP - origin[2]) / direction[2] * direction
    if with_rail and origin[2] > RAIL_TOP and RAIL_Y[0] <= onto_rail[1] <= RAIL_Y[1]:
        return onto_rail, np.array([0.0, 0.0, 1.0])
    ahead = (normal @ ([0.0, 0.0, 1.5] - origin)) / (normal @ direction)
    place = origin + ahead * direction
    return (place, normal) if ahead >= 0.0 and abs(place[1]) <= width else None


PUCK = ("lidar", np.array([[-0.1, -0.1, -0.08], [0.1, 0.1, 0.08]]))
DOWN = np.array([0.0, 0.0, -1.0])


def put(x, y, rules, cast=roof, body=PUCK):
    return placed(cast, (np.array([x, y, 3.0]), DOWN), body, rules)


def test_without_rules_a_sensor_sits_where_it_is_pointed_at():
    free = put(0.123, 0.234, FREE)
    assert free == placed_on(*roof([0.123, 0.234, 3.0], DOWN), *PUCK)
    assert put(0.0, 2.0, FREE) is None


@pytest.mark.parametrize(("x", "y"), [(0.123, 0.234), (-0.41, -0.33), (0.07, 0.02)])
def test_on_the_grid_the_sensor_itself_has_round_coordinates_and_still_touches_the_surface(x, y):
    pose = put(x, y, PlacingRules(grid_m=0.05))
    x_m, y_m, z_m = pose.position_m
    assert (x_m, y_m) == (round(round(x_m / 0.05) * 0.05, 9), round(round(y_m / 0.05) * 0.05, 9))
    assert math.hypot(x_m - x, y_m - y) < 0.06
    normal = np.array([0.1, 0.0, 1.0]) / math.hypot(0.1, 1.0)
    lowest = np.array([0.0, 0.0, -0.08]) @ pose.rotation().T
    assert (np.array([x_m, y_m, z_m]) + lowest - [0.0, 0.0, 1.5]) @ normal == pytest.approx(0.0, abs=0.003)


def test_near_the_middle_line_a_sensor_snaps_onto_it_and_not_without_the_grid():
    assert put(0.2, 0.07, PlacingRules(grid_m=0.05, centre_m=0.08)).position_m[1] == 0.0
    assert put(0.2, 0.09, PlacingRules(grid_m=0.05, centre_m=0.08)).position_m[1] == 0.1
    assert put(0.2, 0.07, PlacingRules(centre_m=0.08)).position_m[1] == 0.07


def test_where_the_grid_would_lie_beside_the_surface_the_place_stays_free():
    def narrow(origin, direction):
        return roof(origin, direction, with_rail=False, width=0.02)

    assert put(0.1, 0.015, PlacingRules(grid_m=0.05), narrow).position_m[1] == 0.0
    shifted = PlacingRules(grid_m=0.7)
    assert put(0.0, 0.55, shifted, lambda o, d: roof(o, d, with_rail=False)) == put(
        0.0, 0.55, FREE, lambda o, d: roof(o, d, with_rail=False)
    )


def test_upright_sensors_are_level_on_a_slope_and_still_touch_it():
    leaning, level = put(0.1, 0.2, FREE), put(0.1, 0.2, PlacingRules(upright=True))
    assert leaning.rpy_deg[1] != 0.0 and level.rpy_deg == (0.0, 0.0, 0.0)
    assert level.position_m[2] > leaning.position_m[2]
    side = (np.array([0.5, 1.0, 1.0]), np.array([0.0, 0.8, 0.6]))
    lens = np.array([[-0.1, -0.05, -0.05], [0.05, 0.05, 0.05]])
    camera = placed_on(*side, "camera", lens, upright=True)
    assert camera.rpy_deg == (0.0, 0.0, 90.0) and placed_on(*side, "camera", lens).rpy_deg[1] != 0.0


@pytest.mark.parametrize("width", [0.6, 0.56])
def test_below_rails_a_sensor_sits_on_the_roof_beside_or_at_its_edge(width):
    def cast(origin, direction):
        return roof(origin, direction, width=width)

    on_rail, below = put(0.0, 0.52, FREE, cast), put(0.0, 0.52, PlacingRules(below_rails=True), cast)
    assert on_rail.position_m[2] == pytest.approx(RAIL_TOP + 0.08)
    assert below.position_m[2] == pytest.approx(1.5 + 0.08, abs=0.006)
    assert below.position_m[1] == pytest.approx(0.52) and below.rpy_deg[1] == pytest.approx(5.71, abs=0.01)


def test_where_there_is_no_rail_looking_below_one_changes_nothing():
    assert put(0.1, 0.1, PlacingRules(below_rails=True)) == put(0.1, 0.1, FREE)


def test_on_a_side_the_grid_is_along_the_side():
    def door(origin, direction):
        t = (0.9 - origin[1]) / direction[1] if direction[1] else -1.0
        return (
            None if t < 0.0 else (np.asarray(origin) + t * np.asarray(direction), np.array([0.0, 1.0, 0.0]))
        )

    ray = (np.array([0.312, 2.0, 0.888]), np.array([0.0, -1.0, 0.0]))
    pose = placed(door, ray, PUCK, PlacingRules(grid_m=0.05, centre_m=9.0))
    assert pose.position_m == (0.3, pytest.approx(0.98), 0.9)
