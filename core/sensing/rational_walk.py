"""Walk a single ray in rational arithmetic, for rays whose numbers are too small or large for the kernels.

Directions with components below 2^-300 arise only from denormal angles; being right there costs a few
milliseconds a ray and keeps the word "exact" true for any input.
"""

from __future__ import annotations

import math
from fractions import Fraction

Cell = tuple[int, int, int]


def _clip(
    g: list[Fraction], d: list[Fraction], t0: Fraction, t1: Fraction, box: list[int]
) -> tuple[Fraction, Fraction]:
    for axis in range(3):
        low, high = box[2 * axis], box[2 * axis + 1]
        if d[axis] == 0:
            if not low <= math.floor(g[axis]) < high:
                return t1, t1
            continue
        first, last = sorted(((low - g[axis]) / d[axis], (high - g[axis]) / d[axis]))
        t0, t1 = max(t0, first), min(t1, last)
    return t0, t1


def walk_rational(
    origin: tuple[float, float, float],
    direction: tuple[float, float, float],
    near: float,
    far: float,
    box: list[int],
) -> list[Cell]:
    """Return voxels in which a ray runs over a positive length; arguments as in `kernels.rays.walk.walk_exact`."""
    g, d = [Fraction(v) for v in origin], [Fraction(v) for v in direction]
    t0, t1 = _clip(g, d, Fraction(near), Fraction(far), box)
    cells: list[Cell] = []
    while t0 < t1:
        cell, leave = [0, 0, 0], t1
        for axis in range(3):
            p = g[axis] + d[axis] * t0
            cell[axis] = math.ceil(p) - 1 if d[axis] < 0 else math.floor(p)
            if d[axis] != 0:
                face = cell[axis] + (1 if d[axis] > 0 else 0)
                leave = min(leave, (face - g[axis]) / d[axis])
        cells.append((cell[0], cell[1], cell[2]))
        t0 = leave
    return cells
