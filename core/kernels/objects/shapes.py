"""Intersect a ray with one object, in the object's own axes."""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.rays.lattice import Direction
from riglens.core.kernels.rays.predicates import Vector
from riglens.core.kernels.runtime.jit import lean_inlined


@lean_inlined
def turned_into(rotation: np.ndarray, v: Direction) -> Direction:
    """Return R^T v: a direction in the axes of an object of rotation (3, 3); summed from left to right."""
    return (
        (rotation[0, 0] * v[0] + rotation[1, 0] * v[1]) + rotation[2, 0] * v[2],
        (rotation[0, 1] * v[0] + rotation[1, 1] * v[1]) + rotation[2, 1] * v[2],
        (rotation[0, 2] * v[0] + rotation[1, 2] * v[1]) + rotation[2, 2] * v[2],
    )


@lean_inlined
def is_inside(start: Vector, half: np.ndarray) -> bool:
    """Return whether a point is in a box or on its surface."""
    return bool(abs(start[0]) <= half[0] and abs(start[1]) <= half[1] and abs(start[2]) <= half[2])
