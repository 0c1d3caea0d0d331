"""Which voxels rays traverse, found by following each of them through a grid in plain doubles: for millions of rays.

Nothing of the product's casting is used: neither its walk nor its predicates. Where two crossings are closer than
MARGIN the moment is noted as doubtful instead, and the voxels around it are decided by fractions, one by one.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from itertools import product

import numba
import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Sensor
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.rays import sensor_rays

MARGIN = 1e-9
"""In voxels along a ray; a crossing is known to 5e-16 of its moment, and no grid here is 10^5 voxels long."""
AROUND = 1e-6
Cell = tuple[int, int, int]


@numba.njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _moment(face: float, g: float, d: float) -> float:
    return (face - g) / d


@numba.njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _cell_after(g: float, d: float, t: float) -> float:
    """Cell of an axis just after a moment, by the crossings as they are computed."""
    if d == 0.0:
        return float(np.floor(g))
    cell = float(np.floor(g + d * t))
    ahead, behind, step = (1.0, 0.0, 1.0) if d > 0.0 else (0.0, 1.0, -1.0)
    while _moment(cell + ahead, g, d) <= t:
        cell += step
    while _moment(cell + behind, g, d) > t:
        cell -= step
    return cell


@numba.njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _clip(
    g: np.ndarray, d: np.ndarray, shape: np.ndarray, reach: np.ndarray
) -> tuple[float, float, int, int]:
    """From and to which moment a ray is in the grid and its range, and the axes whose faces say so (-1: the range)."""
    t0, t1, entry, leave = reach[0], reach[1], -1, -1
    for axis in range(3):
        if d[axis] == 0.0:
            if not 0.0 <= np.floor(g[axis]) < shape[axis]:
                return 1.0, -1.0, -1, -1
            continue
        first, last = _moment(0.0, g[axis], d[axis]), _moment(float(shape[axis]), g[axis], d[axis])
        if first > last:
            first, last = last, first
        if first > t0:
            t0, entry = first, axis
        if last < t1:
            t1, leave = last, axis
    return t0, t1, entry, leave


@numba.njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _is_doubtful(t: float, crossing: float) -> bool:
    """Whether it is open which of two moments is first; a ray that begins on a face is certain to."""
    return abs(t - crossing) <= MARGIN and not (t == 0.0 and crossing == 0.0)


@numba.njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _follow(
    g: np.ndarray, d: np.ndarray, shape: np.ndarray, reach: np.ndarray, seen: np.ndarray, doubts: np.ndarray
) -> int:
    """Mark the voxels of one ray that are certain; write the moments that are not and return how many."""
    t, end, entry, leave = _clip(g, d, shape, reach)
    count = 0
    if t >= end:
        if t - end <= MARGIN:
            doubts[0] = t
            count = 1
        return count
    cell, ahead = np.empty(3), np.empty(3)
    for axis in range(3):
        cell[axis] = _cell_after(g[axis], d[axis], t)
        ahead[axis] = np.inf
        if d[axis] != 0.0:
            up = d[axis] > 0.0
            ahead[axis] = _moment(cell[axis] + (1.0 if up else 0.0), g[axis], d[axis])
            behind = _moment(cell[axis] + (0.0 if up else 1.0), g[axis], d[axis])
            if axis != entry and _is_doubtful(t, behind):
                doubts[count] = t
                count += 1
    while t < end:
        axis = int(np.argmin(ahead))
        until = min(ahead[axis], end)
        if until - t > MARGIN:
            seen[int(cell[0]), int(cell[1]), int(cell[2])] = True
        elif not (t == 0.0 and until == 0.0):
            doubts[count] = t
            count += 1
        if ahead[axis] >= end:
            break
        cell[axis] += 1.0 if d[axis] > 0.0 else -1.0
        if not 0.0 <= cell[axis] < shape[axis]:
            break
        t = until
        ahead[axis] = _moment(cell[axis] + (1.0 if d[axis] > 0.0 else 0.0), g[axis], d[axis])
    for axis in range(3):
        if axis != leave and abs(ahead[axis] - end) <= MARGIN:
            doubts[count] = end
            count += 1
    return count


@numba.njit(error_model="numpy")  # type: ignore[untyped-decorator]
def _follow_all(
    g: np.ndarray,
    directions: np.ndarray,
    shape: np.ndarray,
    reach: np.ndarray,
    seen: np.ndarray,
    numbers: np.ndarray,
    moments: np.ndarray,
) -> int:
    """Follow all rays; write number and moment of the doubtful, as many as there is room for, and return how many."""
    total, doubts = 0, np.empty(shape.sum() + 16)
    for ray in range(len(directions)):
        count = _follow(g, directions[ray], shape, reach, seen, doubts)
        for i in range(count):
            if total + i < len(numbers):
                numbers[total + i] = ray
                moments[total + i] = doubts[i]
        total += count
    return total


def is_hit(g: Iterable[float], d: Iterable[float], near: float, far: float, cell: Cell) -> bool:
    """Whether a ray runs inside a half-open voxel over a positive length, in fractions."""
    first, last = Fraction(near), Fraction(min(far, 1e30))
    for origin, direction, index in zip(g, d, cell, strict=True):
        if direction == 0.0:
            if not index <= origin < index + 1:
                return False
            continue
        times = [(face - Fraction(origin)) / Fraction(direction) for face in (index, index + 1)]
        first, last = max(first, min(times)), min(last, max(times))
    return first < last


def every_ray(grid: VoxelGrid, sensor: Sensor) -> tuple[NDArray[np.bool_], int]:
    """Voxels that the rays of a sensor traverse, (nx, ny, nz), and how many fractions had to decide."""
    directions = np.ascontiguousarray(sensor_rays(sensor).directions)
    low = (-grid.roi_m[0] / 2, -grid.roi_m[1] / 2, 0.0)
    g = np.array([(sensor.position[axis] - low[axis]) / grid.voxel_m for axis in range(3)])
    reach = np.array(sensor.range_m) / grid.voxel_m
    shape, seen = np.array(grid.shape, np.int64), np.zeros(grid.shape, np.bool_)
    room, total = 1 << 16, 1 << 17
    while total > room:
        room = max(total, room)
        numbers, moments = np.empty(room, np.int64), np.empty(room)
        total = _follow_all(g, directions, shape, reach, seen, numbers, moments)
        if total <= room:
            break
    return seen, _decide(g, directions, reach, seen, numbers[:total], moments[:total])


def _decide(
    g: NDArray[np.float64],
    directions: NDArray[np.float64],
    reach: NDArray[np.float64],
    seen: NDArray[np.bool_],
    numbers: NDArray[np.int64],
    moments: NDArray[np.float64],
) -> int:
    """Mark the voxels around doubtful moments that are hit all the same."""
    places, (near, far) = g + directions[numbers] * moments[:, None], reach.tolist()
    below, above = np.floor(places - AROUND).astype(int), np.floor(places + AROUND).astype(int)
    decided = 0
    for ray, low, high in zip(numbers, below.tolist(), above.tolist(), strict=True):
        for i, j, k in product(*({a, b} for a, b in zip(low, high, strict=True))):
            if all(0 <= c < n for c, n in zip((i, j, k), seen.shape, strict=True)) and not seen[i, j, k]:
                decided += 1
                seen[i, j, k] = is_hit(g.tolist(), directions[ray].tolist(), near, far, (i, j, k))
    return decided
