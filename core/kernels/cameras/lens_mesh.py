"""Voxel walking for a camera whose rays fit no table: decide whether any of them hits a voxel, column by column.

Neighbouring rays are joined to triangles, and these to a *mesh*. A voxel whose centre lies in the mesh is hit for
certain as far as its triangles are small: the ray at the nearest corner passes through it near its centre. So all
that matters is where the border of the mesh is. It is laid down by bearing about the vertical: within each of many
narrow *sectors*, the slopes between which a direction is inside for certain, and those beyond which nothing of the mesh
is. Of a column of the grid that gives one run of levels that are hit for certain. Those beside it are tested with
the rays themselves, which are found by their place in the image plane of a pinhole, in *bins*.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.beams.cones import CLEAR, HALF_COLUMN, LONGEST
from riglens.core.kernels.cameras.frustum import SPHERE, columns_in_row
from riglens.core.kernels.rays.bins import Bins, bin_of, bins_around
from riglens.core.kernels.rays.cast import NONE_STOPPED
from riglens.core.kernels.rays.lattice import rotated, rotated_back
from riglens.core.kernels.rays.walk import FARTHEST, Cell, Ray, hits_cell
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined, parallel_kernel
from riglens.core.kernels.runtime.work_stealing import new_counter, take
from riglens.core.kernels.voxels.bits import mark_levels

SECTORS = 8192
"""Sectors of bearing in a turn."""
WIDEST = 10
"""Number of doublings by which sectors are merged: up to the width of the nearest columns."""
BLURRED = 1e-9
"""Tolerance of bearings and slopes, far above their rounding."""
POLAR = 0.3
"""Bearing span (a full turn is 4) beyond which an edge passes close to the vertical."""
OPPOSITE = 1.8
"""Bearing span beyond which an edge may pass the vertical on either side."""
NEAREST = 4.0
"""Voxels in plan within which every voxel is tested."""
TOUCHING = 0.05
"""Distance to the camera within which voxels are tested with all rays."""
AHEAD = 0.002
"""Least distance ahead of anything that is farther away than TOUCHING and met by a ray."""

STOPPED, FREE = 0, 1
NO_BINS = np.zeros((2, 0, 0), np.int64)


class Mesh(NamedTuple):
    """A camera for voxel walking by its mesh: directions of its rays (n, 3), origin (3,) in grid units, rotation
    (3, 3), box (6,) cells, shape (3,) of the grid.

    limit: how far away a voxel is hit for certain whose centre is in the mesh; inside (SECTORS, 2): slopes between
    which a direction is in the mesh; around (2, WIDEST, SECTORS): the least and the largest slope of the mesh in 1, 2,
    4, ... sectors from each on; reach (3, 2): least and largest component of all directions; outline (n, 2): corners
    in plan of what holds the mesh up to its limit; apart (2,): how far a place of a triangle in the image plane may be
    from its corners. is_stopped (n,) as in `kernels.rays.cast.Cast`; before (2, i + 1, j + 1): how many rays
    are stopped, and how many are not, in the bins before; both empty where none is stopped.
    """

    rows: np.ndarray
    origin: np.ndarray
    rotation: np.ndarray
    box: np.ndarray
    shape: np.ndarray
    limit: float
    inside: np.ndarray
    around: np.ndarray
    reach: np.ndarray
    outline: np.ndarray
    apart: np.ndarray
    is_stopped: np.ndarray = NONE_STOPPED
    before: np.ndarray = NO_BINS


@lean_inlined
def _bearing(x: float, y: float) -> float:
    """Return the bearing of a place in plan in sectors, from 0 to SECTORS; it grows with the angle, a little
    unevenly."""
    share = y / (abs(x) + abs(y))
    return (0.25 * SECTORS) * (share + 1.0 if x >= 0.0 else 3.0 - share)


@kernel
def lay_border(border: np.ndarray, inside: np.ndarray, around: np.ndarray) -> None:
    """Write where the border of a mesh is, sector by sector: `Mesh.inside`, and `Mesh.around` for single sectors.

    border (n, 2, 3): edges from a direction to the next, the mesh on their left as seen from outside. An edge that
    goes to larger bearings has it above, one that goes back below. So a slope is in the mesh all over a sector when all
    edges there that have it above are below, and all that have it below are above: over every bearing, edges of both
    kinds follow each other in turn.
    """
    lowest, highest = np.full((SECTORS, 2), np.inf), np.full((SECTORS, 2), -np.inf)
    inside[:, 0], inside[:, 1] = -np.inf, np.inf
    for edge in range(border.shape[0]):
        a, b = border[edge, 0], border[edge, 1]
        start, end = _bearing(a[0], a[1]), _bearing(b[0], b[1])
        if start - end > 0.5 * SECTORS:
            end += SECTORS
        elif end - start > 0.5 * SECTORS:
            start += SECTORS
        s, t = a[2] / np.hypot(a[0], a[1]), b[2] / np.hypot(b[0], b[1])
        turn = abs(end - start) * (4.0 / SECTORS)
        room = (0.55 * turn * turn + BLURRED) * max(abs(s), abs(t)) + BLURRED
        low, high = min(s, t) - room, max(s, t) + room
        first, last = (
            int(np.floor(min(start, end) - BLURRED * SECTORS)),
            int(np.floor(max(start, end) + BLURRED * SECTORS)),
        )
        has_above, has_below = end >= start - BLURRED * SECTORS, end <= start + BLURRED * SECTORS
        if turn > POLAR:  # its slopes go beyond those of its ends, but only away from the horizon
            room = BLURRED * (1.0 + max(abs(s), abs(t)))
            low, high = (min(s, t) - room, np.inf) if s > 0.0 else (-np.inf, max(s, t) + room)
        if turn > OPPOSITE:  # on which side of the vertical it passes is not clear
            first, last, has_above, has_below = 0, SECTORS - 1, True, True
        for number in range(first, last + 1):
            sector = number % SECTORS
            if has_above:
                lowest[sector, 0], highest[sector, 0] = (
                    min(lowest[sector, 0], low),
                    max(highest[sector, 0], high),
                )
                inside[sector, 0] = max(inside[sector, 0], high)
            if has_below:
                lowest[sector, 1], highest[sector, 1] = (
                    min(lowest[sector, 1], low),
                    max(highest[sector, 1], high),
                )
                inside[sector, 1] = min(inside[sector, 1], low)
    for sector in range(SECTORS):
        around[0, 0, sector] = lowest[sector, 0] if lowest[sector, 0] <= lowest[sector, 1] else -np.inf
        around[1, 0, sector] = highest[sector, 1] if highest[sector, 1] >= highest[sector, 0] else np.inf
        if min(lowest[sector, 0], lowest[sector, 1]) == np.inf:
            inside[sector, 0], inside[sector, 1] = np.inf, -np.inf
            around[0, 0, sector], around[1, 0, sector] = np.inf, -np.inf


@lean_inlined
def _slopes_around(mesh: Mesh, bearing: float, half: float) -> tuple[float, float]:
    """Return the least and the largest slope of the mesh within some sectors of a bearing (empty: least > largest)."""
    first, last = int(np.floor(bearing - half)), int(np.floor(bearing + half))
    wide = 0
    while (2 << wide) <= last - first + 1:
        wide += 1
    a, b = first % SECTORS, (last + 1 - (1 << wide)) % SECTORS
    return (
        min(mesh.around[0, wide, a], mesh.around[0, wide, b]),
        max(mesh.around[1, wide, a], mesh.around[1, wide, b]),
    )


@lean_inlined
def _ray_hits(mesh: Mesh, ray: int, cell: Cell) -> bool:
    """Return whether a ray is cast and traverses a voxel: in doubles where they suffice, else exactly."""
    if mesh.is_stopped.size > 0 and mesh.is_stopped[ray]:
        return False
    row = mesh.rows[ray]
    d = rotated(mesh.rotation, (row[0], row[1], row[2]))
    g = (mesh.origin[0], mesh.origin[1], mesh.origin[2])
    if d[0] != 0.0 and d[1] != 0.0 and d[2] != 0.0:
        t_in, t_out = 0.0, FARTHEST
        for axis in range(3):
            pace = 1.0 / d[axis]
            a, b = (cell[axis] - g[axis]) * pace, (cell[axis] + 1.0 - g[axis]) * pace
            t_in, t_out = max(t_in, min(a, b)), min(t_out, max(a, b))
        if abs(t_out - t_in) > CLEAR and t_in < LONGEST and abs(t_out) < LONGEST:
            return bool(t_out > t_in)
    return hits_cell(Ray(g, d, 0.0, FARTHEST), cell)


@lean_inlined
def _is_out_of_reach(mesh: Mesh, low: tuple[float, float, float]) -> bool:
    """Return whether a voxel lies to a side of the camera to which no ray goes; low: its lower corner seen from the
    camera."""
    for axis in range(3):
        if (low[axis] >= 0.0 and mesh.reach[axis, 1] < 0.0) or (
            low[axis] <= -1.0 and mesh.reach[axis, 0] >= 0.0
        ):
            return True
    return False


@lean
def _place_in_image(
    mesh: Mesh, low: tuple[float, float, float], corners: np.ndarray
) -> tuple[float, float, float, float]:
    """Return the span of a voxel in the image plane (y / x from, to, z / x from, to), as far as it is AHEAD; empty
    where nothing of it is. corners (8, 3): work space."""
    for k in range(8):
        x, y, z = rotated_back(mesh.rotation, (low[0] + (k & 1), low[1] + (k >> 1 & 1), low[2] + (k >> 2)))
        corners[k, 0], corners[k, 1], corners[k, 2] = x, y, z
    left, right, bottom, top = np.inf, -np.inf, np.inf, -np.inf
    for k in range(8):
        x, y, z = corners[k, 0], corners[k, 1], corners[k, 2]
        if x >= AHEAD:
            left, right, bottom, top = (
                min(left, y / x),
                max(right, y / x),
                min(bottom, z / x),
                max(top, z / x),
            )
            continue
        for axis in range(3):
            other = k ^ (1 << axis)
            if corners[other, 0] >= AHEAD:
                share = (AHEAD - x) / (corners[other, 0] - x)
                u = (y + share * (corners[other, 1] - y)) / AHEAD
                v = (z + share * (corners[other, 2] - z)) / AHEAD
                left, right, bottom, top = min(left, u), max(right, u), min(bottom, v), max(top, v)
    return left, right, bottom, top


@lean_inlined
def _bin_hits(mesh: Mesh, bins: Bins, i: int, j: int, cell: Cell) -> bool:
    """Return whether one of the rays in a bin traverses a voxel."""
    here = i * bins.sizes[1] + j
    for place in range(bins.first[here], bins.first[here + 1]):
        if _ray_hits(mesh, bins.rays[place], cell):
            return True
    return False


@kernel
def count_before(bins: Bins, is_stopped: np.ndarray, before: np.ndarray) -> None:
    """Write how many rays are stopped, and how many are not, in the bins before, as `Mesh.before`, all 0 before."""
    for i in range(bins.sizes[0]):
        stopped, free = 0, 0
        for j in range(bins.sizes[1]):
            here = i * bins.sizes[1] + j
            for place in range(bins.first[here], bins.first[here + 1]):
                is_one = is_stopped[bins.rays[place]]
                stopped, free = stopped + is_one, free + (not is_one)
            before[STOPPED, i + 1, j + 1] = before[STOPPED, i, j + 1] + stopped
            before[FREE, i + 1, j + 1] = before[FREE, i, j + 1] + free


@lean_inlined
def _count(mesh: Mesh, kind: int, across: tuple[int, int], up: tuple[int, int]) -> int:
    """Count the STOPPED or FREE rays of a range of bins, from and to along both axes; -1 where none is stopped."""
    if mesh.is_stopped.size == 0 or across[0] > across[1] or up[0] > up[1]:
        return -1
    b = mesh.before[kind]
    return int(
        b[across[1] + 1, up[1] + 1] - b[across[0], up[1] + 1] - b[across[1] + 1, up[0]] + b[across[0], up[0]]
    )


@lean_inlined
def _free_or_stopped(
    mesh: Mesh, bins: Bins, low: tuple[float, float, float], high: tuple[float, float, float]
) -> int:
    """Return FREE where no ray is stopped that is a corner of a triangle that holds a place between two, seen from the
    camera, STOPPED where all rays are that meet a voxel with its centre between them, else -1."""
    x0, y0, z0 = rotated_back(mesh.rotation, low)
    x1, y1, z1 = rotated_back(mesh.rotation, high)
    nearest = min(x0, x1)
    if nearest < 0.5:
        return -1
    left, right = min(y0 / x0, y1 / x1), max(y0 / x0, y1 / x1)
    bottom, top = min(z0 / x0, z1 / x1), max(z0 / x0, z1 / x1)
    u, v = mesh.apart[0], mesh.apart[1]
    across, up = bins_around(bins, 0, left - u, right + u), bins_around(bins, 1, bottom - v, top + v)
    if _count(mesh, STOPPED, across, up) == 0:
        return FREE
    if nearest < 2.0 * SPHERE:
        return -1
    # a corner c + e of a voxel lies at (y + e_y) / (x + e_x), |e| < SPHERE: at most this far from y / x
    share = SPHERE / (nearest - SPHERE)
    u, v = share * (1.0 + max(abs(left), abs(right))), share * (1.0 + max(abs(bottom), abs(top)))
    across, up = bins_around(bins, 0, left - u, right + u), bins_around(bins, 1, bottom - v, top + v)
    return STOPPED if _count(mesh, FREE, across, up) == 0 else -1


@lean
def any_ray_hits(mesh: Mesh, bins: Bins, cell: Cell, work: np.ndarray) -> bool:
    """Return whether any ray traverses a voxel, exactly: those of the bins that it touches in the image plane, the
    nearest to the middle of the image first, as a voxel at the border reaches in from outside. work (8, 3)."""
    low = (cell[0] - mesh.origin[0], cell[1] - mesh.origin[1], cell[2] - mesh.origin[2])
    if _is_out_of_reach(mesh, low):
        return False
    x, y, z = rotated_back(mesh.rotation, (low[0] + 0.5, low[1] + 0.5, low[2] + 0.5))
    if x < -SPHERE:
        return False
    from_i, to_i, from_j, to_j = 0, bins.sizes[0] - 1, 0, bins.sizes[1] - 1
    away = max(max(max(low[0], -1.0 - low[0]), max(low[1], -1.0 - low[1])), max(low[2], -1.0 - low[2]))
    if away > TOUCHING:
        left, right, bottom, top = _place_in_image(mesh, low, work)
        if left > right:
            return False
        slant = BLURRED * (1.0 + abs(left) + abs(right) + abs(bottom) + abs(top))
        from_i, to_i = max(bin_of(bins, 0, left - slant), 0), min(bin_of(bins, 0, right + slant), to_i)
        from_j, to_j = max(bin_of(bins, 1, bottom - slant), 0), min(bin_of(bins, 1, top + slant), to_j)
    if _count(mesh, FREE, (from_i, to_i), (from_j, to_j)) == 0:
        return False
    if x > SPHERE:
        i, j = bin_of(bins, 0, y / x), bin_of(bins, 1, z / x)
        if from_i <= i <= to_i and from_j <= j <= to_j and _bin_hits(mesh, bins, i, j, cell):
            return True
    turn_i, turn_j = from_i + to_i > bins.sizes[0], from_j + to_j > bins.sizes[1]
    for across in range(to_i - from_i + 1):
        i = from_i + across if turn_i else to_i - across
        if _count(mesh, FREE, (i, i), (from_j, to_j)) == 0:
            continue
        for up in range(to_j - from_j + 1):
            j = from_j + up if turn_j else to_j - up
            if _count(mesh, FREE, (i, i), (j, j)) != 0 and _bin_hits(mesh, bins, i, j, cell):
                return True
    return False


@lean_inlined
def _level_above(height: float, mesh: Mesh) -> int:
    """Return the first level of the box whose middle is above a height over the camera."""
    level = np.floor(min(max(height + mesh.origin[2] + 0.5, float(mesh.box[4])), float(mesh.box[5])))
    is_above = level + 0.5 - mesh.origin[2] > height
    return int(min(level if is_above else level + 1.0, float(mesh.box[5])))


@lean_inlined
def _is_asked(column: tuple[int, int, int], level: int, keep: np.ndarray, marks: np.ndarray) -> bool:
    """Return whether a level of a column is kept and not yet marked."""
    word = column[2] + (level >> 6)
    return bool(keep[word] & ~marks[word] & (np.uint64(1) << np.uint64(level & 63)) != 0)


@lean_inlined
def _test_levels(
    mesh: Mesh,
    bins: Bins,
    column: tuple[int, int, int],
    levels: tuple[int, int],
    keep: np.ndarray,
    marks: np.ndarray,
    work: np.ndarray,
) -> None:
    """Mark those levels first..end-1 of a column (ix, iy, first word) that are kept, not yet marked, and hit."""
    for level in range(levels[0], levels[1]):
        if _is_asked(column, level, keep, marks) and any_ray_hits(
            mesh, bins, (column[0], column[1], level), work
        ):
            marks[column[2] + (level >> 6)] |= np.uint64(1) << np.uint64(level & 63)


@lean_inlined
def _mark_inside(
    mesh: Mesh,
    bins: Bins,
    column: tuple[int, int, int],
    levels: tuple[int, int],
    keep: np.ndarray,
    marks: np.ndarray,
    work: np.ndarray,
) -> None:
    """Mark the hit levels among first..end-1 of a column, whose centres are all in the mesh: all, where no ray around
    them is stopped, none, where all are. Halves a run until one of the two is known."""
    x, y, z = column[0] + 0.5 - mesh.origin[0], column[1] + 0.5 - mesh.origin[1], 0.5 - mesh.origin[2]
    if mesh.is_stopped.size == 0:
        mark_levels(marks, column[2], levels[0], levels[1] - 1)
        return
    first, last = levels
    while first < last and not _is_asked(column, first, keep, marks):
        first += 1
    while first < last and not _is_asked(column, last - 1, keep, marks):
        last -= 1
    wide = last - first
    while first < last:
        wide = min(wide, last - first)
        end = first + wide
        kind = _free_or_stopped(mesh, bins, (x, y, z + first), (x, y, z + end - 1.0))
        if kind < 0 and wide > 1:
            wide = (wide + 1) // 2
            continue
        if kind == FREE:
            mark_levels(marks, column[2], first, end - 1)
        elif kind < 0:
            _test_levels(mesh, bins, column, (first, end), keep, marks, work)
        first, wide = end, 2 * wide


@lean
def _mark_column(
    mesh: Mesh, bins: Bins, ix: int, iy: int, keep: np.ndarray, marks: np.ndarray, work: np.ndarray
) -> None:
    """Mark the voxels of one column that a ray traverses, whose centre is nearer than the limit."""
    column = (ix, iy, (ix * mesh.shape[1] + iy) * ((mesh.shape[2] + 63) // 64))
    x, y = ix + 0.5 - mesh.origin[0], iy + 0.5 - mesh.origin[1]
    squared, most = x * x + y * y, mesh.limit * mesh.limit
    if squared >= most:
        return
    away, room = np.sqrt(squared), np.sqrt(most - squared)
    first, end = _level_above(-room, mesh), _level_above(room, mesh)
    if away < NEAREST:
        _test_levels(mesh, bins, column, (first, end), keep, marks, work)
        return
    bearing = _bearing(x, y)
    low, high = _slopes_around(mesh, bearing, 1.02 * HALF_COLUMN / away * (0.25 * SECTORS))
    if low > high:
        return
    lowest = min(low * (away - HALF_COLUMN), low * (away + HALF_COLUMN)) - 0.5 - BLURRED
    highest = max(high * (away - HALF_COLUMN), high * (away + HALF_COLUMN)) + 0.5 + BLURRED
    first, end = max(first, _level_above(lowest, mesh)), min(end, _level_above(highest, mesh))
    sector = int(bearing) % SECTORS
    slack = BLURRED * (1.0 + away)
    sure = max(first, _level_above(mesh.inside[sector, 0] * away + slack, mesh))
    sure_end = min(end, _level_above(mesh.inside[sector, 1] * away - slack, mesh))
    if sure >= sure_end:
        _test_levels(mesh, bins, column, (first, end), keep, marks, work)
        return
    _mark_inside(mesh, bins, column, (sure, sure_end), keep, marks, work)
    _test_levels(mesh, bins, column, (first, sure), keep, marks, work)
    _test_levels(mesh, bins, column, (sure_end, end), keep, marks, work)


@parallel_kernel
def mark_mesh(
    mesh: Mesh, bins: Bins, first_row: int, end_row: int, keep: np.ndarray, workers: int, marks: np.ndarray
) -> None:
    """Mark the voxels of the rows first_row..end_row-1 along x that are nearer than the limit and that a ray traverses.

    keep uint64 (words,): voxels worth a test; marks uint64 (words,): every row of the grid is marked by one worker.
    """
    ny, depth, counter = mesh.shape[1], (mesh.shape[2] + 63) // 64, new_counter()
    for _ in numba.prange(workers):
        work = np.empty((8, 3))
        for _turn in range(first_row, end_row):
            ix = first_row + take(counter)
            if ix >= end_row:
                break
            low, high = columns_in_row(mesh.outline, ix + 0.5)
            if low > high:
                continue
            first, end = max(np.floor(low), float(mesh.box[2])), min(np.ceil(high) + 1.0, float(mesh.box[3]))
            for iy in range(int(first), int(end)):
                base = (ix * ny + iy) * depth
                asked = np.uint64(0)
                for part in range(depth):
                    asked |= keep[base + part] & ~marks[base + part]
                if asked != 0:
                    _mark_column(mesh, bins, ix, iy, keep, marks, work)
