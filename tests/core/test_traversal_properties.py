"""Properties that hold for every ray and every rig, whatever its numbers are."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Lidar, Sensor
from riglens.core.sensing.rays import clip_to_roi, sensor_rays
from tests.core.builders import (
    camera,
    evaluate,
    field_of,
    grid_of,
    lidar,
    random_field,
    random_sensor,
    rig_of,
    seen_by,
    spinning,
    synthetic_pog,
)
from tests.core.oracle import bresenham, exact_walk, grid_rays, slab_lengths

GRID = grid_of(12, 10, 7, 0.5)
FIELD = field_of(GRID)
seeds = st.integers(0, 2**32 - 1)


def ray_between(start: np.ndarray, end: np.ndarray, overshoot: float = 1.0) -> Lidar:
    """A single ray from one point towards another, ending there."""
    way = end - start
    length = float(np.linalg.norm(way))
    elevation = math.degrees(math.asin(way[2] / length))
    azimuth = math.degrees(math.atan2(way[1], way[0]))
    return lidar(start, elevations=[elevation], azimuths=[azimuth], range_m=(0.0, length * overshoot))


def random_points(rng: np.random.Generator, count: int) -> np.ndarray:
    """Points in and around the ROI."""
    roi = np.array(GRID.roi_m)
    return rng.uniform(-0.7, 0.7, (count, 3)) * roi + [0.0, 0.0, roi[2] / 2]


def in_order(sensor: Lidar) -> np.ndarray:
    """Covered voxels of a single ray in the order in which it meets them, (n, 3)."""
    (ray,) = grid_rays(GRID, sensor)
    cells = np.argwhere(seen_by(FIELD, sensor))
    middle = (cells + 0.5 - ray.g) @ np.array(ray.d)
    return cells[np.argsort(middle, kind="stable")]


@settings(max_examples=100)
@given(seed=seeds)
def test_successive_voxels_of_a_generic_ray_share_a_face(seed: int) -> None:
    start, end = random_points(np.random.default_rng(seed), 2)
    cells = in_order(ray_between(start, end))
    assert (np.abs(np.diff(cells, axis=0)).sum(axis=1) == 1).all()


@settings(max_examples=100)
@given(
    position=st.tuples(*[st.integers(-8, 8)] * 3), azimuth=st.integers(-4, 4), elevation=st.integers(-2, 2)
)
def test_successive_voxels_share_at_least_a_corner_where_faces_are_crossed_together(
    position: tuple[int, int, int], azimuth: int, elevation: int
) -> None:
    place = np.array(position) * 0.25 + [0.0, 0.0, 2.0]
    cells = in_order(lidar(place, elevations=[elevation * 45.0], azimuths=[azimuth * 45.0]))
    assert (np.abs(np.diff(cells, axis=0)).max(axis=1, initial=0) <= 1).all()
    assert len(np.unique(cells, axis=0)) == len(cells)


@settings(max_examples=100)
@given(seed=seeds)
def test_the_reversed_ray_traverses_the_same_voxels(seed: int) -> None:
    start, end = random_points(np.random.default_rng(seed), 2)
    there, back = seen_by(FIELD, ray_between(start, end)), seen_by(FIELD, ray_between(end, start))
    assert np.array_equal(there, back)


@settings(max_examples=100)
@given(seed=seeds)
def test_segments_in_the_covered_voxels_sum_to_the_clipped_length(seed: int) -> None:
    rng = np.random.default_rng(seed)
    start, end = random_points(rng, 2)
    sensor = ray_between(start, end, float(rng.choice([0.5, 1.0, 100.0])))
    covered = seen_by(FIELD, sensor)
    (ray,) = grid_rays(GRID, sensor)
    t0, t1 = clip_to_roi(GRID, sensor_rays(sensor))
    clipped_m = max(float(t1[0] - t0[0]), 0.0)
    lengths = slab_lengths(GRID.shape, ray)[covered]
    assert (lengths > 0.0).all()
    assert lengths.sum() * GRID.voxel_m == pytest.approx(clipped_m, abs=1e-9)


@settings(max_examples=25)
@given(seed=seeds)
def test_adding_a_sensor_never_lowers_what_is_seen(seed: int) -> None:
    rng = np.random.default_rng(seed)
    field = random_field(GRID, rng)
    sensors = [random_sensor(GRID, rng) for _ in range(4)]
    steps = [evaluate(field, rig_of(*sensors[:count])).scores for count in range(5)]
    for before, after in pairwise(steps):
        for name in before.classes:
            assert after.classes[name].any_seen >= before.classes[name].any_seen
            assert after.classes[name].camera.seen >= before.classes[name].camera.seen
            assert after.classes[name].lidar.seen >= before.classes[name].lidar.seen
            assert after.classes[name].s_ms <= before.classes[name].s_ms
    assert all(0.0 <= c.any_seen <= 1.0 for scores in steps for c in scores.classes.values())


def mirrored(sensor: Sensor) -> Sensor:
    """The sensor on the other side of the car: y, roll and yaw change their signs."""
    (x, y, z), (roll, pitch, yaw) = sensor.position, sensor.rpy_deg
    changes = {"position": (x, -y, z), "rpy_deg": (-roll, pitch, -yaw)}
    if isinstance(sensor, Lidar):
        changes["azimuths_deg"] = tuple(-a for a in map(float, sensor.azimuths()))
        changes["elevations_deg"] = tuple(map(float, sensor.elevations()))
    return sensor.replace(**changes)


@settings(max_examples=40)
@given(seed=seeds)
def test_a_mirrored_rig_in_a_mirrored_scene_has_the_same_scores(seed: int) -> None:
    rng = np.random.default_rng(seed)
    counts = rng.integers(0, 40, (*GRID.shape, 3))
    here = type(FIELD).from_pog(synthetic_pog(GRID, counts, 40))
    there = type(FIELD).from_pog(synthetic_pog(GRID, counts[:, ::-1], 40))
    sensors = [random_sensor(GRID, rng) for _ in range(3)]
    other_side = [mirrored(sensor) for sensor in sensors]
    assert evaluate(here, rig_of(*sensors)).scores == evaluate(there, rig_of(*other_side)).scores
    assert np.array_equal(seen_by(FIELD, *sensors), seen_by(FIELD, *other_side)[:, ::-1])


def test_identical_sensors_change_nothing() -> None:
    field = random_field(GRID, np.random.default_rng(5))
    one = spinning((0.1, 0.2, 1.7))
    eye = camera((0.3, 0.1, 1.5))
    alone, doubled = evaluate(field, rig_of(one, eye)), evaluate(field, rig_of(one, eye, one, eye, one))
    assert alone.scores == doubled.scores
    assert np.array_equal(alone.seen["lidar"], doubled.seen["lidar"])


def test_the_order_of_the_sensors_does_not_matter() -> None:
    rng = np.random.default_rng(6)
    field = random_field(GRID, rng)
    sensors = [random_sensor(GRID, rng) for _ in range(5)]
    expected = evaluate(field, rig_of(*sensors)).scores
    for _ in range(4):
        shuffled = [sensors[i] for i in rng.permutation(5)]
        assert evaluate(field, rig_of(*shuffled)).scores == expected


def test_a_disabled_sensor_counts_as_removed() -> None:
    field = random_field(GRID, np.random.default_rng(7))
    one, other = spinning((0.1, 0.2, 1.7)), camera((0.3, 0.1, 1.5))
    off = rig_of(one, other.replace(enabled=False))
    assert evaluate(field, off).scores == evaluate(field, rig_of(one)).scores


@pytest.mark.parametrize("reading", ["covered", "hits"])
def test_an_empty_rig_scores_zero_and_sees_nothing(reading: str) -> None:
    field = random_field(GRID, np.random.default_rng(8))
    result = evaluate(field, rig_of(), MetricSettings(reading=reading))
    for scores in result.scores.classes.values():
        assert (scores.s_ms, scores.any_seen, scores.camera.seen, scores.lidar.seen) == (0.0, 0.0, 0.0, 0.0)
        assert math.copysign(1.0, scores.s_ms) == 1.0, "no minus zero in front of a user"
        assert scores.h_total > 0.0
    assert not result.seen["camera"].any() and not result.seen["lidar"].any()
    assert set(result.scores.covered_voxels.values()) == {0}


def test_a_rig_that_sees_everything_has_seen_one() -> None:
    grid = grid_of(2, 2, 2)
    result = evaluate(field_of(grid), rig_of(spinning((0.1, 0.2, 0.9), (1.0, 2.0, 3.0), beams=30, count=90)))
    assert all(scores.lidar.seen == scores.any_seen == 1.0 for scores in result.scores.classes.values())


# ---------------------------------------------------------------- Bresenham


@settings(max_examples=60)
@given(seed=seeds)
def test_bresenham_draws_the_line_from_the_first_to_the_last_voxel(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sensor = random_sensor(GRID, rng, rays=12)
    expected = np.zeros(GRID.shape, np.bool_)
    for ray in grid_rays(GRID, sensor):
        if walk := exact_walk(GRID.shape, ray):
            for cell in bresenham(walk[0], walk[-1]):
                expected[cell] = True
    assert np.array_equal(seen_by(FIELD, sensor, method="bresenham"), expected)


@settings(max_examples=20)
@given(seed=seeds)
def test_bresenham_does_not_depend_on_which_voxels_are_informative(seed: int) -> None:
    rng = np.random.default_rng(seed)
    informative = rng.random(GRID.shape) < 0.1
    sensor = random_sensor(GRID, rng, rays=12)
    everywhere = seen_by(FIELD, sensor, method="bresenham")
    assert np.array_equal(
        seen_by(field_of(GRID, informative), sensor, method="bresenham"), everywhere & informative
    )


def test_bresenham_misses_voxels_of_a_slanted_ray() -> None:
    sensor = lidar((-2.9, -2.2, 0.3), (0.0, -11.0, 33.0))
    exact, line = seen_by(FIELD, sensor), seen_by(FIELD, sensor, method="bresenham")
    assert line.sum() < exact.sum()
