"""A tree of boxes over the triangles of the car's body, so that rays find the few triangles near them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
_LEAF_TRIANGLES = 8


@dataclass(frozen=True)
class BodyTree:
    """Triangles in the order of the leaves, and nodes in depth-first order (see `riglens.core.kernels.hits`)."""

    corners_m: Points
    bounds_m: Points
    leaf: NDArray[np.int64]
    skip: NDArray[np.int64]

    @classmethod
    def of(cls, triangles_m: NDArray[np.floating], check: Callable[[], None] = lambda: None) -> BodyTree:
        """The tree over triangles (t, 3, 3) in metres; none at all is fine.

        `check` is called every few triangles: what it raises ends the work early.
        """
        corners = np.asarray(triangles_m, np.float64).reshape(-1, 3, 3)
        builder = _Builder(corners, check)
        if len(corners):
            builder.add(np.arange(len(corners)))
        return cls(
            corners[np.array(builder.order, np.int64)],
            np.array(builder.bounds, np.float64).reshape(-1, 6),
            np.array(builder.leaf, np.int64).reshape(-1, 2),
            np.array(builder.skip, np.int64),
        )


class _Builder:
    """Splits triangles at the median of their centres along the longest side, until few are left."""

    def __init__(self, corners: Points, check: Callable[[], None]) -> None:
        self._check = check
        self._low, self._high = corners.min(axis=1), corners.max(axis=1)
        self._centre = corners.mean(axis=1)
        self.order: list[int] = []
        self.bounds: list[Points] = []
        self.leaf: list[tuple[int, int]] = []
        self.skip: list[int] = []

    def add(self, chosen: NDArray[np.int64]) -> None:
        """Add a node over the chosen triangles and everything below it."""
        self._check()
        node = len(self.skip)
        low, high = self._low[chosen].min(axis=0), self._high[chosen].max(axis=0)
        self.bounds.append(np.concatenate([low, high]))
        self.skip.append(-1)
        if len(chosen) <= _LEAF_TRIANGLES:
            self.leaf.append((len(self.order), len(chosen)))
            self.order.extend(chosen.tolist())
        else:
            self.leaf.append((0, 0))
            half = len(chosen) // 2
            parts = np.argpartition(self._centre[chosen, int(np.argmax(high - low))], half)
            self.add(chosen[parts[:half]])
            self.add(chosen[parts[half:]])
        self.skip[node] = len(self.skip)
