"""Car bodies as data: control nets and decals of a reference car, metres; other sizes are scaled from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Polygon = tuple[tuple[float, float], ...]
Plane = Literal["xz", "yz", "xy"]
Facing = Literal["+x", "-x", "|y|", "+z", "-z"]


@dataclass(frozen=True)
class Decal:
    """A region painted in another material where the surface faces along `facing` (e.g. "+x", "|y|").

    The polygon lies in `plane`, with |y| in place of y, so that one entry serves both sides.
    """

    material: str
    plane: Plane
    facing: Facing
    polygon: Polygon
    round_m: float = 0.0


@dataclass(frozen=True)
class Station:
    """One cross-section of the lower body at `x`: half width and the heights that shape it, metres."""

    x: float
    half_width: float
    z_bottom: float
    z_shoulder: float
    z_deck: float


@dataclass(frozen=True)
class Level:
    """One horizontal outline of the cabin at height `z`: front and rear ends and half width, metres."""

    z: float
    x_front: float
    x_rear: float
    half_width: float


@dataclass(frozen=True)
class BodyProfile:
    """A body of reference size; `axle_x` is rear and front, radii are about the axles."""

    length_m: float
    width_m: float
    height_m: float
    axle_x: tuple[float, float]
    wheel_radius_m: float
    wheel_width_m: float
    arch_radius_m: float
    stations: tuple[Station, ...]
    cabin: tuple[Level, ...]
    body_decals: tuple[Decal, ...]
    shut_lines: tuple[ShutLine, ...]
    cabin_decals: tuple[Decal, ...]
    mirror_m: tuple[float, float, float]


@dataclass(frozen=True)
class ShutLine:
    """A thin gap between panels: a path of points in `plane`, on the side that faces along `facing`."""

    plane: Plane
    facing: Facing
    path: Polygon
    half_width_m: float = 0.007


SEDAN = BodyProfile(
    length_m=4.6,
    width_m=1.9,
    height_m=1.45,
    axle_x=(-1.35, 1.35),
    wheel_radius_m=0.34,
    wheel_width_m=0.23,
    arch_radius_m=0.388,
    stations=(
        Station(-2.31, 0.00, 0.44, 0.62, 0.62),
        Station(-2.31, 0.62, 0.30, 0.84, 0.92),
        Station(-2.28, 0.86, 0.24, 0.93, 1.02),
        Station(-2.14, 0.945, 0.21, 0.955, 1.055),
        Station(-1.85, 0.975, 0.19, 0.965, 1.045),
        Station(-1.45, 0.985, 0.175, 0.965, 1.03),
        Station(-0.90, 0.975, 0.17, 0.955, 1.00),
        Station(-0.30, 0.970, 0.17, 0.940, 0.98),
        Station(0.30, 0.970, 0.17, 0.925, 0.97),
        Station(0.90, 0.975, 0.17, 0.905, 0.985),
        Station(1.35, 0.985, 0.175, 0.870, 0.945),
        Station(1.75, 0.970, 0.18, 0.815, 0.885),
        Station(2.05, 0.925, 0.19, 0.745, 0.815),
        Station(2.22, 0.840, 0.20, 0.680, 0.735),
        Station(2.30, 0.640, 0.23, 0.600, 0.640),
        Station(2.31, 0.00, 0.42, 0.48, 0.48),
    ),
    cabin=(
        Level(0.86, 1.30, -1.98, 0.83),
        Level(0.96, 1.12, -1.84, 0.815),
        Level(1.16, 0.74, -1.46, 0.735),
        Level(1.33, 0.38, -1.06, 0.655),
        Level(1.425, 0.14, -0.78, 0.59),
        Level(1.452, -0.10, -0.58, 0.46),
        Level(1.457, -0.22, -0.38, 0.0),
    ),
    body_decals=(
        Decal("dark", "xy", "-z", ((-3.0, -1.0), (3.0, -1.0), (3.0, 2.0), (-3.0, 2.0))),
        Decal("lamp", "yz", "+x", ((0.53, 0.615), (0.50, 0.675), (1.0, 0.765), (1.0, 0.665)), 0.012),
        Decal("trim", "yz", "+x", ((-1.0, 0.49), (-1.0, 0.635), (0.42, 0.635), (0.33, 0.49)), 0.02),
        Decal("trim", "yz", "+x", ((-1.0, 0.25), (-1.0, 0.345), (0.62, 0.345), (0.74, 0.25)), 0.02),
        Decal("trim", "yz", "+x", ((0.66, 0.38), (0.70, 0.47), (0.86, 0.47), (0.80, 0.38)), 0.02),
        Decal("plate", "yz", "+x", ((-1.0, 0.375), (-1.0, 0.475), (0.26, 0.475), (0.26, 0.375))),
        Decal("tail", "yz", "-x", ((0.42, 0.775), (0.40, 0.875), (1.0, 0.925), (1.0, 0.80)), 0.012),
        Decal("plate", "yz", "-x", ((-1.0, 0.66), (-1.0, 0.76), (0.26, 0.76), (0.26, 0.66))),
        Decal("trim", "yz", "-x", ((-1.0, 0.20), (-1.0, 0.345), (0.70, 0.345), (0.78, 0.20)), 0.02),
        Decal("trim", "xz", "|y|", ((-0.09, 0.775), (-0.09, 0.80), (-0.27, 0.80), (-0.27, 0.775))),
        Decal("trim", "xz", "|y|", ((-0.90, 0.80), (-0.90, 0.825), (-1.08, 0.825), (-1.08, 0.80))),
        Decal("trim", "xz", "|y|", ((-3.0, 0.10), (-3.0, 0.245), (3.0, 0.245), (3.0, 0.10))),
    ),
    shut_lines=(
        ShutLine("xz", "|y|", ((0.80, 0.93), (0.84, 0.66), (0.76, 0.36), (0.70, 0.30), (-0.28, 0.30))),
        ShutLine("xz", "|y|", ((-0.28, 0.30), (-0.34, 0.60), (-0.32, 0.96))),
        ShutLine("xz", "|y|", ((-0.28, 0.30), (-0.86, 0.30), (-0.92, 0.40), (-1.08, 0.74), (-1.30, 0.965))),
        ShutLine("xy", "+z", ((1.10, 0.74), (1.60, 0.69), (2.16, 0.56), (2.24, 0.40), (2.27, 0.0))),
        ShutLine("xy", "+z", ((-1.80, 0.0), (-1.80, 0.62), (-2.0, 0.70), (-2.22, 0.68))),
        ShutLine("xz", "|y|", ((1.62, 0.60), (1.86, 0.50), (2.30, 0.50))),
        ShutLine("xz", "|y|", ((-1.66, 0.62), (-1.84, 0.52), (-2.30, 0.52))),
    ),
    cabin_decals=(
        Decal("glass", "yz", "+x", ((-1.0, 0.985), (-1.0, 1.375), (0.535, 1.355), (0.70, 0.985)), 0.02),
        Decal("glass", "yz", "-x", ((-1.0, 1.035), (-1.0, 1.37), (0.50, 1.35), (0.66, 1.035)), 0.02),
        Decal("glass", "xz", "|y|", ((0.735, 0.965), (0.21, 1.345), (-0.255, 1.365), (-0.285, 0.965)), 0.02),
        Decal(
            "glass",
            "xz",
            "|y|",
            ((-0.365, 0.965), (-0.335, 1.365), (-0.78, 1.335), (-1.22, 1.10), (-1.27, 0.98)),
            0.02,
        ),
        Decal("trim", "xz", "|y|", ((-0.285, 0.95), (-0.255, 1.37), (-0.335, 1.37), (-0.365, 0.95))),
    ),
    mirror_m=(0.70, 0.985, 0.965),
)

PROFILES = {"sedan": SEDAN}
