"""Compute where the car's own body stops the rays of its sensors, once per sensor and body in a process."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Sensor, Vehicle
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.targets.beams import stops_of
from riglens.core.vehicle.solid import Solid, solid_of


@dataclass(frozen=True)
class OwnBody:
    """The body of a car; two of the same fingerprint are the same."""

    fingerprint: str
    solid: Solid = field(compare=False, repr=False)


def own_body(vehicle: Vehicle) -> OwnBody:
    """Return the body of a vehicle; InputError where it is a file whose mesh was not read."""
    solid = solid_of(vehicle)
    return OwnBody(solid.fingerprint, solid)


@lru_cache(maxsize=32)
def stopped_m(sensor: Sensor, body: OwnBody) -> NDArray[np.float64]:
    """As `riglens.core.targets.beams.stops_of`; a native camera takes seconds, and a process meets it many times."""
    return stops_of(sensor, barrier_of(sensor, body.solid))
