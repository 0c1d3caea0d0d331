"""The parametric car bodies by name; each has a reference size, other sizes are scaled from it."""

from __future__ import annotations

from riglens.core.rig.model import Vehicle
from riglens.widgets.car.sedan import SEDAN
from riglens.widgets.car.suv import SUV
from riglens.widgets.car.truck import TRUCK
from riglens.widgets.car.types import BodyProfile
from riglens.widgets.car.van import VAN

PROFILES: dict[str, BodyProfile] = {"sedan": SEDAN, "suv": SUV, "van": VAN, "truck": TRUCK}


def reference_vehicle(body: str) -> Vehicle:
    """A vehicle with a parametric body at its reference size; KeyError for an unknown body."""
    profile = PROFILES[body]
    return Vehicle(
        body=body,
        length=profile.length_m,
        width=profile.width_m,
        height=profile.height_m,
        rear_axle_x=profile.axle_x[0],
    )
