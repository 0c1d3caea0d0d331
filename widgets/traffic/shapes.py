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
_FACES = (
    ((8, 0, 1), (8, 1, 2), (8, 2, 3), (3, 4, 5), (8, 3, 5), (8, 5, 6), (6, 7, 8)),
    ((8, 0, 1), (8, 1, 2), (8, 2, 3), (3, 4, 5), (3, 5, 6), (8, 3, 6), (6, 7, 8)),
    (
        (10, 0, 1), (10, 1, 2), (10, 2, 3), (10, 3, 4), (10, 4, 5), (5, 6, 7), (10, 5, 7), (10, 7, 8), (8, 9, 10),
    ),
    ((3, 0, 1), (1, 2, 3)),
)  # fmt: skip
"""Triangles that fill each outline, by the numbers of its corners."""
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
    face = np.array(_FACES[kind])
    return np.concatenate([left, right]), np.concatenate([sides, face, face[:, ::-1] + count])
