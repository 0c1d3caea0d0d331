"""Classify a sensor's mount by the car's body: on it, above it, inside it, or in the ground. Vehicle frame, metres."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Pose, Vec3
from riglens.core.rig.model import Rig, Sensor
from riglens.core.sensors.registry import kind_of
from riglens.core.vehicle.parts import overlaps
from riglens.core.vehicle.placing import FAR_M
from riglens.core.vehicle.solid import MATERIALS, Solid, solid_of

ALL_ROUND, LEVEL = 0.95, 0.8
"""A place is inside when this share of the directions above the horizon, and of those near it, meets the body."""
NEAR_HORIZON = 0.2
BEHIND_GLASS_M = 0.15
"""Greatest distance behind a pane of a camera that stands behind it, as on windscreens: our choice."""
_DIRECTIONS = 400
Points = NDArray[np.float64]


@dataclass(frozen=True)
class MountStatus:
    """Mount of a sensor at `place_m`: `gap_m` to the nearest surface, inf without a body, at `nearest_m`; `drop_m`
    straight down to the body, None if it is not above it; behind_glass: it is inside, where it may be."""

    inside: bool
    below_ground: bool
    gap_m: float
    drop_m: float | None
    place_m: Vec3
    nearest_m: Vec3 | None = None
    behind_glass: bool = False

    @property
    def is_far(self) -> bool:
        """Return whether the sensor is more than FAR_M off every surface."""
        return FAR_M < self.gap_m < np.inf and not self.inside and not self.below_ground

    @property
    def away_m(self) -> float:
        """Return the distance from the body: straight down where the sensor is above it, else to the nearest
        surface."""
        return self.gap_m if self.drop_m is None else self.drop_m

    @property
    def problem(self) -> str:
        """Return the problem with the place, in a few words; empty when there is none."""
        if self.below_ground:
            return "below the ground"
        if self.inside:
            return f"{self.gap_m:.2f} m inside the body"
        if not self.is_far:
            return ""
        if self.drop_m is not None:
            return f"{self.drop_m:.2f} m above the body: needs a bracket"
        return f"{self.gap_m:.2f} m off the body: needs a bracket"

    @property
    def foot_m(self) -> Vec3:
        """Return where a line from the sensor meets its support: the ground, the body below it, or the nearest
        surface."""
        x_m, y_m, z_m = self.place_m
        if self.below_ground:
            return x_m, y_m, 0.0
        if self.drop_m is not None and not self.inside:
            return x_m, y_m, z_m - self.drop_m
        return self.place_m if self.nearest_m is None else self.nearest_m

    @property
    def height(self) -> str:
        """Return the problem with the place, as short as possible."""
        if self.below_ground:
            return f"{-self.place_m[2]:.2f} m deep"
        if self.inside:
            return "inside"
        return f"{self.away_m:.2f} m"


def problems_in_short(stands: Mapping[str, MountStatus]) -> list[str]:
    """Return a line for each problem with mounting places, with the names of all sensors that have it."""
    named: dict[str, list[str]] = {}
    for name, found in stands.items():
        if found.problem:
            named.setdefault(found.problem, []).append(name)
    return [f"{', '.join(names)}: {problem}" for problem, names in named.items()]


def mount_statuses(rig: Rig) -> dict[str, MountStatus]:
    """Return the mount of each sensor of a rig, by name; InputError where the mesh of a file is needed and missing."""
    solid = solid_of(rig.vehicle)
    return {sensor.name: status_of(sensor, solid) for sensor in rig.sensors}


def status_of(sensor: Sensor, solid: Solid) -> MountStatus:
    """Return the mount of a sensor: one that sees through glass may be inside, right behind a pane."""
    status = mount_status(sensor.position, solid)
    if not (
        status.inside and kind_of(sensor).occlusion.sees_through_glass and status.gap_m <= BEHIND_GLASS_M
    ):
        return status
    pane = skin_of(solid).materials_at(np.array(status.nearest_m))
    return replace(status, inside=False, behind_glass=True) if pane == {"glass"} else status


def mount_status(position_m: Vec3, solid: Solid) -> MountStatus:
    """Return the mount of a sensor at a place.

    Meshes need neither be closed nor face outwards: a place is inside when nearly all directions above the horizon,
    and most of those near it, meet the body, glass included. So a car without a floor has an inside, too, and the
    place under a car is none.
    """
    place = np.array(position_m, np.float64)
    below = float(place[2]) < 0.0
    if not solid.count:
        return MountStatus(False, below, float("inf"), None, position_m)
    nearest = skin_of(solid).nearest(place)
    gap_m = float(np.linalg.norm(nearest - place))
    x_m, y_m, z_m = nearest.tolist()
    return MountStatus(
        is_inside(place, solid), below, gap_m, _drop_m(place, solid), position_m, (x_m, y_m, z_m)
    )


def is_inside(place: Points, solid: Solid) -> bool:
    """Return whether a place (3,) is inside the body, as `mount_status` says it."""
    directions = _even_directions(_DIRECTIONS)
    met = np.isfinite(_first_m(place, directions, solid))
    up, level = directions[:, 2] >= 0.0, np.abs(directions[:, 2]) <= NEAR_HORIZON
    return bool(met[up].mean() >= ALL_ROUND and met[level].mean() >= LEVEL)


def _drop_m(place: Points, solid: Solid) -> float | None:
    down = float(_first_m(place, np.array([[0.0, 0.0, -1.0]]), solid)[0])
    return down if np.isfinite(down) else None


def _first_m(place: Points, directions: Points, solid: Solid) -> Points:
    """Return the distance (n,) to the first surface of any material, inf without one."""
    from riglens.core.kernels.body.solid import meet_listed  # the compiler

    every = np.ones(solid.count, np.bool_)
    most = np.full(len(directions), np.inf)
    return meet_listed(place, directions, solid.tree, every, most, 0.0)[0]


def _even_directions(count: int) -> Points:
    """Return the unit vectors (count, 3) spread evenly over the sphere, on a spiral of golden angles."""
    number = np.arange(count) + 0.5
    z = 1.0 - 2.0 * number / count
    turn = np.pi * (3.0 - np.sqrt(5.0)) * number
    flat = np.sqrt(1.0 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)


class Skin(NamedTuple):
    """Triangles (t, 3, 3) of a surface, their unit normals and the corners low, high (t, 3) of the boxes around them,
    and the numbers of their materials and parts (t,)."""

    triangles: Points
    normals: Points
    low: Points
    high: Points
    materials: NDArray[np.uint8]
    parts: NDArray[np.uint8]

    def near(self, place: Points, reach_m: float) -> Skin:
        """Return the part with triangles whose boxes come that near along each axis."""
        some = np.arange(len(self.low))
        for axis in range(3):  # few are left after the first
            is_near = self.low[some, axis] <= place[axis] + reach_m
            some = some[is_near & (self.high[some, axis] >= place[axis] - reach_m)]
        return self.only(some)

    def only(self, some: NDArray[Any]) -> Skin:
        """Return some of the triangles, by their numbers or flags."""
        places = self.triangles[some], self.normals[some], self.low[some], self.high[some]
        return Skin(*places, self.materials[some], self.parts[some])

    def nearest(self, place: Points) -> Points:
        """Return the point of the surface (3,) nearest to a place.

        Only triangles whose box is nearer than the nearest first corner of all can have it.
        """
        corner = self.triangles[:, 0] - place
        most = float(np.einsum("ij,ij->i", corner, corner).min())
        outside = np.maximum(np.maximum(self.low - place, place - self.high), 0.0)
        some = np.einsum("ij,ij->i", outside, outside) <= most
        points = _nearest_of_each(place, self.triangles[some], self.normals[some])
        return np.asarray(points[np.linalg.norm(points - place, axis=1).argmin()])

    def covered_by(self, pose: Pose, half_m: Points) -> Skin:
        """Return the part that a box of half sides (3,) around a pose meets."""
        turn, middle = pose.rotation(), np.array(pose.position_m)
        near = self.near(middle, float(np.linalg.norm(half_m)))
        met = overlaps(half_m, (near.triangles - middle) @ turn) if len(near.low) else np.zeros(0, np.bool_)
        return near.only(met)

    def materials_at(self, point: Points, within_m: float = 1e-6) -> frozenset[str]:
        """Return the names of the materials at a point of the surface: several where parts meet there."""
        part = self.near(point, within_m)
        feet = _nearest_of_each(point, part.triangles, part.normals)
        there = np.linalg.norm(feet - point, axis=1) <= within_m
        return frozenset(MATERIALS[number] for number in part.materials[there].tolist())


@lru_cache(maxsize=2)
def skin_of(solid: Solid) -> Skin:
    """Return the surface of a solid."""
    a, b, c = solid.triangles_m.transpose(1, 0, 2)
    normals = _cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    low, high = solid.triangles_m.min(axis=1), solid.triangles_m.max(axis=1)
    return Skin(solid.triangles_m, normals, low, high, solid.materials, solid.parts)


def _cross(a: Points, b: Points) -> Points:
    """Return np.cross of (n, 3) by products, which are faster for few rows."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)


def _nearest_of_each(place: Points, triangles: Points, normal: Points) -> Points:
    """Return the point of each triangle (k, 3) nearest to a place: its foot if inside, else a point of an edge."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    foot = place - ((place - a) * normal).sum(axis=1)[:, None] * normal
    within = np.ones(len(triangles), np.bool_)
    nearest, away = foot.copy(), np.full(len(triangles), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        side = end - start
        within &= (_cross(side, foot - start) * normal).sum(axis=1) >= 0.0
        share = ((place - start) * side).sum(axis=1) / (side * side).sum(axis=1)
        point = start + np.clip(share, 0.0, 1.0)[:, None] * side
        this = np.linalg.norm(place - point, axis=1)
        nearest = np.where((this < away)[:, None], point, nearest)
        away = np.minimum(away, this)
    return np.asarray(np.where(within[:, None], foot, nearest))
