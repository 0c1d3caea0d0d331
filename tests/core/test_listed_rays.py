"""Azimuth offsets and lens distortion fit no table of rows and columns: their rays are walked one by one."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.engine.caster import Caster
from riglens.core.engine.fans import by_offset, is_plain
from riglens.core.engine.frustums import make_frustum
from riglens.core.geometry import Pose
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.library import default_library
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Lidar, LinearAngles
from riglens.core.scene.columns import unpack
from riglens.core.sensing.rays import lattice, lattices_by_offset, sensor_rays
from riglens.core.study.reference import exact_cover
from tests.core.builders import evaluate, field_of, grid_of, rig_of, seen_by, spinning

GRID = grid_of(24, 20, 11, 0.25)
FIELD = field_of(GRID)
LENSES = (
    BrownConrady(k1=-0.3, k2=0.08, p1=1e-3),
    BrownConrady(k1=0.4, k2=0.2),
    KannalaBrandt(k1=0.05, k2=-0.01),
)
seeds = st.integers(0, 2**32 - 1)


def staggered(rng: np.random.Generator, rpy_deg: tuple[float, float, float]) -> Lidar:
    """A LiDAR with uneven beams, each turned by an offset of its own."""
    position = rng.uniform(-0.4, 0.4, 3) * GRID.roi_m + [0.0, 0.0, GRID.roi_m[2] / 2]
    return Lidar(
        name="L",
        position=tuple(map(float, position)),
        rpy_deg=rpy_deg,
        elevations_deg=tuple(map(float, np.sort(rng.uniform(-30, 20, 5)))),
        azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=40),
        azimuth_offsets_deg=tuple(map(float, rng.uniform(-8.0, 8.0, 5))),
    )


def bent(rng: np.random.Generator, rpy_deg: tuple[float, float, float]) -> Camera:
    """A camera with lens distortion, looking about as wide as a lens of a car does."""
    position = rng.uniform(-0.4, 0.4, 3) * GRID.roi_m + [0.0, 0.0, GRID.roi_m[2] / 2]
    focal = float(rng.uniform(300.0, 900.0))
    lens = {"fx": focal, "fy": focal, "cx": 799.5, "cy": 452.25}
    return Camera(
        name="C",
        position=tuple(map(float, position)),
        rpy_deg=rpy_deg,
        image=(1600, 900),
        cast=(24, 14),
        distortion=LENSES[rng.integers(3)],
        **lens,
    )


@settings(max_examples=25, deadline=None)
@given(seed=seeds, make=st.sampled_from([staggered, bent]), is_upright=st.booleans())
def test_the_engine_covers_the_voxels_of_every_ray(seed: int, make, is_upright: bool) -> None:
    rng = np.random.default_rng(seed)
    roll, pitch, yaw = (float(angle) for angle in rng.uniform(-180.0, 180.0, 3))
    sensor = make(rng, (0.0, 0.0, yaw) if is_upright else (roll, pitch / 2, yaw))
    assert np.array_equal(seen_by(FIELD, sensor), exact_cover(GRID, [sensor]))


@pytest.mark.parametrize("make", [staggered, bent])
def test_no_short_cut_is_taken(make) -> None:
    sensor = make(np.random.default_rng(3), (0.0, 0.0, 30.0))
    rays = Caster(FIELD).rays(sensor, "exact")
    assert not is_plain(rays)
    if isinstance(sensor, Camera):
        assert make_frustum(sensor, rays) is None


@pytest.mark.parametrize("make", [staggered, bent])
def test_edits_and_the_reading_of_hits_are_those_of_an_evaluation_from_scratch(make) -> None:
    rng = np.random.default_rng(5)
    first, second = make(rng, (0.0, 0.0, 10.0)), make(rng, (1.0, 2.0, 100.0))
    for reading in ("covered", "hits"):
        settings_ = MetricSettings(reading=reading)
        both = evaluate(FIELD, rig_of(first, second), settings_).scores
        assert both == evaluate(FIELD, rig_of(first, second), settings_, threads=1).scores
        assert both != evaluate(FIELD, rig_of(first), settings_).scores


def test_offsets_turn_their_beam_to_the_left() -> None:
    lidar = Lidar(
        name="L",
        position=(0.0, 0.0, 1.0),
        elevations_deg=(-10.0, 5.0),
        azimuths_deg=(0.0, 90.0),
        azimuth_offsets_deg=(3.0, -2.0),
    )
    rays = sensor_rays(lidar).directions
    found = np.degrees(np.arctan2(rays[:, 1], rays[:, 0]))
    assert found == pytest.approx([3.0, 93.0, -2.0, 88.0])
    assert np.degrees(np.arcsin(rays[:, 2])) == pytest.approx([-10.0, -10.0, 5.0, 5.0])


def test_offsets_of_zero_give_the_same_rays_bit_for_bit() -> None:
    plain = spinning((0.3, 0.2, 1.1), (0.0, 0.0, 33.0), beams=7, count=90)
    offset = plain.replace(azimuth_offsets_deg=(0.0,) * 7)
    assert np.array_equal(sensor_rays(offset).directions, sensor_rays(plain).directions)
    assert np.array_equal(seen_by(FIELD, offset), seen_by(FIELD, plain))


def test_a_fisheye_that_sees_behind_itself_covers_voxels_behind_it() -> None:
    fisheye = Camera(
        name="C",
        position=(0.0, 0.0, 1.0),
        image=(1600, 900),
        cast=(160, 90),
        fx=350.0,
        fy=350.0,
        cx=800.0,
        cy=450.0,
        distortion=KannalaBrandt(),
    )
    seen = seen_by(FIELD, fisheye)
    assert seen[:12].sum() > 50 and seen[12:].sum() > 500
    angles = np.degrees(np.arccos(sensor_rays(fisheye).directions[:, 0]))
    assert angles.max() == pytest.approx(np.degrees(math.hypot(795, 445) / 350), abs=1.0)


@pytest.mark.parametrize("workers", [1, 3])
@pytest.mark.parametrize("in_row", [0, 1, 7, 20, 40, 200, 1000])
def test_the_order_in_which_rays_are_walked_does_not_matter(in_row: int, workers: int) -> None:
    """Rows that are known, those that are none, and numbers that do not divide the rays."""
    rng = np.random.default_rng(3)
    sensor = staggered(rng, (3.0, -4.0, 5.0))
    caster, marks = Caster(FIELD, workers), np.zeros_like(FIELD.index.words)
    rays = caster.rays(sensor, "exact")
    assert rays.in_row == 40 and len(rays.rows) == 200
    caster._mark_rays(rays._replace(in_row=in_row), marks, lambda: False)
    assert np.array_equal(unpack(GRID, marks & FIELD.index.words), exact_cover(GRID, [sensor]))


def paired(rng: np.random.Generator) -> Lidar:
    """An upright LiDAR of 27 uneven beams that share three azimuth offsets."""
    beams = tuple(map(float, np.sort(rng.uniform(-20.0, 20.0, 27))))
    offsets = tuple(map(float, rng.permutation([-1.4] * 10 + [0.0] * 8 + [3.125] * 9)))
    lidar = staggered(rng, (0.0, 0.0, float(rng.choice([0.0, 90.0, rng.uniform(-180.0, 180.0)]))))
    azimuths = LinearAngles(from_=-180.0, to=180.0, count=20)
    lidar = lidar.replace(elevations_deg=beams, azimuth_offsets_deg=offsets, azimuths_deg=azimuths)
    return lidar.replace(position=(*lidar.position[:2], 1.3))


class Counting(Caster):
    """A caster that counts the fans it marks."""

    fans = 0

    def _mark_fan(self, *arguments: Any) -> bool:
        self.fans += 1
        return super()._mark_fan(*arguments)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("some_are_stopped", [False, True])
def test_beams_that_share_an_offset_are_a_fan_when_upright(seed: int, some_are_stopped: bool) -> None:
    rng = np.random.default_rng(seed)
    sensor = paired(rng)
    caster = Counting(FIELD, 2)
    rays = caster.rays(sensor, "exact")
    if some_are_stopped:
        rays = rays._replace(is_stopped=rng.random(27 * 20) < 0.3)
    marks, expected = np.zeros_like(FIELD.index.words), np.zeros_like(FIELD.index.words)
    assert caster._mark_free(sensor, rays, "exact", caster.window(sensor), marks, lambda: False)
    caster._mark_rays(rays, expected, lambda: False)
    assert caster.fans == 3
    assert np.array_equal(marks & FIELD.index.words, expected & FIELD.index.words)
    if not some_are_stopped:
        assert np.array_equal(unpack(GRID, marks & FIELD.index.words), exact_cover(GRID, [sensor]))


def test_beams_with_too_many_offsets_or_tilted_are_no_fans() -> None:
    rng = np.random.default_rng(2)
    many = paired(rng).replace(azimuth_offsets_deg=tuple(0.1 * (i // 3) for i in range(27)))
    for sensor in (many, paired(rng).replace(rpy_deg=(1.0, 0.0, 0.0))):
        caster, marks = Counting(FIELD), np.zeros_like(FIELD.index.words)
        assert caster.mark(sensor, "exact", caster.window(sensor), marks)
        assert caster.fans == 0


@pytest.mark.parametrize(
    ("model", "fans"), [("velodyne-vlp-32c", 4), ("hesai-at128", 4), ("ouster-os1-128", 0)]
)
def test_planes_of_steep_beams_and_many_offsets_are_not_worth_it(model: str, fans: int) -> None:
    """OS1-128 has as many beams to an offset as VLP-32C; but most of them leave the region soon."""
    field = field_of(grid_of(160, 100, 10, 0.4))
    sensor = default_library().entry(model).sensor("L", Pose((1.0, 2.0, 2.0), (0.0, 0.0, 7.0)))
    assert isinstance(sensor, Lidar)
    assert len(by_offset(sensor, Caster(field).rays(sensor, "exact"))) == fans


def test_an_abandoned_cast_of_several_fans_says_so() -> None:
    sensor = paired(np.random.default_rng(2))
    caster, marks = Caster(FIELD), np.zeros_like(FIELD.index.words)
    assert not caster.mark(sensor, "exact", caster.window(sensor), marks, lambda: True)


@pytest.mark.parametrize("model", ["velodyne-vlp-32c", "hesai-pandar64", "velodyne-vls-128"])
def test_rays_by_offset_are_the_listed_ones_to_the_last_bit(model: str) -> None:
    sensor = default_library().entry(model).sensor("L", Pose((1.0, 2.0, 3.0), (0.0, 0.0, 7.0)))
    assert isinstance(sensor, Lidar) and sensor.azimuth_offsets_deg is not None
    listed = lattice(sensor).rows.reshape(sensor.beam_count, -1, 3)
    parts = lattices_by_offset(sensor)
    assert len(parts) == len(set(sensor.azimuth_offsets_deg))
    assert sorted(int(beam) for beams, _ in parts for beam in beams) == list(range(sensor.beam_count))
    for beams, part in parts:
        assert np.array_equal(part.directions().reshape(len(beams), -1, 3), listed[beams])
