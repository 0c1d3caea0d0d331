"""Housings of sensors as obstacles: a box or a cylinder around each sensor, of its model's size."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Pose
from riglens.core.rig.library import Cylinder, body_of
from riglens.core.rig.model import Rig, Sensor
from riglens.core.sensors.registry import kind_of
from riglens.core.vehicle.solid import Housing, Solid, joined, solid_of

Doubles = NDArray[np.float64]
SIDES = 32
"""Of the prism that stands for a cylinder; its edges lie on the cylinder."""
_CORNERS = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)], np.float64)
_FACES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))


def half_size_m(sensor: Sensor) -> Doubles:
    """Return half the sides (3,) of the box around a sensor's housing, whose middle is the sensor: that of its library
    model, or one of the usual size of its kind."""
    body = body_of(sensor.model)
    if body is None:
        return np.full(3, kind_of(sensor).occlusion.housing_radius_m / np.sqrt(3.0))
    if isinstance(body, Cylinder):
        return np.array([body.diameter, body.diameter, body.height]) / 2
    return np.array([body.length, body.width, body.height]) / 2


def housing_corners_m(sensor: Sensor) -> Doubles:
    """Return the corners (8, 3) of the box around a sensor's housing in the vehicle frame."""
    return np.asarray((_CORNERS * half_size_m(sensor)) @ sensor.pose.rotation().T + np.array(sensor.position))


def housing_of(sensor: Sensor) -> Housing:
    """Return the housing of a sensor as an obstacle."""
    half = half_size_m(sensor)
    x, y, z = (float(one) for one in half)
    is_round = isinstance(body_of(sensor.model), Cylinder)
    return Housing(sensor.name, sensor.pose, (x, y, z), is_round, float(np.linalg.norm(half)))


def car_of(rig: Rig, stance: Pose = Pose()) -> Solid:
    """Return what stops rays of a rig's sensors: the car's body as by `solid_of` and, where the rig says so, the
    housings of all its sensors, which stop the rays of every sensor but their own."""
    return with_housings(solid_of(rig.vehicle, stance), rig.obstacles)


def with_housings(solid: Solid, obstacles: Sequence[Sensor]) -> Solid:
    """Return a car's solid with the housings of sensors, if any."""
    return _housed(solid, tuple(map(housing_of, obstacles))) if obstacles else solid


@lru_cache(maxsize=2)
def _housed(solid: Solid, housings: tuple[Housing, ...]) -> Solid:
    parts = [one.pose.transform(_triangles(one.half_m, one.is_round)) for one in housings]
    return joined(solid, housings, parts)


@lru_cache(maxsize=64)
def _triangles(half_m: tuple[float, float, float], is_round: bool) -> Doubles:
    """Return the triangles (t, 3, 3) of a housing in the sensor frame."""
    if not is_round:
        corners = _CORNERS * half_m
        return np.array([corners[list(t)] for a, b, c, d in _FACES for t in ((a, b, c), (a, c, d))])
    turn = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)
    rim = np.stack([half_m[0] * np.cos(turn), half_m[1] * np.sin(turn), np.full(SIDES, half_m[2])], axis=1)
    top, down = rim, rim * [1.0, 1.0, -1.0]
    after, under = np.roll(top, -1, axis=0), np.roll(down, -1, axis=0)
    middle = np.broadcast_to([0.0, 0.0, half_m[2]], rim.shape)
    sides = [(top, after, down), (after, under, down), (top, after, middle), (down, under, -middle)]
    return np.concatenate([np.stack(side, axis=1) for side in sides])
