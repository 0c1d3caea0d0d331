"""The probabilistic occupancy grid (POG): per voxel, in how many frames a class is there (paper, eq. 7)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.errors import InputError
from core.kernels import fill, jit
from core.scene.boxes import CLASSES, BoxBatch, BoxSource, DataReport, Progress
from core.scene.columns import VoxelIndex, empty_words
from core.scene.grid import VoxelGrid

BYTES_PER_VOXEL = 4.0 * len(CLASSES) + 0.5
Counts = NDArray[np.uint16] | NDArray[np.uint32]


@dataclass(frozen=True)
class Pog:
    """Occupied voxels and their counts (n, 3) of frames, per class of CLASSES; p = count / frames."""

    grid: VoxelGrid
    data: DataReport
    index: VoxelIndex
    counts: Counts

    def probability(self, cls: int) -> NDArray[np.float64]:
        """p of the occupied voxels for one class, (n,)."""
        result: NDArray[np.float64] = self.counts[:, cls] / max(self.data.frames, 1)
        return result


def _packed(batch: BoxBatch, rows: NDArray[np.bool_]) -> NDArray[np.float64]:
    rotation = batch.rotation[rows].reshape(-1, 9)
    return np.ascontiguousarray(np.hstack([batch.centre_m[rows], batch.size_m[rows] / 2, rotation]))


def fill_batch(batch: BoxBatch, grid: VoxelGrid, counts: list[NDArray[np.uint32]], workers: int) -> None:
    """Add the frames of a batch to the dense counts, one array (nx, ny, nz) per class."""
    origin = np.array(grid.origin_m)
    for cls, target in enumerate(counts):
        rows = batch.cls == cls
        if rows.any():
            fill.fill_counts(_packed(batch, rows), batch.frame[rows], origin, grid.voxel_m, workers, target)


def _compressed(grid: VoxelGrid, counts: list[NDArray[np.uint32]], frames: int) -> tuple[VoxelIndex, Counts]:
    words = empty_words(grid)
    for dense in counts:
        fill.pack_nonzero(dense, words)
    index = VoxelIndex.of(grid, words)
    dtype = np.uint16 if frames <= np.iinfo(np.uint16).max else np.uint32
    packed = np.empty((index.count, len(CLASSES)), dtype)
    i, j, k = index.ijk().T
    for cls, dense in enumerate(counts):
        packed[:, cls] = dense[i, j, k]
    return index, packed


def build_pog(source: BoxSource, grid: VoxelGrid, progress: Progress | None = None) -> Pog:
    """Stream a data set into a POG; memory depends on the grid alone, not on the number of frames.

    Raises InputError on bad input or when the grid does not fit in memory.
    """
    grid.require_memory(BYTES_PER_VOXEL, "building the POG")
    workers = jit.use_threads(None)
    counts = [np.zeros(grid.shape, np.uint32) for _ in CLASSES]
    for batch in source.batches(progress):
        fill_batch(batch, grid, counts, workers)
    report = source.report()
    if report.frames < 1:
        raise InputError(f"{report.source}: holds no frames; at least one is needed")
    index, packed = _compressed(grid, counts, report.frames)
    return Pog(grid, report, index, packed)
