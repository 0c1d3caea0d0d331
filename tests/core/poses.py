"""Every model of the library in random poses: what the engine casts is what its rays traverse, one by one.

`python -m tests.core.campaigns poses` goes through as many as one likes. A pose follows from its number alone.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from riglens.core.engine.caster import Caster
from riglens.core.geometry import Pose, Vec3
from riglens.core.rig.library import Entry, default_library
from riglens.core.rig.model import Camera, Lidar, Sensor
from riglens.core.scene.columns import unpack
from riglens.core.scene.grid import VoxelGrid
from tests.core.builders import seen_ray_by_ray, triple
from tests.core.every_ray import every_ray
from tests.core.rooms import ROOMS, field_at

LARGE = ((0.10, (30.0, 20.0, 4.0)), (0.05, (12.0, 10.0, 4.0)), (0.37, (59.2, 37.0, 3.7)))
"""Voxel edge and region in metres, as large as half a scene."""
MOST_RAYS = 120_000
"""Of most poses: a part of the beams and azimuths that lie side by side is as close as all of them."""


@lru_cache(maxsize=1)
def models() -> tuple[Entry, ...]:
    """Every model of the library, LiDARs and cameras."""
    library = default_library()
    return (*library.entries("lidar"), *library.entries("camera"))


def any_pose(rng: np.random.Generator, grid: VoxelGrid) -> Pose:
    """A place in or near a grid, often on faces, edges and corners; upright, grazing, tilted or anyhow."""
    cells = rng.integers(-4, np.array(grid.shape) + 5) + rng.choice([0.0, 0.5, 0.317, rng.random()], 3)
    tilt = rng.choice([0.0, 0.0, 1e-4, 2.0, 10.0, 40.0, rng.uniform(0.0, 180.0)])
    roll, pitch = tilt * rng.choice([0.0, 1.0, -1.0, rng.uniform(-1.0, 1.0)], 2)
    yaw = rng.choice([0.0, 90.0, 30.0, rng.uniform(-180.0, 180.0)])
    return Pose(triple(np.array(grid.origin_m) + cells * grid.voxel_m), triple((roll, pitch, yaw)))


def _slice(rng: np.random.Generator, count: int, most: int) -> slice:
    first = int(rng.integers(max(count - most, 0) + 1))
    return slice(first, first + most)


def part_of(rng: np.random.Generator, lidar: Lidar, most_rays: int) -> Lidar:
    """Neighbouring beams and azimuths of a LiDAR with its offsets: as close as before, and few enough."""
    beams = _slice(rng, lidar.beam_count, int(rng.choice([16, 64, 1000])))
    elevations, azimuths = lidar.elevations()[beams], lidar.azimuths()
    azimuths = azimuths[_slice(rng, len(azimuths), max(most_rays // len(elevations), 2))]
    offsets = lidar.azimuth_offsets_deg
    return lidar.replace(
        elevations_deg=tuple(elevations.tolist()),
        azimuths_deg=tuple(azimuths.tolist()),
        azimuth_offsets_deg=None if offsets is None else offsets[beams],
    )


def any_model(rng: np.random.Generator, grid: VoxelGrid, most_rays: int = MOST_RAYS) -> Sensor:
    """A model of the library anywhere; a camera's image as it is cast or larger; at times with another range."""
    sensor = models()[rng.integers(len(models()))].sensor("S", any_pose(rng, grid))
    if isinstance(sensor, Lidar) and sensor.rays is None and sensor.ray_count > most_rays:
        sensor = part_of(rng, sensor, most_rays)
    if isinstance(sensor, Camera):
        width_px = int(rng.choice([40, 352, 352, 800]))
        width_px = min(width_px, sensor.image[0], math.isqrt(2 * most_rays))
        sensor = sensor.replace(cast=(width_px, max(min(width_px // 2, sensor.image[1]), 1)))
    if rng.random() < 0.3:
        near = float(rng.choice([0.0, grid.voxel_m, rng.uniform(0.0, 5.0)]))
        sensor = sensor.replace(range_m=(near, near + float(rng.uniform(0.1, 10.0))))
    return sensor


class Watched(Caster):
    """A caster that tells which way the rays went; to be asked once."""

    way = "rays"

    def _mark_fan(self, *args: object) -> bool:
        self.way = "fan"
        return super()._mark_fan(*args)  # type: ignore[arg-type]

    def _mark_sheets(self, *args: object) -> bool:
        self.way = "sheets"
        return super()._mark_sheets(*args)  # type: ignore[arg-type]

    def _mark_frustum(self, *args: object) -> bool:
        self.way = "frustum"
        return super()._mark_frustum(*args)  # type: ignore[arg-type]

    def _mark_mesh(self, *args: object) -> bool:
        self.way = "mesh"
        return super()._mark_mesh(*args)  # type: ignore[arg-type]


def try_pose(seed: int) -> tuple[str, str]:
    """Cast one model three ways: by the engine, by the exact walk, and by following each ray.

    Return the engine's way (fan, sheets, frustum, mesh or rays), and what is wrong: nothing where all three agree.
    """
    rng = np.random.default_rng(seed)
    rooms: tuple[tuple[float, Vec3], ...] = LARGE if rng.random() < 0.1 else ROOMS
    voxel_m, roi_m = rooms[rng.integers(len(rooms))]
    field = field_at(voxel_m, roi_m, float(rng.choice([1.0, 0.3])))
    sensor = any_model(rng, field.grid, 10 * MOST_RAYS if rng.random() < 0.05 else MOST_RAYS)
    caster, marks = Watched(field), np.zeros_like(field.index.words)
    caster.mark(sensor, "exact", caster.window(sensor), marks)
    truth, _ = every_ray(field.grid, sensor)
    truth &= unpack(field.grid, field.index.words)
    found = {
        "the engine": unpack(field.grid, marks & field.index.words),
        "the walk": seen_ray_by_ray(field, sensor),
    }
    wrong = [
        f"{who} misses {(truth & ~seen).sum()} voxels and adds {(seen & ~truth).sum()}"
        for who, seen in found.items()
        if not np.array_equal(seen, truth)
    ]
    return caster.way, "; ".join([f"pose {seed}, {sensor.model}", *wrong]) if wrong else ""
