"""Independent answers, slow and plain: every ray against every voxel box, every box against every centre.

Nothing here uses the kernels. The ray formulas are written again from the definition of the metric; the rays
are then intersected with the voxels in exact rational arithmetic (`exact_*`) or, for many generic rays, in
doubles with a margin (`slab_cover`).
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Camera, Lidar, Sensor
from riglens.core.scene.boxes import BoxBatch
from riglens.core.scene.grid import VoxelGrid

Mask = NDArray[np.bool_]
Cell = tuple[int, int, int]


# ---------------------------------------------------------------- rays


def rotation(rpy_deg: Sequence[float]) -> NDArray[np.float64]:
    """Rz(yaw) Ry(pitch) Rx(roll), the product written out term by term."""
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(math.radians(a)), math.cos(math.radians(a))) for a in rpy_deg)
    forward = (cy * cp, sy * cp, -sp)
    left = (cy * sp * sr - sy * cr, sy * sp * sr + cy * cr, cp * sr)
    up = (cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr)
    return np.column_stack([forward, left, up])


def lidar_directions(lidar: Lidar) -> NDArray[np.float64]:
    """(cos e cos a, cos e sin a, sin e), beam by beam."""
    cos_e, sin_e = np.cos(np.radians(lidar.elevations())), np.sin(np.radians(lidar.elevations()))
    cos_a, sin_a = np.cos(np.radians(lidar.azimuths())), np.sin(np.radians(lidar.azimuths()))
    return np.array(
        [
            (ce * ca, ce * sa, se)
            for ce, se in zip(cos_e, sin_e, strict=True)
            for ca, sa in zip(cos_a, sin_a, strict=True)
        ]
    )


def camera_directions(camera: Camera) -> NDArray[np.float64]:
    """(1, -(w - cx) / fx, -(h - cy) / fy) normalised, through pixel centres of the resized image, by rows."""
    (w0, h0), (u0, v0) = camera.image, camera.resolution
    if camera.hfov_deg is not None:
        fx = fy = (w0 / 2) / math.tan(math.radians(camera.hfov_deg) / 2)
        cx, cy = w0 / 2, h0 / 2
    else:
        assert camera.fx is not None and camera.fy is not None
        assert camera.cx is not None and camera.cy is not None
        fx, fy, cx, cy = camera.fx, camera.fy, camera.cx, camera.cy
    rays = []
    for v in range(v0):
        for u in range(u0):
            y = -((u + 0.5) * w0 / u0 - cx) / fx
            z = -((v + 0.5) * h0 / v0 - cy) / fy
            norm = math.sqrt(1.0 + y * y + z * z)
            rays.append((1.0 / norm, y / norm, z / norm))
    return np.array(rays)


def vehicle_directions(sensor: Sensor) -> NDArray[np.float64]:
    """Directions of all rays in the vehicle frame, (n, 3): R d, summed from left to right."""
    assert isinstance(sensor, (Lidar, Camera))
    local = lidar_directions(sensor) if isinstance(sensor, Lidar) else camera_directions(sensor)
    r = rotation(sensor.rpy_deg)
    return np.column_stack(
        [r[i, 0] * local[:, 0] + r[i, 1] * local[:, 1] + r[i, 2] * local[:, 2] for i in range(3)]
    )


@dataclass(frozen=True)
class GridRay:
    """A ray in grid units: origin g, direction d, parameter from near to far."""

    g: tuple[float, float, float]
    d: tuple[float, float, float]
    near: float = 0.0
    far: float = math.inf


def grid_rays(grid: VoxelGrid, sensor: Sensor) -> list[GridRay]:
    """All rays of a sensor in grid coordinates (x - x_min) / delta, computed in doubles."""
    low = (-grid.roi_m[0] / 2, -grid.roi_m[1] / 2, 0.0)
    x, y, z = ((sensor.position[axis] - low[axis]) / grid.voxel_m for axis in range(3))
    near, far = (limit / grid.voxel_m for limit in sensor.range_m)
    return [
        GridRay((x, y, z), (float(dx), float(dy), float(dz)), near, far)
        for dx, dy, dz in vehicle_directions(sensor)
    ]


# ---------------------------------------------------------------- voxels of a ray, exactly


def _exact_times(
    shape: Sequence[int], ray: GridRay
) -> tuple[list[NDArray[np.object_]], list[NDArray[np.object_]]]:
    """When the ray enters and leaves the slabs [i, i + 1) of each axis: integers over one denominator."""
    faces = [
        [(face - Fraction(g)) / Fraction(d) for face in range(n + 1)] if d != 0.0 else []
        for n, g, d in zip(shape, ray.g, ray.d, strict=True)
    ]
    near = Fraction(ray.near)
    far = max(near, *(t for times in faces for t in times)) + 1 if math.isinf(ray.far) else Fraction(ray.far)
    unit = math.lcm(near.denominator, far.denominator, *(t.denominator for times in faces for t in times))

    def count(t: Fraction) -> int:
        return t.numerator * (unit // t.denominator)

    enter, leave = [], []
    for n, g, times in zip(shape, ray.g, faces, strict=True):
        if times:
            ticks = [count(t) for t in times]
            pairs = [(min(pair), max(pair)) for pair in pairwise(ticks)]
        else:
            pairs = [
                (count(near), count(far)) if i == math.floor(g) else (count(far), count(near))
                for i in range(n)
            ]
        enter.append(np.array([max(a, count(near)) for a, _ in pairs], dtype=object))
        leave.append(np.array([min(b, count(far)) for _, b in pairs], dtype=object))
    return enter, leave


def _box_times(shape: Sequence[int], ray: GridRay) -> tuple[NDArray[np.object_], NDArray[np.object_]]:
    """Entry and exit of every voxel box, (nx, ny, nz) integers; inside where entry < exit."""
    enter, leave = _exact_times(shape, ray)
    first = np.maximum(np.maximum(enter[0][:, None, None], enter[1][:, None]), enter[2])
    last = np.minimum(np.minimum(leave[0][:, None, None], leave[1][:, None]), leave[2])
    return first, last


def exact_mask(shape: Sequence[int], ray: GridRay) -> Mask:
    """Voxels in whose half-open box the ray runs over a positive length."""
    first, last = _box_times(shape, ray)
    return (first < last).astype(np.bool_)


def exact_walk(shape: Sequence[int], ray: GridRay) -> list[Cell]:
    """The same voxels in the order in which the ray meets them."""
    first, last = _box_times(shape, ray)
    cells = np.argwhere((first < last).astype(np.bool_))
    ordered = sorted(cells.tolist(), key=lambda cell: first[tuple(cell)])
    return [(i, j, k) for i, j, k in ordered]


def exact_cover(grid: VoxelGrid, sensors: Iterable[Sensor]) -> Mask:
    """Voxels that at least one ray of the sensors traverses."""
    cover = np.zeros(grid.shape, np.bool_)
    for sensor in sensors:
        for ray in grid_rays(grid, sensor):
            cover |= exact_mask(grid.shape, ray)
    return cover


def exact_visits(grid: VoxelGrid, sensors: Iterable[Sensor]) -> NDArray[np.int64]:
    """How many rays traverse each voxel."""
    visits = np.zeros(grid.shape, np.int64)
    for sensor in sensors:
        for ray in grid_rays(grid, sensor):
            visits += exact_mask(grid.shape, ray)
    return visits


# ---------------------------------------------------------------- voxels of many rays, in doubles


def slab_lengths(shape: Sequence[int], ray: GridRay) -> NDArray[np.float64]:
    """Length of the ray per voxel in grid units; negative or zero: not inside. No component may be zero."""
    first, last = np.full(shape, ray.near), np.full(shape, ray.far)
    for axis in range(3):
        faces = (np.arange(shape[axis] + 1) - ray.g[axis]) / ray.d[axis]
        along = tuple(-1 if other == axis else 1 for other in range(3))
        first = np.maximum(first, np.minimum(faces[:-1], faces[1:]).reshape(along))
        last = np.minimum(last, np.maximum(faces[:-1], faces[1:]).reshape(along))
    inside: NDArray[np.float64] = last - first
    return inside


def slab_cover(grid: VoxelGrid, sensor: Sensor, margin: float = 1e-9) -> tuple[Mask, Mask]:
    """Voxels surely traversed, and voxels possibly traversed, by generic rays (no zero components)."""
    sure, possible = np.zeros(grid.shape, np.bool_), np.zeros(grid.shape, np.bool_)
    for ray in grid_rays(grid, sensor):
        length = slab_lengths(grid.shape, ray)
        sure |= length > margin
        possible |= length > -margin
    return sure, possible


# ---------------------------------------------------------------- Bresenham


def bresenham(start: Cell, end: Cell) -> list[Cell]:
    """3D Bresenham as in the textbooks: two error terms, one step of the driving axis at a time."""
    delta = [abs(b - a) for a, b in zip(start, end, strict=True)]
    step = [1 if b > a else -1 for a, b in zip(start, end, strict=True)]
    drive = delta.index(max(delta))
    others = [axis for axis in range(3) if axis != drive]
    error = {axis: 2 * delta[axis] - delta[drive] for axis in others}
    point = list(start)
    line = [start]
    while point[drive] != end[drive]:
        point[drive] += step[drive]
        for axis in others:
            if error[axis] >= 0:
                point[axis] += step[axis]
                error[axis] -= 2 * delta[drive]
            error[axis] += 2 * delta[axis]
        line.append((point[0], point[1], point[2]))
    return line


# ---------------------------------------------------------------- occupancy and entropy


def occupied_frames(grid: VoxelGrid, batches: Iterable[BoxBatch], classes: int = 3) -> NDArray[np.int64]:
    """Frames in which each voxel's centre lies in at least one box of the class, (nx, ny, nz, classes)."""
    axes = [-grid.roi_m[0] / 2, -grid.roi_m[1] / 2, 0.0]
    centres = np.stack(
        np.meshgrid(
            *[low + (np.arange(n) + 0.5) * grid.voxel_m for low, n in zip(axes, grid.shape, strict=True)],
            indexing="ij",
        ),
        axis=-1,
    )
    counts = np.zeros((*grid.shape, classes), np.int64)
    for batch in batches:
        for frame in np.unique(batch.frame):
            inside = np.zeros_like(counts, np.bool_)
            for b in np.flatnonzero(batch.frame == frame):
                local = (centres - batch.centre_m[b]) @ batch.rotation[b]
                inside[..., batch.cls[b]] |= (np.abs(local) <= batch.size_m[b] / 2).all(axis=-1)
            counts += inside
    return counts


def entropy_nat(count: int, frames: int) -> float:
    """h = -p ln p - (1 - p) ln(1 - p) of p = count / frames; 0 where p is 0 or 1."""
    if count in (0, frames):
        return 0.0
    p, q = count / frames, (frames - count) / frames
    return -p * math.log(p) - q * math.log(q)
