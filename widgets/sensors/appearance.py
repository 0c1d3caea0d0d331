"""Appearance of each kind of sensor: one entry per built-in kind, and a default for any other. No Qt, no VTK."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR, Lidar
from riglens.core.sensors.radar import RADAR
from riglens.core.sensors.registry import BUILT_IN, kind_named
from riglens.core.sensors.ultrasonic import ULTRASONIC
from riglens.widgets.sensors.field_variants import CAMERA_VARIANTS, LIDAR_VARIANTS, FieldVariants
from riglens.widgets.theme import Palette, mix

Shape = Literal["puck", "box", "lens"]
ALL_ROUND_DEG = 300.0
_SELECTED_SHARE = 0.5


@dataclass(frozen=True, eq=False)
class Beams:
    """Rows of rays that turn about the sensor's axis: their numbers (n,) from the lowest up, and whether they close."""

    upwards: NDArray[np.int64]
    goes_round: bool


@dataclass(frozen=True)
class Appearance:
    """Appearance of the sensors of a kind.

    colour: of their bodies and in panels; ray_colours: on dark and on light ground; icon: SVG paths in a square of 24.
    shape: of a body; cuboid: of one that the library knows as a box. beams: None for rays that form no rows that turn.
    outline: the sensor with rows and columns of rays over the same field of view.
    has_corners: whether the rays in the corners of the lattice bound the field of view.
    is_fan: whether each block of the lattice is drawn as its middle row alone, with an arc at its range.
    scale: of the shape, where the library does not know the size.
    heading: above its own fields; variants: fields among them that can be given in several ways.
    """

    colour: str = "#8b5cf6"
    ray_colours: tuple[str, str] = ("#c4a5ff", "#7c3aed")
    icon: str = '<circle cx="12" cy="12" r="3.5"/><path d="M17 7a7 7 0 0 1 0 10M20 4a11 11 0 0 1 0 16"/>'
    shape: Callable[[Any], Shape] = lambda _: "box"
    cuboid: Shape = "box"
    beams: Callable[[Any], Beams | None] = lambda _: None
    outline: Callable[[Any], Any] = lambda sensor: sensor
    has_corners: bool = False
    is_fan: bool = False
    scale: float = 1.0
    heading: str = "Sensor"
    variants: tuple[FieldVariants, ...] = ()


def _lidar_shape(lidar: Lidar) -> Shape:
    """Return the shape of a LiDAR: spinning if it sees nearly all round, else solid-state."""
    azimuths = lidar.azimuths()
    span_deg = float(azimuths.max() - azimuths.min()) * (1.0 + 1.0 / max(1, len(azimuths) - 1))
    return "puck" if span_deg >= ALL_ROUND_DEG or len(azimuths) == 1 else "box"


def _lidar_beams(lidar: Lidar) -> Beams | None:
    if lidar.rays is not None:
        return None
    turn_deg = lidar.azimuths()
    goes_round = float(turn_deg[-1] - turn_deg[0]) > ALL_ROUND_DEG
    return Beams(np.argsort(lidar.elevations(), kind="stable"), goes_round)


PLAIN = Appearance()
APPEARANCES = {
    LIDAR.name: Appearance(
        colour="#14b8a6",
        ray_colours=("#3fe0cb", "#056069"),
        icon='<ellipse cx="12" cy="7" rx="6" ry="2.5"/><path d="M6 7v8c0 1.4 2.7 2.5 6 2.5s6-1.1 6-2.5V7"/>'
        '<path d="M2 11h2M20 11h2M12 21h0"/>',
        shape=_lidar_shape,
        beams=_lidar_beams,
        outline=Lidar.raster,
        heading="Beams",
        variants=LIDAR_VARIANTS,
    ),
    CAMERA.name: Appearance(
        colour="#f97316",
        ray_colours=("#ff9a52", "#c2500a"),
        icon='<rect x="3" y="7" width="12" height="10" rx="1.5"/><path d="M15 11l6-3v8l-6-3"/>',
        shape=lambda _: "lens",
        cuboid="lens",
        has_corners=True,
        heading="Image and lens",
        variants=CAMERA_VARIANTS,
    ),
    RADAR.name: Appearance(
        colour="#84cc16",
        ray_colours=("#b6e24a", "#4f9300"),
        icon='<path d="M12 20L4.5 9.5a9.5 9.5 0 0 1 15 0z"/><path d="M8.3 14.8a5 5 0 0 1 7.4 0"/>',
        is_fan=True,
        scale=0.6,
        heading="Scans",
    ),
    ULTRASONIC.name: Appearance(
        colour="#38bdf8",
        ray_colours=("#7cc8ff", "#1d4ed8"),
        icon='<circle cx="6" cy="12" r="2"/><path d="M11 8a6 6 0 0 1 0 8M15 5.5a10 10 0 0 1 0 13"/>',
        shape=lambda _: "lens",
        cuboid="lens",
        is_fan=True,
        scale=0.3,
        heading="Sound",
    ),
}


def appearance_of(kind: str) -> Appearance:
    """Return how the sensors of the kind of that name look.

    A kind without an entry looks like the one that its model is derived from, in other colours, or else plain.
    """
    found, known = APPEARANCES.get(kind), kind_named(kind)
    if found is not None or known is None:
        return found or PLAIN
    models = {name: BUILT_IN[name].model for name in APPEARANCES}
    base = next(
        (APPEARANCES[name] for name, model in models.items() if issubclass(known.model, model)), PLAIN
    )
    return replace(base, colour=PLAIN.colour, ray_colours=PLAIN.ray_colours)


def colour_of(kind: str) -> str:
    """Return the colour of a kind in panels and of its bodies."""
    return appearance_of(kind).colour


def ray_colour(kind: str, palette: Palette) -> str:
    """Return the colour of the rays of a kind."""
    return appearance_of(kind).ray_colours[not palette.is_dark]


def selected_ray_colour(kind: str, palette: Palette) -> str:
    """Return the colour of the selected sensor's rays: its kind's, on the way to that of the selection."""
    return mix(ray_colour(kind, palette), palette.selected, _SELECTED_SHARE)
