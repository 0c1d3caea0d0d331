"""Explain why a sensor does not see a voxel, from the rays that it casts and the box of the voxel.

Whether it sees the voxel is the engine's answer (`riglens.core.engine.inspect`). Traffic hides nothing in the metric,
so a voxel is missed for one of six reasons: the sensor is off, the voxel is outside its field of view, it is out of
range, it lies between the rays, in a blocked sector, or the car's own body hides it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import singledispatch
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.metric.voxel import Voxel
from riglens.core.rig.model import Camera, Lidar, Sensor
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.rays import farthest_m, limits_m, sensor_rays
from riglens.core.vehicle.solid import Barrier

Verdict = Literal["sees", "off", "outside", "range", "between", "body", "blocked", "missed"]
"""During a drag the reason is left out: then it is just "missed"."""
Side = Literal["above", "below", "beside", ""]
Points = NDArray[np.float64]
RAYS_AT_ONCE = 1 << 18
_SEARCH_STEPS = 60
_WIDE_GAP = 3.0
"""A gap between azimuths this much wider than any other is not between beams: the LiDAR does not look there."""


@dataclass(frozen=True)
class Sight:
    """A sensor's view of a voxel; `distance_m` from the sensor to the voxel's centre.

    For "outside" and "between": `miss_m` is how far the nearest ray stays from the voxel's box and `miss_deg` the
    angle from the nearest ray to its centre; `side` is the direction of the voxel outside the field of view.
    """

    sensor: str
    verdict: Verdict
    distance_m: float
    miss_m: float | None = None
    miss_deg: float | None = None
    side: Side = ""


@dataclass(frozen=True)
class _Nearest:
    """Rays that may pass nearest to a box, unit directions (k, 3), where each ends (k,), and the one nearest by
    angle."""

    directions: Points
    far_m: Points
    by_angle: int
    angle_rad: float


def sight(sensor: Sensor, grid: VoxelGrid, voxel: Voxel, sees: bool, barrier: Barrier | None = None) -> Sight:
    """Return whether a sensor sees a voxel, and if not, why; `sees` is the engine's answer, `barrier` what stops its
    rays."""
    edge = grid.voxel_m
    centre = np.array(grid.origin_m) + (np.array(voxel) + 0.5) * edge - np.array(sensor.position)
    distance_m = float(np.linalg.norm(centre))
    if not sensor.enabled:
        return Sight(sensor.name, "off", distance_m)
    if sees:
        return Sight(sensor.name, "sees", distance_m)
    low, high = centre - edge / 2, centre + edge / 2
    nearest = _nearest_rays(sensor, centre, edge * math.sqrt(3.0) / 2)
    if barrier is not None and _is_behind(sensor, nearest, low, high, barrier):
        return Sight(sensor.name, "body", distance_m)
    if _would_cross(sensor, nearest, low, high):
        return Sight(sensor.name, "range", distance_m)
    if sensor.blocked_rays((sensor.pose.rotation().T @ centre)[None]).any():
        return Sight(sensor.name, "blocked", distance_m)
    side = _outside(sensor, centre, nearest.by_angle)
    if not side and _is_out_of_range(sensor, low, high):
        return Sight(sensor.name, "range", distance_m)
    miss_m = min(float(np.linalg.norm(np.clip(0.0, low, high))), _miss(nearest.directions, low, high))
    angle_deg = math.degrees(nearest.angle_rad)
    return Sight(sensor.name, "outside" if side else "between", distance_m, miss_m, angle_deg, side)


def _chunks(sensor: Sensor) -> Iterator[tuple[NDArray[np.int64], Points]]:
    """Yield numbers (n,) and directions (n, 3) of the rays that a sensor casts, a chunk at a time."""
    for start in range(0, sensor.ray_count, RAYS_AT_ONCE):
        rows = np.arange(start, min(start + RAYS_AT_ONCE, sensor.ray_count))
        directions = sensor_rays(sensor, rows).directions
        exists = ~np.isnan(directions[:, 0])
        if exists.any():
            yield rows[exists], directions[exists]


def _nearest_rays(sensor: Sensor, centre: Points, radius_m: float) -> _Nearest:
    """Return all rays that can pass nearest to a box with this centre, relative to the sensor, and half diagonal.

    A ray is at most `radius_m` nearer to the box than to its centre, so no other ray can. Rays that lead away
    from all of the box are left out: they are nearest where they start.
    """
    length = float(np.linalg.norm(centre))
    kept: list[tuple[Points, Points, Points]] = [(np.zeros((0, 3)), np.zeros(0), np.zeros(0))]
    limits = limits_m(sensor)
    by_angle, best_cosine, least = 0, -math.inf, math.inf
    for rows, directions in _chunks(sensor):
        along = directions @ centre
        beside = np.linalg.norm(centre - np.maximum(along, 0.0)[:, None] * directions, axis=1)
        least = min(least, float(beside.min()))
        near = (beside <= least + radius_m) & (along > -radius_m)
        ends = limits[rows][near] if limits.size else np.full(near.sum(), np.inf)
        kept.append((directions[near], beside[near], np.minimum(ends, sensor.range_m[1])))
        place = int(along.argmax())
        if along[place] > best_cosine:
            by_angle, best_cosine = int(rows[place]), float(along[place])
    directions, distances, far_m = (np.concatenate(parts) for parts in zip(*kept, strict=True))
    angle = math.acos(min(1.0, max(-1.0, best_cosine / length))) if length else 0.0
    chosen = distances <= least + radius_m
    return _Nearest(directions[chosen], far_m[chosen], by_angle, angle)


def _is_out_of_range(sensor: Sensor, low: Points, high: Points) -> bool:
    """Return whether all of the box is beyond the range, or before it."""
    near, far = sensor.range_m[0], farthest_m(sensor)
    nearest = float(np.linalg.norm(np.clip(0.0, low, high)))
    farthest = float(np.linalg.norm(np.maximum(np.abs(low), np.abs(high))))
    return nearest >= far or farthest <= near


def _would_cross(sensor: Sensor, rays: _Nearest, low: Points, high: Points) -> bool:
    """Return whether rays run through the box, but none within the range."""
    enter, leave = _passages(rays.directions, low, high)
    crosses = leave > enter
    return bool(crosses.any() and not (crosses & _in_range(sensor, rays, enter, leave)).any())


def _is_behind(sensor: Sensor, nearest: _Nearest, low: Points, high: Points, barrier: Barrier) -> bool:
    """Return whether rays would run through the box within the range, and end at the car before they leave it."""
    from riglens.core.kernels.body.solid import meet_listed

    enter, leave = _passages(nearest.directions, low, high)
    chosen = (leave > enter) & _in_range(sensor, nearest, enter, leave)
    rays = np.ascontiguousarray(nearest.directions[chosen])
    met = meet_listed(
        np.array(sensor.position), rays, barrier.tree, barrier.stops, leave[chosen], barrier.start_m
    )
    return bool(np.isfinite(met[0]).any())


def _passages(directions: Points, low: Points, high: Points) -> tuple[Points, Points]:
    """Return where rays (k, 3) from the sensor at zero enter and leave a box, metres; missed unless leave > enter."""
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = low / directions, high / directions
    enter = np.maximum(np.nanmax(np.minimum(first, second), axis=1), 0.0)
    return enter, np.asarray(np.nanmin(np.maximum(first, second), axis=1))


def _in_range(sensor: Sensor, rays: _Nearest, enter: Points, leave: Points) -> NDArray[np.bool_]:
    return np.asarray(np.minimum(leave, rays.far_m) > np.maximum(enter, sensor.range_m[0]))


def _miss(directions: Points, low: Points, high: Points) -> float:
    """Return the distance in metres from the nearest of some rays, from the sensor at zero, to a box.

    Along a ray the distance to a box is convex: the smallest is found by trisection.
    """
    start = np.zeros(len(directions))
    end = np.full(len(directions), float(np.linalg.norm(np.maximum(np.abs(low), np.abs(high)))))
    for _ in range(_SEARCH_STEPS):
        third = (end - start) / 3
        left, right = start + third, end - third
        falls = _distance(directions, left, low, high) > _distance(directions, right, low, high)
        start, end = np.where(falls, left, start), np.where(falls, end, right)
    return float(_distance(directions, (start + end) / 2, low, high).min(initial=math.inf))


def _distance(directions: Points, along: Points, low: Points, high: Points) -> Points:
    """Return the distance to the box of the point `along` metres along each ray, (k,)."""
    points = along[:, None] * directions
    result: Points = np.linalg.norm(points - np.clip(points, low, high), axis=1)
    return result


@singledispatch
def _outside(_sensor: Sensor, _centre: Points, _by_angle: int) -> Side:
    """Return the side of the field of view on which a direction lies, "" within it, and for kinds whose field has no
    sides."""
    return ""


@_outside.register
def _outside_lidar(lidar: Lidar, centre: Points, _by_angle: int) -> Side:
    """Return on which side of a LiDAR's beams or sector a voxel lies, empty if it lies within them."""
    direction = lidar.pose.rotation().T @ centre
    elevation = math.degrees(math.atan2(direction[2], math.hypot(direction[0], direction[1])))
    if elevation > lidar.elevations().max():
        return "above"
    if elevation < lidar.elevations().min():
        return "below"
    azimuths = np.sort(lidar.azimuths() % 360.0)
    gaps = np.diff(azimuths, append=azimuths[0] + 360.0)
    widest = int(gaps.argmax())
    others = np.delete(gaps, widest)
    if len(others) and gaps[widest] <= _WIDE_GAP * others.max():
        return ""
    past = (math.degrees(math.atan2(direction[1], direction[0])) - azimuths[widest]) % 360.0
    return "beside" if 0.0 < past < gaps[widest] else ""


@_outside.register
def _outside_camera(camera: Camera, centre: Points, by_angle: int) -> Side:
    """Return the same for a camera, whose view reaches to its outermost rays and half their spacing more: the image's
    edge."""
    columns, rows = camera.resolution
    row, column = divmod(by_angle, columns)
    pairs: list[tuple[int, Side]] = [
        (row * columns + _inwards(column, columns), "beside"),
        (_inwards(row, rows) * columns + column, "above" if row == 0 else "below"),
    ]
    direction = centre / max(float(np.linalg.norm(centre)), 1e-12)
    for inner, side in pairs:
        if inner == by_angle:
            continue
        edge, inside = sensor_rays(camera, np.array([by_angle, inner])).directions
        outwards = edge - inside
        if (direction - edge) @ outwards > 0.5 * (outwards @ outwards):
            return side
    return ""


def _inwards(place: int, count: int) -> int:
    """Return the neighbour of the first or last of `count` places; every other place itself."""
    if count == 1 or 0 < place < count - 1:
        return place
    return 1 if place == 0 else place - 1
