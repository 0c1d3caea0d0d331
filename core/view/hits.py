"""Find the first hits of rays from one point in one frame: traffic boxes, the ground, the car's own body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Vec3
from riglens.core.kernels.runtime.codes import BODY, GROUND, NOTHING
from riglens.core.vehicle.solid import Barrier
from riglens.core.view.frames import FrameBoxes

__all__ = ["BODY", "GROUND", "NOTHING", "Hits", "cast"]


@dataclass(frozen=True)
class Hits:
    """Hits of n rays: range_m (n,), inf where nothing is hit; what (n,) int32: number of a box, GROUND, BODY or
    NOTHING; facing (n,): 0 to 1, how squarely a ray meets the body, 0 elsewhere."""

    range_m: NDArray[np.float64]
    what: NDArray[np.int32]
    facing: NDArray[np.float64]


def cast(
    origin_m: Vec3,
    directions: NDArray[np.float64],
    boxes: FrameBoxes,
    body: Barrier,
    range_m: tuple[float, float],
    has_ground: bool = True,
) -> Hits:
    """Return the first hits of rays with unit directions (n, 3) in the vehicle frame, zero or NaN for rays that do not
    exist.

    Anything nearer than the start of the range (metres, from and to) blocks the ray but gives no return, as with a
    LiDAR.
    """
    from riglens.core.kernels.body import hits as kernel  # the compiler, only when a picture is computed
    from riglens.core.kernels.body.solid import meet_listed

    origin, rays = np.array(origin_m, np.float64), np.nan_to_num(directions)
    distance = np.full(len(rays), float(range_m[1]))
    what = np.full(len(rays), NOTHING, np.int32)
    nearest = kernel.Nearest(distance, what)
    if has_ground:
        kernel.hit_ground(origin[2], rays, nearest)
    kernel.hit_boxes(origin, rays, kernel.Boxes(boxes.centre_m, boxes.size_m / 2, boxes.rotation), nearest)
    met, number, facing = meet_listed(origin, rays, body.tree, body.stops, distance, body.start_m)
    distance[number >= 0], what[number >= 0] = met[number >= 0], BODY
    what[distance < range_m[0]] = NOTHING
    distance[what == NOTHING] = np.inf
    facing[what != BODY] = 0.0
    return Hits(distance, what, facing)
