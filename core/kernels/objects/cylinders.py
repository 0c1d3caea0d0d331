"""Intersect rays with upright cylinders: objects near the car."""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.rays.cast import Cast, ray_direction
from riglens.core.kernels.rays.predicates import Vector
from riglens.core.kernels.runtime.jit import inlined, kernel


@inlined
def _stay_in(o: Vector, d: Vector, cylinder: np.ndarray, near: float, far: float) -> tuple[float, float]:
    """Return the part of a ray inside of an upright cylinder (5,): x, y, radius, bottom, top; empty when first >=
    second."""
    x, y = o[0] - cylinder[0], o[1] - cylinder[1]
    a, b = d[0] * d[0] + d[1] * d[1], x * d[0] + y * d[1]
    c = x * x + y * y - cylinder[2] * cylinder[2]
    if a > 0.0:
        inner = b * b - a * c
        if inner <= 0.0:
            return np.inf, -np.inf
        root = np.sqrt(inner)
        near, far = max(near, (-b - root) / a), min(far, (-b + root) / a)
    elif c >= 0.0:
        return np.inf, -np.inf
    if d[2] != 0.0:
        low, high = (cylinder[3] - o[2]) / d[2], (cylinder[4] - o[2]) / d[2]
        near, far = max(near, min(low, high)), min(far, max(low, high))
    elif not cylinder[3] <= o[2] <= cylinder[4]:
        return np.inf, -np.inf
    return near, far


@kernel
def count_on_cylinders(rays: Cast, cylinders: np.ndarray, cones: np.ndarray, counts: np.ndarray) -> None:
    """Count the rays, in metres, that meet each upright cylinder alone, over a positive length within their range.

    cylinders (m, 5): x, y, radius, bottom, top; cones (m, 4): unit direction from the sensor to the middle of each,
    and a cosine below which no ray can meet it. Written to counts int64 (m, 2): rays that get there before they end
    (`rays.ends`, metres, or none of them ends), and rays that would if nothing of the car stopped them.
    """
    o = (rays.origin[0], rays.origin[1], rays.origin[2])
    for ray in range(rays.rows.shape[0] * rays.planes.shape[0]):
        d = ray_direction(rays, ray)
        for k in range(cylinders.shape[0]):
            if d[0] * cones[k, 0] + d[1] * cones[k, 1] + d[2] * cones[k, 2] < cones[k, 3]:
                continue
            near, far = _stay_in(o, d, cylinders[k], rays.reach[0], rays.reach[1])
            if near < far:
                counts[k, 1] += 1
                if rays.ends.size == 0 or near < rays.ends[ray]:
                    counts[k, 0] += 1
