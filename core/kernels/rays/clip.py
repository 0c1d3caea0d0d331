"""Clip convex polygons by planes (Sutherland and Hodgman, 1974)."""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.runtime.jit import kernel


@kernel
def _cut(source: np.ndarray, count: int, plane: np.ndarray, target: np.ndarray) -> int:
    """Clip a polygon to the part above a plane; return its number of corners."""
    kept = 0
    for i in range(count):
        j = (i + 1) % count
        a, b = plane[3], plane[3]
        for axis in range(3):
            a += plane[axis] * source[i, axis]
            b += plane[axis] * source[j, axis]
        if a >= 0.0:
            for axis in range(3):
                target[kept, axis] = source[i, axis]
            kept += 1
        if (a >= 0.0) != (b >= 0.0):
            for axis in range(3):
                target[kept, axis] = source[i, axis] + (source[j, axis] - source[i, axis]) * (a / (a - b))
            kept += 1
    return kept


@kernel
def clip_polygons(polygons: np.ndarray, planes: np.ndarray, clipped: np.ndarray, counts: np.ndarray) -> None:
    """Clip convex polygons (n, k, 3) to where a x + b y + c z + d >= 0 for all planes (m, 4).

    clipped (n, k + m, 3) and counts (n,) take the result; 0 corners where nothing is left.
    """
    most = clipped.shape[1]
    buffers = np.empty((2, most, 3))
    for n in range(polygons.shape[0]):
        count, held = polygons.shape[1], 0
        for i in range(count):
            for axis in range(3):
                buffers[0, i, axis] = polygons[n, i, axis]
        for m in range(planes.shape[0]):
            count = _cut(buffers[held], count, planes[m], buffers[1 - held])
            held = 1 - held
        counts[n] = count if count >= 3 else 0
        for i in range(counts[n]):
            for axis in range(3):
                clipped[n, i, axis] = buffers[held, i, axis]
