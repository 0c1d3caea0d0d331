"""The rays of a sensor: the very doubles that the metric casts and the window draws."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Vec3
from riglens.core.kernels.runtime import codes
from riglens.core.rig.model import Lidar, Sensor
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.kept import RAYS
from riglens.core.sensors.base import unplaced
from riglens.core.sensors.kind import REFERENCE, Echo
from riglens.core.sensors.lattice import Ids, Lattice
from riglens.core.sensors.lidar import beam_lattice
from riglens.core.sensors.registry import kind_of

_AT_ONCE = 1 << 16


@dataclass(frozen=True)
class Rays:
    """Rays in the vehicle frame: `origin_m` (3,), unit `directions` (n, 3), `range_m` (from, to) in metres, and
    `limits_m` (n,) where rays end sooner, (0,) where none does."""

    origin_m: Vec3
    directions: NDArray[np.float64]
    range_m: tuple[float, float]
    limits_m: NDArray[np.float64]

    @property
    def far_m(self) -> NDArray[np.float64]:
        """Return the end of each ray, metres (n,), or of all of them ()."""
        return np.minimum(self.range_m[1], self.limits_m) if self.limits_m.size else np.array(self.range_m[1])


def lattice(sensor: Sensor) -> Lattice:
    """Return the ray lattice of a sensor in its own frame."""
    tables = None if sensor.blocked else kind_of(sensor).lattice(sensor)
    if tables is None:
        return _listed(unplaced(sensor))
    limits = limits_m(sensor)
    return replace(tables, limits_m=limits) if limits.size else tables


def is_listed(sensor: Sensor) -> bool:
    """Return whether rays have to be listed one by one, as those of a lens with distortion, beams with azimuth offsets
    or a sensor of which sectors are blocked."""
    return bool(sensor.blocked) or kind_of(sensor).lattice(sensor) is None


def lattices_by_offset(lidar: Lidar) -> tuple[tuple[Ids, Lattice], ...]:
    """Return the beams that share an azimuth offset, by number (k,), and the lattice of their rays, for each offset;
    nothing if the LiDAR has none, or the doubles would differ from those of its listed rays in any bit."""
    if lidar.azimuth_offsets_deg is None or lidar.blocked:
        return ()
    return _by_offset(unplaced(lidar))


@RAYS.of
def _by_offset(lidar: Lidar) -> tuple[tuple[Ids, Lattice], ...]:
    """Return the beams and lattices of `lattices_by_offset`, for a LiDAR without its position."""
    listed = _listed(lidar).rows.reshape(lidar.beam_count, -1, 3)
    offsets_deg = np.array(lidar.azimuth_offsets_deg)
    rows = beam_lattice(lidar).rows
    parts = []
    for offset_deg in np.unique(offsets_deg):
        beams = np.flatnonzero(offsets_deg == offset_deg)
        azimuth = np.radians(lidar.azimuths() + offset_deg)
        part = Lattice(codes.LIDAR, rows[beams], np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1))
        if not np.array_equal(part.directions(), listed[beams].reshape(-1, 3)):
            return ()
        parts.append((beams, part))
    return tuple(parts)


@RAYS.of
def _listed(sensor: Sensor) -> Lattice:
    """Return the lattice of a listed sensor without its position, the same one throughout a drag."""
    parts = []
    for start in range(0, sensor.ray_count, _AT_ONCE):
        parts.append(local_directions(sensor, np.arange(start, min(start + _AT_ONCE, sensor.ray_count))))
    every = np.concatenate(parts)
    exists = ~np.isnan(every[:, 0])
    limits = limits_m(sensor)
    return Lattice(
        codes.LISTED, every[exists], np.zeros((1, 2)), exists, limits[exists] if limits.size else limits
    )


def local_directions(sensor: Sensor, rays: Ids) -> NDArray[np.float64]:
    """Return directions in the sensor frame of rays by number (row * planes + plane), (n, 3); NaN for missing ones."""
    found: NDArray[np.float64] = kind_of(sensor).directions(sensor, rays)
    if sensor.blocked:
        found[sensor.blocked_rays(found)] = np.nan
    return found


def missing_ray_count(sensor: Sensor) -> int:
    """Return the number of lattice rays that are not cast because they have no direction, as outside a lens's image;
    rays of blocked sectors do not count."""
    sensor = sensor.model_copy(update={"blocked": ()})
    return sensor.ray_count - len(lattice(sensor).rows) if is_listed(sensor) else 0


def limits_m(sensor: Sensor, echo: Echo = REFERENCE) -> NDArray[np.float64]:
    """Return the range of each ray to an object, metres (rays,), where its kind limits rows; (0,) where not."""
    rows = kind_of(sensor).limits_m(sensor, echo)
    return np.zeros(0) if rows is None else np.repeat(rows, sensor.resolution[0])


def farthest_m(sensor: Sensor) -> float:
    """Return the range of the longest ray of a sensor, metres."""
    rows = kind_of(sensor).limits_m(sensor, REFERENCE)
    return sensor.range_m[1] if rows is None else min(sensor.range_m[1], float(rows.max()))


def rotate(rotation: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return R d for directions (n, 3), summed from left to right, as the kernels do (no BLAS, no fused operations)."""
    x, y, z = directions[:, 0], directions[:, 1], directions[:, 2]
    return np.stack([(row[0] * x + row[1] * y) + row[2] * z for row in rotation], axis=-1)


def sensor_rays(sensor: Sensor, rows: Ids | None = None) -> Rays:
    """Return rays of a sensor in the vehicle frame: all that it casts, or some by number.

    `rows` (k,) counts over the whole lattice, row * planes + plane; a ray for which the lens model has no
    direction is then NaN.
    """
    if rows is None:
        table = lattice(sensor)
        local, limits = table.directions(), table.limits_m
    else:
        local, limits = local_directions(sensor, rows), limits_m(sensor)
        limits = limits[rows] if limits.size else limits
    return Rays(sensor.position, rotate(sensor.pose.rotation(), local), sensor.range_m, limits)


def clip_to_roi(grid: VoxelGrid, rays: Rays) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where each ray enters and leaves the ROI and its range, metres along the ray, (n,) each; t1 <= t0: it
    misses.

    For drawing and culling; the metric clips exactly.
    """
    low = np.array(grid.origin_m)
    high = low + np.array(grid.shape) * grid.voxel_m
    origin = np.array(rays.origin_m)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        first = (low - origin) / rays.directions
        second = (high - origin) / rays.directions
    flat = rays.directions == 0.0
    inside = (low <= origin) & (origin < high)
    first = np.where(flat, np.where(inside, -math.inf, math.inf), first)
    second = np.where(flat, np.where(inside, math.inf, -math.inf), second)
    t0 = np.maximum(np.minimum(first, second).max(axis=1), rays.range_m[0])
    t1 = np.minimum(np.maximum(first, second).min(axis=1), rays.far_m)
    return t0, np.where(flat.any(axis=1) & ~(inside | ~flat).all(axis=1), t0, t1)
