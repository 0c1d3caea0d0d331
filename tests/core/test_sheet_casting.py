"""LiDARs in any pose are cast by core and sheets; the set is that of their rays, one by one and exactly."""

import math
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from numpy.typing import NDArray

from riglens.core.engine.caster import Caster
from riglens.core.engine.sheets import WORTH, make_sheets
from riglens.core.geometry import Pose
from riglens.core.metric.entropy import EntropyField
from riglens.core.rig.library import Entry, default_library
from riglens.core.rig.model import Lidar
from riglens.core.scene.columns import unpack
from riglens.core.scene.grid import VoxelGrid
from tests.core.builders import lidar, seen_ray_by_ray
from tests.core.oracle import exact_cover
from tests.core.poses import LARGE, any_pose
from tests.core.rooms import ROOMS, SMALL, SMALL_FIELD, field_at, seeds

Mask = NDArray[np.bool_]


@lru_cache(maxsize=1)
def models() -> tuple[Entry, ...]:
    """Every LiDAR of the library."""
    return default_library().entries("lidar")


def any_lidar(rng: np.random.Generator, grid: VoxelGrid) -> Lidar:
    """A LiDAR of the library in or near the grid, often on faces and corners, upright, a little or much turned, at
    times with another range."""
    sensor = models()[rng.integers(len(models()))].sensor("L", any_pose(rng, grid))
    assert isinstance(sensor, Lidar)
    if rng.random() < 0.3:
        near = float(rng.choice([0.0, rng.uniform(0.0, 5.0)]))
        sensor = sensor.replace(range_m=(near, near + float(rng.uniform(0.1, 10.0))))
    return sensor


def seen_by_sheets(sensor: Lidar, field: EntropyField, workers: int = 1, **limits: float) -> Mask | None:
    """Return the voxels that core and sheets mark; None for a sensor without them."""
    caster, marks = Caster(field, workers), np.zeros_like(field.index.words)
    rays = caster.rays(sensor, "exact")
    sheets = make_sheets(sensor, rays, **limits)  # type: ignore[arg-type]
    if sheets is None:
        return None
    caster._mark_sheets(sheets, rays, caster.window(sensor), marks, lambda: False)
    return unpack(field.grid, marks & field.index.words)


def differs(seed: int, rooms: tuple[tuple[float, tuple[float, float, float]], ...]) -> str:
    """What is wrong with a random LiDAR in a random room; nothing where core and sheets equal its rays or are not
    used."""
    rng = np.random.default_rng(seed)
    voxel_m, roi_m = rooms[rng.integers(len(rooms))]
    field = field_at(voxel_m, roi_m, float(rng.choice([1.0, 0.3])))
    sensor, workers = any_lidar(rng, field.grid), int(rng.integers(1, 4))
    seen = seen_by_sheets(sensor, field, workers, worth=float(rng.choice([WORTH, math.inf])), fewest=0)
    if seen is None:
        return ""
    truth = seen_ray_by_ray(field, sensor)
    missing, extra = int((truth & ~seen).sum()), int((seen & ~truth).sum())
    return f"seed {seed}, {sensor.model}: {missing} missing, {extra} extra" if missing or extra else ""


@settings(max_examples=15)
@given(seed=seeds)
def test_close_rays_in_any_pose_cover_what_the_oracle_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cells = rng.integers(-4, np.array(SMALL.shape) + 5) + rng.choice([0.0, 0.5, 0.317], 3)
    rpy_deg = rng.choice([0.0, 180.0, rng.uniform(-30.0, 30.0)], 2)
    beams = np.sort(rng.uniform(-30.0, 30.0, 4))
    azimuths = np.arange(14) * rng.choice([0.3, 0.5]) + rng.choice([0.0, 90.0, rng.uniform(-180.0, 180.0)])
    sensor = lidar(
        np.array(SMALL.origin_m) + cells * SMALL.voxel_m,
        (*rpy_deg, rng.uniform(-180.0, 180.0)),
        beams,
        azimuths,
    )
    seen = seen_by_sheets(sensor, SMALL_FIELD, fewest=0)
    assert seen is not None and np.array_equal(seen, exact_cover(SMALL, [sensor]))


@settings(max_examples=60)
@given(seed=seeds)
def test_sheets_and_ray_walking_agree_for_every_model_in_any_pose(seed: int) -> None:
    assert differs(seed, ROOMS) == ""


@pytest.mark.slow
@pytest.mark.parametrize("block", range(100))
def test_sheets_and_ray_walking_agree_in_twenty_thousand_poses(block: int) -> None:
    """Of these, every tenth in a room as large as a scene."""
    seeds = range(10_000_000 + 200 * block, 10_000_000 + 200 * (block + 1))
    wrong = [differs(seed, LARGE if seed % 10 == 0 else ROOMS) for seed in seeds]
    assert [told for told in wrong if told] == []


@pytest.mark.parametrize(
    "model", ["velodyne-vls-128", "hesai-pandar128e4x", "hesai-at128", "robosense-bpearl"]
)
@pytest.mark.parametrize("rpy_deg", [(2.0, -3.0, 8.0), (0.0, 0.0, 0.0)])
def test_a_model_of_the_library_is_cast_by_sheets(model: str, rpy_deg: tuple[float, float, float]) -> None:
    field = field_at(0.37, (59.2, 37.0, 3.7), 1.0)
    entry = next(entry for entry in models() if entry.name == model)
    sensor = entry.sensor("L", Pose(position_m=(1.0, 0.2, 2.0), rpy_deg=rpy_deg))
    assert isinstance(sensor, Lidar)
    seen = seen_by_sheets(sensor, field)
    assert seen is not None and seen.sum() > 1_000
    assert np.array_equal(seen, seen_ray_by_ray(field, sensor))


def test_the_set_does_not_depend_on_the_number_of_threads() -> None:
    field = field_at(0.10, (8.0, 6.0, 2.0), 1.0)
    sensor = models()[4].sensor("L", Pose(position_m=(0.3, 0.2, 1.1), rpy_deg=(3.0, -4.0, 0.0)))
    sets = []
    for workers in (1, 2, 3):
        caster, marks = Caster(field, workers), np.zeros_like(field.index.words)
        caster.mark(sensor, "exact", caster.window(sensor), marks)
        sets.append(marks)
    assert all(np.array_equal(marks, sets[0]) for marks in sets)


def test_an_abandoned_cast_says_so() -> None:
    field = field_at(0.10, (8.0, 6.0, 2.0), 1.0)
    sensor = models()[4].sensor("L", Pose(position_m=(0.3, 0.2, 1.1), rpy_deg=(3.0, -4.0, 0.0)))
    caster, marks = Caster(field), np.zeros_like(field.index.words)
    assert not caster.mark(sensor, "exact", caster.window(sensor), marks, lambda: True)
    assert math.isinf(lidar().range_m[1])
