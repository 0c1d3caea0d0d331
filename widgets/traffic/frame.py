"""Prepare one frame for the 3D view, as plain arrays and colours. No graphics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MISSED_COLOUR, FEW_COLOUR, ENOUGH_COLOUR, MANY_COLOUR = "#dc2626", "#f59e0b", "#7fd6cb", "#149c8d"
"""Colours of an object without any point, with too few, with enough, and with many times as many."""
STANDING_COLOUR = "#8a94a3"
"""Colour of occluders."""
MANY_TIMES = 10


@dataclass(frozen=True, eq=False)
class ShownFrame:
    """Boxes of one frame, n of them, in the vehicle frame, and the points of the LiDARs. Equal only to itself.

    cls (n,): index into CLASSES, more for what is no object; centre_m, size_m (n, 3); rotation (n, 3, 3); points
    (n,): LiDAR points on each; places_m (p, 3): where rays end; on_box (p,): whether on a box. `pointed_out` is the
    number of one box, None for none; from `enough` points on an object counts as detected. `is_plain`: nothing is
    said of points, and all boxes have the same colour.
    """

    cls: NDArray[np.uint8]
    centre_m: NDArray[np.float64]
    size_m: NDArray[np.float64]
    rotation: NDArray[np.float64]
    points: NDArray[np.int64]
    places_m: NDArray[np.float32]
    on_box: NDArray[np.bool_]
    enough: int
    pointed_out: int | None = None
    is_plain: bool = False

    @classmethod
    def plain(
        cls,
        kinds: NDArray[np.uint8],
        centre_m: NDArray[np.float64],
        size_m: NDArray[np.float64],
        rotation: NDArray[np.float64],
    ) -> ShownFrame:
        """Return boxes (k,), (k, 3), (k, 3), (k, 3, 3) of which nothing is known but where they are."""
        points, places = np.zeros(len(kinds), np.int64), np.zeros((0, 3), np.float32)
        return cls(kinds, centre_m, size_m, rotation, points, places, np.zeros(0, np.bool_), 1, is_plain=True)


def colour_of(points: int, enough: int) -> str:
    """Return the colour of an object with this many points."""
    if points == 0:
        return MISSED_COLOUR
    if points < enough:
        return FEW_COLOUR
    return ENOUGH_COLOUR if points < MANY_TIMES * enough else MANY_COLOUR
