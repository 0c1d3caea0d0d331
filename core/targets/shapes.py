"""Model objects as parts within their boxes, so that rays pass where there is nothing; and what surfaces return.

All constants of this file were fitted together, on the nuScenes mini recording and four logs of Argoverse 2:
docs/study-targets.md. Bounds of parts are in half sizes of the box.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.runtime.codes import MOST_PARTS

Shape = Literal["box", "class"]
Doubles = NDArray[np.float64]
LOW_M, TALL_M = 2.3, 3.0
"""A car up to the first height is a low one; from there its bounds go over into those of a bus at the second."""
RIDDEN_M = 1.35
"""Bicycles less tall than this have no rider."""
GLASS_PASSES, GLASS_RETURNS = 0.08, 0.2
"""DrawKeys of a LiDAR's ray that meets the glass of a car; all others are lost."""
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
SHAPES = ((LOW_CAR, TALL_CAR), (CYCLIST,), (PEDESTRIAN,), (WHOLE,), (BICYCLE,))
"""Shapes of the classes and of other things, in the order of their numbers, then of a bicycle without a rider; of a car
those of a low one and of a tall one."""
_WHOLE, _UNRIDDEN = SHAPES.index((WHOLE,)), SHAPES.index((BICYCLE,))


class Kinds(NamedTuple):
    """Kinds of shapes, k of them, as `kernels.objects.box_frames.FrameBoxes` holds them."""

    numbers: NDArray[np.int64]
    bounds: Doubles
    heights_m: Doubles
    glass: NDArray[np.bool_]


def kinds_of(shapes: Sequence[Sequence[tuple[Part, ...]]]) -> Kinds:
    """Return kinds for the kernels: of each the parts of a box, or those of a low one and of a tall one."""
    numbers = np.array([len(shape[0]) for shape in shapes])
    bounds = np.zeros((len(shapes), MOST_PARTS, 2, 2, 3))
    glass = np.zeros((len(shapes), MOST_PARTS), np.bool_)
    heights_m = np.array([(math.inf, math.inf) if len(shape) == 1 else (LOW_M, TALL_M) for shape in shapes])
    for kind, shape in enumerate(shapes):
        for height, parts in enumerate((shape[0], shape[-1])):
            for place, part in enumerate(parts):
                low, high = np.array((part.x, part.y, part.z)).T
                bounds[kind, place, height] = (low + high) / 2.0, (high - low) / 2.0
                glass[kind, place] = part.is_glass
    return Kinds(numbers, bounds, heights_m, glass)


def kind_numbers(shape: Shape, cls: NDArray[np.uint8], size_m: Doubles) -> NDArray[np.uint8]:
    """Return which of `SHAPES` boxes have, (n,), by their classes (n,), as in Traffic, and sizes (n, 3) in metres."""
    if shape == "box":
        return np.full(len(cls), _WHOLE, np.uint8)
    return np.where((cls == 1) & (size_m[:, 2] < RIDDEN_M), _UNRIDDEN, cls).astype(np.uint8)
