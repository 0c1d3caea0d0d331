"""Rays of a fan that are walked one by one: those that planes leave to the exact walk.

A separate kernel: inlined into the walk of planes, the exact walk took longer to compile than all the rest.
"""

from __future__ import annotations

import numba
import numpy as np

from riglens.core.kernels.fans.planes import ALL, Fan, Space
from riglens.core.kernels.rays.lattice import direction, rotated
from riglens.core.kernels.rays.walk import Ray, walk_exact
from riglens.core.kernels.runtime.jit import kernel, parallel_kernel
from riglens.core.kernels.voxels.bits import mark_levels


@kernel
def _walk_listed(fan: Fan, space: Space, rays: np.ndarray, marks: np.ndarray) -> None:
    """Walk the rays that one worker has noted, int32 (n, 6) as in `kernels.fans.planes.LeftoverRays`, exactly, unless
    they are stopped, and mark the voxels that they meet."""
    runs = np.empty((space.shape[0] + space.shape[1] + 3, 3), np.int32)
    g, box = (space.origin[0], space.origin[1], space.origin[2]), space.box.copy()
    rows, planes, depth = fan.rows.shape[0], fan.planes.shape[0], (space.shape[2] + 63) // 64
    for i in range(rays.shape[0]):
        plane, noted = rays[i, 0], rays[i, 1]
        for side in range(4):
            box[side] = rays[i, 2 + side]
        for row in range(max(noted, 0), rows if noted == ALL else noted + 1):
            if fan.is_stopped.size > 0 and fan.is_stopped[row * planes + plane]:
                continue
            d = rotated(space.rotation, direction(fan.kind, fan.rows[row], fan.planes[plane]))
            for r in range(walk_exact(Ray(g, d, fan.reach[0], fan.reach[1]), box, space.shape[1], runs)):
                mark_levels(marks, np.int64(runs[r, 0]) * depth, np.int64(runs[r, 1]), np.int64(runs[r, 2]))


@parallel_kernel
def mark_alone(fan: Fan, space: Space, rays: np.ndarray, counts: np.ndarray, marks: np.ndarray) -> None:
    """Mark the voxels that the rays noted traverse; rays (workers, most, 6) and counts (workers,) as each worker left
    them, which walks them in its own rows of the grid; marks uint64 (words,)."""
    for worker in numba.prange(counts.size):
        _walk_listed(fan, space, rays[worker, : counts[worker]], marks)
