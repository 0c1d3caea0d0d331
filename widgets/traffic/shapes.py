"""Simple solids by class, in a box of size 1 around the origin: x ahead, y to the left, z up.

For display only: `riglens.core.targets` defines the counted shapes.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Solid = tuple[NDArray[np.float64], NDArray[np.int64]]
"""Corners (k, 3) and triangles (t, 3)."""

_CAR = (
    (-0.5, -0.38), (-0.5, 0.08), (-0.44, 0.14), (-0.3, 0.5), (0.1, 0.5), (0.27, 0.12), (0.47, 0.02), (0.5, -0.1),
    (0.5, -0.38),
)  # fmt: skip
_RIDER = (
    (-0.5, -0.5), (-0.5, -0.12), (-0.2, 0.05), (-0.12, 0.42), (0.02, 0.5), (0.12, 0.42), (0.16, 0.1), (0.5, -0.12),
    (0.5, -0.5),
)  # fmt: skip
_PERSON = (
    (-0.32, -0.5), (-0.5, 0.1), (-0.4, 0.3), (-0.18, 0.34), (-0.2, 0.46), (0.0, 0.5), (0.2, 0.46), (0.18, 0.34),
    (0.4, 0.3), (0.5, 0.1), (0.32, -0.5),
)  # fmt: skip
_BOX = ((-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5))
_PROFILES = (_CAR, _RIDER, _PERSON, _BOX)
"""Outlines from the side (x, z), by class; the last one for everything else."""
_INSET = (0.86, 0.7, 0.8, 1.0)
"""Width of the upper edge as a part of the box's."""


@lru_cache(maxsize=8)
def shape_of(cls: int) -> Solid:
    """Return the solid of a class by its index, a box by default."""
    kind = min(cls, len(_PROFILES) - 1)
    outline = np.array(_PROFILES[kind])
    half = 0.5 * (1.0 + (_INSET[kind] - 1.0) * np.clip(2.0 * outline[:, 1], 0.0, 1.0))
    left = np.stack([outline[:, 0], half, outline[:, 1]], axis=1)
    right = left * (1.0, -1.0, 1.0)
    count = len(outline)
    here = np.arange(count)
    there = np.roll(here, -1)
    sides = np.concatenate(
        [
            np.stack([here, there, there + count], axis=1),
            np.stack([here, there + count, here + count], axis=1),
        ]
    )
    face = _filled(outline)
    return np.concatenate([left, right]), np.concatenate([sides, face, face[:, ::-1] + count])


def _filled(outline: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return triangles (k - 2, 3) that fill a simple outline (k, 2), by cutting off ears."""
    left, found = list(range(len(outline))), []
    sign = np.sign(_area(outline))
    while len(left) > 3:
        for place in range(len(left)):
            a, b, c = left[place - 1], left[place], left[(place + 1) % len(left)]
            if _is_ear(outline, left, (a, b, c), sign):
                found.append((a, b, c))
                left.pop(place)
                break
        else:
            break
    return np.array([*found, tuple(left[:3])], np.int64)


def _area(outline: NDArray[np.float64]) -> float:
    x, z = outline[:, 0], outline[:, 1]
    return float((x * np.roll(z, -1) - np.roll(x, -1) * z).sum())


def _is_ear(outline: NDArray[np.float64], left: list[int], corner: tuple[int, int, int], sign: float) -> bool:
    """Return whether a corner sticks out and holds no other corner."""
    a, b, c = (outline[number] for number in corner)
    if _area(np.array([a, b, c])) * sign <= 0.0:
        return False
    others = [outline[number] for number in left if number not in corner]
    return not any(_is_within(point, a, b, c, sign) for point in others)


def _is_within(
    point: NDArray[np.float64],
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    c: NDArray[np.float64],
    sign: float,
) -> bool:
    return all(_area(np.array([p, q, point])) * sign >= 0.0 for p, q in ((a, b), (b, c), (c, a)))
