"""Rotate a sensor that is put on a surface, from the outward unit normal (3,) in the vehicle frame."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Vec3, rpy_deg_from_rotation

Doubles = NDArray[np.float64]
_STEEP = math.sin(math.radians(50.0))
_FLAT = 0.2


def upright_rpy_deg(normal: Doubles) -> Vec3:
    """Return angles upright on the surface: z along the normal, x as near to the car's x axis as possible."""
    up = np.asarray(normal, dtype=np.float64)
    ahead = np.array([1.0, 0.0, 0.0])
    if abs(float(up @ ahead)) > 0.99:  # on the very front or rear: its x axis looks down or up
        ahead = np.array([0.0, 0.0, -math.copysign(1.0, float(up[0]))])
    left = np.cross(up, ahead)
    left /= np.linalg.norm(left)
    return rpy_deg_from_rotation(np.stack([np.cross(left, up), left, up], axis=1))


def outwards_rpy_deg(normal: Doubles) -> Vec3:
    """Return angles that look along the normal with a level horizon; where the normal rises by more than 50 degrees,
    as on a roof, a bonnet or a windscreen, angles that are level and look the way the surface falls, ahead on a flat
    one."""
    x, y, z = (float(value) for value in normal)
    flat = math.hypot(x, y)
    if abs(z) > _STEEP:
        return (0.0, 0.0, math.degrees(math.atan2(y, x)) if flat > _FLAT else 0.0)
    return (0.0, math.degrees(math.atan2(-z, flat)), math.degrees(math.atan2(y, x)))
