"""A coarser grid for pictures: blocks of voxels, few enough for a smooth view; the metric never uses it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.voxels import cells
from riglens.core.kernels.voxels.cells import CellMap
from riglens.core.metric.entropy import QUANTA_PER_NAT, EntropyField
from riglens.core.scene.columns import VoxelIndex, Words, words_per_column
from riglens.core.scene.pog import Pog

MAX_CELLS = 200_000
NO_NUMBERS = np.zeros((0, 0, 0), np.int32)


@dataclass(frozen=True)
class DisplayGrid:
    """Cells of `block`^3 voxels that hold an occupied voxel; centres_m (m, 3) float32, cell_m their edge.

    The entropies of the last class, int64 (m,), are cached for drags.
    """

    pog: Pog
    entropies: EntropyField
    block: int
    cell_m: float
    centres_m: NDArray[np.float32]
    _numbers: NDArray[np.int32]
    _last: dict[int, NDArray[np.int64]] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def build(cls, pog: Pog, field: EntropyField, max_cells: int = MAX_CELLS) -> DisplayGrid:
        """Return the finest display grid with at most `max_cells` cells."""
        block = 0
        while True:
            block += 1
            if pog.index.count > max_cells * block**3:  # too many cells, were they all full
                continue
            flags = np.zeros([-(-n // block) for n in pog.grid.shape], np.uint8)
            cells.flag_blocks(_cell_map(pog.index, NO_NUMBERS, block), flags)
            if np.count_nonzero(flags.view(np.bool_)) <= max_cells:
                break
        used = np.transpose(np.unravel_index(np.flatnonzero(flags.view(np.bool_)), flags.shape))
        numbers = np.cumsum(flags.ravel(), dtype=np.int32).reshape(flags.shape) - 1
        centres = np.array(pog.grid.origin_m) + (used + 0.5) * block * pog.grid.voxel_m
        return cls(pog, field, block, block * pog.grid.voxel_m, centres.astype(np.float32), numbers)

    def probability(self, cls: int) -> NDArray[np.float32]:
        """Return the largest p of the voxels of each cell, (m,)."""
        pog, largest = self.pog, np.zeros(len(self.centres_m), self.pog.rows.dtype)
        voxels = _cell_map(pog.index, self._numbers, self.block)
        cells.largest_per_cell(voxels, pog.runs, np.ascontiguousarray(pog.rows[:, cls]), largest)
        result: NDArray[np.float32] = (largest / max(pog.data.frames, 1)).astype(np.float32)
        return result

    def entropy(self, cls: int) -> NDArray[np.float32]:
        """Return the entropy of each cell in nat: the sum over its voxels, (m,)."""
        return (self._total_q(cls) / QUANTA_PER_NAT).astype(np.float32)

    def seen_share(self, cls: int, words: Words) -> NDArray[np.float32]:
        """Return the share of each cell's entropy in a seen set, 0 to 1, 0 where there is none, (m,)."""
        seen_q, total_q = self._seen_q(cls, words), self._total_q(cls)
        return np.divide(seen_q, total_q, out=np.zeros(len(seen_q)), where=total_q > 0).astype(np.float32)

    def seen_entropy(self, cls: int, words: Words) -> NDArray[np.float32]:
        """Return the entropy of each cell that lies in a set of voxels, nat, (m,)."""
        return (self._seen_q(cls, words) / QUANTA_PER_NAT).astype(np.float32)

    def _seen_q(self, cls: int, words: Words) -> NDArray[np.int64]:
        return self._levels_q(cls, words[None])[:, 1]

    def _levels_q(self, cls: int, levels: NDArray[np.uint64]) -> NDArray[np.int64]:
        """Return each cell's entropy by the number of nested sets that hold it, (m, n + 1)."""
        sums_q = np.zeros((len(self.centres_m), len(levels) + 1), np.int64)
        field = self.entropies
        voxels = _cell_map(field.index, self._numbers, self.block)
        values_q = field.entropies_q[:, cls].astype(np.int64)
        cells.levels_per_cell(levels, voxels, field.runs, values_q, sums_q)
        return sums_q

    def prevailing(self, cls: int, levels: NDArray[np.uint64]) -> NDArray[np.float32]:
        """Return in which of nested sets most of each cell's entropy lies: 0 none, 1 the first only, ..., (m,).

        `levels` (n, words): sets of voxels, each a part of the one before. Where two are equal the lower counts.
        """
        level: NDArray[np.float32] = np.argmax(self._levels_q(cls, levels), axis=1).astype(np.float32)
        return level

    def _total_q(self, cls: int) -> NDArray[np.int64]:
        """Return the entropy of each cell, (m,)."""
        if cls not in self._last:
            self._last.clear()
            no_sets = np.zeros((0, self.entropies.index.words.size), np.uint64)
            self._last[cls] = self._levels_q(cls, no_sets)[:, 0]
        return self._last[cls]


def _cell_map(index: VoxelIndex, numbers: NDArray[np.int32], block: int) -> CellMap:
    return CellMap(index.words, numbers, index.grid.shape[1], words_per_column(index.grid), block)
