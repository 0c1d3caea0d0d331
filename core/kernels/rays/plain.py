"""The straightforward ways, kept as yardsticks: rays through a dense grid of bytes, one thread, one sum.

Amanatides and Woo (1987), voxel by voxel, times summed up step by step; rounding decides its ties. And points on each
ray at even distances.
"""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.runtime.jit import inlined, kernel


@inlined
def _between(
    g: np.ndarray, d: np.ndarray, near: float, far: float, shape: tuple[int, int, int]
) -> tuple[float, float]:
    """Return the t at which a ray enters and leaves the grid, within its range; it misses unless the second is
    larger."""
    real = g.dtype.type
    t0, t1 = real(near), real(far)
    for axis in range(3):
        o, along, n = g[axis], d[axis], shape[axis]
        if along == real(0.0):
            if o < real(0.0) or o >= real(n):
                t1 = real(-1.0)
        else:
            first, second = -o / along, (real(n) - o) / along
            t0, t1 = max(t0, min(first, second)), min(t1, max(first, second))
    return t0, t1


@kernel
def walk_dense(
    g: np.ndarray, directions: np.ndarray, near: float, far: float, flag: int, seen: np.ndarray
) -> None:
    """Set every voxel that a ray visits to `flag`.

    g (3,) origin in grid units; directions (n, 3) of the same float type, in which all times are computed;
    near, far: range in units of the direction; seen: uint8 (nx, ny, nz).
    """
    real = g.dtype.type
    bit = np.uint8(flag)
    nx, ny, nz = seen.shape
    endless = far == np.inf
    for r in range(directions.shape[0]):
        dx, dy, dz = directions[r, 0], directions[r, 1], directions[r, 2]
        t0, t1 = _between(g, directions[r], near, far, seen.shape)
        if t1 <= t0:
            continue
        ix = min(max(int(np.floor(g[0] + t0 * dx)), 0), nx - 1)
        iy = min(max(int(np.floor(g[1] + t0 * dy)), 0), ny - 1)
        iz = min(max(int(np.floor(g[2] + t0 * dz)), 0), nz - 1)
        sx, sy, sz = (1 if dx > 0 else -1), (1 if dy > 0 else -1), (1 if dz > 0 else -1)
        px = (real(ix + (dx > 0)) - g[0]) / dx if dx != 0 else real(np.inf)
        py = (real(iy + (dy > 0)) - g[1]) / dy if dy != 0 else real(np.inf)
        pz = (real(iz + (dz > 0)) - g[2]) / dz if dz != 0 else real(np.inf)
        qx, qy, qz = abs(real(1.0) / dx), abs(real(1.0) / dy), abs(real(1.0) / dz)
        while True:
            seen[ix, iy, iz] = bit
            if not endless and min(px, py, pz) >= t1:
                break
            if px < py and px < pz:
                ix += sx
                if ix < 0 or ix >= nx:
                    break
                px += qx
            elif py < pz:
                iy += sy
                if iy < 0 or iy >= ny:
                    break
                py += qy
            else:
                iz += sz
                if iz < 0 or iz >= nz:
                    break
                pz += qz


@kernel
def walk_sampled(
    g: np.ndarray, directions: np.ndarray, near: float, far: float, step: float, seen: np.ndarray
) -> None:
    """Set every voxel to 1 that holds one of the points of a ray at near, near + step, near + 2 step ...

    Arguments as for `walk_dense`, the step in units of the direction. Whatever is set, a ray passes through; what it
    cuts by less than a step may be left out.
    """
    nx, ny, nz = seen.shape
    for r in range(directions.shape[0]):
        dx, dy, dz = directions[r, 0], directions[r, 1], directions[r, 2]
        t0, t1 = _between(g, directions[r], near, far, seen.shape)
        number = np.ceil((t0 - near) / step)
        t = near + number * step
        while t < t1:
            ix, iy, iz = (
                int(np.floor(g[0] + t * dx)),
                int(np.floor(g[1] + t * dy)),
                int(np.floor(g[2] + t * dz)),
            )
            if 0 <= ix < nx and 0 <= iy < ny and 0 <= iz < nz:
                seen[ix, iy, iz] = 1
            number += 1.0
            t = near + number * step


@kernel
def sum_dense(seen: np.ndarray, h: np.ndarray, sums: np.ndarray) -> None:
    """Add the entropies h (voxels, 3) of seen voxels to sums (3, 3), in one pass that skips eight unseen voxels at a
    time.

    seen: uint8 (2, voxels) by cameras and by LiDARs; rows of the sums: camera, LiDAR, any; columns: classes.
    """
    voxels = seen.shape[1]
    whole = voxels - voxels % 8
    cameras, lidars = seen[0, :whole].view(np.uint64), seen[1, :whole].view(np.uint64)
    for eight in range(whole // 8):
        if cameras[eight] | lidars[eight] != 0:
            for i in range(8 * eight, 8 * eight + 8):
                _add(seen[0, i], seen[1, i], h[i], sums)
    for i in range(whole, voxels):
        _add(seen[0, i], seen[1, i], h[i], sums)


@inlined
def _add(camera: int, lidar: int, h: np.ndarray, sums: np.ndarray) -> None:
    """Add the entropies h (3,) of one voxel to the rows of those that see it."""
    if not (camera or lidar):
        return
    for c in range(3):
        if camera:
            sums[0, c] += h[c]
        if lidar:
            sums[1, c] += h[c]
        sums[2, c] += h[c]
