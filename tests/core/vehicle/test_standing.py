"""Where a sensor stands is said honestly: above the roof, inside, in the ground; for meshes with holes too."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.rig.model import PARAMETRIC_BODIES, Vehicle
from riglens.core.rig.presets import preset
from riglens.core.vehicle.profile import reference_vehicle
from riglens.core.vehicle.solid import Solid, solid_of
from riglens.core.vehicle.standing import mount_status, problems_in_short
from tests.core.vehicle.solids import box, plate

ROOM = Solid.of(box((-2.0, -1.0, 0.3), (2.0, 1.0, 1.5)))


def test_the_lidars_of_the_papers_rig_float_three_quarters_of_a_metre_above_a_sedans_roof() -> None:
    rig = preset("W+T")
    solid = solid_of(rig.vehicle)
    found = {s.name: mount_status(s.position, solid) for s in rig.sensors}
    assert found["LIDAR_1"].drop_m == pytest.approx(0.75, abs=0.02)
    assert found["LIDAR_1"].problem == f"{found['LIDAR_1'].drop_m:.2f} m above the body: needs a bracket"
    assert all(found[s.name].problem for s in rig.enabled_lidars())


@pytest.mark.parametrize("body", PARAMETRIC_BODIES)
def test_the_cabin_is_inside_and_all_around_the_car_is_not(body: str) -> None:
    vehicle = reference_vehicle(body)
    solid = solid_of(vehicle)
    seat = (2.9 if body == "truck" else 0.1, 0.0, 0.72 * vehicle.height)
    assert mount_status(seat, solid).inside and mount_status(seat, solid).problem.endswith(
        "m inside the body"
    )
    for place in (
        (0.0, 0.0, vehicle.height + 0.05),
        (vehicle.length / 2 + 0.05, 0.0, 0.6),
        (0.0, vehicle.width / 2 + 0.1, 0.6),
        (0.0, 0.0, 0.05),
    ):
        assert not mount_status(place, solid).inside, place


@given(st.floats(-1.9, 1.9), st.floats(-0.9, 0.9), st.floats(0.35, 1.45))
def test_every_place_in_a_closed_box_is_inside_and_its_gap_is_to_the_nearest_wall(
    x: float, y: float, z: float
) -> None:
    found = mount_status((x, y, z), ROOM)
    assert found.inside and found.drop_m == pytest.approx(z - 0.3)
    assert found.gap_m == pytest.approx(min(2 - abs(x), 1 - abs(y), z - 0.3, 1.5 - z))


def test_a_box_without_a_floor_or_turned_inside_out_has_an_inside_too() -> None:
    faces = box((-2.0, -1.0, 0.3), (2.0, 1.0, 1.5))
    open_below = faces[~(faces[:, :, 2] == 0.3).all(axis=1)]
    for triangles in (open_below, faces[:, ::-1]):
        assert mount_status((0.0, 0.0, 0.9), Solid.of(triangles)).inside
        assert not mount_status((0.0, 0.0, 0.1), Solid.of(triangles)).inside
        assert not mount_status((0.0, 0.0, 1.6), Solid.of(triangles)).inside


@pytest.mark.parametrize(
    ("place", "gap_m", "drop_m", "problem"),
    [
        ((0.0, 0.0, 1.55), 0.05, 0.05, ""),
        ((0.0, 0.0, 1.8), 0.3, 0.3, "0.30 m above the body: needs a bracket"),
        ((3.0, 0.0, 0.9), 1.0, None, "1.00 m off the body: needs a bracket"),
        ((5.0, 5.0, 1.5), 5.0, None, "5.00 m off the body: needs a bracket"),
        ((0.0, 0.0, -0.2), 0.5, None, "below the ground"),
    ],
)
def test_gap_drop_and_what_is_said(
    place: tuple[float, float, float], gap_m: float, drop_m: float | None, problem: str
) -> None:
    found = mount_status(place, ROOM)
    assert found.gap_m == pytest.approx(gap_m) and found.problem == problem
    assert found.drop_m == (None if drop_m is None else pytest.approx(drop_m))


def test_without_a_body_there_is_nothing_to_stand_on_and_nothing_is_said() -> None:
    found = mount_status((0.0, 0.0, 1.0), Solid.of(np.zeros((0, 3, 3))))
    assert (found.inside, found.gap_m, found.drop_m, found.problem) == (False, np.inf, None, "")


def test_the_gap_to_a_large_triangle_is_not_to_its_corners() -> None:
    wall = Solid.of(plate(2.0, half_m=30.0))
    assert mount_status((1.5, 3.0, 4.0), wall).gap_m == pytest.approx(0.5)
    assert mount_status((2.2, 31.0, 4.0), wall).gap_m == pytest.approx(np.hypot(0.2, 1.0))


def test_another_car_changes_where_a_sensor_stands() -> None:
    place = (-0.4, 0.2, 1.6)
    assert not mount_status(place, solid_of(Vehicle())).inside
    assert mount_status(place, solid_of(Vehicle(body="van", height=2.3))).inside


def distances_m(place: np.ndarray, triangles: np.ndarray) -> float:
    """The least distance to a fine net of points on each triangle."""
    steps = np.linspace(0.0, 1.0, 41)
    u, v = (part.ravel() for part in np.meshgrid(steps, steps))
    weights = np.stack([(1 - u), u * (1 - v), u * v], axis=1)
    return float(np.linalg.norm(weights @ triangles - place, axis=2).min())


@given(st.floats(-4.0, 4.0), st.floats(-3.0, 3.0), st.floats(0.1, 3.0))
def test_the_nearest_place_is_on_the_surface_and_nothing_is_nearer(x: float, y: float, z: float) -> None:
    found = mount_status((x, y, z), ROOM)
    place, nearest = np.array((x, y, z)), np.array(found.nearest_m)
    assert found.gap_m == pytest.approx(np.linalg.norm(nearest - place))
    assert distances_m(nearest, ROOM.triangles_m) <= 0.06  # the net's mesh
    assert found.gap_m <= distances_m(place, ROOM.triangles_m) + 1e-9


@pytest.mark.parametrize(
    ("place", "foot_m", "height"),
    [
        ((0.0, 0.0, 1.8), (0.0, 0.0, 1.5), "0.30 m"),
        ((3.0, 0.2, 0.9), (2.0, 0.2, 0.9), "1.00 m"),
        ((0.5, 0.0, -0.2), (0.5, 0.0, 0.0), "0.20 m deep"),
        ((1.8, 0.0, 0.9), (2.0, 0.0, 0.9), "inside"),
    ],
)
def test_a_line_to_where_it_should_stand(
    place: tuple[float, float, float], foot_m: tuple[float, float, float], height: str
) -> None:
    found = mount_status(place, ROOM)
    assert found.foot_m == pytest.approx(foot_m) and found.height == height


def test_what_is_wrong_is_said_once_for_all_sensors_of_which_it_is_true() -> None:
    stands = {
        name: mount_status((x, 0.0, 1.8 if x < 2 else 1.55), ROOM)
        for name, x in (("a", 0.0), ("b", 1.0), ("c", 2.0))
    }
    assert problems_in_short({"c": mount_status((0.0, 0.0, 1.5), ROOM)}) == []
    assert problems_in_short(stands)[0] == "a, b: 0.30 m above the body: needs a bracket"
