"""A coarser copy of a scene, for a first answer: every second or third voxel along each axis stands for a block."""

from __future__ import annotations

import numpy as np

from riglens.core.scene.columns import VoxelIndex, pack, words_per_column
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.pog import Pog

STEPS = (2, 3)


def coarse_pog(pog: Pog) -> Pog | None:
    """The POG of a grid two (else three) times as coarse; None when the number of voxels allows neither.

    Each block gets the counts of one of its voxels, the middle one or the one next to it, so that the classes
    stay as likely and as far from each other as they are.
    """
    step = next((step for step in STEPS if all(count % step == 0 for count in pog.grid.shape)), None)
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
    return Pog(grid, pog.data, VoxelIndex.of(grid, pack(grid, mask)), pog.counts[np.concatenate(rows)])
