"""Cutting a ray lattice into rectangles that the car's body leaves free, and what is left of it.

A lattice of which some rays end at the body is cast in pieces: every piece is a lattice too, each ray is in exactly one
of them, and the voxels that a sensor sees are those that any of its pieces sees. So free pieces may be cast the fast
ways, and the cut is free to follow speed alone.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.cast import Cast

MOST_FREE = 6
SMALLEST_SHARE = 0.02
"""Of all rays: smaller free pieces are not worth their start."""
CELLS = (32, 64)
"""Rectangles are looked for on a mask of at most so many cells, each of some rows and planes."""

Mask = NDArray[np.bool_]


class Patch(NamedTuple):
    """Rows and planes of a lattice: first and end of both."""

    first_row: int
    end_row: int
    first_plane: int
    end_plane: int

    @property
    def ray_count(self) -> int:
        """Number of rays."""
        return (self.end_row - self.first_row) * (self.end_plane - self.first_plane)


def free_patches(free: Mask) -> list[Patch]:
    """Disjoint rectangles of rays that are all free, the largest first; free (rows, planes)."""
    rows, planes = (_cuts(size, cells) for size, cells in zip(free.shape, CELLS, strict=True))
    left = np.logical_and.reduceat(np.logical_and.reduceat(free, rows[:-1], axis=0), planes[:-1], axis=1)
    found: list[Patch] = []
    while len(found) < MOST_FREE and left.any():
        top, bottom, start, end = largest_rectangle(left)
        patch = Patch(int(rows[top]), int(rows[bottom]), int(planes[start]), int(planes[end]))
        if patch.ray_count < SMALLEST_SHARE * free.size:
            break
        found.append(patch)
        left[top:bottom, start:end] = False
    return found


def _cuts(size: int, cells: int) -> NDArray[np.int64]:
    """Where cells of about equal size begin, and the end of the last."""
    return np.linspace(0, size, min(size, cells) + 1).astype(np.int64)


def largest_rectangle(free: Mask) -> Patch:
    """The rectangle of most free cells, of free (rows, columns) with at least one.

    For every pair of rows at once: the longest run of columns that are free between them.
    """
    rows, columns = free.shape
    taken = np.concatenate([np.zeros((1, columns), np.int32), np.cumsum(~free, axis=0, dtype=np.int32)])
    top, last = np.triu_indices(rows)
    is_free = taken[last + 1] == taken[top]
    places = np.arange(1, columns + 1, dtype=np.int32)
    runs = places - np.maximum.accumulate(np.where(is_free, 0, places), axis=1)
    sizes = runs * (last - top + 1).astype(np.int32)[:, None]
    pair, column = divmod(int(np.argmax(sizes)), columns)
    end = column + 1
    return Patch(int(top[pair]), int(last[pair]) + 1, end - int(runs[pair, column]), end)


def patches_between(found: list[Patch], rows: int, planes: int) -> list[Patch]:
    """Disjoint rectangles that hold what disjoint rectangles leave of a lattice."""
    cuts = sorted({0, rows, *(row for patch in found for row in (patch.first_row, patch.end_row))})
    rest: list[Patch] = []
    for first, end in pairwise(cuts):
        here = sorted(p[2:] for p in found if p.first_row <= first and end <= p.end_row)
        starts, ends = [0, *(p[1] for p in here)], [*(p[0] for p in here), planes]
        rest += [Patch(first, end, a, b) for a, b in zip(starts, ends, strict=True) if a < b]
    return rest


def part_of(rays: Cast, patch: Patch) -> Cast:
    """The rays of a patch, with their ends where one of them has one."""
    rows, planes = slice(patch.first_row, patch.end_row), slice(patch.first_plane, patch.end_plane)
    ends = rays.ends
    if ends.size:
        ends = ends.reshape(len(rays.rows), len(rays.planes))[rows, planes].ravel()
    if ends.size and (ends >= rays.reach[1]).all():
        ends = np.zeros(0)
    return rays._replace(rows=rays.rows[rows], planes=rays.planes[planes], ends=ends)


def cut_up(rays: Cast) -> tuple[list[Patch], list[Cast]]:
    """Free patches of a lattice of rays with ends, and the casts of all other rays."""
    rows, planes = len(rays.rows), len(rays.planes)
    found = free_patches((rays.ends >= rays.reach[1]).reshape(rows, planes))
    return found, [part_of(rays, patch) for patch in patches_between(found, rows, planes)]
