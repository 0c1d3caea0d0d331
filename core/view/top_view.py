"""Define the view from above: the seen share of each column's entropy, on a grid suitable for a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SeenBy = str
"""Key of the set of voxels that a map shows, one of `voxel_sets` in core/figures/registry.py."""
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
        """Return whether no cell holds any entropy: there is nothing to see of this class."""
        return not self.levels.any()

    def cell_at(self, x_m: float, y_m: float) -> tuple[int, int] | None:
        """Return the cell that holds a point, None outside the ROI."""
        ix = int(np.floor((x_m - self.origin_m[0]) / self.cell_m))
        iy = int(np.floor((y_m - self.origin_m[1]) / self.cell_m))
        inside = 0 <= ix < self.levels.shape[0] and 0 <= iy < self.levels.shape[1]
        return (ix, iy) if inside else None

    def blind_share(self) -> float:
        """Return the share of the cells with entropy of which nothing is seen."""
        holding = np.count_nonzero(self.levels)
        return float(np.count_nonzero(self.levels == BLIND) / holding) if holding else 0.0
