"""Solids to throw rays at, and an oracle: the stated formula for every ray and every triangle, in plain numpy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.sensing.body_ends import barrier_ends, barrier_of
from riglens.core.sensors.base import Sensor
from riglens.core.vehicle.solid import GLASS, Solid

GROWN_M, EDGE = 1e-6, 1e-7
Array = NDArray[np.float64]


def body_ends(sensor: Sensor, solid: Solid, workers: int = 1) -> Array:
    """The distance in metres (rays,) at which each ray first meets a solid beyond the housing, inf if free."""
    return barrier_ends(sensor, barrier_of(sensor, solid), workers)


def soup(seed: int, count: int = 300, size_m: float = 0.5, spread_m: float = 2.0) -> Solid:
    """Random triangles about the origin, some as thin as needles, some flat along an axis, a few of glass."""
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-spread_m, spread_m, (count, 1, 3)) + rng.uniform(-size_m, size_m, (count, 3, 3))
    thin = rng.random(count) < 0.1
    corners[thin, 2] = corners[thin, 0] + (corners[thin, 1] - corners[thin, 0]) * rng.uniform(0.2, 0.9)
    corners[thin, 2] += rng.uniform(-1e-4, 1e-4, (int(thin.sum()), 3))
    flat = rng.random(count) < 0.2
    corners[flat, :, 2] = corners[flat, :1, 2]
    materials = np.where(rng.random(count) < 0.2, GLASS, 0)
    return Solid.of(corners, materials)


def plate(x: float, half_m: float = 50.0, axis: int = 0, facing: int = 0) -> Array:
    """Two triangles (2, 3, 3) that make a square across an axis at x, turned to either side by `facing`."""
    a, b = (i for i in range(3) if i != axis)
    corners = np.full((4, 3), x)
    corners[:, a], corners[:, b] = half_m * np.array([-1, 1, 1, -1]), half_m * np.array([-1, -1, 1, 1])
    order = [[0, 1, 2], [0, 2, 3]] if facing == 0 else [[0, 2, 1], [0, 3, 2]]
    return np.asarray(corners[np.array(order)])


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Array:
    """Twelve triangles (12, 3, 3): the closed surface of a box."""
    corners = np.array([[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return np.asarray(corners[np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])])


def brute_force(origin: Array, directions: Array, corners: Array, start_m: float) -> tuple[Array, Array]:
    """Distance (n,) to the first of the triangles (t, 3, 3), inf without one, and the lowest number there, or -1."""
    if not len(directions) or not len(corners):
        return np.full(len(directions), np.inf), np.full(len(directions), -1)
    low, high = corners.min(axis=1) - GROWN_M, corners.max(axis=1) + GROWN_M
    parts = np.array_split(directions, -(-len(directions) * len(corners) // 100_000))
    t = np.concatenate([_meetings(origin, part[:, :, None], corners, low, high) for part in parts])
    t[~(t > start_m)] = np.inf
    distance = t.min(axis=1)
    return distance, np.where(np.isfinite(distance), t.argmin(axis=1), -1)


def _meetings(o: Array, directions: Array, corners: Array, low: Array, high: Array) -> Array:
    """Distances (n, t) of rays with directions (n, 3, 1) to triangles, inf where they do not meet."""
    d = directions.swapaxes(0, 1)
    t0, t1 = np.zeros((len(directions), len(corners))), np.full((len(directions), len(corners)), np.inf)
    with np.errstate(all="ignore"):
        for axis in range(3):
            a, b = (low[:, axis] - o[axis]) / d[axis], (high[:, axis] - o[axis]) / d[axis]
            outside = (o[axis] < low[:, axis]) | (o[axis] > high[:, axis])
            level, never = d[axis] == 0.0, np.where(outside, np.inf, 0.0)
            t0 = np.maximum(t0, np.where(level, never, np.minimum(a, b)))
            t1 = np.where(level, np.where(outside, -np.inf, t1), np.minimum(t1, np.maximum(a, b)))
        ux, uy, uz = (corners[:, 1] - corners[:, 0]).T
        vx, vy, vz = (corners[:, 2] - corners[:, 0]).T
        px, py, pz = d[1] * vz - d[2] * vy, d[2] * vx - d[0] * vz, d[0] * vy - d[1] * vx
        volume = ux * px + uy * py + uz * pz
        sx, sy, sz = (o - corners[:, 0]).T
        u = (sx * px + sy * py + sz * pz) / volume
        qx, qy, qz = sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux
        v = (d[0] * qx + d[1] * qy + d[2] * qz) / volume
        t = np.clip((vx * qx + vy * qy + vz * qz) / volume, t0, t1)
        met = (t0 <= t1) & (volume != 0.0) & (u >= -EDGE) & (v >= -EDGE) & (u + v <= 1.0 + EDGE)
    return np.where(met, t, np.inf)
