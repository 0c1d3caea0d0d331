"""The probabilistic occupancy grid (POG): per voxel, in how many frames a class is there (paper, eq. 7)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.kernels import fill, jit
from riglens.core.scene.boxes import CLASSES, BoxSource, DataReport, Progress
from riglens.core.scene.columns import VoxelIndex, empty_words, unpack
from riglens.core.scene.filling import fill_batch
from riglens.core.scene.grid import VoxelGrid

BYTES_PER_VOXEL = 4.0 * len(CLASSES) + 1.5
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


class PogSum:
    """Adds up boxes and POGs of parts of a data set on one grid.

    Counts are whole numbers, so the sum is the same to the last bit however the data were split and in
    whatever order the parts come. Memory depends on the grid alone: `counts` holds one dense array per class.
    Raises InputError when the grid does not fit in memory.
    """

    def __init__(self, grid: VoxelGrid) -> None:
        grid.require_memory(BYTES_PER_VOXEL, "building the POG")
        self.grid = grid
        self.counts = [np.zeros(grid.shape, np.uint32) for _ in CLASSES]

    def add(self, part: Pog) -> None:
        """Add the POG of some other frames on the same grid."""
        occupied = unpack(self.grid, part.index.words)  # in the order in which voxels are numbered
        for cls, dense in enumerate(self.counts):
            dense[occupied] += part.counts[:, cls]

    def pog(self, report: DataReport) -> Pog:
        """The POG of everything that was added; `report` says how many frames that were."""
        words = empty_words(self.grid)
        for dense in self.counts:
            fill.pack_nonzero(dense, words)
        index = VoxelIndex.of(self.grid, words)
        dtype = np.uint16 if report.frames <= np.iinfo(np.uint16).max else np.uint32
        packed = np.empty((index.count, len(CLASSES)), dtype)
        occupied = unpack(self.grid, words)
        for cls, dense in enumerate(self.counts):
            packed[:, cls] = dense[occupied]
        return Pog(self.grid, report, index, packed)


def build_pog(
    source: BoxSource, grid: VoxelGrid, progress: Progress | None = None, threads: int | None = None
) -> Pog:
    """Stream a data set into a POG; memory depends on the grid alone, not on the number of frames.

    Raises InputError on bad input or when the grid does not fit in memory.
    """
    pog = build_part(source, grid, progress, threads)
    if pog.data.frames < 1:
        raise InputError(f"{pog.data.source}: holds no frames; at least one is needed")
    return pog


def build_part(
    source: BoxSource, grid: VoxelGrid, progress: Progress | None = None, threads: int | None = None
) -> Pog:
    """As build_pog, for a part of a data set: it may hold no frame at all."""
    total, workers = PogSum(grid), jit.use_threads(threads)
    for batch in source.batches(progress):
        fill_batch(batch, grid, total.counts, workers)
    return total.pog(source.report())
