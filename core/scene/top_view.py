"""The scene from above: how much of each column's entropy is seen, on a grid that a picture can show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from core.kernels.top_view import update_columns
from core.metric.entropy import QUANTA_PER_NAT, EntropyField
from core.scene.columns import Words, empty_words, words_per_column

SeenBy = Literal["any", "lidar", "camera"]
MAX_CELLS = 300_000
EMPTY, BLIND, LEAST, MOST = 0, 1, 2, 255
"""Levels of a cell: nothing to see, something there and none of it seen, and from LEAST to MOST the share seen."""


@dataclass(frozen=True)
class TopView:
    """Cells of `cell_m` metres over the ROI, index (ix, iy) as in the grid; `origin_m` is their lower corner.

    entropy_nat (nx, ny) float32: of all voxels above the cell; seen (nx, ny) float32: share of it that is seen,
    0 to 1; levels (nx, ny) uint8: the same as a picture shows it, EMPTY and BLIND told apart from low shares.
    """

    cell_m: float
    origin_m: tuple[float, float]
    class_name: str
    seen_by: SeenBy
    entropy_nat: NDArray[np.float32]
    seen: NDArray[np.float32]
    levels: NDArray[np.uint8]

    @property
    def is_empty(self) -> bool:
        """Whether no cell holds any entropy: there is nothing to see of this class."""
        return not self.levels.any()

    def cell_at(self, x_m: float, y_m: float) -> tuple[int, int] | None:
        """The cell that holds a point, None outside the ROI."""
        ix = int(np.floor((x_m - self.origin_m[0]) / self.cell_m))
        iy = int(np.floor((y_m - self.origin_m[1]) / self.cell_m))
        inside = 0 <= ix < self.levels.shape[0] and 0 <= iy < self.levels.shape[1]
        return (ix, iy) if inside else None

    def blind_share(self) -> float:
        """Share of the cells with entropy of which nothing is seen."""
        holding = np.count_nonzero(self.levels)
        return float(np.count_nonzero(self.levels == BLIND) / holding) if holding else 0.0


@dataclass
class _Sums:
    """Sums over the columns of a set of voxels, and that set."""

    words: Words
    sums_q: NDArray[np.int64]


class TopViews:
    """Makes top views of one field. A view follows the one before by what changed, in integers, so that it is
    the same as one made from scratch. Called by one thread only."""

    def __init__(self, entropies: EntropyField, max_cells: int = MAX_CELLS) -> None:
        self._field = entropies
        nx, ny, _ = entropies.grid.shape
        self.block = 1
        while -(-nx // self.block) * -(-ny // self.block) > max_cells:
            self.block += 1
        self._cls = -1
        self._total, self._seen = self._nothing(), self._nothing()

    def view(self, cls: int, class_name: str, seen_by: SeenBy, seen: Words) -> TopView:
        """The seen share of each column for a class of CLASSES; `seen` are words of voxels."""
        if cls != self._cls:
            self._cls, self._total, self._seen = cls, self._nothing(), self._nothing()
            self._follow(self._total, self._field.index.words)
        self._follow(self._seen, seen)
        total_q, seen_q = self._total.sums_q, self._seen.sums_q
        share = np.zeros(total_q.shape, np.float32)
        np.divide(seen_q, total_q, out=share, where=total_q > 0, casting="unsafe")
        grid = self._field.grid
        return TopView(
            grid.voxel_m * self.block,
            (grid.origin_m[0], grid.origin_m[1]),
            class_name,
            seen_by,
            (total_q / QUANTA_PER_NAT).astype(np.float32),
            share,
            levels_of(total_q, seen_q, share),
        )

    def _nothing(self) -> _Sums:
        grid = self._field.grid
        nx, ny, _ = grid.shape
        return _Sums(empty_words(grid), np.zeros((-(-nx // self.block), -(-ny // self.block)), np.int64))

    def _follow(self, sums: _Sums, words: Words) -> None:
        """Bring the sums in line with another set of voxels."""
        field, index = self._field, self._field.index
        nx, ny, _ = field.grid.shape
        shape = nx, ny, words_per_column(field.grid)
        values_q = field.palette_q[:, self._cls].astype(np.int64)
        now = words & index.words
        runs = field.runs
        update_columns(
            sums.words, now, runs.starts, runs.first, runs.codes, values_q, shape, self.block, sums.sums_q
        )
        sums.words = now


def levels_of(
    total_q: NDArray[np.int64], seen_q: NDArray[np.int64], share: NDArray[np.float32]
) -> NDArray[np.uint8]:
    """Levels of cells: EMPTY without entropy, BLIND where nothing is seen, else by the share."""
    levels = (LEAST + np.rint(share * (MOST - LEAST))).astype(np.uint8)
    levels[seen_q == 0] = BLIND
    levels[total_q == 0] = EMPTY
    return levels
