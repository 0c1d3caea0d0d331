"""The rays of a sensor: the very doubles that the metric casts and the window draws."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Vec3
from riglens.core.kernels.runtime import codes
from riglens.core.rig.model import Camera, Lidar, Sensor, rays_of
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.camera import cast_px, pixel_directions

Ids = NDArray[np.int64]
_AT_ONCE = 1 << 16


@dataclass(frozen=True)
class Rays:
    """Rays in the vehicle frame: `origin_m` (3,), unit `directions` (n, 3), `range_m` (from, to) in metres."""

    origin_m: Vec3
    directions: NDArray[np.float64]
    range_m: tuple[float, float]


@dataclass(frozen=True)
class Lattice:
    """Tables from which the directions of a sensor's rays follow, ray = row * planes + plane.

    rows (r, 2): a LiDAR's beams, a camera's image rows; planes (p, 2): azimuths or image columns. Lens distortion
    and azimuth offsets do not fit such tables: rows (n, 3) are then the directions themselves, of the rays that
    exist (see `kernels.rays.lattice`): those at which `exists` (rays of the whole lattice,) is set.
    """

    kind: int
    rows: NDArray[np.float64]
    planes: NDArray[np.float64]
    exists: NDArray[np.bool_] | None = None

    def directions(self, rays: Ids | None = None) -> NDArray[np.float64]:
        """Directions in the sensor frame of all rays, or of some by number, (n, 3)."""
        every = np.arange(len(self.rows) * len(self.planes)) if rays is None else rays
        return lattice_directions(self.kind, self.rows, self.planes, every)


def lattice_directions(
    kind: int, rows: NDArray[np.float64], planes: NDArray[np.float64], rays: Ids
) -> NDArray[np.float64]:
    """Directions (n, 3) in the sensor frame of the rays `rays` (n,), ray = row * planes + plane.

    The same doubles as the compiled `kernels.rays.lattice.direction` gives, which says what the tables mean;
    in plain numpy, because the window draws some rays before the compiler is loaded.
    """
    row, plane = rows[rays // len(planes)], planes[rays % len(planes)]
    if kind == codes.LISTED:
        return np.asarray(row)
    with np.errstate(over="ignore", invalid="ignore"):  # as in compiled code, which never warns
        if kind == codes.LIDAR:
            return np.stack([row[:, 0] * plane[:, 0], row[:, 0] * plane[:, 1], row[:, 1]], axis=1)
        y, z = plane[:, 0], row[:, 0]
        norm = np.sqrt(1.0 + y * y + z * z)
        return np.stack([1.0 / norm, y / norm, z / norm], axis=1)


def lidar_lattice(lidar: Lidar) -> Lattice:
    """Directions (cos e cos a, cos e sin a, sin e), beam by beam (paper, eq. 2, as its text means it)."""
    elevation, azimuth = np.radians(lidar.elevations()), np.radians(lidar.azimuths())
    rows = np.stack([np.cos(elevation), np.sin(elevation)], axis=1)
    return Lattice(codes.LIDAR, rows, np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1))


def camera_lattice(camera: Camera) -> Lattice:
    """Rays through pixel centres of the resized image, row by row (paper, eq. 3-5).

    w = (u + 1/2) w0 / u0, h = (v + 1/2) h0 / v0; (1, -(w - cx) / fx, -(h - cy) / fy), normalised.
    """
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    w = (np.arange(camera.cast[0]) + 0.5) * camera.image[0] / camera.cast[0]
    h = (np.arange(camera.cast[1]) + 0.5) * camera.image[1] / camera.cast[1]
    y, z = -(w - cx_px) / fx_px, -(h - cy_px) / fy_px
    rows = np.stack([z, np.zeros_like(z)], axis=1)
    return Lattice(codes.CAMERA, rows, np.stack([y, np.zeros_like(y)], axis=1))


def lattice(sensor: Sensor) -> Lattice:
    """The ray lattice of a sensor in its own frame."""
    if is_listed(sensor):
        return _listed(rays_of(sensor).model_copy(update=NOWHERE))
    return lidar_lattice(sensor) if isinstance(sensor, Lidar) else camera_lattice(sensor)


def is_listed(sensor: Sensor) -> bool:
    """Whether rays have to be listed one by one: a lens with distortion, beams with azimuth offsets."""
    if isinstance(sensor, Camera):
        return sensor.distortion is not None
    return sensor.azimuth_offsets_deg is not None


def lattices_by_offset(lidar: Lidar) -> tuple[tuple[Ids, Lattice], ...]:
    """The beams that share an azimuth offset, by number (k,), and the lattice of their rays, for each offset; nothing
    where the LiDAR has none, or the doubles were not those of its listed rays to the last bit."""
    if lidar.azimuth_offsets_deg is None:
        return ()
    return _by_offset(rays_of(lidar).model_copy(update=NOWHERE))


@lru_cache(maxsize=4)
def _by_offset(lidar: Lidar) -> tuple[tuple[Ids, Lattice], ...]:
    """As `lattices_by_offset`, of a LiDAR without its place."""
    listed = _listed(lidar).rows.reshape(lidar.beam_count, -1, 3)
    offsets_deg = np.array(lidar.azimuth_offsets_deg)
    rows = lidar_lattice(lidar).rows
    parts = []
    for offset_deg in np.unique(offsets_deg):
        beams = np.flatnonzero(offsets_deg == offset_deg)
        azimuth = np.radians(lidar.azimuths() + offset_deg)
        part = Lattice(codes.LIDAR, rows[beams], np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1))
        if not np.array_equal(part.directions(), listed[beams].reshape(-1, 3)):
            return ()
        parts.append((beams, part))
    return tuple(parts)


NOWHERE = {"position": (0.0, 0.0, 0.0), "rpy_deg": (0.0, 0.0, 0.0), "range_m": (0.0, math.inf)}
"""What decides where the rays are, but none of their directions in the sensor frame."""


@lru_cache(maxsize=4)
def _listed(sensor: Sensor) -> Lattice:
    """The lattice of a listed sensor without its place: the same one through a whole drag."""
    parts = []
    for start in range(0, sensor.ray_count, _AT_ONCE):
        parts.append(local_directions(sensor, np.arange(start, min(start + _AT_ONCE, sensor.ray_count))))
    every = np.concatenate(parts)
    exists = ~np.isnan(every[:, 0])
    return Lattice(codes.LISTED, every[exists], np.zeros((1, 2)), exists)


def local_directions(sensor: Sensor, rays: Ids) -> NDArray[np.float64]:
    """Directions in the sensor frame of rays by number (row * planes + plane), (n, 3); NaN: the lens has none."""
    if not is_listed(sensor):
        return lattice(sensor).directions(rays)
    if isinstance(sensor, Camera):
        return pixel_directions(sensor, cast_px(sensor, rays))
    azimuths = sensor.azimuths()
    beam, turn = rays // azimuths.size, rays % azimuths.size
    elevation = np.radians(sensor.elevations()[beam])
    azimuth = np.radians(azimuths[turn] + np.array(sensor.azimuth_offsets_deg)[beam])
    flat = np.cos(elevation)
    return np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=-1)


def missing_ray_count(sensor: Sensor) -> int:
    """Rays of a camera's lattice that are not cast, because its lens model gives their pixels no direction."""
    return (
        sensor.ray_count - len(lattice(sensor).rows)
        if isinstance(sensor, Camera) and is_listed(sensor)
        else 0
    )


def rotate(rotation: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """R d for directions (n, 3), summed from left to right, as the kernels do (no BLAS, no fused operations)."""
    x, y, z = directions[:, 0], directions[:, 1], directions[:, 2]
    return np.stack([(row[0] * x + row[1] * y) + row[2] * z for row in rotation], axis=-1)


def sensor_rays(sensor: Sensor, rows: Ids | None = None) -> Rays:
    """Rays of a sensor in the vehicle frame: all that it casts, or some by number.

    `rows` (k,) counts over the whole lattice, row * planes + plane; a ray for which the lens model has no
    direction is then NaN.
    """
    local = lattice(sensor).directions() if rows is None else local_directions(sensor, rows)
    return Rays(sensor.position, rotate(sensor.pose.rotation(), local), sensor.range_m)


def clip_to_roi(grid: VoxelGrid, rays: Rays) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where each ray enters and leaves the ROI and its range, metres along the ray, (n,) each; t1 <= t0: it misses.

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
    t1 = np.minimum(np.maximum(first, second).min(axis=1), rays.range_m[1])
    return t0, np.where(flat.any(axis=1) & ~(inside | ~flat).all(axis=1), t0, t1)
