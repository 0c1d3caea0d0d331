"""Spread numbers of a rig's objects over the ground around the car."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.counts import Counted
from riglens.core.targets.settings import NEAR_M

CELL_M = 1.0
"""Edge of a cell: our choice."""
Doubles = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class GroundView:
    """Cells of `cell_m` metres over the ground, index (ix, iy), with the objects of a class within `near_m` of each,
    between centres of cells; `origin_m` is their lower corner. Equal only to itself.

    is_of_class (k,): which counted objects are of the class; cell (those,): the cells that hold them, numbered row by
    row; side: number of cells along each axis.
    """

    counted: Counted
    class_name: str
    is_of_class: NDArray[np.bool_]
    cell: NDArray[np.int64]
    side: int
    cell_m: float = CELL_M
    near_m: float = NEAR_M

    @property
    def origin_m(self) -> tuple[float, float]:
        """The lower corner of the first cell."""
        return -self.side // 2 * self.cell_m, -self.side // 2 * self.cell_m

    @property
    def frames(self) -> int:
        """Number of frames in which objects were counted."""
        return self.counted.frames_used

    def near(self, values: Doubles) -> tuple[NDArray[np.int64], Doubles]:
        """Return how many objects with a value are near each cell, and the sum of their values, (nx, ny) each. values
        (k,): one number for each counted object, NaN for none."""
        mine = values[self.is_of_class]
        there = ~np.isnan(mine)
        cell, shape = self.cell[there], (self.side, self.side)
        counts, sums = (
            _near(np.bincount(cell, weights, self.side**2).reshape(shape)) for weights in (None, mine[there])
        )
        return counts.astype(np.int64), sums

    def cell_at(self, x_m: float, y_m: float) -> tuple[int, int] | None:
        """Return the cell that holds a point, None outside all of them."""
        ix, iy = (
            int(np.floor((at - low) / self.cell_m)) for at, low in zip((x_m, y_m), self.origin_m, strict=True)
        )
        return (ix, iy) if 0 <= ix < self.side and 0 <= iy < self.side else None


def ground_view(counted: Counted, class_name: str) -> GroundView:
    """Return the ground with the objects of a class that were counted."""
    objects, traffic = counted.objects, counted.traffic
    mine = traffic.cls[objects.box] == CLASSES.index(class_name)
    half = int(np.ceil(counted.within_m / CELL_M))
    place = np.floor(traffic.centre_m[objects.box[mine], :2] / CELL_M).astype(np.int64) + half
    cell = np.clip(place, 0, 2 * half - 1) @ (2 * half, 1)
    return GroundView(counted, class_name, mine, cell, 2 * half)


def _near(cells: NDArray[Any]) -> Doubles:
    """Return sums over all cells whose centres are within NEAR_M, always in the same order."""
    reach = int(NEAR_M / CELL_M)
    wide, found = np.pad(cells.astype(np.float64), reach), np.zeros(cells.shape)
    nx, ny = cells.shape
    for dx in range(-reach, reach + 1):
        for dy in range(-reach, reach + 1):
            if (dx * dx + dy * dy) * CELL_M**2 <= NEAR_M**2:
                found += wide[reach + dx : reach + dx + nx, reach + dy : reach + dy + ny]
    return found
