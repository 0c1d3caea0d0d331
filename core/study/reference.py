"""The voxels of rays straight from the definition: the judge of every method in the stability study.

All moments at which a ray meets a plane between voxels are sorted; from one moment to the next the ray is
inside a single voxel, that of the point half-way. This is done in doubles with a bound on their rounding, and
again in rational numbers for each ray on which the bound does not decide. No code is shared with the engine.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Sensor
from riglens.core.scene.boxes import Progress
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.rays import sensor_rays

Mask = NDArray[np.bool_]
Doubles = NDArray[np.float64]
RAYS_AT_ONCE = 1 << 12
UNIT_ROUNDOFF = 2.0**-53
TIES = 8.0 * UNIT_ROUNDOFF
"""Two computed moments, each off by at most 3 roundoffs, are in their true order when they differ by more."""
NEAR_A_PLANE = 16.0 * UNIT_ROUNDOFF
SMALLEST = 1e-100
"""Components between 0 and this could underflow on the way; their rays are done in rational numbers."""


def exact_cover(grid: VoxelGrid, sensors: Iterable[Sensor], progress: Progress | None = None) -> Mask:
    """Return voxels (nx, ny, nz) in which at least one ray of the sensors runs over a positive length."""
    seen = np.zeros(grid.shape, np.bool_)
    every = list(sensors)
    total = sum(sensor.ray_count for sensor in every)
    done = 0
    for sensor in every:
        origin = np.array(grid.to_grid(sensor.position))
        near, far = (limit / grid.voxel_m for limit in sensor.range_m)
        for start in range(0, sensor.ray_count, RAYS_AT_ONCE):
            numbers = np.arange(start, min(start + RAYS_AT_ONCE, sensor.ray_count))
            directions = sensor_rays(sensor, numbers).directions
            directions = directions[~np.isnan(directions[:, 0])]
            for ray in _mark_clear(origin, directions, near, far, seen):
                _mark_rational(origin, directions[ray], near, far, seen)
            done += numbers.size
            if progress is not None:
                progress(done / total)
    return seen


def _mark_clear(
    origin: Doubles, directions: Doubles, near: float, far: float, seen: Mask
) -> NDArray[np.intp]:
    """Mark the voxels of the rays that doubles decide; returns the numbers of the others."""
    tiny = np.abs(np.concatenate([np.broadcast_to(origin, directions.shape), directions], axis=1))
    left = ((tiny > 0.0) & (tiny < SMALLEST)).any(axis=1) | (0.0 < near < SMALLEST)
    moments = _moments(origin, directions, near, far, seen.shape)
    first, last = moments[:, :-1], moments[:, 1:]
    with np.errstate(invalid="ignore", over="ignore"):
        gap = last - first
        tied = (gap <= TIES * np.maximum(np.abs(first), np.abs(last))) & (last != 0.0)  # 0 / d is exact
        left |= (tied & np.isfinite(last) & (last >= near) & (first <= far)).any(axis=1)
        between = (gap > 0.0) & (first >= near) & (last <= far) & np.isfinite(last)
        cells, doubtful = _cells(origin, directions, first + 0.5 * gap, last, between, seen.shape)
    left |= doubtful
    rays, which = np.nonzero(cells[3] & ~left[:, None])
    seen[cells[0][rays, which], cells[1][rays, which], cells[2][rays, which]] = True
    return np.flatnonzero(left)


def _moments(
    origin: Doubles, directions: Doubles, near: float, far: float, shape: tuple[int, ...]
) -> Doubles:
    """Return the moments at which each ray meets a plane, and the ends of its range, ascending, (n, planes + 2)."""
    ends = np.broadcast_to(np.array([near, far]), (len(directions), 2))
    columns = [ends]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for axis, count in enumerate(shape):
            along = directions[:, axis, None]
            meets = (np.arange(count + 1) - origin[axis]) / along
            columns.append(np.where(along == 0.0, np.inf, meets))
    return np.sort(np.concatenate(columns, axis=1), axis=1)


def _cells(
    origin: Doubles,
    directions: Doubles,
    middle: Doubles,
    last: Doubles,
    between: Mask,
    shape: tuple[int, ...],
) -> tuple[list[NDArray[np.int64] | Mask], Mask]:
    """Return voxel indices along x, y, z of the midpoints and whether they count; and the rays too near to a plane."""
    inside = between.copy()
    unsure = np.zeros_like(between)
    indices: list[NDArray[np.int64] | Mask] = []
    for axis, count in enumerate(shape):
        along = directions[:, axis, None]
        place = np.where(between, origin[axis] + along * middle, -1.0)
        size = np.abs(origin[axis]) + np.abs(along) * np.abs(last)
        unsure |= (along != 0.0) & (np.abs(place - np.rint(place)) <= NEAR_A_PLANE * size)
        index = np.floor(place)
        inside &= (index >= 0) & (index < count)
        indices.append(np.clip(index, 0, count - 1).astype(np.int64))
    doubtful: Mask = np.any(unsure & between, axis=1)
    return [*indices, inside], doubtful


def _mark_rational(origin: Doubles, direction: Doubles, near: float, far: float, seen: Mask) -> None:
    place = [Fraction(float(value)) for value in origin]
    along = [Fraction(float(value)) for value in direction]
    moments = {Fraction(near)} | ({Fraction(far)} if math.isfinite(far) else set())
    for start, step, count in zip(place, along, seen.shape, strict=True):
        if step:
            moments |= {(plane - start) / step for plane in range(count + 1)}
    ordered = sorted(moment for moment in moments if near <= moment <= far)
    for first, last in pairwise(ordered):
        middle = (first + last) / 2
        cell = [math.floor(start + step * middle) for start, step in zip(place, along, strict=True)]
        if all(0 <= index < count for index, count in zip(cell, seen.shape, strict=True)):
            seen[tuple(cell)] = True
