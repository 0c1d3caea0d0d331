"""Map a rig's figures for objects over the ground: hit coverage near each cell, and missed objects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.counts import Counted

CELL_M, NEAR_M = 1.0, 2.0
"""Edge of a cell, and the distance within which objects belong to a cell, between centres: our choice."""


@dataclass(frozen=True, eq=False)
class GroundView:
    """Cells of `cell_m` metres over the ground, index (ix, iy); `origin_m` is their lower corner. Equal only to itself.

    objects (nx, ny): objects of the class near each cell, in all frames counted; on_target (nx, ny): mean of theirs,
    NaN where there are none; missed (nx, ny): those with fewer than `min_points` points of all LiDARs.
    """

    class_name: str
    cell_m: float
    near_m: float
    min_points: int
    frames: int
    origin_m: tuple[float, float]
    objects: NDArray[np.int64]
    on_target: NDArray[np.float64]
    missed: NDArray[np.int64]

    def cell_at(self, x_m: float, y_m: float) -> tuple[int, int] | None:
        """Return the cell that holds a point, None outside all of them."""
        ix, iy = (
            int(np.floor((at - low) / self.cell_m)) for at, low in zip((x_m, y_m), self.origin_m, strict=True)
        )
        inside = 0 <= ix < self.objects.shape[0] and 0 <= iy < self.objects.shape[1]
        return (ix, iy) if inside else None


def ground_view(counted: Counted, class_name: str) -> GroundView:
    """Spread a rig's figures for the objects of a class over the ground."""
    objects, traffic = counted.objects, counted.traffic
    mine = traffic.cls[objects.box] == CLASSES.index(class_name)
    half = int(np.ceil(counted.within_m / CELL_M))
    cell = np.floor(traffic.centre_m[objects.box[mine], :2] / CELL_M).astype(np.int64) + half
    place = np.clip(cell, 0, 2 * half - 1) @ (2 * half, 1)
    is_missed = objects.all_points[mine] < counted.settings.min_points
    counts, missed, sums = (
        _near(np.bincount(place, weights, (2 * half) ** 2).reshape(2 * half, 2 * half))
        for weights in (None, is_missed, objects.on_target[mine])
    )
    mean = np.divide(sums, counts, out=np.full(counts.shape, np.nan), where=counts > 0)
    return GroundView(
        class_name, CELL_M, NEAR_M, counted.settings.min_points, counted.frames_used, (-half * CELL_M, -half * CELL_M),
        counts.astype(np.int64), mean, missed.astype(np.int64),
    )  # fmt: skip


def _near(cells: NDArray[Any]) -> NDArray[np.float64]:
    """Return sums over all cells whose centres are within NEAR_M, always in the same order."""
    reach = int(NEAR_M / CELL_M)
    wide, found = np.pad(cells.astype(np.float64), reach), np.zeros(cells.shape)
    nx, ny = cells.shape
    for dx in range(-reach, reach + 1):
        for dy in range(-reach, reach + 1):
            if (dx * dx + dy * dy) * CELL_M**2 <= NEAR_M**2:
                found += wide[reach + dx : reach + dx + nx, reach + dy : reach + dy + ny]
    return found
