"""Compute views from above: sums of entropy over the columns of a field, updated with the coverage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.voxels.cells import Columns, update_columns
from riglens.core.metric.entropy import QUANTA_PER_NAT, EntropyField
from riglens.core.scene.columns import Words, empty_words, words_per_column
from riglens.core.view.top_view import BLIND, EMPTY, LEAST, MOST, SeenBy, TopView

MAX_CELLS = 300_000


@dataclass
class _Sums:
    """Sums over the columns of a set of voxels, and that set."""

    words: Words
    sums_q: NDArray[np.int64]


class TopViews:
    """Maker of top views of one field. A view follows the one before by what changed, in integers, so that it is the
    same as one made from scratch. Called by one thread only."""

    def __init__(self, entropies: EntropyField, max_cells: int = MAX_CELLS) -> None:
        self._field = entropies
        nx, ny, _ = entropies.grid.shape
        self.block = 1
        while -(-nx // self.block) * -(-ny // self.block) > max_cells:
            self.block += 1
        self._cls = -1
        self._total, self._seen = self._nothing(), self._nothing()

    def view(self, cls: int, class_name: str, seen_by: SeenBy, seen: Words) -> TopView:
        """Return the seen share of each column for a class of CLASSES; `seen` are words of voxels."""
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
        """Update the sums to another set of voxels."""
        field, index = self._field, self._field.index
        nx, ny, _ = field.grid.shape
        columns = Columns(nx, ny, words_per_column(field.grid), self.block)
        values_q = field.entropies_q[:, self._cls].astype(np.int64)
        now = words & index.words
        update_columns(sums.words, now, field.runs, values_q, columns, sums.sums_q)
        sums.words = now


def levels_of(
    total_q: NDArray[np.int64], seen_q: NDArray[np.int64], share: NDArray[np.float32]
) -> NDArray[np.uint8]:
    """Return the levels of cells: EMPTY without entropy, BLIND where nothing is seen, else by the share."""
    levels = (LEAST + np.rint(share * (MOST - LEAST))).astype(np.uint8)
    levels[seen_q == 0] = BLIND
    levels[total_q == 0] = EMPTY
    return levels
