"""Count boxes into the dense grid, in calls short enough for Ctrl-C to be noticed in between."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.voxels import fill
from riglens.core.scene.boxes import BoxBatch
from riglens.core.scene.grid import VoxelGrid

VOXELS_PER_CALL = 1 << 27
"""Compiled code does not notice Ctrl-C; this much takes it a few tenths of a second, rarely more than one."""

BOXES_PER_FRAME = 1 << 12
"""With more boxes than this in one frame, looking for overlaps between all of them takes longer than marking."""

Counts = NDArray[np.uint32]


def fill_batch(batch: BoxBatch, grid: VoxelGrid, counts: list[Counts], workers: int) -> None:
    """Add the frames of a batch to the dense counts, one array (nx, ny, nz) per class."""
    for cls, target in enumerate(counts):
        rows = (batch.cls == cls) & near_grid(batch, grid)
        if rows.any():
            _fill_class(_packed(batch, rows), batch.frame[rows], grid, target, workers)


def near_grid(batch: BoxBatch, grid: VoxelGrid) -> NDArray[np.bool_]:
    """Return whether each box may reach a voxel, (n,): false only where it ends more than a voxel outside the grid."""
    low, high = _extent(batch.centre_m, batch.size_m / 2, batch.rotation, grid)
    near = (high > -1.0) & (low < np.add(grid.shape, 1.0))
    return np.asarray(near.all(axis=1), dtype=np.bool_)


def _fill_class(
    boxes: NDArray[np.float64], frame: NDArray[np.int64], grid: VoxelGrid, target: Counts, workers: int
) -> None:
    voxels = voxels_within_reach(boxes, grid)
    for start, end, is_heavy in _runs_of_frames(frame, voxels):
        run = slice(start, end)
        if is_heavy:
            _fill_heavy_frame(boxes[run], voxels[run], grid, target, workers)
        else:
            _call(boxes[run], frame[run], grid, target, workers)


def _fill_heavy_frame(
    boxes: NDArray[np.float64], voxels: NDArray[np.int64], grid: VoxelGrid, target: Counts, workers: int
) -> None:
    """Add one frame box by box: mark on a separate grid, as if each box were a frame, then count once."""
    marks = np.zeros_like(target)
    each = np.arange(len(boxes), dtype=np.int64)
    for start, end, _ in _runs_of_frames(each, voxels):
        _call(boxes[start:end], each[start:end], grid, marks, workers)
    np.add(target, marks > 0, out=target)


def _call(
    boxes: NDArray[np.float64], frame: NDArray[np.int64], grid: VoxelGrid, target: Counts, workers: int
) -> None:
    fill.fill_counts(boxes, frame, fill.Raster(np.array(grid.origin_m), grid.voxel_m), workers, target)


def _packed(batch: BoxBatch, rows: NDArray[np.bool_]) -> NDArray[np.float64]:
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
