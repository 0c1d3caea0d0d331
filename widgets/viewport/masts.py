"""What the 3D view shows of sensors that stand on nothing: a line to where they should stand, and how far that is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from riglens.core.geometry import Vec3
from riglens.core.vehicle.standing import Stand


@dataclass(frozen=True)
class Mast:
    """A line from a sensor to `foot_m`; what it says in short, and in full where there is room.

    `is_buried`: the sensor is inside the body or in the ground, so that the line is seen through both.
    """

    name: str
    foot_m: Vec3
    short: str
    full: str
    is_buried: bool = False


def masts_of(stands: Mapping[str, Stand]) -> tuple[Mast, ...]:
    """Return a mast for each sensor with a place that is wrong."""
    return tuple(
        Mast(name, found.foot_m, found.height, found.problem, found.inside or found.below_ground)
        for name, found in stands.items()
        if found.problem
    )
