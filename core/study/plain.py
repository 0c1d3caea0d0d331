"""Plain DDA as a whole evaluation: what the engine is measured against, in the studies and the benchmarks."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels import plain
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scoring import KINDS
from riglens.core.rig.model import Camera, Lidar
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.rays import sensor_rays

FLAGS = {kind: 1 << number for number, kind in enumerate(KINDS)}
"""The bit of a kind of sensor in a byte per informative voxel."""
BYTES_PER_VOXEL = 14.0


class GridRays(NamedTuple):
    """Rays of a sensor in grid units: origin (3,), directions (n, 3), range, kind as in KINDS."""

    origin: NDArray[Any]
    directions: NDArray[Any]
    near: float
    far: float
    kind: int


def grid_rays(sensor: Lidar | Camera, grid: VoxelGrid, real: type[np.floating[Any]] = np.float64) -> GridRays:
    """The rays of a sensor in the float type that they are to be walked in."""
    rays = sensor_rays(sensor)
    near, far = (metres / grid.voxel_m if math.isfinite(metres) else math.inf for metres in rays.range_m)
    origin = np.array(grid.to_grid(rays.origin_m)).astype(real)
    return GridRays(origin, rays.directions.astype(real), near, far, KINDS.index(sensor.kind))


class PlainDda:
    """Every ray through a dense byte grid on one thread, then one sum over all voxels.

    `seen` uint8 (2, nx, ny, nz): by cameras, by LiDARs.

    Raises InputError when the dense grids do not fit in memory.
    """

    def __init__(self, field: EntropyField) -> None:
        field.grid.require_memory(BYTES_PER_VOXEL, "plain DDA")
        self.seen = np.zeros((len(KINDS), *field.grid.shape), np.uint8)
        self._h = np.zeros((*field.grid.shape, 3), np.float32)
        ix, iy, iz = field.index.ijk().T
        for cls in range(len(CLASSES)):
            self._h[ix, iy, iz, cls] = field.entropy_nat(cls)

    def cast(self, rays: GridRays) -> None:
        """Mark what the rays of one sensor visit."""
        plain.walk_dense(rays.origin, rays.directions, rays.near, rays.far, 1, self.seen[rays.kind])

    def sums(self) -> NDArray[np.float64]:
        """Covered entropy in nat, (3, 3): seen by cameras, by LiDARs, by any sensor; per class."""
        sums = np.zeros((3, 3))
        plain.sum_dense(self.seen.reshape(len(KINDS), -1), self._h.reshape(-1, 3), sums)
        return sums

    def clear(self) -> None:
        """Forget what was seen."""
        self.seen[:] = 0
