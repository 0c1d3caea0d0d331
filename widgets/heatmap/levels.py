"""Select the cells of a heatmap to draw, and the parts of a frame: levels of detail and pieces. No Qt, no VTK."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.view.heatmap_data import HeatmapData, Values
from riglens.widgets.drawing.camera import OrbitCamera, Size

DRAG_CELLS = 30_000


@dataclass(frozen=True)
class DetailLevel:
    """Cells of one resolution, and the cells of the full heatmap that each of them represents.

    rows (n,): cells of the heatmap, those of a block side by side; first (k,): where each block begins, None
    where every cell is drawn by itself.
    """

    centres_m: Values
    cell_m: float
    rows: NDArray[np.int64]
    first: NDArray[np.int64] | None = None

    def largest(self, values: Values) -> Values:
        """Return the largest value of each cell's block."""
        own = values[self.rows]
        return own if self.first is None else np.maximum.reduceat(own, self.first)

    def merged(self, data: HeatmapData) -> tuple[Values, Values | None]:
        """Return merged values and weights of the cells: the largest of a block, for changes by size, for steps the
        most frequent."""
        weights = data.weights if data.weights is None else self.largest(data.weights)
        if self.first is None or data.scale in ("ramp", "level"):
            return self.largest(data.values), weights
        if data.scale == "change":
            most, least = self.largest(data.values), -self.largest(-data.values)
            return np.where(most >= -least, most, least), weights
        shares = np.ones_like(data.values) if data.weights is None else data.weights
        own, shares = data.values[self.rows], shares[self.rows]
        votes = [np.add.reduceat(shares * (own == step), self.first) for step in range(len(data.labels))]
        return np.argmax(votes, axis=0).astype(np.float32), weights


def full_level(centres_m: Values, cell_m: float, rows: NDArray[np.int64] | None = None) -> DetailLevel:
    """Return the level that shows every cell, or those of some rows."""
    rows = np.arange(len(centres_m)) if rows is None else rows
    return DetailLevel(np.asarray(centres_m, dtype=np.float32)[rows], cell_m, rows)


def coarse_level(level: DetailLevel, most: int = DRAG_CELLS) -> DetailLevel:
    """Merge cells into blocks of 2, 3, ... cells per edge until at most `most` are left."""
    coarse, factor = level, 1
    while len(coarse.centres_m) > most:
        factor += 1
        coarse = _blocks(level, factor)
    return coarse


def _blocks(level: DetailLevel, factor: int) -> DetailLevel:
    edge_m = level.cell_m * factor
    low = level.centres_m.min(axis=0) - level.cell_m / 2
    block = np.floor((level.centres_m - low) / edge_m).astype(np.int64)
    key = (block[:, 0] << 42) | (block[:, 1] << 21) | block[:, 2]
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.diff(key[order], prepend=-1))
    centres = (low + (block[order[first]] + 0.5) * edge_m).astype(np.float32)
    return DetailLevel(centres, edge_m, level.rows[order], first)


LEVEL_LAYERS, _THINNEST = 1.5, 0.06
"""Seen level, all rows of cells together are as opaque as this many layers; no cell becomes fainter than the second."""


class RowsBehind:
    """Number of cells behind one another along x and along y, where most of the drawing is."""

    def __init__(self, level: DetailLevel) -> None:
        self._columns = [_columns(level, axis) for axis in (0, 1)]
        self._deep = [1.0, 1.0]

    def count(self, shown: NDArray[np.int64], strengths: Values) -> None:
        """Count the cells drawn (k,), by their numbers, weighted by their strength (k,), 0 to 1."""
        for axis, columns in enumerate(self._columns):
            sums = np.bincount(columns[shown], strengths)
            self._deep[axis] = float(sums @ sums) / max(1e-12, float(sums.sum()))

    def thinned(self, camera: OrbitCamera) -> float:
        """Return the factor by which cells are drawn fainter for this camera, 0 to 1: seen level, so that they do not
        form a wall."""
        along_x = math.cos(math.radians(camera.azimuth_deg)) ** 2
        deep = along_x * self._deep[0] + (1.0 - along_x) * self._deep[1]
        thinnest = min(1.0, max(_THINNEST, LEVEL_LAYERS / max(1e-12, deep)))
        return 1.0 - (1.0 - thinnest) * camera.from_the_side


def _columns(level: DetailLevel, axis: int) -> NDArray[np.int64]:
    """Return the number of the column along an axis that each cell is in, (n,)."""
    if not len(level.centres_m):
        return np.zeros(0, np.int64)
    low = level.centres_m.min(axis=0)
    places = np.rint((level.centres_m - low) / level.cell_m).astype(np.int64)
    return np.asarray(places[:, 1 - axis] * (int(places[:, 2].max()) + 1) + places[:, 2])


SLANTED = 1.25
"""Squares that face the eye are this much larger than a cell, or gaps would show at a slant."""
SMALLEST_PX = 1.0
PART_PX = 4e6
"""Blended pixels of a part: about 20 ms on two cores without a graphics card."""
_CORNERS_PX = 20.0
"""Cost of a cell before its first pixel is drawn, in pixels."""


def cell_scale_px(cell_m: float, camera: OrbitCamera, size: Size) -> float:
    """Return the edge of a cell's square in pixels: of a parallel view, else of a cell one metre in front of the
    eye."""
    at_1m = cell_m * size[1] / 2 / math.tan(math.radians(camera.view_angle_deg) / 2)
    return at_1m / camera.distance_m if camera.parallel else SLANTED * at_1m


def in_parts(
    centres_m: NDArray[np.float32],
    order: NDArray[np.int64],
    cell_m: float,
    camera: OrbitCamera,
    size: Size,
    part_px: float = PART_PX,
) -> list[NDArray[np.int64]]:
    """Cut `order` (k,), rows of `centres_m` (n, 3), into parts of about `part_px` pixels each."""
    right, down, depth_m = camera.project(centres_m.astype(np.float64), size).T
    edge_px = cell_scale_px(cell_m, camera, size) / (1.0 if camera.parallel else np.maximum(depth_m, 1e-3))
    edge_px = np.maximum(edge_px, SMALLEST_PX)
    across = np.abs(2 * right - size[0]) < size[0] + edge_px
    in_view = (depth_m > 0.0) & across & (np.abs(2 * down - size[1]) < size[1] + edge_px)
    pixels = _CORNERS_PX + in_view * np.minimum(edge_px, size[0]) * np.minimum(edge_px, size[1])
    total_px = np.cumsum(pixels[order])
    cuts = np.arange(part_px, total_px[-1] if len(order) else 0.0, part_px)
    return [part for part in np.split(order, np.searchsorted(total_px, cuts)) if len(part)]
