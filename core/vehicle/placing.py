"""Place a sensor on a surface: point and outward normal in, pose out. Vehicle frame, metres."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Pose
from riglens.core.sensors.registry import kind_of

Vector = NDArray[np.float64]
Body = tuple[str, Vector]
"""Kind of a sensor, and the lowest and highest corner (2, 3) of its body in its own frame, metres."""


@dataclass(frozen=True)
class PlacingRules:
    """Rules that turn a point on the car into a sensor's pose.

    With a `grid_m` the coordinates along the surface end on its multiples, and nearer than `centre_m` to the middle
    plane on y = 0. `upright` keeps sensors level. `below_rails` looks through narrow things on
    the roof, such as rails and bars.
    """

    grid_m: float | None = None
    centre_m: float = 0.0
    upright: bool = False
    below_rails: bool = False


FREE = PlacingRules()
Hit = tuple[Vector, Vector]
"""Hit of a ray on the car: a point (3,) in metres, and the unit normal there (3,), outwards."""
Cast = Callable[[Vector, Vector], Hit | None]
"""Function that returns the first hit of a ray from an origin (3,) along a unit direction (3,)."""
FAR_M = 0.1
"""A sensor farther than this from every surface needs a bracket: our choice."""
_SPARE_M = 0.005
_OFF_M = 0.3
_MISSED_M = 0.002
_ROUNDS = 6
_DECIMALS = 9
_RAIL_WIDTH_M, _RAIL_STEP_M = 0.16, 0.02
_RAIL_HEIGHT_M = (0.012, 0.25)
_ROOF = 0.7


def placed(cast: Cast, ray: tuple[Vector, Vector], body: Body, rules: PlacingRules = FREE) -> Pose | None:
    """Return the pose of a sensor with a `body` where a view ray meets the car, by these rules; None off the car."""
    hit = cast(*ray)
    if hit is None:
        return None
    if rules.below_rails:
        hit = _below_rail(hit, cast)
    pose = placed_on(*hit, *body, upright=rules.upright)
    return pose if rules.grid_m is None else _on_grid(pose, hit, cast, body, rules)


def _on_grid(free: Pose, hit: Hit, cast: Cast, body: Body, rules: PlacingRules) -> Pose:
    """Return a pose nearby with round coordinates along the surface; `free` where the surface ends before it.

    Across the surface the sensor still touches it: the ray is shifted until the sensor, not the point, is on the grid.
    """
    assert rules.grid_m is not None
    axis = int(np.argmax(np.abs(hit[1])))
    along = [other for other in range(3) if other != axis]
    wanted_m = np.array(free.position_m)
    wanted_m[along] = np.round(wanted_m[along] / rules.grid_m) * rules.grid_m
    if axis != 1 and abs(free.position_m[1]) <= rules.centre_m:
        wanted_m[1] = 0.0
    outwards = np.zeros(3)
    outwards[axis] = np.copysign(1.0, hit[1][axis])
    pose, (point_m, _) = free, hit
    for _ in range(_ROUNDS):
        start_m = point_m + (wanted_m - pose.position_m) * (outwards == 0.0) + _OFF_M * outwards
        found = cast(start_m, -outwards)
        if found is None:
            return free
        found = _below_rail(found, cast) if rules.below_rails else found
        point_m, pose = found[0], placed_on(*found, *body, upright=rules.upright)
    if np.abs(np.subtract(pose.position_m, wanted_m)[along]).max() > _MISSED_M:
        return free
    x, y, z = (
        round(float(wanted_m[place]), _DECIMALS) + 0.0 if place in along else value
        for place, value in enumerate(pose.position_m)
    )
    return Pose((x, y, z), pose.rpy_deg)


def _below_rail(hit: Hit, cast: Cast) -> Hit:
    """Return the roof under a narrow thing that was hit; the hit itself when nothing lies lower on both sides of it."""
    for axis in (1, 0):
        sides = [_beside(hit[0], axis, sign, cast) for sign in (1.0, -1.0)]
        roofs = [side for side in sides if side is not None and side[1][2] > _ROOF]
        if all(side is not None for side in sides) and roofs:
            point_m = np.array(hit[0])
            point_m[2] = float(np.mean([roof[0][2] for roof in roofs]))
            normal = np.sum([roof[1] for roof in roofs], axis=0)
            return point_m, normal / np.linalg.norm(normal)
    return hit


def _beside(point_m: Vector, axis: int, sign: float, cast: Cast) -> Hit | None:
    """Return the first place next to a point that is lower by the height of a rail; None when there is none nearby."""
    low_m, high_m = _RAIL_HEIGHT_M
    for step in range(1, round(_RAIL_WIDTH_M / _RAIL_STEP_M) + 1):
        start_m = np.array(point_m)
        start_m[2] += _OFF_M
        start_m[axis] += sign * step * _RAIL_STEP_M
        found = cast(start_m, np.array([0.0, 0.0, -1.0]))
        drop_m = high_m + 1.0 if found is None else float(point_m[2] - found[0][2])
        if drop_m >= low_m:
            return found if drop_m <= high_m and found is not None else _OFF_ROOF
    return None


_OFF_ROOF: Hit = (np.full(3, np.nan), np.array([0.0, 0.0, -1.0]))
"""Stand-in for the side of a rail at the edge of the roof: lower, but no roof."""


def placed_on(point_m: Vector, normal: Vector, kind: str, box_m: Vector, upright: bool = False) -> Pose:
    """Return the pose of a sensor whose body touches a surface at a point with unit normal (3,), from outside; a deep
    housing is let into the surface, so that the sensor needs no bracket.

    Its kind decides how it is turned; an `upright` sensor is level and looks ahead, or away from the surface.
    `box_m` (2, 3) are the lowest and highest corner of the body in the sensor's frame.
    """
    placement = kind_of(kind).placement
    angles = placement.rpy_deg(normal)
    if upright:
        angles = (0.0, 0.0, angles[2] if placement.away_when_level else 0.0)
    roll, pitch, yaw = (round(angle, 2) + 0.0 for angle in angles)
    turned = Pose((0.0, 0.0, 0.0), (roll, pitch, yaw))
    corners = np.stack(np.meshgrid(*np.asarray(box_m).T), axis=-1).reshape(-1, 3) @ turned.rotation().T
    off_m = min(-float((corners @ normal).min()), FAR_M - _SPARE_M)
    position = np.asarray(point_m) + off_m * np.asarray(normal)
    x, y, z = (round(float(value), 4) + 0.0 for value in position)
    return Pose((x, y, z), turned.rpy_deg)
