"""Where a sensor stands by the car's body: on it, above it, inside it, or in the ground. Vehicle frame, metres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Vec3
from riglens.core.vehicle.solid import Solid

FAR_M = 0.1
"""A sensor farther than this from every surface needs something to stand on: our choice."""
ALL_ROUND, LEVEL = 0.95, 0.8
"""A place is inside when this share of the directions above the horizon, and of those near it, meets the body."""
NEAR_HORIZON = 0.2
_DIRECTIONS = 400
Points = NDArray[np.float64]


@dataclass(frozen=True)
class Stand:
    """How a sensor stands: `gap_m` to the nearest surface, inf without a body; `drop_m` straight down to the body,
    None where it is not over it."""

    inside: bool
    below_ground: bool
    gap_m: float
    drop_m: float | None

    @property
    def is_far(self) -> bool:
        """Whether it hangs in the air, more than FAR_M off every surface."""
        return FAR_M < self.gap_m < np.inf and not self.inside and not self.below_ground

    @property
    def problem(self) -> str:
        """What is wrong with the place, in a few words; empty when nothing is."""
        if self.below_ground:
            return "below the ground"
        if self.inside:
            return "inside the body"
        if not self.is_far:
            return ""
        if self.drop_m is not None:
            return f"{self.drop_m:.2f} m above the body: needs a bracket"
        return f"{self.gap_m:.2f} m off the body: needs a bracket"


def stand(position_m: Vec3, solid: Solid) -> Stand:
    """How a sensor at a place stands by the body.

    Meshes need neither be closed nor face outwards: a place is inside when nearly all directions above the horizon,
    and most of those near it, meet the body, glass included. So a car without a floor has an inside, too, and the
    place under a car is none.
    """
    place = np.array(position_m, np.float64)
    below = float(place[2]) < 0.0
    if not solid.count:
        return Stand(False, below, float("inf"), None)
    return Stand(_is_inside(place, solid), below, _gap_m(place, solid.triangles_m), _drop_m(place, solid))


def _is_inside(place: Points, solid: Solid) -> bool:
    directions = _even_directions(_DIRECTIONS)
    met = np.isfinite(_first_m(place, directions, solid))
    up, level = directions[:, 2] >= 0.0, np.abs(directions[:, 2]) <= NEAR_HORIZON
    return bool(met[up].mean() >= ALL_ROUND and met[level].mean() >= LEVEL)


def _drop_m(place: Points, solid: Solid) -> float | None:
    down = float(_first_m(place, np.array([[0.0, 0.0, -1.0]]), solid)[0])
    return down if np.isfinite(down) else None


def _first_m(place: Points, directions: Points, solid: Solid) -> Points:
    """Distance (n,) to the first surface of any material, inf without one."""
    from riglens.core.kernels.solid import meet_listed  # the compiler

    every = np.ones(solid.count, np.bool_)
    most = np.full(len(directions), np.inf)
    return meet_listed(place, directions, solid.tree, every, most, 0.0)[0]


def _even_directions(count: int) -> Points:
    """Unit vectors (count, 3) spread evenly over the sphere, on a spiral of golden angles."""
    number = np.arange(count) + 0.5
    z = 1.0 - 2.0 * number / count
    turn = np.pi * (3.0 - np.sqrt(5.0)) * number
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


def _gap_m(place: Points, triangles: Points) -> float:
    """Distance to the nearest of the triangles (t, 3, 3).

    Only those whose box is nearer than the nearest corner of all can be.
    """
    nearest = float(np.linalg.norm(triangles - place, axis=2).min())
    outside = np.maximum(triangles.min(axis=1) - place, place - triangles.max(axis=1))
    near = np.linalg.norm(np.maximum(outside, 0.0), axis=1) <= nearest
    return min(nearest, float(_distances(place, triangles[near]).min()))


def _distances(place: Points, triangles: Points) -> Points:
    """Distance of a point to each triangle (k,): to its plane where the foot is within it, else to its sides."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    height = ((place - a) * normal).sum(axis=1)
    foot = place - height[:, None] * normal
    within = np.ones(len(triangles), np.bool_)
    to_sides = np.full(len(triangles), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        side = end - start
        within &= (np.cross(side, foot - start) * normal).sum(axis=1) >= 0.0
        share = ((place - start) * side).sum(axis=1) / (side * side).sum(axis=1)
        nearest = start + np.clip(share, 0.0, 1.0)[:, None] * side
        to_sides = np.minimum(to_sides, np.linalg.norm(place - nearest, axis=1))
    return np.where(within, np.abs(height), to_sides)
