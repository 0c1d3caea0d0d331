"""Compute directions of a ray lattice on demand from one table per row and one per column (plane).

LiDAR: row (cos e, sin e), plane (cos a, sin a), direction (cos e cos a, cos e sin a, sin e).
Camera: row (z, 0), plane (y, 0) on the image plane x = 1, direction (1, y, z) / sqrt(1 + y^2 + z^2).
Listed: row (x, y, z) is the direction itself, and there is one plane, which is not looked at.
"""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.runtime.codes import LIDAR, LISTED
from riglens.core.kernels.runtime.jit import lean_inlined

Direction = tuple[float, float, float]


@lean_inlined
def direction(kind: int, row: np.ndarray, plane: np.ndarray) -> Direction:
    """Return the unit direction in the sensor frame."""
    if kind == LIDAR:
        return row[0] * plane[0], row[0] * plane[1], row[1]
    if kind == LISTED:
        return row[0], row[1], row[2]
    y, z = plane[0], row[0]
    norm = np.sqrt(1.0 + y * y + z * z)
    return 1.0 / norm, y / norm, z / norm


@lean_inlined
def rotated(rotation: np.ndarray, d: Direction) -> Direction:
    """Return R d, summed from left to right."""
    return (
        (rotation[0, 0] * d[0] + rotation[0, 1] * d[1]) + rotation[0, 2] * d[2],
        (rotation[1, 0] * d[0] + rotation[1, 1] * d[1]) + rotation[1, 2] * d[2],
        (rotation[2, 0] * d[0] + rotation[2, 1] * d[1]) + rotation[2, 2] * d[2],
    )


@lean_inlined
def rotated_back(rotation: np.ndarray, v: Direction) -> Direction:
    """Return R^T v, summed from left to right: what is in the outer frame as the inner one has it."""
    return (
        (rotation[0, 0] * v[0] + rotation[1, 0] * v[1]) + rotation[2, 0] * v[2],
        (rotation[0, 1] * v[0] + rotation[1, 1] * v[1]) + rotation[2, 1] * v[2],
        (rotation[0, 2] * v[0] + rotation[1, 2] * v[1]) + rotation[2, 2] * v[2],
    )
