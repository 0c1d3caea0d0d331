"""The rays of a sensor: the very doubles that the metric casts and the window draws."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.geometry import Vec3
from core.kernels import lattice as kernel
from core.rig.model import Camera, Lidar
from core.scene.grid import VoxelGrid

Ids = NDArray[np.int64]


@dataclass(frozen=True)
class Rays:
    """Rays in the vehicle frame: `origin_m` (3,), unit `directions` (n, 3), `range_m` (from, to) in metres."""

    origin_m: Vec3
    directions: NDArray[np.float64]
    range_m: tuple[float, float]


@dataclass(frozen=True)
class Lattice:
    """Tables from which the directions of a sensor's rays follow, ray = row * planes + plane.

    rows (r, 2): a LiDAR's beams, a camera's image rows; planes (p, 2): azimuths or image columns
    (see `core.kernels.lattice`).
    """

    kind: int
    rows: NDArray[np.float64]
    planes: NDArray[np.float64]

    def directions(self, rays: Ids | None = None) -> NDArray[np.float64]:
        """Directions in the sensor frame of all rays, or of some by number, (n, 3)."""
        every = np.arange(len(self.rows) * len(self.planes)) if rays is None else rays
        return kernel.directions(self.kind, self.rows, self.planes, every)


def lidar_lattice(lidar: Lidar) -> Lattice:
    """Directions (cos e cos a, cos e sin a, sin e), beam by beam (paper, eq. 2, as its text means it)."""
    elevation, azimuth = np.radians(lidar.elevations()), np.radians(lidar.azimuths())
    rows = np.stack([np.cos(elevation), np.sin(elevation)], axis=1)
    return Lattice(kernel.LIDAR, rows, np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1))


def camera_lattice(camera: Camera) -> Lattice:
    """Rays through pixel centres of the resized image, row by row (paper, eq. 3-5).

    w = (u + 1/2) w0 / u0, h = (v + 1/2) h0 / v0; (1, -(w - cx) / fx, -(h - cy) / fy), normalised.
    """
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    w = (np.arange(camera.cast[0]) + 0.5) * camera.image[0] / camera.cast[0]
    h = (np.arange(camera.cast[1]) + 0.5) * camera.image[1] / camera.cast[1]
    y, z = -(w - cx_px) / fx_px, -(h - cy_px) / fy_px
    rows = np.stack([z, np.zeros_like(z)], axis=1)
    return Lattice(kernel.CAMERA, rows, np.stack([y, np.zeros_like(y)], axis=1))


def lattice(sensor: Lidar | Camera) -> Lattice:
    """The ray lattice of a sensor in its own frame."""
    return lidar_lattice(sensor) if isinstance(sensor, Lidar) else camera_lattice(sensor)


def rotate(rotation: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """R d for directions (n, 3), summed from left to right, as the kernels do (no BLAS, no fused operations)."""
    x, y, z = directions[:, 0], directions[:, 1], directions[:, 2]
    return np.stack([(row[0] * x + row[1] * y) + row[2] * z for row in rotation], axis=-1)


def sensor_rays(sensor: Lidar | Camera, rows: Ids | None = None) -> Rays:
    """Rays of a sensor in the vehicle frame; `rows` (k,) picks some of them by index."""
    return Rays(
        sensor.position, rotate(sensor.pose.rotation(), lattice(sensor).directions(rows)), sensor.range_m
    )


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
