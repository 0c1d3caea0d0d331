"""Prepare one frame for the 3D view, as plain arrays and colours. No graphics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from riglens.core.scene.boxes import CLASSES

if TYPE_CHECKING:
    from riglens.core.targets.traffic import Traffic

MISSED_COLOUR, FEW_COLOUR, ENOUGH_COLOUR, MANY_COLOUR = "#dc2626", "#f59e0b", "#7fd6cb", "#149c8d"
"""Colours of an object without any point, with too few, with enough, and with many times as many."""
STANDING_COLOUR = "#8a94a3"
"""Colour of occluders."""
MANY_TIMES = 10
_AHEAD_M, _ASIDE_M, _CLOSE_M = (10.0, 45.0), 12.0, 12.0
_SOME = 9
"""Ground ahead and to the sides, distance below which an object would hide the car, and number of objects that shows
the scale without a crowd: our choice for the first view."""


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
    frame: int = 0
    """Number of the frame in the data."""


def plain_frame(traffic: Traffic) -> ShownFrame:
    """Return the bodies of a frame with some objects ahead, the first of those with the number closest to `_SOME`,
    and if possible none close to the car, where it would hide the car."""
    is_object, x, y = traffic.cls < len(CLASSES), traffic.centre_m[:, 0], traffic.centre_m[:, 1]
    ahead = is_object & (x > _AHEAD_M[0]) & (x < _AHEAD_M[1]) & (np.abs(y) < _ASIDE_M)
    counts, close = (
        np.bincount(traffic.frame_of_box[chosen], minlength=traffic.frames)
        for chosen in (ahead, traffic.distance_m < _CLOSE_M)
    )
    off = np.abs(counts - _SOME) + np.where(close > 0, len(traffic.cls), 0)
    first = min(np.flatnonzero(off == off.min()), key=lambda place: int(traffic.frame[place]))
    part = slice(int(traffic.starts[first]), int(traffic.starts[first + 1]))
    chosen = np.flatnonzero(is_object[part]) + part.start
    return ShownFrame(
        traffic.cls[chosen], traffic.centre_m[chosen], traffic.size_m[chosen], traffic.rotation[chosen],
        np.zeros(len(chosen), np.int64), np.zeros((0, 3), np.float32), np.zeros(0, np.bool_), 1, is_plain=True,
        frame=int(traffic.frame[first]),
    )  # fmt: skip


def colour_of(points: int, enough: int) -> str:
    """Return the colour of an object with this many points."""
    if points == 0:
        return MISSED_COLOUR
    if points < enough:
        return FEW_COLOUR
    return ENOUGH_COLOUR if points < MANY_TIMES * enough else MANY_COLOUR
