"""Where a ray meets one road user, in the object's own axes."""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.jit import inlined
from riglens.core.kernels.lattice import Direction
from riglens.core.kernels.predicates import Vector

MISSED = np.inf


@inlined
def turned_into(rotation: np.ndarray, v: Direction) -> Direction:
    """R^T v: a direction in the axes of an object whose rotation (3, 3) leads from them; summed from left to right."""
    return (
        (rotation[0, 0] * v[0] + rotation[1, 0] * v[1]) + rotation[2, 0] * v[2],
        (rotation[0, 1] * v[0] + rotation[1, 1] * v[1]) + rotation[2, 1] * v[2],
        (rotation[0, 2] * v[0] + rotation[1, 2] * v[1]) + rotation[2, 2] * v[2],
    )


@inlined
def _slab(start: float, along: float, half: float, t0: float, t1: float) -> tuple[float, float]:
    """The part of (t0, t1) between two faces; empty (t0 >= t1) when there is none. A face itself is outside."""
    if along == 0.0:
        return (t0, t1) if -half < start < half else (np.inf, -np.inf)
    a, b = (-half - start) / along, (half - start) / along
    return max(t0, min(a, b)), min(t1, max(a, b))


@inlined
def enter_box(start: Vector, along: Direction, half: np.ndarray, near: float, far: float) -> float:
    """Distance at which a ray, cut to near..far, enters a box over a positive length; MISSED when it does not.

    A ray that only touches a face, an edge or a corner misses it.
    """
    t0, t1 = _slab(start[0], along[0], half[0], near, far)
    t0, t1 = _slab(start[1], along[1], half[1], t0, t1)
    t0, t1 = _slab(start[2], along[2], half[2], t0, t1)
    return t0 if t0 < t1 else MISSED


@inlined
def is_inside(start: Vector, half: np.ndarray) -> bool:
    """Whether a point stands in a box or on its surface."""
    return bool(abs(start[0]) <= half[0] and abs(start[1]) <= half[1] and abs(start[2]) <= half[2])
