"""The rays of a sensor: the very doubles that the metric casts and the window draws."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.geometry import Vec3
from core.rig.model import Camera, Lidar
from core.scene.grid import VoxelGrid


@dataclass(frozen=True)
class Rays:
    """Rays in the vehicle frame: `origin_m` (3,), unit `directions` (n, 3), `range_m` (from, to) in metres."""

    origin_m: Vec3
    directions: NDArray[np.float64]
    range_m: tuple[float, float]


def lidar_lattice(lidar: Lidar) -> NDArray[np.float64]:
    """Directions (cos e cos a, cos e sin a, sin e) in the sensor frame, (beams * azimuths, 3), beam by beam."""
    elevation = np.radians(lidar.elevations())[:, None]
    azimuth = np.radians(lidar.azimuths())[None, :]
    x = np.cos(elevation) * np.cos(azimuth)
    y = np.cos(elevation) * np.sin(azimuth)
    z = np.broadcast_to(np.sin(elevation), x.shape)
    return np.stack([x, y, z], axis=-1).reshape(-1, 3)


def camera_lattice(camera: Camera) -> NDArray[np.float64]:
    """Directions through pixel centres of the resized image in the body frame, (rows * columns, 3), row by row.

    w = (u + 1/2) w0 / u0, h = (v + 1/2) h0 / v0; (1, -(w - cx) / fx, -(h - cy) / fy), normalised (eq. 3-5).
    """
    columns, rows = camera.cast
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    w = (np.arange(columns) + 0.5) * camera.image[0] / columns
    h = (np.arange(rows) + 0.5) * camera.image[1] / rows
    y = (-(w - cx_px) / fx_px)[None, :]
    z = (-(h - cy_px) / fy_px)[:, None]
    norm = np.sqrt(1.0 + y * y + z * z)
    return np.stack([1.0 / norm, y / norm, z / norm], axis=-1).reshape(-1, 3)


def lattice(sensor: Lidar | Camera) -> NDArray[np.float64]:
    """Directions of all rays in the sensor frame, (n, 3), float64."""
    return lidar_lattice(sensor) if isinstance(sensor, Lidar) else camera_lattice(sensor)


def rotate(rotation: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """R d for directions (n, 3), summed from left to right, as the kernels do (no BLAS, no fused operations)."""
    x, y, z = directions[:, 0], directions[:, 1], directions[:, 2]
    return np.stack([(row[0] * x + row[1] * y) + row[2] * z for row in rotation], axis=-1)


def sensor_rays(sensor: Lidar | Camera, rows: NDArray[np.int64] | None = None) -> Rays:
    """Rays of a sensor in the vehicle frame; `rows` (k,) picks some of them by index."""
    directions = lattice(sensor)
    if rows is not None:
        directions = directions[rows]
    return Rays(sensor.position, rotate(sensor.pose.rotation(), directions), sensor.range_m)


def clip_to_roi(grid: VoxelGrid, rays: Rays) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where each ray enters and leaves the ROI and its range, metres along the ray, (n,) each; t1 <= t0: it misses.

    For drawing and culling; the metric clips exactly.
    """
    low = np.array(grid.origin_m)
    high = low + np.array(grid.shape) * grid.voxel_m
    origin = np.array(rays.origin_m)
    with np.errstate(divide="ignore", invalid="ignore"):
        first = (low - origin) / rays.directions
        second = (high - origin) / rays.directions
    flat = rays.directions == 0.0
    inside = (low <= origin) & (origin < high)
    first = np.where(flat, np.where(inside, -math.inf, math.inf), first)
    second = np.where(flat, np.where(inside, math.inf, -math.inf), second)
    t0 = np.maximum(np.minimum(first, second).max(axis=1), rays.range_m[0])
    t1 = np.minimum(np.maximum(first, second).min(axis=1), rays.range_m[1])
    return t0, np.where(flat.any(axis=1) & ~(inside | ~flat).all(axis=1), t0, t1)
