"""Register the kinds of sensors: everything that depends on the kind follows from these entries."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Generic, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Vec3
from riglens.core.sensors.base import Sensor
from riglens.core.sensors.lattice import Ids, Lattice

S = TypeVar("S", bound=Sensor)
Doubles = NDArray[np.float64]


@dataclass(frozen=True)
class Occlusion:
    """Self-occlusion of a kind: the body stops no rays within `housing_radius_m` of the sensor, the radius of a housing
    whose model is not known, nor within `passes_within_m`, whatever the housing, as a bumper's skin lets radar pass,
    nor where it is of glass, if the sensor sees through that."""

    housing_radius_m: float
    sees_through_glass: bool = False
    passes_within_m: float = 0.0


@dataclass(frozen=True)
class Placement:
    """Default mount of a new sensor: its height above the roof, and its rotation, in degrees, from the outward normal
    (3,) of a surface; one that is kept level faces ahead, or `away_when_level` from the surface.

    in_bumpers_m: heights from and to where it is mounted in bumpers, None for kinds that stand anywhere on the car;
    may_cover: parts of the body, kept free of others, that it may sit on.
    """

    above_roof_m: float
    rpy_deg: Callable[[Doubles], Vec3]
    away_when_level: bool = False
    in_bumpers_m: tuple[float, float] | None = None
    may_cover: tuple[str, ...] = ()


@dataclass(frozen=True)
class Echo:
    """An object that sends waves back: its class, "" for none, and its width in metres, None if it is not known."""

    cls: str = ""
    width_m: float | None = None


REFERENCE = Echo()
"""The object that a voxel counts as, which a data sheet's range refers to."""


@dataclass(frozen=True)
class HitMeasure:
    """Measure of a sensor's hits on an object.

    `measure`: "points" counts the rays of LiDARs, "pixels" the rows of the image that shows it tallest, "returns" the
    rays of any other kind. From `threshold` of them on, `label` in sentences and `unit` behind a number, an object is
    detected.
    """

    measure: Literal["points", "pixels", "returns"]
    threshold: float
    label: str
    unit: str


@dataclass(frozen=True, eq=False)
class SensorKind(Generic[S]):
    """A kind of sensor.

    name: its key in rig files, JSON and on the command line; title, plural: in sentences; model: its fields and limits.
    directions: unit directions (n, 3) in the sensor frame of rays by number, row * columns + column; NaN where there is
    none. lattice: tables that give the same doubles, None for a sensor whose rays have to be listed one by one.
    view_deg: horizontal and vertical field of view. brief: its type in a few characters; size: the heading and the text
    of a column of its resolution; summary: captions and values that follow from its fields.
    spelled_out: of fields that can be written in several ways, what they say as an array.
    library_figures: data-sheet entries of the sensor library that this kind has.
    score_weight: in S-MS; "lambda" is the camera weight of the settings, 0 for kinds that the paper does not know.
    has_range_law: whether the range law decides which of its rays return.
    spins: whether a turn may start at any azimuth, so that each frame has a phase of its own.
    coarse_power: of the ratio between what two rigs see on voxels twice as large, in an estimate on those.
    limits_m: how far each row of the lattice reaches an object (rows,), beside `range_m`; None: no other limit.
    in_field: whether places (n, 3) of an object in the sensor frame, so far off (n,), are in view; None: by `view_deg`.
    cells: resolution cells (n, k) of places (n, 3) in the sensor frame: objects in the same one count once.
    blocks: how many lattices of equal rows lie above each other in that of a sensor.
    """

    name: str
    title: str
    plural: str
    model: type[S]
    directions: Callable[[S, Ids], Doubles]
    view_deg: Callable[[S], tuple[float, float]]
    brief: Callable[[S], str]
    size: tuple[str, Callable[[S], str]]
    summary: Callable[[S], list[tuple[str, str]]]
    occlusion: Occlusion
    placement: Placement
    hits: HitMeasure
    lattice: Callable[[S], Lattice | None] = lambda _: None
    spelled_out: Mapping[str, Callable[[S], Doubles]] = field(default_factory=dict)
    library_figures: tuple[str, ...] = ()
    score_weight: float | Literal["lambda"] = 0.0
    has_range_law: bool = False
    coarse_power: float = 1.0
    spins: bool = False
    limits_m: Callable[[S, Echo], Doubles | None] = lambda *_: None
    in_field: Callable[[S, Doubles, Doubles, Echo], NDArray[np.bool_]] | None = None
    cells: Callable[[S, Doubles], NDArray[np.int64]] | None = None
    blocks: Callable[[S], int] = lambda _: 1

    @property
    def heading(self) -> str:
        """Plural that begins with a capital, above lists."""
        return self.plural[:1].upper() + self.plural[1:]
