"""The reason why a sensor misses a voxel is the true one, and the miss distance that of its nearest ray."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.engine.engine import Engine
from riglens.core.engine.inspect import sees_voxel
from riglens.core.engine.sight import sight
from riglens.core.rig.model import Lidar, LinearAngles
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.sensing.rays import sensor_rays
from riglens.core.vehicle.solid import Solid
from tests.core.builders import camera, field_of, grid_of, lidar, random_sensor, rig_of, spinning
from tests.core.vehicle.solids import box

GRID = VoxelGrid(0.1, (20.0, 20.0, 4.0))


def voxel_at(grid, point):
    return tuple(int(np.floor(place)) for place in grid.to_grid(point))


def plain_miss(sensor, grid, voxel, count=4000):
    """Distance of the nearest ray from the voxel's box by looking at many points of every ray."""
    low = np.array(grid.origin_m) + np.array(voxel) * grid.voxel_m
    directions = sensor_rays(sensor).directions
    reach = 2.0 * float(np.linalg.norm(low - np.array(sensor.position))) + 2.0
    points = np.array(sensor.position) + np.linspace(0.0, reach, count)[:, None, None] * directions
    return float(
        np.linalg.norm(points - np.clip(points, low, low + grid.voxel_m), axis=2).min()
    ), reach / count


@settings(max_examples=7)
@given(seed=st.integers(0, 2**32 - 1))
def test_what_the_engine_does_not_mark_gets_a_reason_that_holds(seed):
    grid = grid_of(10, 9, 8, 0.5)
    rng = np.random.default_rng(seed)
    field, sensor = field_of(grid), random_sensor(grid, rng, rays=12)
    engine, endless = Engine(field), Engine(field)
    engine.evaluate(rig_of(sensor))
    endless.evaluate(rig_of(sensor.replace(range_m=(0.0, float("inf")))))
    for voxel in map(tuple, rng.integers(0, grid.shape, (25, 3)).tolist()):
        sees = sees_voxel(engine, sensor, "exact", voxel)
        found = sight(sensor, grid, voxel, bool(sees))
        assert (found.verdict == "sees") == sees
        if found.verdict in ("between", "outside"):
            plain, step = plain_miss(sensor, grid, voxel)
            assert plain - 2 * step <= found.miss_m <= plain + 1e-9
        elif found.verdict == "range":
            low = np.array(grid.origin_m) + np.array(voxel) * grid.voxel_m - np.array(sensor.position)
            corners = low + grid.voxel_m * np.array(list(itertools.product((0, 1), repeat=3)))
            is_near = np.linalg.norm(corners, axis=1).max() <= sensor.range_m[0]
            is_far = np.linalg.norm(np.clip(0.0, low, low + grid.voxel_m)) >= sensor.range_m[1]
            crossed = sees_voxel(endless, sensor.replace(range_m=(0.0, float("inf"))), "exact", voxel)
            assert crossed or is_near or is_far


@pytest.mark.parametrize(("seed", "voxel"), [(5, (6, 3, 5)), (17, (8, 2, 4))])
def test_the_nearest_ray_is_that_to_the_box_and_not_to_its_centre(seed, voxel):
    """One that passes beside a corner is nearer than another that comes closer to the centre, beside a face."""
    grid = grid_of(10, 9, 8, 0.5)
    sensor = random_sensor(grid, np.random.default_rng(seed), rays=12).replace(range_m=(0.0, float("inf")))
    found = sight(sensor, grid, voxel, False)
    plain, step = plain_miss(sensor, grid, voxel, 100_000)
    assert found.verdict in ("between", "outside") and plain - 2 * step <= found.miss_m <= plain + 1e-9


def test_a_voxel_between_two_beams_is_missed_by_the_distance_to_the_nearer_one():
    roof = lidar((0.0, 0.0, 2.0), elevations=(0.0, 10.0), azimuths=np.arange(-180.0, 180.0))
    voxel = voxel_at(GRID, (5.02, 0.01, 2.33))
    found = sight(roof, GRID, voxel, sees=False)
    assert (found.verdict, found.side) == ("between", "")
    assert found.miss_m == pytest.approx(0.3, abs=1e-6)
    assert found.distance_m == pytest.approx(np.linalg.norm([5.05, 0.05, 0.35]), abs=1e-6)


@pytest.mark.parametrize(
    ("point", "side"), [((3.0, 0.0, 3.9), "above"), ((3.0, 0.0, 0.3), "below"), ((-3.0, 1.0, 2.05), "beside")]
)
def test_beyond_the_highest_and_lowest_beam_and_the_sector_a_lidar_does_not_look(point, side):
    front = Lidar(
        name="front",
        position=(0.0, 0.0, 2.0),
        elevations_deg=(-10.0, 0.0, 10.0),
        azimuths_deg=LinearAngles(**{"from": -60.0, "to": 60.0, "count": 120}),
    )
    found = sight(front, GRID, voxel_at(GRID, point), sees=False)
    assert (found.verdict, found.side) == ("outside", side)
    assert found.miss_deg > 5.0 and found.miss_m > 0.5


def test_a_lidar_that_turns_all_round_has_no_sector():
    roof = spinning((0.0, 0.0, 2.0), beams=3, count=7)
    verdicts = {
        sight(roof, GRID, voxel_at(GRID, (4 * np.cos(a), 4 * np.sin(a), 2.6)), False).verdict
        for a in np.radians([5, 95, 185, 275, 355])
    }
    assert verdicts == {"between"}


@pytest.mark.parametrize(
    ("point", "verdict", "side"),
    [
        ((6.0, 0.07, 2.0), "between", ""),
        ((6.0, 5.5, 2.0), "outside", "beside"),
        ((6.0, -5.5, 2.0), "outside", "beside"),
        ((-6.0, 0.0, 2.0), "outside", "beside"),
        ((2.0, 0.0, 3.9), "outside", "above"),
        ((2.0, 0.0, 0.1), "outside", "below"),
    ],
)
def test_a_camera_does_not_look_beyond_the_edge_of_its_image(point, verdict, side):
    front = camera((0.0, 0.0, 2.0), cast=(8, 6), hfov_deg=70.0)
    found = sight(front, GRID, voxel_at(GRID, point), sees=False)
    assert (found.verdict, found.side) == (verdict, side)


def test_a_camera_of_one_ray_has_no_field_of_view_to_leave():
    assert sight(camera((0.0, 0.0, 2.0), cast=(1, 1)), GRID, (0, 0, 0), False).verdict == "between"


def test_what_only_the_range_cuts_off_is_out_of_range():
    ahead = lidar((0.0, 0.05, 2.05), range_m=(2.0, 6.0))
    at = {x: sight(ahead, GRID, voxel_at(GRID, (x, 0.02, 2.02)), sees=False).verdict for x in (1.0, 7.0)}
    assert at == {1.0: "range", 7.0: "range"}
    assert sight(ahead, GRID, voxel_at(GRID, (4.0, 0.02, 3.0)), sees=False).verdict == "outside"


def test_between_rays_but_before_the_range_begins_or_after_it_ends_is_out_of_range():
    """Beams 40 degrees apart, and voxels half-way between them."""
    round_about = np.arange(-180.0, 180.0)
    sparse = lidar((0.0, 0.05, 2.05), elevations=(-20.0, 20.0), azimuths=round_about, range_m=(2.0, 6.0))
    at = {
        x: sight(sparse, GRID, voxel_at(GRID, (x, 0.02, 2.02)), sees=False).verdict for x in (0.9, 4.0, 7.0)
    }
    assert at == {0.9: "range", 4.0: "between", 7.0: "range"}


@pytest.mark.parametrize(
    ("yaw_deg", "point", "verdict"),
    [
        (0.0, (3.0, 1.5, 2.25), "between"),
        (0.0, (1.5, 3.0, 2.25), "outside"),
        (90.0, (1.5, 3.0, 2.25), "between"),
        (90.0, (1.5, -3.0, 2.25), "outside"),
    ],
)
def test_the_sector_of_a_lidar_turns_with_it_and_within_it_nothing_is_beside(yaw_deg, point, verdict):
    sector = Lidar(
        name="sector", position=(0.0, 0.0, 2.0), rpy_deg=(0.0, 0.0, yaw_deg), elevations_deg=(-10.0, 0.0, 10.0),
        azimuths_deg=LinearAngles(**{"from": -60.0, "to": 60.0, "count": 120}),
    )  # fmt: skip
    found = sight(sector, GRID, voxel_at(GRID, point), sees=False)
    assert (found.verdict, found.side) == (verdict, "" if verdict == "between" else "beside")


def test_outside_the_field_of_view_comes_before_out_of_range():
    ahead = lidar((0.0, 0.05, 2.05), range_m=(0.0, 3.0))
    found = sight(ahead, GRID, voxel_at(GRID, (6.0, 0.02, 3.9)), sees=False)
    assert (found.verdict, found.side) == ("outside", "above")


def test_a_sensor_that_is_off_is_the_reason_whatever_it_would_see():
    off = lidar((0.0, 0.05, 2.05)).replace(enabled=False)
    assert sight(off, GRID, voxel_at(GRID, (1.0, 0.02, 2.02)), sees=False).verdict == "off"


def test_many_rays_are_looked_through_in_parts():
    dense = camera((0.0, 0.0, 2.0), cast=(1000, 600))
    found = sight(dense, GRID, voxel_at(GRID, (-6.0, 0.0, 2.0)), sees=False)
    thin = sight(camera((0.0, 0.0, 2.0), cast=(100, 60)), GRID, voxel_at(GRID, (-6.0, 0.0, 2.0)), False)
    assert found.verdict == "outside"
    assert found.miss_deg == pytest.approx(thin.miss_deg, abs=1.0)


def test_a_voxel_that_the_car_hides_is_behind_its_body_and_one_beside_it_is_not() -> None:
    """A wall from x = 1 to the right: what rays would meet behind it is hidden, before it and beside it nothing is."""
    wall = Solid.of(box((1.0, -3.0, 0.0), (1.2, 0.0, 3.0)))
    roof = lidar((0.0, 0.0, 2.05), elevations=(0.0,), azimuths=np.arange(-180.0, 180.0))
    verdicts = []
    for azimuth_deg, away_m in ((-20.0, 3.0), (-20.0, 0.7), (20.0, 3.0)):
        turn = np.radians(azimuth_deg)
        voxel = voxel_at(GRID, (away_m * np.cos(turn), away_m * np.sin(turn), 2.05))
        found = sight(roof, GRID, voxel, False, barrier_of(roof, wall))
        verdicts.append(found.verdict == "body")
    assert verdicts == [True, False, False]
