"""Where no sensor is to stand, as it is painted on the car. No Qt, no VTK."""

from __future__ import annotations

from dataclasses import dataclass

from riglens.core.geometry import Vec3
from riglens.core.rig.model import Spot

Box = tuple[Vec3, Vec3]
"""The lowest and the highest corner, metres."""


@dataclass(frozen=True)
class Zone:
    """A material of the car, the parts of it that lie in boxes, or what is both; None: any material."""

    material: str | None = None
    boxes_m: tuple[Box, ...] = ()


@dataclass(frozen=True)
class KeepOut:
    """What is painted on the car: zones that somebody requires, and the spots of the rig itself."""

    zones: tuple[Zone, ...] = ()
    spots: tuple[Spot, ...] = ()
