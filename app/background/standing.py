"""Compute in a thread, with serial kernels, how sensors are mounted, and which rays of one of them the body stops."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.app.background.worker import Context
from riglens.core.geometry import Vec3
from riglens.core.rig.model import Sensor, Vehicle
from riglens.core.sensing.rays import sensor_rays
from riglens.core.vehicle.housings import with_housings
from riglens.core.vehicle.solid import solid_of
from riglens.core.vehicle.standing import MountStatus, mount_status

MOST_RAYS = 3000
NONE_M = np.zeros((0, 3), np.float32)


@dataclass(frozen=True)
class MountStatusRequest:
    """Request for the mounts of sensors on a body, by name and position, metres, and for the stopped rays of one
    sensor, if any; at the body, or at the housings of `obstacles`."""

    vehicle: Vehicle
    places_m: tuple[tuple[str, Vec3], ...]
    stopped_of: Sensor | None = None
    obstacles: tuple[Sensor, ...] = ()


MountStatusAnswer = tuple[Mapping[str, MountStatus], NDArray[np.float32]]
"""Mount of each sensor, by name, and where rays end at the body, (n, 3) metres."""


def stopped_rays(request: MountStatusRequest) -> NDArray[np.float32]:
    """Return where rays of the selected sensor end at the body, (n, 3): of evenly chosen ones, MOST_RAYS at most."""
    sensor = request.stopped_of
    if sensor is None:
        return NONE_M
    rows = np.arange(0, sensor.ray_count, max(1, -(-sensor.ray_count // MOST_RAYS)))
    directions = sensor_rays(sensor, rows).directions
    from riglens.core.sensing.body_ends import barrier_of, listed_ends  # the compiler

    solid = with_housings(solid_of(request.vehicle), request.obstacles)
    met_m = listed_ends(sensor, directions, barrier_of(sensor, solid))
    stopped = np.isfinite(met_m)
    return np.asarray(np.array(sensor.position) + met_m[stopped, None] * directions[stopped], np.float32)


class MountStatuses:
    """Mounts of sensors; cached while body and place stay the same, so a drag costs the moved sensor only."""

    def __init__(self) -> None:
        self._vehicle: Vehicle | None = None
        self._known: dict[Vec3, MountStatus] = {}

    def __call__(self, request: MountStatusRequest, context: Context[MountStatusAnswer]) -> MountStatusAnswer:
        """Return the answer to a request."""
        if request.vehicle != self._vehicle:
            self._vehicle, self._known = request.vehicle, {}
        solid, known = solid_of(request.vehicle), {}
        for _, place_m in request.places_m:
            context.stop_if_closing()
            known[place_m] = self._known.get(place_m) or mount_status(place_m, solid)
        self._known = known
        return {name: known[place_m] for name, place_m in request.places_m}, stopped_rays(request)
