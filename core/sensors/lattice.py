"""Tables from which the directions of a sensor's rays follow, in its own frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.runtime import codes

Ids = NDArray[np.int64]
MAX_LISTED_RAYS = 1 << 23
"""Rays that do not form a table of rows and columns (lens distortion, azimuth offsets) are stored one by one."""


@dataclass(frozen=True)
class Lattice:
    """Tables from which the directions of a sensor's rays follow, ray = row * planes + plane.

    rows (r, 2): a LiDAR's beams, a camera's image rows; planes (p, 2): azimuths or image columns. Lens distortion
    and azimuth offsets do not fit such tables: rows (n, 3) are then the directions themselves, of the rays that
    exist (see `kernels.rays.lattice`): those at which `exists` (rays of the whole lattice,) is set. limits_m: where
    each ray ends sooner than the sensor's range, metres; (0,) where none does.
    """

    kind: int
    rows: NDArray[np.float64]
    planes: NDArray[np.float64]
    exists: NDArray[np.bool_] | None = None
    limits_m: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))

    def directions(self, rays: Ids | None = None) -> NDArray[np.float64]:
        """Return the directions in the sensor frame of all rays, or of some by number, (n, 3).

        The same doubles as the compiled `kernels.rays.lattice.direction` gives, which says what the tables mean;
        in plain numpy, because the window draws some rays before the compiler is loaded.
        """
        if rays is None and self.kind == codes.LISTED:
            return self.rows
        every = np.arange(len(self.rows) * len(self.planes)) if rays is None else rays
        row, plane = self.rows[every // len(self.planes)], self.planes[every % len(self.planes)]
        if self.kind == codes.LISTED:
            return np.asarray(row)
        with np.errstate(over="ignore", invalid="ignore"):  # as in compiled code, which never warns
            if self.kind == codes.LIDAR:
                return np.stack([row[:, 0] * plane[:, 0], row[:, 0] * plane[:, 1], row[:, 1]], axis=1)
            y, z = plane[:, 0], row[:, 0]
            norm = np.sqrt(1.0 + y * y + z * z)
            return np.stack([1.0 / norm, y / norm, z / norm], axis=1)
