"""Fill a POG: count the frames in which a voxel's centre is inside at least one box of the class."""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.runtime.jit import inlined, kernel, parallel_kernel


class Raster(NamedTuple):
    """Placement of the voxels: the lower corner (3,) of the grid, and their edge, in metres."""

    origin_m: np.ndarray
    voxel_m: float


@inlined
def _inside(box: np.ndarray, x: float, y: float, z: float) -> bool:
    """Return whether a point lies in a box [centre 3, half size 3, rotation 9 by rows]; faces belong to the box."""
    dx, dy, dz = x - box[0], y - box[1], z - box[2]
    for axis in range(3):
        local = (box[6 + axis] * dx + box[9 + axis] * dy) + box[12 + axis] * dz
        if abs(local) > box[3 + axis]:
            return False
    return True


@inlined
def _reach(box: np.ndarray, axis: int) -> float:
    """Return the half extent of a rotated box along a grid axis, a little enlarged."""
    row = 6 + 3 * axis
    half = abs(box[row]) * box[3] + abs(box[row + 1]) * box[4] + abs(box[row + 2]) * box[5]
    return float(half * (1.0 + 1e-9) + 1e-9)


@inlined
def _first_cell(low: float, origin: float, voxel: float, count: int) -> int:
    return int(min(max(math.floor((low - origin) / voxel - 0.5), 0.0), float(count)))


@inlined
def _end_cell(high: float, origin: float, voxel: float, count: int) -> int:
    return int(min(max(math.ceil((high - origin) / voxel + 0.5), 0.0), float(count)))


@kernel
def _upright_levels(box: np.ndarray, origin: float, voxel: float, low: int, end: int) -> tuple[int, int]:
    """Return the levels low..end-1 whose centre an upright box holds, by the same comparison as `_inside`."""
    while low < end and abs(origin + (low + 0.5) * voxel - box[2]) > box[5]:
        low += 1
    while low < end and abs(origin + (end - 0.5) * voxel - box[2]) > box[5]:
        end -= 1
    return low, end


@kernel
def _earlier_overlaps(boxes: np.ndarray, frame: np.ndarray, b: int, overlaps: np.ndarray) -> int:
    """Return the boxes of the same frame before box b whose extents overlap its own; their number and, in overlaps,
    their rows."""
    count = 0
    other = b - 1
    while other >= 0 and frame[other] == frame[b]:
        apart = False
        for axis in range(3):
            gap = abs(boxes[other, axis] - boxes[b, axis])
            apart |= gap > _reach(boxes[other], axis) + _reach(boxes[b], axis)
        if not apart:
            overlaps[count] = other
            count += 1
        other -= 1
    return count


@kernel
def _fill_box(
    boxes: np.ndarray,
    b: int,
    others: np.ndarray,
    raster: Raster,
    x_from: int,
    x_to: int,
    counts: np.ndarray,
) -> None:
    """Count box b in the slab x_from..x_to, leaving out voxels that an earlier box of the frame has counted."""
    box, origin, voxel = boxes[b], raster.origin_m, raster.voxel_m
    _, ny, nz = counts.shape
    low_x = max(_first_cell(box[0] - _reach(box, 0), origin[0], voxel, x_to), x_from)
    end_x = min(_end_cell(box[0] + _reach(box, 0), origin[0], voxel, x_to), x_to)
    low_y = _first_cell(box[1] - _reach(box, 1), origin[1], voxel, ny)
    end_y = _end_cell(box[1] + _reach(box, 1), origin[1], voxel, ny)
    low_z = _first_cell(box[2] - _reach(box, 2), origin[2], voxel, nz)
    end_z = _end_cell(box[2] + _reach(box, 2), origin[2], voxel, nz)
    upright = box[8] == 0.0 and box[11] == 0.0 and box[12] == 0.0 and box[13] == 0.0 and box[14] == 1.0
    if upright:
        low_z, end_z = _upright_levels(box, origin[2], voxel, low_z, end_z)
    for ix in range(low_x, end_x):
        x = origin[0] + (ix + 0.5) * voxel
        for iy in range(low_y, end_y):
            y = origin[1] + (iy + 0.5) * voxel
            if upright and not _inside(box, x, y, box[2]):
                continue
            if upright and others.size == 0:
                for iz in range(low_z, end_z):
                    counts[ix, iy, iz] += 1
                continue
            for iz in range(low_z, end_z):
                z = origin[2] + (iz + 0.5) * voxel
                if _inside(box, x, y, z):
                    new = True
                    for other in others:
                        new &= not _inside(boxes[other], x, y, z)
                    counts[ix, iy, iz] += new


@parallel_kernel
def fill_counts(
    boxes: np.ndarray, frame: np.ndarray, raster: Raster, workers: int, counts: np.ndarray
) -> None:
    """Add whole frames of one class to counts (nx, ny, nz); each worker owns slabs along x.

    boxes (n, 15): centre, half size in metres, rotation by rows; frame int64 (n,): equal ones stand together.
    """
    nx = counts.shape[0]
    slabs = workers * 8
    for worker in numba.prange(workers):
        overlaps = np.empty(max(frame.size, 1), np.int64)
        for b in range(frame.size):
            found = _earlier_overlaps(boxes, frame, b, overlaps)
            for slab in range(worker, slabs, workers):
                x_from, x_to = nx * slab // slabs, nx * (slab + 1) // slabs
                _fill_box(boxes, b, overlaps[:found], raster, x_from, x_to, counts)


@parallel_kernel
def pack_nonzero(counts: np.ndarray, words: np.ndarray) -> None:
    """Set the bits of the voxels with a count, counts (nx, ny, nz), words (nx * ny * depth,)."""
    nx, ny, nz = counts.shape
    depth = (nz + 63) // 64
    for ix in numba.prange(nx):
        for iy in range(ny):
            for iz in range(nz):
                if counts[ix, iy, iz] != 0:
                    words[(ix * ny + iy) * depth + (iz >> 6)] |= np.uint64(1) << np.uint64(iz & 63)
