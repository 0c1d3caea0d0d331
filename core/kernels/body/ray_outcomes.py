"""Classify the outcome of every ray of a sensor: the first of a few ends that fits."""

from __future__ import annotations

import numba
import numpy as np

from riglens.core.kernels.rays.cast import BLOCK, Cast, ray_direction, walk_ray
from riglens.core.kernels.runtime.jit import inlined, parallel_kernel
from riglens.core.kernels.voxels.bits import mask_of

CAR, OUTSIDE, GROUND, NOTHING, SHARED, NEW = range(6)
"""Outcomes of a ray: it hits the car; never enters the grid; leaves it through its floor, or otherwise, without an
informative voxel; meets only what others see; meets something new."""
OPEN = -1
"""Outcome left to the walk in rational numbers."""
PROBES, STEP, MARGIN = 48, 8.0, 1e-6
"""Points at which a ray is tried before it is walked, how far apart, and how far from faces a point is certainly in its
voxel; all in grid units."""


@inlined
def _meets(runs: np.ndarray, count: int, depth: int, informative: np.ndarray, others: np.ndarray) -> int:
    """Return NOTHING, SHARED or NEW for the voxels of some runs; informative, others uint64 (words,)."""
    found = NOTHING
    for r in range(count):
        for part in range(runs[r, 1] >> 6, (runs[r, 2] >> 6) + 1):
            word = np.int64(runs[r, 0]) * depth + part
            met = informative[word] & mask_of(runs[r, 1], runs[r, 2], part)
            if met & ~others[word] != 0:
                return NEW
            if met != 0:
                found = SHARED
    return found


@inlined
def ends_at_ground(rays: Cast, ray: int, d: tuple[float, float, float]) -> bool:
    """Return whether a ray passes the floor of the grid, within its sides and its range."""
    if d[2] >= 0.0 or rays.origin[2] < 0.0:
        return False
    t = rays.origin[2] / -d[2]
    x, y = rays.origin[0] + t * d[0], rays.origin[1] + t * d[1]
    far = min(rays.reach[1], rays.ends[ray]) if rays.ends.size > 0 else rays.reach[1]
    return bool(0.0 <= x < rays.shape[0] and 0.0 <= y < rays.shape[1] and t <= far)


@inlined
def _is_new_at_a_glance(rays: Cast, ray: int, informative: np.ndarray, others: np.ndarray) -> bool:
    """Return whether one of a few points along a ray lies in an informative voxel that no other sensor sees.

    The ray then runs in that voxel over a positive length, so the walk is spared; False decides nothing."""
    d = ray_direction(rays, ray)
    depth = (rays.shape[2] + 63) // 64
    far = min(rays.reach[1], rays.ends[ray]) if rays.ends.size > 0 else rays.reach[1]
    for probe in range(PROBES):
        t = rays.reach[0] + (probe + 0.5) * STEP
        if t >= far:
            return False
        x, y, z = rays.origin[0] + t * d[0], rays.origin[1] + t * d[1], rays.origin[2] + t * d[2]
        if 0.0 <= x < rays.shape[0] and 0.0 <= y < rays.shape[1] and 0.0 <= z < rays.shape[2]:
            ix, iy, iz = int(x), int(y), int(z)
            word, bit = (ix * rays.shape[1] + iy) * depth + (iz >> 6), np.uint64(1) << np.uint64(iz & 63)
            if informative[word] & ~others[word] & bit != 0:
                low = min(x - ix, min(y - iy, z - iz))
                high = max(x - ix, max(y - iy, z - iz))
                if low > MARGIN and high < 1.0 - MARGIN:
                    return True
    return False


@inlined
def _outcome(rays: Cast, ray: int, informative: np.ndarray, others: np.ndarray, runs: np.ndarray) -> int:
    if rays.is_stopped.size > 0 and rays.is_stopped[ray]:
        return CAR
    if _is_new_at_a_glance(rays, ray, informative, others):
        return NEW
    count = walk_ray(rays, ray, runs)
    if count <= 0:
        return OUTSIDE if count == 0 else OPEN
    found = _meets(runs, count, (rays.shape[2] + 63) // 64, informative, others)
    return GROUND if found == NOTHING and ends_at_ground(rays, ray, ray_direction(rays, ray)) else found


@parallel_kernel
def follow_rays(
    rays: Cast, informative: np.ndarray, others: np.ndarray, workers: int, outcomes: np.ndarray
) -> None:
    """Write the outcome of each ray, int8 (rays,), whose box is the whole grid and whose `is_stopped` are those that
    meet the car; informative uint64 (words,), and `others`: voxels of the other sensors."""
    blocks = (outcomes.size + BLOCK - 1) // BLOCK
    for worker in numba.prange(workers):
        runs = np.empty((rays.shape[0] + rays.shape[1] + rays.shape[2] + 3, 3), np.int32)
        for block in range(worker, blocks, workers):
            for ray in range(block * BLOCK, min((block + 1) * BLOCK, outcomes.size)):
                outcomes[ray] = _outcome(rays, ray, informative, others, runs)
