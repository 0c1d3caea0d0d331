"""Compute where the car's own body stops the rays of its sensors, once per sensor and body in a process."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from riglens.core.metric.scores import Body
from riglens.core.rig.model import Rig, Sensor
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.targets.beams import NOT_STOPPED, stops_of
from riglens.core.vehicle.housings import car_of
from riglens.core.vehicle.solid import Solid


def own_solid(rig: Rig, said: Body | None) -> Solid | None:
    """Return the body of a rig's car where it blocks, as said or else as the rig says."""
    return car_of(rig) if (said or rig.body) == "blocks" else None


@lru_cache(maxsize=32)
def stopped_m(sensor: Sensor, body: Solid | None) -> NDArray[np.float64]:
    """Return the distances of `riglens.core.targets.beams.stops_of`, kept: a native camera takes seconds, and a
    process needs it many times."""
    return NOT_STOPPED if body is None else stops_of(sensor, barrier_of(sensor, body))
