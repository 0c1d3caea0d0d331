"""Check mounts: height, distance from the skin and from each other, overhang, and material under the sensor."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from riglens.core.blind.outline import Outline
from riglens.core.geometry import Vec3
from riglens.core.plain import Frozen
from riglens.core.rig.model import Rig, Sensor
from riglens.core.vehicle.housings import housing_corners_m
from riglens.core.vehicle.solid import MATERIALS, Solid, solid_of
from riglens.core.vehicle.standing import MountStatus, mount_status, skin_of

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
    """Keep-out zone on the car: on a material, in boxes, or on a material within boxes."""

    name: Annotated[str, Field(min_length=1, max_length=100)]
    material: str | None = None
    boxes: Annotated[tuple[Box, ...], Field(max_length=100)] = ()

    @model_validator(mode="after")
    def _known(self) -> Self:
        if self.material is None and not self.boxes:
            raise ValueError("specify material, boxes or both")
        if self.material is not None and self.material not in MATERIALS:
            raise ValueError(f"material must be one of {', '.join(MATERIALS)} (got '{self.material}')")
        return self


_DOOR = {"x": (0.28, 0.72), "z": (0.2, 0.62)}
USUAL_KEEP_OUT = (
    KeepOut(name="glass", material="glass"),
    KeepOut(name="head lamp", material="lamp"),
    KeepOut(name="tail lamp", material="tail"),
    KeepOut(name="number plate", material="plate"),
    KeepOut(name="shut line", material="gap"),
    KeepOut(name="door", boxes=(Box(y=(0.9, 1.1), **_DOOR), Box(y=(-0.1, 0.1), **_DOOR))),
)
"""Usual keep-out zones: our choice, as are the shares of a car's sides that are doors."""


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


@dataclass(frozen=True)
class Violation:
    """Violation in one line: the sensor, the fact, the limit."""

    sensor: str
    text: str


@lru_cache(maxsize=64)  # while one sensor moves, the others cost nothing
def _footing(place_m: Vec3, solid: Solid, has_materials: bool) -> tuple[MountStatus, frozenset[str]]:
    """Return the mount status of a place on a car, and the materials there."""
    standing = mount_status(place_m, solid)
    if not has_materials or standing.nearest_m is None:
        return standing, frozenset()
    return standing, skin_of(solid).materials_at(np.array(standing.nearest_m))


def mounts_of(rig: Rig, keep_out: tuple[KeepOut, ...] = USUAL_KEEP_OUT) -> tuple[Mount, ...]:
    """Return the mounts of the rig's enabled sensors. A mesh file has no materials: only boxes and the spots of the rig
    apply."""
    outline, solid = Outline.of(rig.vehicle), solid_of(rig.vehicle)
    sensors = [sensor for sensor in rig.sensors if sensor.enabled]
    found = []
    for sensor in sensors:
        standing, materials = _footing(sensor.position, solid, not rig.vehicle.has_mesh_file)
        where = standing.nearest_m or sensor.position
        zones = tuple(zone.name for zone in keep_out if is_in_zone(zone, where, materials, rig, outline))
        zones += (OWN_ZONE,) * is_kept_out(rig, where)
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


def is_in_zone(
    zone: KeepOut, at_m: tuple[float, float, float], materials: frozenset[str], rig: Rig, outline: Outline
) -> bool:
    """Return whether a sensor on the skin at a place is in a zone."""
    if zone.material is not None and zone.material not in materials:
        return False
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
    keep_out = USUAL_KEEP_OUT if limits.keep_out is None else limits.keep_out
    mounts = mounts_of(rig, keep_out)
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
    if limits.spacing_m is not None and mount.neighbour_m < limits.spacing_m:
        lines.append(
            f"distance from {mount.neighbour} must be at least {limits.spacing_m:g} m (is {mount.neighbour_m:.3f} m)"
        )
    for side in SIDES:
        most = getattr(limits.beyond_m, side)
        if most is not None and mount.beyond_m[side] > most:
            lines.append(f"overhang ({side}) must be at most {most:g} m (is {mount.beyond_m[side]:.3f} m)")
    return [*lines, *(f"is in the keep-out zone {zone}" for zone in mount.zones)]


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
