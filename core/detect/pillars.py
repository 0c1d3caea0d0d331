"""Prepare the detector's input and target from a sweep: figures per occupied column of the ground, and peaks.

No torch here: samples are packed as plain arrays, which files hold and processes share.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from riglens.core.scene.boxes import CLASSES

Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]

SLICES_M = (0.2, 0.6, 1.1, 1.7, 3.0)
"""Heights between which points of a column are counted apart."""
FEATURES = 7 + len(SLICES_M) - 1
ACROSS_X, ACROSS_Y = 5, 6
"""The features that change their sign in a mirror."""
HIGHEST_M = 4.0
_RADIUS_CELLS = (1.6, 1.0, 0.8)
"""Width of the peaks that the net learns, of car, bicycle and pedestrian, cells of the answer."""


@dataclass(frozen=True)
class Region:
    """Ground that is covered: centred on the car, cells of `cell_m`; the net's output has cells twice as wide."""

    length_m: float = 60.0
    width_m: float = 40.0
    cell_m: float = 0.25

    @property
    def shape(self) -> tuple[int, int]:
        """Cells along x and along y."""
        return round(self.length_m / self.cell_m), round(self.width_m / self.cell_m)

    def mirrored(self, cell: NDArray[np.int32], mirror: int) -> NDArray[np.int32]:
        """Return cells with x (bit 1) and y (bit 0) mirrored."""
        rows, columns = self.shape
        row, column = np.divmod(cell, columns)
        row = rows - 1 - row if mirror & 2 else row
        column = columns - 1 - column if mirror & 1 else column
        return np.asarray(row * columns + column, np.int32)

    def holds(self, centre_m: Doubles) -> NDArray[np.bool_]:
        """Return which of the centres (n, 2) lie in the region, lower ends included."""
        half = np.array([self.length_m, self.width_m]) / 2
        return np.asarray(((centre_m >= -half) & (centre_m < half)).all(axis=1))

    def places(self, centre_m: Doubles) -> Doubles:
        """Return positions (n, 2) in cells from the region's lower corner."""
        half = np.array([self.length_m, self.width_m]) / 2
        return np.asarray((centre_m + half) / self.cell_m)


class Sample(NamedTuple):
    """A frame as the net sees it: cell (k,) occupied cells, row by row of x; features (k, FEATURES
    or more); and its objects in the region: cls (n,), centre_m (n, 2), points (n,) of LiDARs on each."""

    cell: NDArray[np.int32]
    features: NDArray[np.float16]
    cls: NDArray[np.uint8]
    centre_m: Doubles
    points: Ids


def pillars(
    points_m: NDArray[np.float32],
    intensity: NDArray[np.float32],
    region: Region,
    painted: Doubles | None = None,
) -> tuple[NDArray[np.int32], NDArray[np.float16]]:
    """Return the occupied cells (k,) and their figures (k, FEATURES) of a sweep's points (n, 3) and intensities (n,), 0
    to 255.

    The figures: log of the count; highest, lowest and mean height; mean intensity; mean place within the cell across x
    and y; logs of the counts between SLICES_M. Points above 4 m are left out. painted (n, c): what cameras say of each
    point, whose means make c more figures.
    """
    more = np.zeros((len(points_m), 0)) if painted is None else painted
    points = points_m.astype(np.float64)
    inside = region.holds(points[:, :2]) & (points[:, 2] < HIGHEST_M)
    points, bright, more = points[inside], intensity[inside].astype(np.float64), more[inside]
    place = region.places(points[:, :2])
    corner = np.floor(place).astype(np.int64)
    number = corner[:, 0] * region.shape[1] + corner[:, 1]
    order = np.argsort(number, kind="stable")
    cell, start = np.unique(number[order], return_index=True)
    if not cell.size:
        return cell.astype(np.int32), np.zeros((0, FEATURES + more.shape[1]), np.float16)
    z, within = points[order, 2], (place - corner)[order] - 0.5
    count = np.diff(np.append(start, len(order))).astype(np.float64)
    slices = [(z >= low) & (z < high) for low, high in pairwise(SLICES_M)]
    sums = np.stack([z, bright[order] / 255.0, *within.T, *slices, *more[order].T], axis=1)
    end = 4 + len(slices)
    totals = np.add.reduceat(sums, start, axis=0)
    features = [
        np.log1p(count) / 4.0,
        np.maximum.reduceat(z, start) / 2.0,
        np.minimum.reduceat(z, start) / 2.0,
        totals[:, 0] / count / 2.0,
        *(totals[:, 1:4] / count[:, None]).T,
        *(np.log1p(totals[:, 4:end]) / 3.0).T,
        *(totals[:, end:] / count[:, None]).T,
    ]
    return cell.astype(np.int32), np.stack(features, axis=1).astype(np.float16)


Target = tuple[NDArray[np.float32], NDArray[np.float32], Ids]
"""Training target: peaks (classes, a, b) with 1 at the cell of each object; two figures of the object, (p, 2), in the p
cells that hold one; and these cells (p,)."""


def wanted(sample: Sample, region: Region) -> Target:
    """Return the training target of the objects that have a point; the two figures are the place within the cell, 0 to
    1."""
    hit = sample.points > 0
    place = region.places(sample.centre_m[hit]) / 2.0
    corner = np.floor(place).astype(np.int64)
    shape = region.shape[0] // 2, region.shape[1] // 2
    return target(shape, sample.cls[hit], corner, place - corner)


def target(shape: tuple[int, int], kinds: NDArray[np.uint8], corner: Ids, figures: Doubles) -> Target:
    """Return the target on (rows, columns) cells of objects of some classes (n,) in cells (n, 2) with figures (n, 2).

    Of two objects of any class in one cell the figures of the later one count.
    """
    rows, columns = shape
    peaks = np.zeros((len(CLASSES), rows, columns), np.float32)
    for cls, (row, column) in zip(kinds.tolist(), corner.tolist(), strict=True):
        reach, width = int(np.ceil(3 * _RADIUS_CELLS[cls])), _RADIUS_CELLS[cls]
        rows_there = np.arange(max(0, row - reach), min(rows, row + reach + 1))
        columns_there = np.arange(max(0, column - reach), min(columns, column + reach + 1))
        apart = np.square(rows_there - row)[:, None] + np.square(columns_there - column)
        there = peaks[cls, rows_there[0] : rows_there[-1] + 1, columns_there[0] : columns_there[-1] + 1]
        np.maximum(there, np.exp(-apart / (2.0 * width**2)), out=there, casting="same_kind")
    number = corner[:, 0] * columns + corner[:, 1]
    cells, last = np.unique(number[::-1], return_index=True)
    return peaks, figures[::-1][last].astype(np.float32), cells


@dataclass(frozen=True)
class Samples:
    """Many samples in a row, as arrays: starts (f + 1,) of their cells, object_starts (f + 1,) of their objects, frame
    (f,): which frame of the data each is."""

    frame: Ids
    starts: Ids
    cell: NDArray[np.int32]
    features: NDArray[np.float16]
    object_starts: Ids
    cls: NDArray[np.uint8]
    centre_m: Doubles
    points: Ids

    @classmethod
    def of(cls, frames: Iterable[int], samples: Iterator[Sample]) -> Self:
        """Pack samples, one for each of the frames."""
        held = list(samples)
        ends = np.cumsum([0, *(len(one.cell) for one in held)])
        object_ends = np.cumsum([0, *(len(one.cls) for one in held)])
        figures = held[0].features.shape[1] if held else FEATURES
        nothing = Sample(
            np.zeros(0, np.int32), np.zeros((0, figures), np.float16), np.zeros(0, np.uint8), np.zeros((0, 2)),
            np.zeros(0, np.int64),
        )  # fmt: skip
        columns = [np.concatenate(parts) for parts in zip(nothing, *held, strict=True)]
        cell, features, kinds, centre_m, points = columns
        return cls(np.array(list(frames)), ends, cell, features, object_ends, kinds, centre_m, points)

    def __len__(self) -> int:
        return len(self.frame)

    def __getitem__(self, place: int) -> Sample:
        cells = slice(*self.starts[place : place + 2])
        objects = slice(*self.object_starts[place : place + 2])
        return Sample(
            self.cell[cells],
            self.features[cells],
            self.cls[objects],
            self.centre_m[objects],
            self.points[objects],
        )
