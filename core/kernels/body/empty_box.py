"""The largest box of cells around a place that holds nothing: in it, where a ray ends makes no difference."""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.body.shadow import is_in
from riglens.core.kernels.rays.cast import Cast, ray_direction
from riglens.core.kernels.runtime.jit import inlined, kernel
from riglens.core.kernels.voxels.bits import mask_of


@inlined
def _is_empty(words: np.ndarray, shape: np.ndarray, box: np.ndarray) -> bool:
    """Return whether a box of cells [lx hx ly hy lz hz), some of each, holds no set bit."""
    depth = (shape[2] + 63) // 64
    for part in range(box[4] // 64, (box[5] - 1) // 64 + 1):
        mask = mask_of(box[4], box[5] - 1, part)
        for ix in range(box[0], box[1]):
            for iy in range(box[2], box[3]):
                if words[(ix * shape[1] + iy) * depth + part] & mask != 0:
                    return False
    return True


@inlined
def _copy(one: np.ndarray, to: np.ndarray) -> None:
    """Copy a box; a slice that is set to another takes a second to compile."""
    for side in range(6):
        to[side] = one[side]


@inlined
def _grow(
    words: np.ndarray, shape: np.ndarray, limits: np.ndarray, first: int, end: int, box: np.ndarray
) -> None:
    """Move the sides first..end-1 of an empty box outwards, a layer on each in turn, as long as it remains empty."""
    grows, layer, growing = np.ones(6, np.bool_), np.empty(6, np.int64), end - first
    while growing > 0:
        growing = 0
        for side in range(first, end):
            step, other = (1, side - 1) if side % 2 else (-1, side + 1)
            if not grows[side] or box[side] == limits[side]:
                grows[side] = False
                continue
            _copy(box, layer)
            layer[side], layer[other] = box[side] + step, box[side]
            grows[side] = _is_empty(words, shape, layer)
            box[side] += step * grows[side]
            growing += grows[side]


@kernel
def grow_empty_box(words: np.ndarray, shape: np.ndarray, cell: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Return a box of cells int64 (6,) [lx hx ly hy lz hz) around a cell (3,) that holds no set bit, as large as it
    becomes when it grows on all sides in turn, or along one axis before the others, within limits (6,), a box that
    holds the cell; empty where the cell is set."""
    best, box, most = np.zeros(6, np.int64), np.empty(6, np.int64), 0
    for axis in range(-1, 3):
        for along in range(3):
            box[2 * along], box[2 * along + 1] = cell[along], cell[along] + 1
        if not _is_empty(words, shape, box):
            return best
        if axis >= 0:
            _grow(words, shape, limits, 2 * axis, 2 * axis + 2, box)
        _grow(words, shape, limits, 0, 6, box)
        size = (box[1] - box[0]) * (box[3] - box[2]) * (box[5] - box[4])
        if size > most:
            _copy(box, best)
            most = size
    return best


@kernel
def finite_ends(ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return which of some rays (n,) have an end, int32 (k,) in rising order, and where (k,)."""
    count = 0
    for ray in range(ends.size):
        count += ends[ray] < np.inf
    cut, cut_m, place = np.empty(count, np.int32), np.empty(count), 0
    for ray in range(ends.size):
        if ends[ray] < np.inf:
            cut[place], cut_m[place] = ray, ends[ray]
            place += 1
    return cut, cut_m


@kernel
def stop_rays(
    rays: Cast, cut: np.ndarray, cut_m: np.ndarray, empty_box: np.ndarray, is_stopped: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Note in is_stopped (rays,) that rays end (k,), by number, at distances (k,); return those that end outside of an
    empty box, and where."""
    outside, outside_m, count, o = np.empty(cut.size, np.int64), np.empty(cut.size), 0, rays.origin
    has_box = empty_box[0] <= empty_box[3] and empty_box[1] <= empty_box[4] and empty_box[2] <= empty_box[5]
    for place in range(cut.size):
        ray, t = cut[place], cut_m[place]
        is_stopped[ray] = True
        if has_box:
            d = ray_direction(rays, ray)
            if is_in(empty_box, (o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2])):
                continue
        outside[count], outside_m[count] = ray, t
        count += 1
    return outside[:count], outside_m[:count]
