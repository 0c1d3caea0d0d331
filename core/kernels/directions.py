"""Directions of a ray lattice in plain numpy: nothing here needs the compiler.

The window draws some rays before the compiler is loaded. `lattice.py` says what the tables mean.
"""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.codes import LIDAR, LISTED


def directions(kind: int, rows: np.ndarray, planes: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """Directions (n, 3) in the sensor frame of the rays `rays` (n,), ray = row * planes + plane.

    The same doubles as the compiled `lattice.direction` gives.
    """
    row, plane = rows[rays // len(planes)], planes[rays % len(planes)]
    if kind == LISTED:
        return np.asarray(row)
    with np.errstate(over="ignore", invalid="ignore"):  # as in compiled code, which never warns
        if kind == LIDAR:
            return np.stack([row[:, 0] * plane[:, 0], row[:, 0] * plane[:, 1], row[:, 1]], axis=1)
        y, z = plane[:, 0], row[:, 0]
        norm = np.sqrt(1.0 + y * y + z * z)
        return np.stack([1.0 / norm, y / norm, z / norm], axis=1)
