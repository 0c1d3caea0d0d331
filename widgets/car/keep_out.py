"""Keep-out zones, as they are painted on the car. No Qt, no VTK."""

from __future__ import annotations

from dataclasses import dataclass

from riglens.core.geometry import Vec3
from riglens.core.rig.model import Spot

Box = tuple[Vec3, Vec3]
"""The lowest and the highest corner, metres."""


@dataclass(frozen=True)
class Zone:
    """A material of the car, the parts of it in boxes, or both combined; None: any material."""

    material: str | None = None
    boxes_m: tuple[Box, ...] = ()


@dataclass(frozen=True)
class KeepOut:
    """Zones painted on the car: required ones, and the spots of the rig itself."""

    zones: tuple[Zone, ...] = ()
    spots: tuple[Spot, ...] = ()
