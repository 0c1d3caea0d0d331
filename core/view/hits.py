"""What rays from one point hit first in one frame: traffic boxes, the ground, the car's own body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Vec3
from riglens.core.kernels.codes import BODY, GROUND, NOTHING
from riglens.core.view.frames import FrameBoxes

__all__ = ["BODY", "GROUND", "NOTHING", "BodyTree", "Hits", "cast"]

Points = NDArray[np.float64]
_LEAF_TRIANGLES = 8


@dataclass(frozen=True)
class Hits:
    """Of n rays: range_m (n,), inf where nothing is hit; what (n,) int32: number of a box, GROUND, BODY or
    NOTHING; facing (n,): 0 to 1, how squarely a ray meets the body, 0 elsewhere."""

    range_m: NDArray[np.float64]
    what: NDArray[np.int32]
    facing: NDArray[np.float64]


def cast(
    origin_m: Vec3,
    directions: NDArray[np.float64],
    boxes: FrameBoxes,
    body: BodyTree,
    range_m: tuple[float, float],
    has_ground: bool = True,
) -> Hits:
    """First hits of rays with unit directions (n, 3) in the vehicle frame.

    Anything nearer than the start of the range (metres, from and to) blocks the ray but gives no return, as with a
    LiDAR.
    """
    from riglens.core.kernels import hits as kernel  # the compiler, only when a picture is computed

    origin, rays = np.array(origin_m, np.float64), np.ascontiguousarray(directions)
    distance = np.full(len(rays), float(range_m[1]))
    what = np.full(len(rays), NOTHING, np.int32)
    facing = np.zeros(len(rays))
    nearest = kernel.Nearest(distance, what, facing)
    if has_ground:
        kernel.hit_ground(origin[2], rays, nearest)
    kernel.hit_boxes(origin, rays, kernel.Boxes(boxes.centre_m, boxes.size_m / 2, boxes.rotation), nearest)
    tree = kernel.Triangles(body.corners_m, body.bounds_m, body.leaf, body.skip)
    kernel.hit_triangles(origin, rays, tree, nearest)
    what[distance < range_m[0]] = NOTHING
    distance[what == NOTHING] = np.inf
    facing[what != BODY] = 0.0
    return Hits(distance, what, facing)


@dataclass(frozen=True)
class BodyTree:
    """A tree of boxes over the triangles of the car's body, so that a ray looks at the few triangles near it.

    Triangles in the order of the leaves, and nodes in depth-first order, as in `riglens.core.kernels.hits.Triangles`.
    """

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
