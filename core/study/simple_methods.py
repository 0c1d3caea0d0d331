"""Simple methods to find the coverage of a rig, which the studies compare with the engine.

Plain DDA walks every ray through a dense byte grid, and sampling takes points on it. The two approximations test
every informative voxel once per sensor. Bounding rectangles take a voxel for covered when its outline as the sensor
sees it (image rectangle, or angles) holds a ray of the lattice: no covered voxel is missed, some are added. Centres in
view stand for infinitely many rays: the lattice does not matter at all.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.rays import approximate, plain
from riglens.core.kernels.rays.approximate import Place, Tested
from riglens.core.kernels.runtime import jit
from riglens.core.metric.entropy import QUANTA_PER_NAT, EntropyField
from riglens.core.rig.model import Camera, Lidar, Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.rays import is_listed, sensor_rays
from riglens.core.sensors.camera import picture_slopes

KINDS = ("camera", "lidar")
"""The two kinds of the paper, on which methods are compared: rows of their sums."""
FLAGS = {kind: 1 << number for number, kind in enumerate(KINDS)}
"""The bit of a kind of sensor in a byte per informative voxel."""
BYTES_PER_VOXEL = 14.0
Flags = NDArray[np.uint8]


class GridRays(NamedTuple):
    """Rays of a sensor in grid units: origin (3,), directions (n, 3), range, kind as in KINDS."""

    origin: NDArray[Any]
    directions: NDArray[Any]
    near: float
    far: float
    kind: int


def grid_rays(sensor: Sensor, grid: VoxelGrid, real: type[np.floating[Any]] = np.float64) -> GridRays:
    """Return the rays of a sensor in the float type of the walk."""
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
        """Mark the voxels that the rays of one sensor visit."""
        plain.walk_dense(rays.origin, rays.directions, rays.near, rays.far, 1, self.seen[rays.kind])

    def sample(self, rays: GridRays, step_voxels: float) -> None:
        """Mark the voxels of points on the rays, one at every step."""
        plain.walk_sampled(
            rays.origin, rays.directions, rays.near, rays.far, step_voxels, self.seen[rays.kind]
        )

    def sums(self) -> NDArray[np.float64]:
        """Return the covered entropy in nat, (3, 3): seen by cameras, by LiDARs, by any sensor; per class."""
        sums = np.zeros((3, 3))
        plain.sum_dense(self.seen.reshape(len(KINDS), -1), self._h.reshape(-1, 3), sums)
        return sums

    def clear(self) -> None:
        """Forget what was seen."""
        self.seen[:] = 0


# ---------------------------------------------------------------- approximations


def unknown_to_rough(rig: Rig) -> list[str]:
    """Return the names of the sensors that bounding rectangles and centres in view do not support: lenses with
    distortion, beams with azimuth offsets. With one of these in the rig both methods are left out."""
    return [sensor.name for sensor in rig.sensors if sensor.enabled and is_listed(sensor)]


def _placed(sensor: Sensor, grid: VoxelGrid) -> Place:
    reach = np.array(sensor.range_m) / grid.voxel_m
    return Place(np.array(grid.to_grid(sensor.position)), sensor.pose.rotation(), reach)


class VoxelTests:
    """The informative voxels of a field as a list, tested one by one; bit 1: cameras, bit 2: LiDARs."""

    def __init__(self, field: EntropyField, threads: int | None = None) -> None:
        self._field = field
        self._threads = threads
        self._voxels = field.index.ijk()

    def bounding_rectangles(self, rig: Rig) -> Flags:
        """Return the voxels (n,) whose outline holds a ray of an enabled sensor."""
        seen, workers = self._start()
        for camera in rig.enabled_cameras():
            where, tested = _placed(camera, self._field.grid), Tested(self._voxels, FLAGS["camera"])
            approximate.camera_rectangles(where, _lens(camera), tested, workers, seen)
        for lidar in rig.enabled_lidars():
            where, tested = _placed(lidar, self._field.grid), Tested(self._voxels, FLAGS["lidar"])
            tangents = np.sort(_tangents(lidar))
            azimuths = np.sort(np.radians(lidar.azimuths()) % approximate.TURN)
            approximate.lidar_angles(where, tangents, azimuths, tested, workers, seen)
        return seen

    def centres_in_view(self, rig: Rig) -> Flags:
        """Return the voxels (n,) whose centre is in the field of view of an enabled sensor."""
        seen, workers = self._start()
        for camera in rig.enabled_cameras():
            where, tested = _placed(camera, self._field.grid), Tested(self._voxels, FLAGS["camera"])
            approximate.camera_centres(where, picture_slopes(camera), tested, workers, seen)
        for lidar in rig.enabled_lidars():
            where, tested = _placed(lidar, self._field.grid), Tested(self._voxels, FLAGS["lidar"])
            tangents = _tangents(lidar)
            outer = np.array([tangents.min(), tangents.max()])
            approximate.lidar_centres(where, outer, _sector(lidar), tested, workers, seen)
        return seen

    def sums(self, seen: Flags) -> NDArray[np.float64]:
        """Return the covered entropy in nat, (2, 3): seen by cameras, by LiDARs; per class."""
        workers = jit.use_threads(self._threads)
        sums: NDArray[np.float64] = (
            approximate.sum_flagged(seen, self._field.codes(), self._field.entropies_q, workers)
            / QUANTA_PER_NAT
        )
        return sums

    def _start(self) -> tuple[Flags, int]:
        return np.zeros(len(self._voxels), np.uint8), jit.use_threads(self._threads)


def _lens(camera: Camera) -> NDArray[np.float64]:
    """Return c0 to c5: lattice column = c0 - c1 y / x out of c2, lattice row = c3 - c4 z / x out of c5 (paper, eq.
    3)."""
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    (width, height), (columns, rows) = camera.image, camera.resolution
    across = (cx_px * (columns / width) - 0.5, fx_px * (columns / width), float(columns))
    return np.array([*across, cy_px * (rows / height) - 0.5, fy_px * (rows / height), float(rows)])


def _tangents(lidar: Lidar) -> NDArray[np.float64]:
    elevation = np.radians(lidar.elevations())
    tangents: NDArray[np.float64] = np.sin(elevation) / np.cos(elevation)
    return tangents


def _sector(lidar: Lidar) -> NDArray[np.float64]:
    """Return the first azimuth and width in radians of the sector that the azimuths span, an open end included."""
    first_deg, last_deg = lidar.turn_ends_deg
    return np.array([math.radians(first_deg), math.radians(last_deg - first_deg)])
