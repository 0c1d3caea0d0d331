"""Two approximate evaluations that the accuracy study measures: bounding rectangles, voxel centres in view.

Both look at every informative voxel once per sensor. Bounding rectangles take a voxel for covered when its
outline as the sensor sees it (image rectangle, or angles) holds a ray of the lattice: no covered voxel is
missed, some are added. Centres in view stand for infinitely many rays: the lattice does not matter at all.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels import approximate, jit
from riglens.core.metric.entropy import QUANTA_PER_NAT, EntropyField
from riglens.core.rig.model import Camera, EvenAngles, Lidar, Rig
from riglens.core.scene.grid import VoxelGrid
from riglens.core.study.plain import FLAGS

Flags = NDArray[np.uint8]


class _Placed(NamedTuple):
    """Where a sensor is in grid units: origin (3,), rotation (3, 3), range (2,)."""

    g: NDArray[np.float64]
    rotation: NDArray[np.float64]
    reach: NDArray[np.float64]


def _placed(sensor: Lidar | Camera, grid: VoxelGrid) -> _Placed:
    reach = np.array(sensor.range_m) / grid.voxel_m
    return _Placed(np.array(grid.to_grid(sensor.position)), sensor.pose.rotation(), reach)


class VoxelTests:
    """The informative voxels of a field as a list, tested one by one; bit 1: cameras, bit 2: LiDARs."""

    def __init__(self, field: EntropyField, threads: int | None = None) -> None:
        self._field = field
        self._threads = threads
        self._voxels = field.index.ijk()

    def bounding_rectangles(self, rig: Rig) -> Flags:
        """Voxels (n,) whose outline holds a ray of an enabled sensor."""
        seen, workers = self._start()
        for camera in rig.cameras():
            where, flag = _placed(camera, self._field.grid), FLAGS["camera"]
            approximate.camera_rectangles(*where, _lens(camera), self._voxels, flag, workers, seen)
        for lidar in rig.lidars():
            where, flag = _placed(lidar, self._field.grid), FLAGS["lidar"]
            tangents = np.sort(_tangents(lidar))
            azimuths = np.sort(np.radians(lidar.azimuths()) % approximate.TURN)
            approximate.lidar_angles(*where, tangents, azimuths, self._voxels, flag, workers, seen)
        return seen

    def centres_in_view(self, rig: Rig) -> Flags:
        """Voxels (n,) whose centre lies in the field of view of an enabled sensor."""
        seen, workers = self._start()
        for camera in rig.cameras():
            where, flag = _placed(camera, self._field.grid), FLAGS["camera"]
            approximate.camera_centres(*where, _image_edges(camera), self._voxels, flag, workers, seen)
        for lidar in rig.lidars():
            where, flag = _placed(lidar, self._field.grid), FLAGS["lidar"]
            tangents = _tangents(lidar)
            outer = np.array([tangents.min(), tangents.max()])
            approximate.lidar_centres(*where, outer, _sector(lidar), self._voxels, flag, workers, seen)
        return seen

    def sums(self, seen: Flags) -> NDArray[np.float64]:
        """Covered entropy in nat, (2, 3): seen by cameras, by LiDARs; per class."""
        workers = jit.use_threads(self._threads)
        sums: NDArray[np.float64] = (
            approximate.sum_flagged(seen, self._field.codes(), self._field.palette_q, workers)
            / QUANTA_PER_NAT
        )
        return sums

    def _start(self) -> tuple[Flags, int]:
        return np.zeros(len(self._voxels), np.uint8), jit.use_threads(self._threads)


def _lens(camera: Camera) -> NDArray[np.float64]:
    """Lattice column = c0 - c1 y / x out of c2, lattice row = c3 - c4 z / x out of c5 (paper, eq. 3)."""
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    per_column, per_row = camera.cast[0] / camera.image[0], camera.cast[1] / camera.image[1]
    columns = (cx_px * per_column - 0.5, fx_px * per_column, float(camera.cast[0]))
    return np.array([*columns, cy_px * per_row - 0.5, fy_px * per_row, float(camera.cast[1])])


def _image_edges(camera: Camera) -> NDArray[np.float64]:
    """y / x from, to, z / x from, to at the edges of the image."""
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    width_px, height_px = camera.image
    return np.array([(cx_px - width_px) / fx_px, cx_px / fx_px, (cy_px - height_px) / fy_px, cy_px / fy_px])


def _tangents(lidar: Lidar) -> NDArray[np.float64]:
    elevation = np.radians(lidar.elevations())
    tangents: NDArray[np.float64] = np.sin(elevation) / np.cos(elevation)
    return tangents


def _sector(lidar: Lidar) -> NDArray[np.float64]:
    """First azimuth and width in radians of the sector that the azimuths span, an open end included."""
    turn = lidar.azimuths_deg
    first_deg, last_deg = (turn.from_, turn.to) if isinstance(turn, EvenAngles) else (min(turn), max(turn))
    return np.array([math.radians(first_deg), math.radians(last_deg - first_deg)])
