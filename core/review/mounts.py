"""Check mounts: height, distance from the skin and from each other, overhang, and material under the sensor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from riglens.core.blind.outline import Outline
from riglens.core.geometry import Vec3
from riglens.core.plain import Frozen
from riglens.core.rig.model import Rig, Sensor, Vehicle
from riglens.core.sensors.registry import kind_named, kinds
from riglens.core.vehicle.housings import half_size_m, housing_corners_m
from riglens.core.vehicle.parts import PARTS
from riglens.core.vehicle.solid import MATERIALS, Solid, solid_of
from riglens.core.vehicle.standing import MountStatus, Skin, skin_of, status_of

Doubles = NDArray[np.float64]
Limit = Annotated[float, Field(allow_inf_nan=False, ge=-100.0, le=100.0)]
Length = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=100.0)]
Share = Annotated[float, Field(allow_inf_nan=False, ge=-10.0, le=10.0)]
Span = tuple[Share, Share]
SIDES = ("front", "rear", "left", "right", "top")


class Box(Frozen):
    """Part of the car in shares of its length from the rear, its width from the right, its height from the ground."""

    x: Span = (-10.0, 10.0)
    y: Span = (-10.0, 10.0)
    z: Span = (-10.0, 10.0)

    @model_validator(mode="after")
    def _from_to(self) -> Self:
        for name in ("x", "y", "z"):
            low, high = getattr(self, name)
            if not low <= high:
                raise ValueError(f"{name} must be [from, to] with from <= to (got [{low:g}, {high:g}])")
        return self


class KeepOut(Frozen):
    """Keep-out zone on the car: a part of the body or a material that the housing covers, boxes in which its place on
    the skin lies, or all that are given at once; but not for the kinds of sensors that it allows."""

    name: Annotated[str, Field(min_length=1, max_length=100)]
    part: str | None = None
    material: str | None = None
    boxes: Annotated[tuple[Box, ...], Field(max_length=100)] = ()
    allows: Annotated[tuple[str, ...], Field(max_length=100)] = ()

    @model_validator(mode="after")
    def _known(self) -> Self:
        if self.part is None and self.material is None and not self.boxes:
            raise ValueError("specify part, material or boxes")
        for name, known in (("part", PARTS), ("material", MATERIALS)):
            if getattr(self, name) not in (None, *known):
                raise ValueError(f"{name} must be one of {', '.join(known)} (got '{getattr(self, name)}')")
        for kind in self.allows:
            if kind_named(kind) is None:
                known_kinds = ", ".join(one.name for one in kinds())
                raise ValueError(f"allows must name kinds of sensors: {known_kinds} (got '{kind}')")
        return self


def _allows(part: str) -> tuple[str, ...]:
    """Return the kinds of sensors that may sit on a part."""
    return tuple(kind.name for kind in kinds() if part in kind.placement.may_cover)


_DOOR = {"x": (0.28, 0.72), "z": (0.2, 0.62)}
USUAL_KEEP_OUT = tuple(
    KeepOut(name=part, part=part, allows=_allows(part)) for part in PARTS if part != "body"
)
"""Usual keep-out zones of bodies that name their parts: our choice."""
UNNAMED_KEEP_OUT = (
    KeepOut(name="door", boxes=(Box(y=(0.9, 1.1), **_DOOR), Box(y=(-0.1, 0.1), **_DOOR))),
    KeepOut(
        name="door mirror",
        boxes=(Box(y=(1.001, 10.0)), Box(y=(-10.0, -0.001))),
        allows=_allows("door mirror"),
    ),
)
"""Those of a mesh that does not: our choice, as are the shares of a car's sides that are doors."""
REACH_M = 0.02
"""Least distance of a part from the box around a housing: room for a seal or a bracket, our choice."""


ONE_PLACE_M = 0.01
"""Two sensors whose middles are nearer are in one place, where only one can be: our choice."""
OWN_ZONE = "of the rig"
"""Name of the zone that a rig's own `keep_out` is."""


class Overhang(Frozen):
    """Limits of the overhang of housings over the car's outline and roof, metres."""

    front: Limit | None = None
    rear: Limit | None = None
    left: Limit | None = None
    right: Limit | None = None
    top: Limit | None = None


class MountLimits(Frozen):
    """Limits of every mount, metres; a limit that is not given does not apply.

    height_m: lowest and highest place over the ground; gap_m: how far from the skin at most; spacing_m: least distance
    between two sensors' middles; within [width, length, height]_m: what the car with its sensors may measure.
    """

    height_m: tuple[Limit, Limit] | None = None
    gap_m: Length | None = None
    spacing_m: Length | None = None
    beyond_m: Overhang = Overhang()
    length_m: Length | None = None
    width_m: Length | None = None
    total_height_m: Length | None = None
    keep_out: Annotated[tuple[KeepOut, ...], Field(max_length=100)] | None = None

    @model_validator(mode="after")
    def _lowest_first(self) -> Self:
        if self.height_m is not None and not self.height_m[0] <= self.height_m[1]:
            raise ValueError("height_m must be [lowest, highest] with lowest <= highest")
        return self


USUAL_LIMITS = MountLimits(gap_m=0.1)
"""Limits that apply without a file: our choice. Farther off the skin a sensor needs a bracket."""


@dataclass(frozen=True)
class Mount:
    """Mount of a sensor: height over the ground and over the skin, its nearest neighbour, the overhang of its housing
    by SIDES (below 0: none), the material under it, the keep-out zones that it is in, and the lowest point of its
    housing over the ground."""

    name: str
    height_m: float
    status: MountStatus
    neighbour: str | None
    neighbour_m: float
    beyond_m: dict[str, float]
    materials: frozenset[str]
    zones: tuple[str, ...]
    lowest_m: float

    @property
    def is_below_ground(self) -> bool:
        """Return whether any of its housing is in the road."""
        return self.status.below_ground or self.lowest_m < 0.0

    @property
    def is_in_one_place(self) -> bool:
        """Return whether another sensor is where it is."""
        return self.neighbour_m < ONE_PLACE_M


@dataclass(frozen=True)
class Violation:
    """Violation in one line: the sensor, the fact, the limit."""

    sensor: str
    text: str


@dataclass(frozen=True)
class Footing:
    """Support of a sensor: its place on the skin, the materials there, and those and the parts that its housing
    covers."""

    at_m: Vec3
    materials: frozenset[str]
    covers: frozenset[str]
    parts: frozenset[str]


def footing_of(sensor: Sensor, at_m: Vec3, skin: Skin, has_materials: bool) -> Footing:
    """Return what a sensor stands on, at its place on the skin of a car or on a part of it around the sensor."""
    covered = skin.covered_by(sensor.pose, half_size_m(sensor) + REACH_M)
    parts = frozenset(PARTS[number] for number in np.unique(covered.parts).tolist())
    if not has_materials:
        return Footing(at_m, frozenset(), frozenset(), parts)
    materials = skin.materials_at(np.array(at_m))
    covers = materials | {MATERIALS[number] for number in np.unique(covered.materials).tolist()}
    return Footing(at_m, materials, covers, parts)


@lru_cache(maxsize=2)  # a car takes 20 MB: those of sensors on earlier ones go with it
def _footings(solid: Solid, has_materials: bool) -> Callable[[Sensor], tuple[MountStatus, Footing]]:
    """Return what gives the mount status of a sensor on a car, and what it stands on."""

    @lru_cache(maxsize=64)  # while one sensor moves, the others cost nothing
    def footing(sensor: Sensor) -> tuple[MountStatus, Footing]:
        standing = status_of(sensor, solid)
        if standing.nearest_m is None:
            return standing, Footing(sensor.position, frozenset(), frozenset(), frozenset())
        return standing, footing_of(sensor, standing.nearest_m, skin_of(solid), has_materials)

    return footing


def usual_keep_out(vehicle: Vehicle) -> tuple[KeepOut, ...]:
    """Return the usual keep-out zones of a car."""
    return USUAL_KEEP_OUT if solid_of(vehicle).names_parts else UNNAMED_KEEP_OUT


def mounts_of(rig: Rig, keep_out: tuple[KeepOut, ...] | None = None) -> tuple[Mount, ...]:
    """Return the mounts of the rig's enabled sensors, with the zones that they are in, by default of the usual ones. A
    mesh file has no materials, and parts where its meshes or materials are called after them."""
    outline, solid = Outline.of(rig.vehicle), solid_of(rig.vehicle)
    keep_out = usual_keep_out(rig.vehicle) if keep_out is None else keep_out
    sensors = [sensor for sensor in rig.sensors if sensor.enabled]
    found = []
    for sensor in sensors:
        standing, footing = _footings(solid, not rig.vehicle.has_mesh_file)(sensor)
        materials = footing.materials
        judged = zones_for(sensor, keep_out, standing.behind_glass)
        zones = tuple(zone.name for zone in judged if is_in_zone(zone, footing, rig, outline))
        zones += (OWN_ZONE,) * is_kept_out(rig, footing.at_m)
        beyond = dict(zip(SIDES, beyond_m(sensor, rig, outline).tolist(), strict=True))
        found.append(
            Mount(
                sensor.name,
                sensor.position[2],
                standing,
                *_neighbour(sensor, sensors),
                beyond,
                materials,
                zones,
                float(housing_corners_m(sensor)[:, 2].min()),
            )
        )
    return tuple(found)


def _neighbour(sensor: Sensor, sensors: list[Sensor]) -> tuple[str | None, float]:
    """Return the nearest other sensor, and the distance of their middles."""
    others = [other for other in sensors if other.name != sensor.name]
    if not others:
        return None, float("inf")
    away = np.linalg.norm(np.array([other.position for other in others]) - sensor.position, axis=1)
    nearest = int(np.argmin(away))
    return others[nearest].name, float(away[nearest])


def beyond_m(sensor: Sensor, rig: Rig, outline: Outline) -> Doubles:
    """Return how far a housing sticks out by SIDES, (5,); below 0: not at all."""
    corners = housing_corners_m(sensor)
    (x0, y0, _), (x1, y1, z1) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    sides = x1 - outline.front_m, outline.rear_m - x0, y1 - outline.left_m, outline.right_m - y0
    return np.array([*sides, z1 - rig.vehicle.height])


def is_kept_out(rig: Rig, at_m: tuple[float, float, float]) -> bool:
    """Return whether a place on the skin lies within a spot of the rig's own keep-out zones."""
    if not rig.keep_out:
        return False
    spots = np.array(rig.keep_out)
    return bool((np.linalg.norm(spots[:, :3] - at_m, axis=1) <= spots[:, 3]).any())


def zones_for(sensor: Sensor, keep_out: tuple[KeepOut, ...], behind_glass: bool) -> tuple[KeepOut, ...]:
    """Return the zones that keep a sensor out: not those that allow its kind, nor glass where it is behind a pane."""
    found = (zone for zone in keep_out if sensor.kind not in zone.allows)
    return tuple(one for one in found if not (behind_glass and "glass" in (one.part, one.material)))


def is_in_zone(zone: KeepOut, footing: Footing, rig: Rig, outline: Outline) -> bool:
    """Return whether a sensor is in a zone."""
    if zone.part is not None and zone.part not in footing.parts:
        return False
    if zone.material is not None and zone.material not in footing.covers:
        return False
    at_m = footing.at_m
    shares = (
        (at_m[0] - outline.rear_m) / outline.length_m,
        (at_m[1] - outline.right_m) / outline.width_m,
        at_m[2] / rig.vehicle.height,
    )
    inside = [
        all(a <= share <= b for share, (a, b) in zip(shares, (box.x, box.y, box.z), strict=True))
        for box in zone.boxes
    ]
    return any(inside) if zone.boxes else True


def violations(rig: Rig, limits: MountLimits) -> tuple[Violation, ...]:
    """Return the violations of a rig's mounts, one line each, in the order of its sensors."""
    mounts = mounts_of(rig, limits.keep_out)
    found = [Violation(mount.name, text) for mount in mounts for text in _complaints(mount, limits)]
    return (*found, *_size_complaints(rig, mounts, limits))


def _complaints(mount: Mount, limits: MountLimits) -> list[str]:
    lines = []
    if limits.height_m is not None and not limits.height_m[0] <= mount.height_m <= limits.height_m[1]:
        low, high = limits.height_m
        lines.append(f"height over the ground must be {low:g} to {high:g} m (is {mount.height_m:.3f} m)")
    if mount.status.inside or mount.status.below_ground:
        lines.append(mount.status.problem)
    elif mount.is_below_ground:
        lines.append(f"housing is {-mount.lowest_m:.3f} m below the ground")
    elif limits.gap_m is not None and mount.status.gap_m > limits.gap_m:
        lines.append(
            f"height over the skin must be at most {limits.gap_m:g} m (is {mount.status.gap_m:.3f} m)"
        )
    if mount.is_in_one_place:
        lines.append(f"is in one place with {mount.neighbour}")
    elif limits.spacing_m is not None and mount.neighbour_m < limits.spacing_m:
        lines.append(
            f"distance from {mount.neighbour} must be at least {limits.spacing_m:g} m (is {mount.neighbour_m:.3f} m)"
        )
    for side in SIDES:
        most = getattr(limits.beyond_m, side)
        if most is not None and mount.beyond_m[side] > most:
            lines.append(f"overhang ({side}) must be at most {most:g} m (is {mount.beyond_m[side]:.3f} m)")
    return [*lines, *(_zone_text(zone) for zone in mount.zones)]


def _size_complaints(rig: Rig, mounts: tuple[Mount, ...], limits: MountLimits) -> list[Violation]:
    """Return the violations of the car's size with its sensors."""
    beyond = np.array([list(mount.beyond_m.values()) for mount in mounts]).reshape(-1, len(SIDES))
    out = beyond.max(axis=0, initial=0.0)
    return [
        Violation("car", f"{word} with sensors must be at most {most:g} m (is {size:.3f} m)")
        for word, size, most in sizes_m(out, rig, Outline.of(rig.vehicle), limits)
        if most is not None and size > most
    ]


def sizes_m(
    out: Doubles, rig: Rig, outline: Outline, limits: MountLimits
) -> tuple[tuple[str, Doubles, float | None], ...]:
    """Return length, width and height (...) of the car with housings that stick out by SIDES (..., 5), and limits."""
    return (
        ("length", outline.length_m + out[..., 0] + out[..., 1], limits.length_m),
        ("width", outline.width_m + out[..., 2] + out[..., 3], limits.width_m),
        ("height", rig.vehicle.height + out[..., 4], limits.total_height_m),
    )


def _zone_text(zone: str) -> str:
    """Return what is wrong in a zone: of those named after a part of the car, which part."""
    if any(zone == usual.name for usual in USUAL_KEEP_OUT):
        return f"sits on {zone}" if zone == "glass" else f"sits on a {zone}"
    return f"is in the keep-out zone {zone}"
