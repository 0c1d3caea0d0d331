"""Casting one sensor: from its description to the set of informative voxels its rays traverse."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from core.kernels import cast
from core.metric.entropy import EntropyField
from core.metric.scores import Method
from core.rational_walk import walk_rational
from core.rays import lattice
from core.rig.model import Camera, Lidar
from core.scene.columns import Words, words_per_column

RAYS_PER_CHUNK = 1 << 15
LATTICE_CACHE_BYTES = 256 << 20
FARTHEST = 1e30
"""Stands for "no limit" along a ray: beyond any ROI, and small enough for the exact predicates."""

IsStale = Callable[[], bool]


def never_stale() -> bool:
    """For callers that want every answer."""
    return False


class Caster:
    """Casts sensors against one entropy field; keeps the ray lattices of the lenses in use."""

    def __init__(self, field: EntropyField) -> None:
        self.workers = 1
        self._field = field
        self._shape = np.array(field.grid.shape, np.int64)
        self._lattices: OrderedDict[Lidar | Camera, NDArray[np.float64]] = OrderedDict()

    def mark(self, sensor: Lidar | Camera, method: Method, marks: Words, is_stale: IsStale = never_stale) -> bool:
        """Set the bits of the informative voxels traversed; False when abandoned half-way (marks are then dirty)."""
        index = self._field.index
        for chunk in self._chunks(sensor):
            if is_stale():
                return False
            irregular = np.zeros(len(chunk), np.bool_)
            cast.mark_rays(*self._geometry(sensor, chunk, method), index.words, marks, irregular)
            for cells in self._walk_irregular(sensor, chunk, irregular, method):
                marks[cells[0]] |= cells[1] & index.words[cells[0]]
        return True

    def hits(self, sensor: Lidar | Camera, method: Method, is_stale: IsStale = never_stale) -> tuple[int, ...] | None:
        """Sum over rays over their voxels of h in fixed point, per class; None when abandoned."""
        index, h_q = self._field.index, self._field.h_q
        totals = [0, 0, 0]
        for chunk in self._chunks(sensor):
            if is_stale():
                return None
            irregular = np.zeros(len(chunk), np.bool_)
            sums = cast.sum_hits(
                *self._geometry(sensor, chunk, method), index.words, index.first, h_q, irregular
            )
            totals = [total + int(part) for total, part in zip(totals, sums, strict=True)]
            for word, bit in self._walk_irregular(sensor, chunk, irregular, method):
                totals = [t + h for t, h in zip(totals, self._entropy_at(word, bit), strict=True)]
        return tuple(totals)

    def _entropy_at(self, word: int, bit: np.uint64) -> list[int]:
        index = self._field.index
        if not int(index.words[word]) & int(bit):
            return [0, 0, 0]
        voxel = int(index.first[word]) + (int(index.words[word]) & (int(bit) - 1)).bit_count()
        return [int(h) for h in self._field.h_q[voxel]]

    def _chunks(self, sensor: Lidar | Camera) -> Iterator[NDArray[np.float64]]:
        directions = self._lattice(sensor)
        for start in range(0, len(directions), RAYS_PER_CHUNK):
            yield directions[start : start + RAYS_PER_CHUNK]

    def _lattice(self, sensor: Lidar | Camera) -> NDArray[np.float64]:
        lens = sensor.model_copy(
            update={"name": "", "model": None, "position": (0.0, 0.0, 0.0), "rpy_deg": (0.0, 0.0, 0.0), "enabled": True}
        )
        if lens not in self._lattices:
            self._lattices[lens] = lattice(sensor)
            while len(self._lattices) > 1 and sum(a.nbytes for a in self._lattices.values()) > LATTICE_CACHE_BYTES:
                self._lattices.popitem(last=False)
        self._lattices.move_to_end(lens)
        return self._lattices[lens]

    def _box(self, method: Method) -> NDArray[np.int64]:
        """Cells the rays are walked in: what is informative; Bresenham's lines depend on their ends: the ROI."""
        if method == "bresenham":
            nx, ny, nz = self._field.grid.shape
            return np.array([0, nx, 0, ny, 0, nz], np.int64)
        return self._field.index.bounds

    def _reach(self, sensor: Lidar | Camera) -> NDArray[np.float64]:
        low, high = sensor.range_m
        voxel_m = self._field.grid.voxel_m
        return np.array([low / voxel_m, FARTHEST if math.isinf(high) else high / voxel_m])

    def _geometry(self, sensor: Lidar | Camera, chunk: NDArray[np.float64], method: Method) -> tuple[object, ...]:
        origin = np.array(self._field.grid.to_grid(sensor.position))
        rotation = sensor.pose.rotation()
        bresenham = method == "bresenham"
        return origin, rotation, chunk, self._reach(sensor), self._box(method), self._shape, bresenham, self.workers

    def _walk_irregular(
        self, sensor: Lidar | Camera, chunk: NDArray[np.float64], irregular: NDArray[np.bool_], method: Method
    ) -> Iterator[tuple[int, np.uint64]]:
        """Word and bit of the voxels of the rays that the kernels left out."""
        grid = self._field.grid
        depth = words_per_column(grid)
        rotation, reach, box = sensor.pose.rotation(), self._reach(sensor), self._box(method)
        for x, y, z in chunk[irregular]:
            direction = tuple(float((row[0] * x + row[1] * y) + row[2] * z) for row in rotation)
            origin = grid.to_grid(sensor.position)
            near, far = float(reach[0]), float(reach[1])
            for ix, iy, iz in walk_rational(origin, direction, near, far, [int(b) for b in box]):  # type: ignore[arg-type]
                yield (ix * grid.shape[1] + iy) * depth + iz // 64, np.uint64(1 << (iz % 64))
