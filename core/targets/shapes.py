"""Model objects as parts within their boxes, so that rays pass where there is nothing; and what surfaces return.

All constants of this file were fitted together, on the nuScenes mini recording and four logs of Argoverse 2:
docs/study-targets.md. Bounds of parts are in half sizes of the box.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

Shape = Literal["box", "class"]
Doubles = NDArray[np.float64]
LOW_M, TALL_M = 2.3, 3.0
"""A car up to the first height is a low one; from there its bounds go over into those of a bus at the second."""
RIDDEN_M = 1.35
"""Bicycles less tall than this have no rider."""
GLASS_PASSES, GLASS_RETURNS = 0.08, 0.2
"""Chances of a LiDAR's ray that meets the glass of a car; all others are lost."""
REFLECTIVITY = (0.15, 0.15, 0.22)
"""Of car, bicycle and pedestrian; glass returns as much as a car."""
WIDTH = 0.25
"""Of the logistic by which returns fall around their range, relative to the range."""


@dataclass(frozen=True)
class Part:
    """A box within the unit box: from and to along each axis, -1 to 1; x forward, y left, z up."""

    x: tuple[float, float]
    y: tuple[float, float]
    z: tuple[float, float]
    is_glass: bool = False


WHOLE = (Part((-1.0, 1.0), (-1.0, 1.0), (-1.0, 1.0)),)
LOW_CAR = (
    Part((-0.97, 0.97), (-0.93, 0.93), (-0.72, 0.22)),
    Part((-0.75, 0.45), (-0.80, 0.80), (0.22, 0.88), is_glass=True),
    Part((-0.60, 0.25), (-0.75, 0.75), (0.88, 1.00)),
)
TALL_CAR = (
    Part((-0.98, 0.98), (-0.95, 0.95), (-0.75, 0.25)),
    Part((-0.98, 0.98), (-0.95, 0.95), (0.25, 0.70), is_glass=True),
    Part((-0.98, 0.98), (-0.95, 0.95), (0.70, 1.00)),
)
CYCLIST = (
    Part((-0.75, 0.75), (-0.13, 0.13), (-0.80, -0.10)),
    Part((-0.22, 0.18), (-0.36, 0.36), (-0.10, 0.90)),
)
BICYCLE = (
    Part((-0.80, 0.80), (-0.08, 0.08), (-0.85, 0.40)),
    Part((0.30, 0.42), (-0.50, 0.50), (0.40, 0.80)),
)
PEDESTRIAN = (Part((-0.32, 0.32), (-0.33, 0.33), (-0.90, 0.95)),)
SHAPES = (LOW_CAR, CYCLIST, PEDESTRIAN, WHOLE, BICYCLE)
"""Of the classes and of other things, in the order of their numbers; then a bicycle without a rider."""


class Parts(NamedTuple):
    """Parts of n boxes, m in all: starts (n + 1,), box (m,), offset and half size (m, 3) in metres, is_glass (m,)."""

    starts: NDArray[np.int64]
    box: NDArray[np.int32]
    offset_m: Doubles
    half_m: Doubles
    is_glass: NDArray[np.bool_]


def parts_of(shape: Shape, cls: NDArray[np.uint8], size_m: Doubles) -> Parts:
    """Return parts of boxes of classes (n,), as in Traffic, and sizes (n, 3) in metres."""
    height_m = size_m[:, 2]
    if shape == "box":
        return parts_by_kind((WHOLE,), np.zeros(len(cls), np.int64), size_m)
    kind = np.where((cls == 1) & (height_m < RIDDEN_M), 4, cls.astype(np.int64))
    parts = parts_by_kind(SHAPES, kind, size_m)
    higher = np.flatnonzero((cls == 0) & (height_m > LOW_M))
    tall = parts_by_kind((TALL_CAR,), np.zeros(higher.size, np.int64), size_m[higher])
    mine = (parts.starts[higher, None] + np.arange(len(TALL_CAR))).ravel()
    share = np.clip((height_m[higher] - LOW_M) / (TALL_M - LOW_M), 0.0, 1.0)[tall.box, None]
    for column, towards in ((parts.offset_m, tall.offset_m), (parts.half_m, tall.half_m)):
        column[mine] += share * (towards - column[mine])
    return parts


def parts_by_kind(shapes: Sequence[tuple[Part, ...]], kind: NDArray[np.int64], size_m: Doubles) -> Parts:
    """Return parts of boxes of kinds (n,), places in `shapes`, and sizes (n, 3) in metres."""
    number = np.array([len(parts) for parts in shapes])[kind]
    starts = np.concatenate([[0], np.cumsum(number)])
    box = np.repeat(np.arange(len(kind)), number)
    place = np.arange(len(box)) - starts[box]
    bounds, glass = _tables(tuple(shapes))
    low, high = bounds[kind[box], place, :, 0], bounds[kind[box], place, :, 1]
    half = size_m[box] / 2.0
    return Parts(
        starts,
        box.astype(np.int32),
        (low + high) / 2.0 * half,
        (high - low) / 2.0 * half,
        glass[kind[box], place],
    )


@lru_cache(maxsize=8)
def _tables(shapes: tuple[tuple[Part, ...], ...]) -> tuple[Doubles, NDArray[np.bool_]]:
    """Return bounds (shapes, parts, 3, 2) and which parts are glass (shapes, parts)."""
    most = max(len(parts) for parts in shapes)
    bounds, glass = np.zeros((len(shapes), most, 3, 2)), np.zeros((len(shapes), most), np.bool_)
    for number, parts in enumerate(shapes):
        for place, part in enumerate(parts):
            bounds[number, place] = part.x, part.y, part.z
            glass[number, place] = part.is_glass
    return bounds, glass
