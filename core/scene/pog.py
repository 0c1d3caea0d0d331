"""Probabilistic occupancy grid (POG): the number of frames in which a class occupies each voxel (paper, eq. 7)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.kernels.runtime import jit
from riglens.core.kernels.voxels import fill
from riglens.core.kernels.voxels.entropy_codes import Runs
from riglens.core.scene.boxes import CLASSES, BoxSource, DataReport, Progress
from riglens.core.scene.columns import VoxelIndex, empty_words, pack, unpack, words_per_column
from riglens.core.scene.filling import fill_batch
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.runs import Rows, codes_of, runs_of

COARSE_STEPS = (2, 3)
"""Coarsening factors for a quick first answer; the first one that the grid allows is used."""
BYTES_PER_VOXEL = 4.0 * len(CLASSES) + 1.5
Counts = Rows


@dataclass(frozen=True)
class Pog:
    """Occupied voxels and their counts of frames, per class of CLASSES; p = count / frames.

    Voxels share few combinations of counts, neighbours in a column often the same: `runs` holds the row of each voxel
    in `rows` (m, 3), the most frequent first; `uses` (m,): the number of voxels of each row.
    """

    grid: VoxelGrid
    data: DataReport
    index: VoxelIndex
    runs: Runs
    rows: Counts
    uses: NDArray[np.int64]

    @classmethod
    def of(cls, grid: VoxelGrid, data: DataReport, index: VoxelIndex, counts: Counts) -> Pog:
        """Return the POG of voxels and their counts (n, 3); raise ValueError where a kernel would index by arrays that
        do not belong to each other."""
        if index.grid != grid or counts.shape != (index.count, len(CLASSES)):
            raise ValueError(f"counts must have one row per voxel (got {counts.shape} for {index.count})")
        return cls(grid, data, index, *runs_of(index.words, counts))

    def codes(self) -> NDArray[np.unsignedinteger[Any]]:
        """Return the number of the row of every voxel, (n,); a new array each time."""
        return codes_of(self.index, self.runs)

    @property
    def counts(self) -> Counts:
        """The counts of every voxel, (n, 3); a new array each time."""
        counts: Counts = self.rows[self.codes()]
        return counts

    def counts_of(self, word: int, bit: int) -> Counts:
        """Return the counts (3,) of a voxel, given by its word and its bit as a number; 0 where no box ever was."""
        if not int(self.index.words[word]) & bit:
            return np.zeros(len(CLASSES), self.rows.dtype)
        begun = int(self.runs.starts[word]) & (2 * bit - 1)
        counts: Counts = self.rows[self.runs.codes[int(self.runs.first[word]) + begun.bit_count() - 1]]
        return counts

    def probability(self, cls: int) -> NDArray[np.float64]:
        """Return p of the occupied voxels for one class, (n,)."""
        result: NDArray[np.float64] = self.rows[self.codes(), cls] / max(self.data.frames, 1)
        return result


class PogSum:
    """Sum of boxes and POGs of parts of a data set on one grid.

    Counts are whole numbers, so the sum is the same to the last bit however the data were split and in
    whatever order the parts come. Memory depends on the grid alone: `counts` holds one dense array per class.
    Raises InputError when the grid does not fit in memory.
    """

    def __init__(self, grid: VoxelGrid) -> None:
        grid.require_memory(BYTES_PER_VOXEL, "building the POG")
        self.grid = grid
        self.counts = [np.zeros(grid.shape, np.uint32) for _ in CLASSES]

    def add(self, part: Pog) -> None:
        """Add the POG of some other frames; raise ValueError unless it is on the same grid."""
        if part.grid != self.grid:
            raise ValueError(f"the grid of a part must be {self.grid} (got {part.grid})")
        occupied = unpack(self.grid, part.index.words)  # in the order in which voxels are numbered
        codes = part.codes()
        for cls, dense in enumerate(self.counts):
            dense[occupied] += part.rows[codes, cls]

    def pog(self, report: DataReport) -> Pog:
        """Return the POG of the sum; `report` holds the number of frames."""
        words = empty_words(self.grid)
        for dense in self.counts:
            fill.pack_nonzero(dense, words)
        index = VoxelIndex.of(self.grid, words)
        dtype = np.uint16 if report.frames <= np.iinfo(np.uint16).max else np.uint32
        packed = np.empty((index.count, len(CLASSES)), dtype)
        occupied = unpack(self.grid, words)
        for cls, dense in enumerate(self.counts):
            packed[:, cls] = dense[occupied]
        return Pog.of(self.grid, report, index, packed)


def build_pog(source: BoxSource, grid: VoxelGrid, progress: Progress | None = None) -> Pog:
    """Stream a data set into a POG; memory depends on the grid alone, not on the number of frames.

    Raises InputError on bad input or when the grid does not fit in memory.
    """
    pog = build_part(source, grid, progress)
    if pog.data.frames < 1:
        raise InputError(f"{pog.data.source}: holds no frames; at least one is needed")
    return pog


def build_part(
    source: BoxSource, grid: VoxelGrid, progress: Progress | None = None, threads: int | None = None
) -> Pog:
    """Build the POG of a part of a data set, as build_pog does; the part may hold no frame."""
    total, workers = PogSum(grid), jit.use_threads(threads)
    for batch in source.batches(progress):
        fill_batch(batch, grid, total.counts, workers)
    return total.pog(source.report())


def coarse_pog(pog: Pog) -> Pog | None:
    """Return the POG of a grid two (else three) times as coarse, for a first answer; None when neither divides the
    number of voxels along each axis.

    Each block gets the counts of one of its voxels, the middle one or the one next to it, so that the classes
    stay as likely and as far from each other as they are.
    """
    step = next((step for step in COARSE_STEPS if all(count % step == 0 for count in pog.grid.shape)), None)
    return None if step is None else _thinned(pog, step)


def _thinned(pog: Pog, step: int) -> Pog:
    nx, ny, nz = pog.grid.shape
    grid = VoxelGrid(pog.grid.voxel_m * step, pog.grid.roi_m)
    depth, middle = words_per_column(pog.grid), step // 2
    slabs = pog.index.words.reshape(nx, ny * depth)
    mask, rows = np.zeros(grid.shape, np.bool_), [np.zeros(0, np.int64)]
    for slab in range(middle, nx, step):
        bits = np.unpackbits(slabs[slab].astype("<u8", copy=False).view(np.uint8), bitorder="little")
        occupied = bits.view(np.bool_).reshape(ny, depth * 64)
        chosen = np.zeros_like(occupied)
        chosen[middle::step, middle:nz:step] = True
        mask[slab // step] = occupied[middle::step, middle:nz:step]
        rows.append(int(pog.index.first[slab * ny * depth]) + np.flatnonzero(chosen[occupied]))
    counts = pog.rows[pog.codes()[np.concatenate(rows)]]
    return Pog.of(grid, pog.data, VoxelIndex.of(grid, pack(grid, mask)), counts)
