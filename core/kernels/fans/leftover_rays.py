"""Rays of a fan that are walked one by one: those that planes leave to the exact walk.

A separate kernel: inlined into the walk of planes, the exact walk took longer to compile than all the rest.
"""

from __future__ import annotations

import numba
import numpy as np

from riglens.core.kernels.fans.planes import ALL
from riglens.core.kernels.rays.cast import Cast, direction_at
from riglens.core.kernels.rays.walk import Ray, walk_exact
from riglens.core.kernels.runtime.jit import kernel, parallel_kernel
from riglens.core.kernels.voxels.bits import mark_levels


@kernel
def _walk_listed(rays: Cast, listed: np.ndarray, marks: np.ndarray) -> None:
    """Walk the rays that one worker has noted, int32 (n, 6) as in `kernels.fans.planes.LeftoverRays`, exactly, unless
    they are stopped, and mark the voxels that they meet."""
    runs = np.empty((rays.shape[0] + rays.shape[1] + 3, 3), np.int32)
    g, box = (rays.origin[0], rays.origin[1], rays.origin[2]), rays.box.copy()
    rows, planes, depth = rays.rows.shape[0], rays.planes.shape[0], (rays.shape[2] + 63) // 64
    for i in range(listed.shape[0]):
        plane, noted = listed[i, 0], listed[i, 1]
        for side in range(4):
            box[side] = listed[i, 2 + side]
        for row in range(max(noted, 0), rows if noted == ALL else noted + 1):
            if rays.is_stopped.size > 0 and rays.is_stopped[row * planes + plane]:
                continue
            ray = Ray(g, direction_at(rays, row, plane), rays.reach[0], rays.reach[1])
            for r in range(walk_exact(ray, box, rays.shape[1], runs)):
                mark_levels(marks, np.int64(runs[r, 0]) * depth, np.int64(runs[r, 1]), np.int64(runs[r, 2]))


@parallel_kernel
def mark_alone(rays: Cast, listed: np.ndarray, counts: np.ndarray, marks: np.ndarray) -> None:
    """Mark the voxels that the rays noted traverse; listed (workers, most, 6) and counts (workers,) as each worker left
    them, which walks them in its own rows of the grid; marks uint64 (words,)."""
    for worker in numba.prange(counts.size):
        _walk_listed(rays, listed[worker, : counts[worker]], marks)
