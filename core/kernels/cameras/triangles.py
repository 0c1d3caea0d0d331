"""Measure the triangles that join the neighbouring rays of a lens."""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.runtime.jit import kernel, lean_inlined

SIZES = 6
"""Figures of triangles: radius, steps along three axes, widths along two axes of the image plane."""


@lean_inlined
def _include(
    rows: np.ndarray, a: int, b: int, c: int, longest: float, sizes: np.ndarray
) -> tuple[bool, bool]:
    """Widen the sizes by a triangle of rays unless a side is longer than that; return whether it turns left seen from
    outside, and whether it counts."""
    ab = (rows[a, 0] - rows[b, 0], rows[a, 1] - rows[b, 1], rows[a, 2] - rows[b, 2])
    bc = (rows[b, 0] - rows[c, 0], rows[b, 1] - rows[c, 1], rows[b, 2] - rows[c, 2])
    ca = (rows[c, 0] - rows[a, 0], rows[c, 1] - rows[a, 1], rows[c, 2] - rows[a, 2])
    nx, ny, nz = ca[1] * ab[2] - ca[2] * ab[1], ca[2] * ab[0] - ca[0] * ab[2], ca[0] * ab[1] - ca[1] * ab[0]
    if not nx * rows[a, 0] + ny * rows[a, 1] + nz * rows[a, 2] > 0.0:
        return False, False
    one = ab[0] * ab[0] + ab[1] * ab[1] + ab[2] * ab[2]
    two = bc[0] * bc[0] + bc[1] * bc[1] + bc[2] * bc[2]
    three = ca[0] * ca[0] + ca[1] * ca[1] + ca[2] * ca[2]
    most = max(one, max(two, three))
    if most > longest * longest:
        return True, False
    if 2.0 * most >= one + two + three:  # obtuse: the ball around its longest side
        radius = 0.5 * np.sqrt(most)
    else:
        radius = np.sqrt(one * two * three / (nx * nx + ny * ny + nz * nz)) / 2.0
    sizes[0] = max(sizes[0], radius)
    for axis in range(3):
        sizes[1 + axis] = max(sizes[1 + axis], 0.5 * (abs(bc[axis]) + abs(ca[axis])))
    for axis in range(1, 3):
        at, on, off = rows[a, axis] / rows[a, 0], rows[b, axis] / rows[b, 0], rows[c, axis] / rows[c, 0]
        sizes[3 + axis] = max(sizes[3 + axis], max(at, max(on, off)) - min(at, min(on, off)))
    return True, True


@kernel
def measure_triangles(
    rows: np.ndarray,
    numbers: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    longest: float,
    sizes: np.ndarray,
) -> bool:
    """Take out the triangles between rays with a side longer than that, and measure the others; return whether none is
    turned over. sizes (SIZES,), with 0 before, are the largest: radius of a ball around a triangle, half the sum of the
    two steps from its last corner along each axis, and width along both axes of the image plane at x = 1.

    rows (n, 3): directions; numbers (i, j): of rays by row and column; lower, upper (i - 1, j - 1): which triangles
    there are between four rays, that below the diagonal from the first one, and that above it.
    """
    for i in range(lower.shape[0]):
        for j in range(lower.shape[1]):
            first, last, turns_left = numbers[i, j], numbers[i + 1, j + 1], True
            if lower[i, j]:
                turns_left, lower[i, j] = _include(rows, first, last, numbers[i + 1, j], longest, sizes)
            if turns_left and upper[i, j]:
                turns_left, upper[i, j] = _include(rows, last, first, numbers[i, j + 1], longest, sizes)
            if not turns_left:
                return False
    return True
