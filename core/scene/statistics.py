"""Tallies of boxes, from which a survey and every check of box data are made.

They are whole numbers by class, place, size and height, so those of the parts of a data set add up.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Vec3

SECTORS = ("front", "left", "rear", "right")
"""Quarters around the car, each 45° to both sides of its direction."""

RINGS_M = (0.0, 10.0, 20.0, 30.0, 50.0, math.inf)
"""Borders of the distances, horizontally from the car's middle to the middle of a box."""

NEAR_M = 20.0
"""Only boxes this near determine the ground: farther away the road may rise or fall."""

STEP_M = 0.01
SIZE_STEPS, HEIGHT_STEPS, LOWEST_M = 4000, 4000, -20.0
"""Sizes from 0 and heights from LOWEST_M are tallied in steps of STEP_M; what lies beyond the ends counts there."""
PLACES = len(SECTORS) * (len(RINGS_M) - 1)
"""Sectors and rings of a class."""


@dataclass(frozen=True)
class BoxStatistics:
    """Numbers of boxes by flat index, the class always first.

    placed: by (class, sector, ring); sizes: by (class, edge, step), edges length, width, height; bottoms: those within
    NEAR_M by (class, step of the height of their lower side). frames: with boxes; most: boxes in one frame. origin_m:
    place of the source's origin in the vehicle frame, metres, None where members differ; is_origin_known: whether the
    format fixes it.
    """

    placed: Counter[int] = field(default_factory=Counter)
    sizes: Counter[int] = field(default_factory=Counter)
    bottoms: Counter[int] = field(default_factory=Counter)
    frames: int = 0
    most: int = 0
    origin_m: Vec3 | None = None
    is_origin_known: bool = False

    @staticmethod
    def joined(parts: Iterable[BoxStatistics | None]) -> BoxStatistics | None:
        """Return those of several sets of frames together; None where a set has none."""
        listed = list(parts)
        known = [one for one in listed if one is not None]
        if not known or len(known) < len(listed):
            return None
        placed, sizes, bottoms = Counter[int](), Counter[int](), Counter[int]()
        for one in known:
            placed.update(one.placed)
            sizes.update(one.sizes)
            bottoms.update(one.bottoms)
        places = {one.origin_m for one in known}
        return BoxStatistics(
            placed,
            sizes,
            bottoms,
            sum(one.frames for one in known),
            max(one.most for one in known),
            places.pop() if len(places) == 1 else None,
            all(one.is_origin_known for one in known),
        )


class BoxTally:
    """Statistics that grow while boxes stream by."""

    def __init__(self) -> None:
        self._placed, self._sizes, self._bottoms = Counter[int](), Counter[int](), Counter[int]()
        self._frames = self._most = 0

    def add(
        self,
        frame: NDArray[np.int64],
        cls: NDArray[np.uint8],
        centre_m: NDArray[np.float64],
        size_m: NDArray[np.float64],
        rotation: NDArray[np.float64],
    ) -> None:
        """Add boxes of whole frames, n of them, in the vehicle frame: the columns of a BoxBatch."""
        if not frame.size:
            return
        per_frame = np.unique(frame, return_counts=True)[1]
        self._frames += per_frame.size
        self._most = max(self._most, int(per_frame.max()))
        which = cls.astype(np.int64)
        x, y, z = centre_m.T
        sector = np.floor((np.arctan2(y, x) + math.pi / 4) / (math.pi / 2)).astype(np.int64) % len(SECTORS)
        distance_m = np.hypot(x, y)
        ring = np.searchsorted(RINGS_M, distance_m, side="right") - 1
        _count(self._placed, which * PLACES + sector * (len(RINGS_M) - 1) + ring)
        edges = which[:, None] * 3 + np.arange(3)
        _count(self._sizes, edges * SIZE_STEPS + _steps(size_m, 0.0, SIZE_STEPS))
        near = distance_m <= NEAR_M
        bottom_m = (z - rotation[:, 2, 2] * size_m[:, 2] / 2)[near]
        _count(self._bottoms, which[near] * HEIGHT_STEPS + _steps(bottom_m, LOWEST_M, HEIGHT_STEPS))

    def statistics(self, origin_m: Vec3 | None = None, is_origin_known: bool = False) -> BoxStatistics:
        """Return the statistics of the boxes added so far."""
        tallies = self._placed, self._sizes, self._bottoms
        return BoxStatistics(*tallies, self._frames, self._most, origin_m, is_origin_known)


def _steps(values_m: NDArray[np.float64], low_m: float, count: int) -> NDArray[np.int64]:
    return np.clip(np.floor((values_m - low_m) / STEP_M), 0, count - 1).astype(np.int64)


def _count(tally: Counter[int], places: NDArray[np.int64]) -> None:
    found, numbers = np.unique(places, return_counts=True)
    tally.update(dict(zip(found.tolist(), numbers.tolist(), strict=True)))
