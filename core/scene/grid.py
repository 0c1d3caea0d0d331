"""The voxel grid over the region of interest (ROI): half-open cubes of edge delta around the ego car."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import psutil
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.geometry import Vec3

DEFAULT_ROI_M = (60.0, 40.0, 4.0)
DEFAULT_VOXEL_M = 0.10
MIN_VOXEL_M, MAX_VOXEL_M = 1e-4, 1e3
MAX_SIDE_M = 1e5
MAX_COLUMNS = 1 << 31
"""The kernels number columns (x, y) in 32 bits."""
MAX_VOXELS = 1 << 40
_DIVIDES_TOLERANCE = 1e-6


@dataclass(frozen=True)
class VoxelGrid:
    """ROI x in [-L/2, L/2), y in [-W/2, W/2), z in [0, H), cut into cubes of edge `voxel_m` (metres).

    Raises InputError when a number is not positive or out of the limits, when delta does not divide the ROI (no half
    voxels: the stated ROI is exactly what is computed) or when the index would overflow.
    """

    voxel_m: float = DEFAULT_VOXEL_M
    roi_m: Vec3 = DEFAULT_ROI_M

    def __post_init__(self) -> None:
        if not MIN_VOXEL_M <= self.voxel_m <= MAX_VOXEL_M:
            why = ": the grid would be too large" if 0.0 < self.voxel_m < MIN_VOXEL_M else ""
            limits = f"between {MIN_VOXEL_M:g} and {MAX_VOXEL_M:g} m"
            raise InputError(f"must be {limits} (got {self.voxel_m}){why}", "voxel_m")
        for name, length in zip("LWH", self.roi_m, strict=True):
            self._check_side(name, length)
        nx, ny, nz = self.shape
        if nx * ny >= MAX_COLUMNS or nx * ny * nz >= MAX_VOXELS:
            raise InputError(
                f"makes a grid of {nx} x {ny} x {nz} voxels, which is too large: use larger voxels or a smaller ROI",
                "voxel_m",
            )

    def _check_side(self, name: str, length: float) -> None:
        if not 0.0 < length <= MAX_SIDE_M:
            raise InputError(f"{name} must be above 0 and at most {MAX_SIDE_M:g} m (got {length})", "roi_m")
        count = length / self.voxel_m
        whole = round(count)
        if whole < 1 or abs(count - whole) > _DIVIDES_TOLERANCE * max(1.0, whole) ** 0.5:
            near = max(1, whole) * self.voxel_m
            raise InputError(
                f"{name} must be a multiple of the voxel edge {self.voxel_m:g} m, such as {near:g} m (got {length:g})",
                "roi_m",
            )

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of voxels along x, y, z."""
        nx, ny, nz = (round(length / self.voxel_m) for length in self.roi_m)
        return nx, ny, nz

    @property
    def origin_m(self) -> Vec3:
        """Lower corner of voxel (0, 0, 0) in the vehicle frame, metres."""
        return -self.roi_m[0] / 2, -self.roi_m[1] / 2, 0.0

    @property
    def voxel_count(self) -> int:
        """Number of voxels of the ROI."""
        return math.prod(self.shape)

    def to_grid(self, position_m: Vec3) -> Vec3:
        """Return grid coordinates (x - x_min) / delta in double precision; a face is where the quotient is an
        integer."""
        x, y, z = ((p - o) / self.voxel_m for p, o in zip(position_m, self.origin_m, strict=True))
        return x, y, z

    def centres_m(self, axis: int) -> NDArray[np.float64]:
        """Return the voxel centre coordinates along one axis, (shape[axis],), metres."""
        cells = np.arange(self.shape[axis], dtype=np.float64)
        return self.origin_m[axis] + (cells + 0.5) * self.voxel_m

    def require_memory(self, bytes_per_voxel: float, purpose: str) -> None:
        """Raise InputError with the size when that much memory is not available."""
        needed = self.voxel_count * bytes_per_voxel
        available = psutil.virtual_memory().available
        if needed > available:
            nx, ny, nz = self.shape
            raise InputError(
                f"voxel {self.voxel_m:g} m: a grid of {nx} x {ny} x {nz} voxels needs {needed / 1e9:.1f} GB for "
                f"{purpose}, but {available / 1e9:.1f} GB are free; use larger voxels or a smaller ROI"
            )
