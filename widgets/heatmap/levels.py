"""Levels of detail of a heatmap: every cell, or blocks of cells while something moves. No Qt, no VTK."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.widgets.heatmap.scale import HeatmapData, Values

DRAG_CELLS = 30_000


@dataclass(frozen=True)
class Level:
    """Cells of one resolution, and which cells of the full heatmap each of them stands for.

    rows (n,): cells of the heatmap, those of a block side by side; first (k,): where each block begins, None
    where every cell is drawn by itself.
    """

    centres_m: Values
    cell_m: float
    rows: NDArray[np.int64]
    first: NDArray[np.int64] | None = None

    def largest(self, values: Values) -> Values:
        """The largest value of each cell's block."""
        own = values[self.rows]
        return own if self.first is None else np.maximum.reduceat(own, self.first)

    def merged(self, data: HeatmapData) -> tuple[Values, Values | None]:
        """Values and weights of the cells: the largest of a block, of changes by size; of steps the commonest."""
        weights = data.weights if data.weights is None else self.largest(data.weights)
        if self.first is None or data.scale == "ramp":
            return self.largest(data.values), weights
        if data.scale == "change":
            most, least = self.largest(data.values), -self.largest(-data.values)
            return np.where(most >= -least, most, least), weights
        shares = np.ones_like(data.values) if data.weights is None else data.weights
        own, shares = data.values[self.rows], shares[self.rows]
        votes = [np.add.reduceat(shares * (own == step), self.first) for step in range(len(data.labels))]
        return np.argmax(votes, axis=0).astype(np.float32), weights


def full_level(centres_m: Values, cell_m: float, rows: NDArray[np.int64] | None = None) -> Level:
    """The level that shows every cell, or those of some rows."""
    rows = np.arange(len(centres_m)) if rows is None else rows
    return Level(np.asarray(centres_m, dtype=np.float32)[rows], cell_m, rows)


def coarse_level(level: Level, most: int = DRAG_CELLS) -> Level:
    """Blocks of 2, 3, ... cells per edge until there are at most `most`."""
    coarse, factor = level, 1
    while len(coarse.centres_m) > most:
        factor += 1
        coarse = _blocks(level, factor)
    return coarse


def _blocks(level: Level, factor: int) -> Level:
    edge_m = level.cell_m * factor
    low = level.centres_m.min(axis=0) - level.cell_m / 2
    block = np.floor((level.centres_m - low) / edge_m).astype(np.int64)
    key = (block[:, 0] << 42) | (block[:, 1] << 21) | block[:, 2]
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.diff(key[order], prepend=-1))
    centres = (low + (block[order[first]] + 0.5) * edge_m).astype(np.float32)
    return Level(centres, edge_m, level.rows[order], first)
