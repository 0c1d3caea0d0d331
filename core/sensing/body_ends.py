"""Where the rays of a sensor end at the car's own body."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.kernels.cast import Cast
from riglens.core.rig.library import Cylinder, default_library
from riglens.core.rig.model import Sensor
from riglens.core.sensing.rays import lattice
from riglens.core.vehicle.solid import Barrier, Solid

USUAL_RADIUS_M = {"lidar": 0.105, "camera": 0.05}
"""Radius of the housing of a sensor whose model is not known, or has no size in the library: our choice."""


def housing_radius_m(sensor: Sensor) -> float:
    """Radius of the ball around a sensor that its housing fits in: what is nearer than this stops none of its rays.

    Half the diagonal of the housing in the sensor library.
    """
    known = _known_radius_m(sensor.model) if sensor.model else None
    return USUAL_RADIUS_M[sensor.kind] if known is None else known


@lru_cache(maxsize=256)
def _known_radius_m(model: str) -> float | None:
    try:
        body = default_library().entry(model).body_m
    except InputError:
        return None
    if body is None:
        return None
    sides = (
        (body.diameter, body.height) if isinstance(body, Cylinder) else (body.length, body.width, body.height)
    )
    return float(np.linalg.norm(sides)) / 2


def barrier_of(sensor: Sensor, solid: Solid) -> Barrier:
    """What of the car stops the rays of a sensor."""
    return solid.barrier(sensor.kind, housing_radius_m(sensor))


def rays_in_metres(sensor: Sensor) -> Cast:
    """The rays of a sensor in the vehicle frame, for kernels that know no grid."""
    table = lattice(sensor)
    return Cast(
        table.kind,
        table.rows,
        table.planes,
        np.array(sensor.position, np.float64),
        sensor.pose.rotation(),
        np.array(sensor.range_m),
        np.zeros(6, np.int64),
        np.zeros(3, np.int64),
        False,
        np.zeros(0),
    )


def body_ends(sensor: Sensor, solid: Solid, workers: int = 1) -> NDArray[np.float64]:
    """Distance in metres (rays,) at which each ray first meets the solid beyond the housing, inf where it is free.

    Rays as in `lattice(sensor).directions()`: row by row, of a listed sensor those that exist. Range limits play no
    part. With one worker any thread may call it, with more only the one that owns the parallel kernels.
    """
    return barrier_ends(sensor, barrier_of(sensor, solid), workers)


def barrier_ends(sensor: Sensor, barrier: Barrier, workers: int = 1) -> NDArray[np.float64]:
    """As `body_ends`, for what stops the sensor's rays."""
    from riglens.core.kernels import solid as kernel  # the compiler

    rays = rays_in_metres(sensor)
    ends = np.full(len(rays.rows) * len(rays.planes), np.inf)
    if not len(barrier.stops):
        return ends
    if workers == 1:
        kernel.ends_by_tree(rays, *barrier, ends)
    else:
        kernel.ends_by_tree_parallel(rays, *barrier, workers, ends)
    return ends
