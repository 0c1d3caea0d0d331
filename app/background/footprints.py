"""Find footprints in a thread, with serial kernels, for the view to draw."""

from __future__ import annotations

from dataclasses import dataclass

from riglens.app.background.worker import Context
from riglens.core.footprint.ground import FOOTPRINTS
from riglens.core.rig.model import Sensor, Vehicle
from riglens.core.vehicle.housings import with_housings
from riglens.core.vehicle.solid import solid_of


@dataclass(frozen=True)
class FootprintsRequest:
    """Request for footprints of sensors, of cameras with bands of `px_per_m`: without what a body and the housings of
    `obstacles` hide, if there is a body."""

    sensors: tuple[Sensor, ...]
    px_per_m: tuple[float, ...]
    body: Vehicle | None
    obstacles: tuple[Sensor, ...]


def find_footprints(request: FootprintsRequest, context: Context[None]) -> None:
    """Find footprints, which the process keeps, until there is a newer request."""
    solid = None if request.body is None else with_housings(solid_of(request.body), request.obstacles)
    for number, sensor in enumerate(request.sensors):
        context.report(number / len(request.sensors))
        FOOTPRINTS.found(sensor, request.px_per_m, solid)
