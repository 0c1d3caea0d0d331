"""Prepare masts of sensors without support, and rays that end at the car's body, for the 3D view."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Vec3
from riglens.core.vehicle.standing import MountStatus


@dataclass(frozen=True)
class Mast:
    """Line from a sensor to `foot_m`; its label in short, and in full where there is room.

    `is_buried`: the sensor is inside the body or in the ground, so that the line is seen through both.
    """

    name: str
    foot_m: Vec3
    short: str
    full: str
    is_buried: bool = False


@dataclass(frozen=True, eq=False)
class Stubs:
    """Rays of a sensor at `place_m` that the car's own body stops, at ends_m (n, 3). Equal only to itself."""

    name: str
    place_m: Vec3
    ends_m: NDArray[np.float32]


def masts_of(stands: Mapping[str, MountStatus]) -> tuple[Mast, ...]:
    """Return a mast for each sensor with a place that is wrong."""
    return tuple(
        Mast(name, found.foot_m, found.height, found.problem, found.inside or found.below_ground)
        for name, found in stands.items()
        if found.problem
    )
