"""Define car bodies as data: control nets, decals and blocks of a reference car, metres."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from typing import Literal, NamedTuple

from pydantic import TypeAdapter

from riglens.assets import asset_path
from riglens.core.rig.model import Vehicle

BODIES = asset_path("bodies.toml")
"""The built-in bodies, by the names that a rig file may give."""

Polygon = tuple[tuple[float, float], ...]
Plane = Literal["xz", "yz", "xy"]
Facing = Literal["+x", "-x", "|y|", "+z", "-z"]


class Decal(NamedTuple):
    """A region painted in another material where the surface faces along `facing` (e.g. "+x", "|y|").

    The polygon lies in `plane`, with |y| in place of y, so that one entry serves both sides.
    """

    material: str
    plane: Plane
    facing: Facing
    polygon: Polygon
    round_m: float = 0.0


class Station(NamedTuple):
    """One cross-section of the lower body at `x`: half width and the heights that shape it, metres."""

    x: float
    half_width: float
    z_bottom: float
    z_shoulder: float
    z_deck: float


class CabinOutline(NamedTuple):
    """One horizontal outline of the cabin at height `z`: front and rear ends and half width, metres."""

    z: float
    x_front: float
    x_rear: float
    half_width: float


class ShutLine(NamedTuple):
    """A thin gap between panels: a path of points in `plane`, on the side that faces along `facing`."""

    plane: Plane
    facing: Facing
    path: Polygon
    half_width_m: float = 0.007


class Region(NamedTuple):
    """A part of the body that opens: a polygon in `plane` on the side that faces along `facing`, at least `beyond_m`
    from the origin that way."""

    plane: Plane
    facing: Facing
    polygon: Polygon
    beyond_m: float = 0.0


class RoundedBlock(NamedTuple):
    """A box with rounded edges from corner `low` to `high`, metres; `on_both_sides` adds its image at -y."""

    material: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    round_m: float = 0.03
    on_both_sides: bool = False
    shut_lines: tuple[ShutLine, ...] = ()


@dataclass(frozen=True)
class BodyProfile:
    """A body of reference size; `axle_x` and `wheel_width_m` are rear and front, radii are about the axles.

    The lower body is lofted along x over `stations`, the cabin upwards over `cabin`; either may be missing.
    """

    length_m: float
    width_m: float
    height_m: float
    axle_x: tuple[float, float]
    wheel_radius_m: float
    wheel_width_m: tuple[float, float]
    arch_radius_m: float
    stations: tuple[Station, ...]
    cabin: tuple[CabinOutline, ...]
    body_decals: tuple[Decal, ...]
    shut_lines: tuple[ShutLine, ...]
    cabin_decals: tuple[Decal, ...]
    mirror_m: tuple[float, float, float]
    mirror_radii_m: tuple[float, float, float] = (0.075, 0.125, 0.075)
    arch_lip_m: float = 0.022
    cabin_shut_lines: tuple[ShutLine, ...] = ()
    cabin_bow_m: float = 0.10
    blocks: tuple[RoundedBlock, ...] = ()
    mirror_arms: tuple[RoundedBlock, ...] = ()
    mirror_decals: tuple[Decal, ...] = ()
    doors: tuple[Region, ...] = ()
    lids: tuple[Region, ...] = ()


@cache
def _profiles() -> dict[str, BodyProfile]:
    with BODIES.open("rb") as file:
        return TypeAdapter(dict[str, BodyProfile]).validate_python(tomllib.load(file))


def profile_of(body: str) -> BodyProfile:
    """Return a built-in body; KeyError for an unknown one."""
    return _profiles()[body]


def reference_vehicle(body: str) -> Vehicle:
    """Return a vehicle with a built-in body at its reference size; KeyError for an unknown body."""
    profile = profile_of(body)
    return Vehicle(
        body=body,
        length=profile.length_m,
        width=profile.width_m,
        height=profile.height_m,
        rear_axle_x=profile.axle_x[0],
    )
