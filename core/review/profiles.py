"""Profiles of objects that sensors must see: cylinders placed relative to the car's outermost points.

A profile is data: those that ship with the program are in `assets/review/blind.yaml`, and a user's own are files of the
same form. Every profile names its source.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from riglens.assets import asset_path
from riglens.core.blind.outline import Outline
from riglens.core.blind.zones import By
from riglens.core.errors import InputError
from riglens.core.plain import Frozen
from riglens.core.rig.model import Vehicle
from riglens.core.rig.yaml.checked import read_checked

ONLY_GEOMETRY = "geometry only, no approval"
MAX_OBJECTS = 2_000
Along = Annotated[float, Field(allow_inf_nan=False, ge=-100.0, le=100.0)]
Size = Annotated[float, Field(allow_inf_nan=False, ge=0.01, le=10.0)]
Text = Annotated[str, Field(min_length=1, max_length=500)]
_X, _Y = ("ahead", "behind", "x"), ("left", "right", "y")


class Shape(Frozen):
    """An upright cylinder, metres."""

    height: Size
    diameter: Size


class Place(Frozen):
    """Place of an object's middle: one of ahead, behind, x and one of left, right, y, metres."""

    name: Text | None = None
    ahead: Along | None = None
    behind: Along | None = None
    x: Along | None = None
    left: Along | None = None
    right: Along | None = None
    y: Along | None = None

    @model_validator(mode="after")
    def _one_of_each(self) -> Self:
        for names in (_X, _Y):
            if sum(getattr(self, name) is not None for name in names) != 1:
                raise ValueError(f"specify exactly one of {', '.join(names)}")
        return self

    def at_m(self, outline: Outline) -> tuple[float, float]:
        """Return x and y in the vehicle frame."""
        xs = ((self.ahead, outline.front_m, 1.0), (self.behind, outline.rear_m, -1.0), (self.x, 0.0, 1.0))
        ys = ((self.left, outline.left_m, 1.0), (self.right, outline.right_m, -1.0), (self.y, 0.0, 1.0))
        return _first(xs), _first(ys)


def _first(said: tuple[tuple[float | None, float, float], ...]) -> float:
    """Return the given place: an offset from an edge, outwards by its sign."""
    return next(edge_m + sign * offset_m for offset_m, edge_m, sign in said if offset_m is not None)


Span = tuple[Along, Along]
Category = Literal["M1", "M2", "M3", "N1", "N2", "N3"]
"""Of vehicles, as in UNECE's R.E.3: cars, buses up to and over 5 t; vans, trucks up to and over 12 t."""
_HEAVY: tuple[Category, ...] = ("M2", "M3", "N2", "N3")


class Area(Frozen):
    """A rectangle: from and to, ahead of the front or behind the rear; left, right, or across the car's width."""

    ahead: Span | None = None
    behind: Span | None = None
    left: Span | None = None
    right: Span | None = None
    across: Literal["width"] | None = None

    @model_validator(mode="after")
    def _two_sides(self) -> Self:
        if (self.ahead is None) == (self.behind is None):
            raise ValueError("specify exactly one of ahead, behind")
        if sum(side is not None for side in (self.left, self.right, self.across)) != 1:
            raise ValueError("specify exactly one of left, right, across")
        return self

    def spans_m(self, outline: Outline) -> tuple[Span, Span]:
        """Return the spans along x and along y in the vehicle frame."""
        if self.ahead is not None:
            x = (outline.front_m + self.ahead[0], outline.front_m + self.ahead[1])
        else:
            assert self.behind is not None
            x = (outline.rear_m - self.behind[1], outline.rear_m - self.behind[0])
        if self.left is not None:
            y = (outline.left_m + self.left[0], outline.left_m + self.left[1])
        elif self.right is not None:
            y = (outline.right_m - self.right[1], outline.right_m - self.right[0])
        else:
            y = (outline.right_m, outline.left_m)
        return (min(x), max(x)), (min(y), max(y))


class Profile(Frozen):
    """Objects of one shape, the condition for seeing one, and the source.

    An object is seen by `rays` rays or more of the sensors in `by`, and with `share` by one of them that has so much of
    the surface that faces it in view. `vehicles`: the UN categories that the source is about, none for any.
    `from_memory`: places or sizes were not compared with the source; such a profile is not used in reports.
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]{0,59}$")]
    title: Text
    source: Text
    vehicles: tuple[Category, ...] = ()
    from_memory: bool = False
    by: By = "any"
    rays: Annotated[int, Field(ge=1, le=1_000_000)] = 1
    share: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    object: Shape
    at: Annotated[tuple[Place, ...], Field(max_length=MAX_OBJECTS)] = ()
    field: Area | None = None
    spacing: Annotated[float, Field(ge=0.02, le=100.0)] = 0.5

    def is_for(self, vehicle: Vehicle) -> bool:
        """Return whether the source is about such vehicles: trucks and buses, or cars and vans."""
        heavy = {category in _HEAVY for category in self.vehicles}
        return not heavy or (vehicle.body == "truck") in heavy

    @model_validator(mode="after")
    def _has_objects(self) -> Self:
        if (not self.at) == (self.field is None):
            raise ValueError("specify exactly one of at, field")
        return self


class Profiles(Frozen):
    """A file of profiles."""

    riglens_profiles: Literal[1]
    profiles: Annotated[tuple[Profile, ...], Field(min_length=1, max_length=200)]

    @model_validator(mode="after")
    def _names_unique(self) -> Self:
        names = [profile.name for profile in self.profiles]
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"profile '{name}' is given twice")
        return self


@dataclass(frozen=True)
class Target:
    """One object of a profile: an upright cylinder on the ground, metres in the vehicle frame."""

    name: str
    x_m: float
    y_m: float
    radius_m: float
    height_m: float

    @property
    def cylinder(self) -> tuple[float, float, float, float, float]:
        """x, y, radius, bottom, top."""
        return self.x_m, self.y_m, self.radius_m, 0.0, self.height_m


def targets_of(profile: Profile, outline: Outline) -> tuple[Target, ...]:
    """Return the objects of a profile around a car; those of a field are spaced evenly from edge to edge, the car's
    left first."""
    radius, height = profile.object.diameter / 2, profile.object.height
    if profile.field is None:
        return tuple(
            Target(place.name or str(number), *place.at_m(outline), radius, height)
            for number, place in enumerate(profile.at, 1)
        )
    (x0, x1), (y0, y1) = profile.field.spans_m(outline)
    rows, columns = (math.ceil(round((b - a) / profile.spacing, 9)) + 1 for a, b in ((x0, x1), (y0, y1)))
    if rows * columns > MAX_OBJECTS:
        raise InputError(f"{profile.name}: must be at most {MAX_OBJECTS} objects (got {rows * columns})")
    xs, ys = np.linspace(x1, x0, rows).tolist(), np.linspace(y1, y0, columns).tolist()
    return tuple(
        Target(f"{row + 1}.{column + 1}", x, y, radius, height)
        for row, x in enumerate(xs)
        for column, y in enumerate(ys)
    )


def read_profiles(path: str | os.PathLike[str]) -> tuple[Profile, ...]:
    """Read a file of profiles; InputError with file, line and field when one is wrong, or has the name of a bundled
    profile and differs from it: verdicts name their profile."""
    found, bundled = _read(path), {one.name: one for one in bundled_profiles()}
    for one in found:
        if bundled.get(one.name, one) != one:
            raise InputError(
                f"{path}: profile '{one.name}' differs from the bundled one of that name: rename it"
            )
    return found


def _read(path: str | os.PathLike[str]) -> tuple[Profile, ...]:
    return read_checked(
        path, Profiles, "a file of blind zone profiles, which starts with riglens_profiles: 1"
    ).profiles


@cache
def bundled_profiles() -> tuple[Profile, ...]:
    """Return the profiles that ship with the program."""
    return _read(asset_path("review/blind.yaml"))


def profiles_in(files: Sequence[Path]) -> tuple[Profile, ...]:
    """Return the profiles of some files, of those that ship with the program where none is named."""
    return tuple(p for path in files for p in read_profiles(path)) if files else bundled_profiles()
