"""Ray lattices follow the definitions of the metric to the last bit, and clipping says where rays run."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from riglens.core.rig.model import Camera, Lidar, Sensor
from riglens.core.sensing.rays import clip_to_roi, sensor_rays
from riglens.core.sensors.camera import field_of_view_deg
from tests.core.builders import camera, grid_of, lidar, random_sensor, spinning
from tests.core.oracle import camera_directions, grid_rays, lidar_directions, slab_lengths, vehicle_directions

GRID = grid_of(12, 10, 7, 0.5)
seeds = st.integers(0, 2**32 - 1)


def in_sensor_frame(sensor: Sensor) -> np.ndarray:
    """Directions of a sensor that is not turned, (n, 3)."""
    return sensor_rays(sensor.replace(rpy_deg=(0.0, 0.0, 0.0))).directions


def by_intrinsics(**changes: object) -> Camera:
    fields = {"fx": 700.0, "fy": 650.5, "cx": 801.25, "cy": 444.0} | changes
    return Camera(name="C", position=(0.0, 0.0, 1.0), image=(1600, 900), cast=(16, 9), **fields)


@settings(max_examples=60)
@given(seed=seeds)
def test_directions_are_those_of_the_formulas_bit_for_bit(seed: int) -> None:
    sensor = random_sensor(GRID, np.random.default_rng(seed))
    local = lidar_directions(sensor) if isinstance(sensor, Lidar) else camera_directions(sensor)
    rays = sensor_rays(sensor)
    assert np.array_equal(in_sensor_frame(sensor), local)
    assert np.array_equal(rays.directions, vehicle_directions(sensor))
    assert rays.origin_m == sensor.position
    assert rays.range_m == sensor.range_m


def test_evenly_spaced_angles_and_intrinsics_follow_the_formulas_too() -> None:
    for sensor in (spinning((0, 0, 2), (1, 2, 3), beams=16, count=360), by_intrinsics()):
        assert np.array_equal(sensor_rays(sensor).directions, vehicle_directions(sensor))


@settings(max_examples=60)
@given(seed=seeds)
def test_directions_agree_with_scipy(seed: int) -> None:
    sensor = random_sensor(GRID, np.random.default_rng(seed))
    roll, pitch, yaw = sensor.rpy_deg
    turned = Rotation.from_euler("ZYX", [yaw, pitch, roll], degrees=True).apply(in_sensor_frame(sensor))
    assert np.abs(sensor_rays(sensor).directions - turned).max() < 1e-12
    assert np.abs(np.linalg.norm(turned, axis=1) - 1.0).max() < 1e-12


def test_rows_pick_the_same_rays() -> None:
    sensor = camera((1.0, 2.0, 1.5), (3.0, 4.0, 50.0))
    rows = np.array([0, 17, 62, 5])
    picked = sensor_rays(sensor, rows).directions
    assert np.array_equal(picked, sensor_rays(sensor).directions[rows])


def test_a_lidar_casts_beam_by_beam_from_the_lowest_with_both_ends() -> None:
    rays = sensor_rays(spinning((0, 0, 2), beams=16, count=360)).directions.reshape(16, 360, 3)
    elevation = np.degrees(np.arcsin(rays[..., 2]))
    assert elevation[:, 0] == pytest.approx(np.linspace(-25.0, 25.0, 16))
    azimuth = np.degrees(np.arctan2(rays[8, :, 1], rays[8, :, 0]))
    assert azimuth[1:] == pytest.approx(np.arange(-179.0, 180.0))
    assert abs(azimuth[0]) == pytest.approx(180.0)


def test_a_full_turn_has_no_duplicate_end() -> None:
    azimuths = spinning((0, 0, 2), count=360).azimuths()
    assert len(np.unique(azimuths % 360.0)) == 360


def test_a_camera_casts_row_by_row_from_the_upper_left_through_pixel_centres() -> None:
    rays = sensor_rays(camera((0, 0, 0), cast=(4, 2), hfov_deg=90.0)).directions.reshape(2, 4, 3)
    tangents = rays[..., 1:] / rays[..., :1]
    assert tangents[0, :, 0] == pytest.approx([0.75, 0.25, -0.25, -0.75])
    assert tangents[:, 0, 1] == pytest.approx([900 / 1600 / 2, -900 / 1600 / 2])


def test_native_rays_look_through_every_pixel() -> None:
    tiny = Camera(
        name="C", position=(0.0, 0.0, 0.0), image=(3, 1), cast=(3, 1), fx=1.0, fy=1.0, cx=1.5, cy=0.5
    )
    directions = sensor_rays(tiny).directions
    assert directions[:, 1] / directions[:, 0] == pytest.approx([1.0, 0.0, -1.0])


def test_positive_pitch_looks_down_and_positive_yaw_to_the_left() -> None:
    assert sensor_rays(lidar(rpy_deg=(0, 30, 0))).directions[0] == pytest.approx([math.sqrt(0.75), 0.0, -0.5])
    assert sensor_rays(lidar(rpy_deg=(0, 0, 30))).directions[0] == pytest.approx([math.sqrt(0.75), 0.5, 0.0])
    left = lidar(rpy_deg=(30, 0, 0), azimuths=[90.0])
    assert sensor_rays(left).directions[0] == pytest.approx([0.0, math.sqrt(0.75), 0.5])


@settings(max_examples=60)
@given(seed=seeds)
def test_clipping_to_the_roi_gives_the_length_inside(seed: int) -> None:
    sensor = random_sensor(GRID, np.random.default_rng(seed), rays=12)
    t0, t1 = clip_to_roi(GRID, sensor_rays(sensor))
    for start, end, ray in zip(t0, t1, grid_rays(GRID, sensor), strict=True):
        inside = np.maximum(slab_lengths(GRID.shape, ray), 0.0).sum() * GRID.voxel_m
        assert max(end - start, 0.0) == pytest.approx(inside, abs=1e-9)


@pytest.mark.parametrize(
    ("position", "length_m"),
    [
        ((0.0, 0.0, 1.0), 3.0),
        ((-3.0, 0.0, 0.0), 6.0),
        ((0.0, -2.5, 1.0), 3.0),
        ((0.0, 2.5, 1.0), 0.0),
        ((0.0, 0.0, 3.5), 0.0),
        ((3.0, 0.0, 1.0), 0.0),
        ((0.0, 9.0, 1.0), 0.0),
    ],
)
def test_a_ray_along_an_axis_is_clipped_like_half_open_voxels(
    position: tuple[float, ...], length_m: float
) -> None:
    t0, t1 = clip_to_roi(GRID, sensor_rays(lidar(position)))
    assert max(float(t1[0] - t0[0]), 0.0) == length_m


@pytest.mark.parametrize("tiny", [1e-310, 5e-324, -1e-300, -0.0])
def test_clipping_bears_denormal_directions(tiny: float) -> None:
    t0, t1 = clip_to_roi(GRID, sensor_rays(lidar((0.1, 0.1, 1.0), (tiny, tiny, tiny), azimuths=[0.0, tiny])))
    assert (t1 - t0) == pytest.approx([2.9, 2.9])


def test_clipping_respects_the_range() -> None:
    t0, t1 = clip_to_roi(GRID, sensor_rays(lidar((0.0, 0.0, 1.0), range_m=(0.5, 2.0))))
    assert (t0[0], t1[0]) == (0.5, 2.0)


def test_the_field_of_view_of_an_image_off_its_centre_is_the_sum_of_both_sides() -> None:
    found = field_of_view_deg(by_intrinsics())
    across = math.atan(801.25 / 700.0) + math.atan(798.75 / 700.0)
    upwards = math.atan(444.0 / 650.5) + math.atan(456.0 / 650.5)
    assert found == pytest.approx(np.degrees([across, upwards]).tolist())
