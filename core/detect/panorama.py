"""Prepare the input of the second detector: a range image of all LiDARs, seen from a point above the car.

Each pixel holds the nearest point. What is behind another thing as seen from there is lost, even where a LiDAR
elsewhere on the car has measured it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.pillars import ACROSS_X, ACROSS_Y, HIGHEST_M, Region

Doubles = NDArray[np.float64]
FEATURES = 7
RANGE, RANGE_M = 0, 40.0
"""The feature that is above 0 in each pixel with a point, and its unit."""
PLACE_M = (30.0, 20.0)
"""Units of the places across x and y, features ACROSS_X and ACROSS_Y."""
_STEPS_PER_M, _STEPS = 1 << 17, 1 << 24


@dataclass(frozen=True)
class Panorama:
    """Pixels of equal angles around the point `height_m` above the vehicle frame's origin: columns from behind over the
    right, rows from the lowest elevation up; points beyond the ends are in the first or the last row."""

    rows: int = 48
    columns: int = 720
    lowest_deg: float = -35.0
    highest_deg: float = 10.0
    height_m: float = 1.9

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.rows, self.columns

    def pixels(
        self,
        points_m: NDArray[np.float32],
        intensity: NDArray[np.float32],
        region: Region,
        more: Doubles,
    ) -> tuple[NDArray[np.int32], NDArray[np.float16]]:
        """Return the occupied pixels (k,) and their figures (k, FEATURES + c) of points (n, 3) in the region.

        The figures: distance, height and intensity of the nearest point, log of the count, distance of the farthest
        point, place across x and y; then `more` (n, c) of the nearest point.
        """
        points = points_m.astype(np.float64)
        inside = region.holds(points[:, :2]) & (points[:, 2] < HIGHEST_M)
        points, bright, more = points[inside], intensity[inside].astype(np.float64) / 255.0, more[inside]
        x, y, z = points.T
        flat_m = np.hypot(x, y)
        away_m = np.maximum(np.hypot(flat_m, z - self.height_m), 1e-3)
        pixel = self._row(np.arctan2(z - self.height_m, flat_m)) * self.columns + self._column(y, x)
        steps = np.minimum(away_m * _STEPS_PER_M, _STEPS - 1).astype(np.int64)  # one sort is faster than two
        order = np.argsort(pixel * _STEPS + steps, kind="stable")
        cell, start, count = np.unique(pixel[order], return_index=True, return_counts=True)
        first, last = order[start], order[start + count - 1]
        figures = [
            away_m[first] / RANGE_M,
            z[first] / 2.0,
            bright[first],
            np.log1p(count) / 4.0,
            away_m[last] / RANGE_M,
            x[first] / PLACE_M[0],
            y[first] / PLACE_M[1],
            *more[first].T,
        ]
        return cell.astype(np.int32), np.stack(figures, axis=1).astype(np.float16)

    def _row(self, elevation_rad: Doubles) -> NDArray[np.int64]:
        share = (np.degrees(elevation_rad) - self.lowest_deg) / (self.highest_deg - self.lowest_deg)
        return np.clip(np.floor(share * self.rows), 0, self.rows - 1).astype(np.int64)

    def _column(self, y: Doubles, x: Doubles) -> NDArray[np.int64]:
        turn = (np.arctan2(y, x) + np.pi) / (2.0 * np.pi)
        return np.floor(turn * self.columns).astype(np.int64) % self.columns

    def mirrored(self, cell: NDArray[np.int32], mirror: int) -> NDArray[np.int32]:
        """Return the pixels with x (bit 1) and y (bit 0) mirrored."""
        row, column = np.divmod(cell, self.columns)
        if mirror & 2:
            column = (self.columns // 2 - 1 - column) % self.columns
        if mirror & 1:
            column = self.columns - 1 - column
        return np.asarray(row * self.columns + column, np.int32)


assert (ACROSS_X, ACROSS_Y) == (5, 6)  # as in `pixels`
