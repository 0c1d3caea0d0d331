"""Probabilistic occupancy grid (POG): the number of frames in which a class occupies each voxel (paper, eq. 7)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.kernels.runtime import jit
from riglens.core.kernels.voxels import fill
from riglens.core.kernels.voxels.entropy_codes import Runs
from riglens.core.scene.boxes import CLASSES, BoxBatch, BoxSource, DataReport, Progress
from riglens.core.scene.columns import (
    Counts,
    VoxelIndex,
    codes_of,
    empty_words,
    pack,
    runs_of,
    unpack,
    words_per_column,
)
from riglens.core.scene.grid import VoxelGrid

COARSE_STEPS = (2, 3)
"""Coarsening factors for a quick first answer; the first one that the grid allows is used."""
BYTES_PER_VOXEL = 4.0 * len(CLASSES) + 1.5
VOXELS_PER_CALL = 1 << 27
"""Compiled code does not notice Ctrl-C; this much takes it a few tenths of a second, rarely more than one."""
BOXES_PER_FRAME = 1 << 12
"""With more boxes than this in one frame, looking for overlaps between all of them takes longer than marking."""


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

    def add_boxes(self, batch: BoxBatch, workers: int) -> None:
        """Add the frames of a batch, in calls short enough for Ctrl-C to be noticed in between."""
        raster = fill.Raster(np.array(self.grid.origin_m), self.grid.voxel_m)
        is_near = near_grid(batch, self.grid)
        for cls, target in enumerate(self.counts):
            rows = (batch.cls == cls) & is_near
            if not rows.any():
                continue
            boxes, frames = packed_boxes(batch, rows), batch.frame[rows]
            voxels = voxels_within_reach(boxes, self.grid)
            for start, end, is_heavy in _runs_of_frames(frames, voxels):
                counts, frame, calls = target, frames[start:end], [(0, end - start, False)]
                if (
                    is_heavy
                ):  # box by box: mark on a separate grid, as if each box were a frame, then count once
                    counts, frame = np.zeros_like(target), np.arange(end - start, dtype=np.int64)
                    calls = list(_runs_of_frames(frame, voxels[start:end]))
                for first, last, _ in calls:
                    some = boxes[start + first : start + last]
                    fill.fill_counts(some, frame[first:last], raster, workers, counts)
                if is_heavy:
                    np.add(target, counts > 0, out=target)

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
        total.add_boxes(batch, workers)
    return total.pog(source.report())


def near_grid(batch: BoxBatch, grid: VoxelGrid) -> NDArray[np.bool_]:
    """Return whether each box may reach a voxel, (n,): false only where it ends more than a voxel outside the grid."""
    low, high = _extent(batch.centre_m, batch.size_m / 2, batch.rotation, grid)
    near = (high > -1.0) & (low < np.add(grid.shape, 1.0))
    return np.asarray(near.all(axis=1), dtype=np.bool_)


def packed_boxes(batch: BoxBatch, rows: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return some boxes as the kernel takes them, (n, 15)."""
    rotation = batch.rotation[rows].reshape(-1, 9)
    return np.ascontiguousarray(np.hstack([batch.centre_m[rows], batch.size_m[rows] / 2, rotation]))


def voxels_within_reach(boxes: NDArray[np.float64], grid: VoxelGrid) -> NDArray[np.int64]:
    """Return about how many voxels of the grid must be tested for each box, (n,), at least 1.

    boxes (n, 15): centre, half size, rotation by rows, as the kernel takes them.
    """
    low, high = _extent(boxes[:, 0:3], boxes[:, 3:6], boxes[:, 6:15].reshape(-1, 3, 3), grid)
    cells = np.clip(high, 0, grid.shape) - np.clip(low, 0, grid.shape) + 1
    return np.asarray(np.prod(cells, axis=1), dtype=np.int64)


def _extent(
    centre_m: NDArray[np.float64], half_m: NDArray[np.float64], rotation: NDArray[np.float64], grid: VoxelGrid
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return lowest and highest corner of the upright box around each box, each (n, 3), in voxels from the grid's
    origin."""
    reach_m = np.einsum("nij,nj->ni", np.abs(rotation), half_m)
    low = (centre_m - reach_m - grid.origin_m) / grid.voxel_m
    return low, (centre_m + reach_m - grid.origin_m) / grid.voxel_m


def _runs_of_frames(frame: NDArray[np.int64], voxels: NDArray[np.int64]) -> Iterator[tuple[int, int, bool]]:
    """Yield start and end of runs of whole frames, each for one call, and whether it is one heavy frame."""
    starts = np.flatnonzero(np.diff(frame, prepend=frame[0] - 1))
    sizes = np.diff(starts, append=frame.size)
    work = np.add.reduceat(voxels, starts)
    heavy = (work > VOXELS_PER_CALL) | (sizes > BOXES_PER_FRAME)
    share = (np.cumsum(work) - work) // VOXELS_PER_CALL
    begins = np.diff(share, prepend=-1) != 0
    begins |= heavy
    begins[1:] |= heavy[:-1]
    first = starts[begins].tolist()
    yield from zip(first, [*first[1:], int(frame.size)], heavy[begins].tolist(), strict=True)


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
