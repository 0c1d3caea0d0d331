"""Define the base of all sensors: a name, a pose, a range and blocked sectors."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Annotated, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from riglens.core.geometry import Pose
from riglens.core.plain import Degrees, Frozen
from riglens.core.sensors.scan import RayTable

Doubles = NDArray[np.float64]
Bools = NDArray[np.bool_]
Azimuth = Annotated[float, Field(allow_inf_nan=False, ge=-180.0, le=180.0)]
Elevation = Annotated[float, Field(allow_inf_nan=False, ge=-90.0, le=90.0)]
Azimuths = Annotated[
    tuple[Azimuth, Azimuth], Field(title="Azimuth", description="from, to; positive turns left")
]
Elevations = Annotated[
    tuple[Elevation, Elevation], Field(title="Elevation", description="from, to; positive looks up")
]


class Sector(Frozen):
    """Limits in azimuth and elevation."""

    azimuth_deg: Azimuths
    elevation_deg: Elevations

    @model_validator(mode="after")
    def _rising(self) -> Self:
        for name, (low, high) in (("azimuth_deg", self.azimuth_deg), ("elevation_deg", self.elevation_deg)):
            if not low < high:
                raise ValueError(f"{name} must rise (got {low:g} to {high:g})")
        return self

    def mirrored(self) -> Self:
        """Return it as its mirror image in the plane of x and z has it."""
        right, left = self.azimuth_deg
        return self.model_copy(update={"azimuth_deg": (0.0 - left, 0.0 - right)})

    def holds(self, local_m: Doubles) -> Bools:
        """Return whether places (n, 3) in the sensor frame lie within the limits."""
        across = np.degrees(np.arctan2(local_m[:, 1], local_m[:, 0]))
        up = np.degrees(np.arctan2(local_m[:, 2], np.hypot(local_m[:, 0], local_m[:, 1])))
        (right, left), (low, high) = self.azimuth_deg, self.elevation_deg
        return np.asarray((across >= right) & (across <= left) & (up >= low) & (up <= high))


class Blocked(Sector):
    """A sector into which a sensor sees nothing."""

    azimuth_deg: Azimuths = (0.0, 180.0)
    elevation_deg: Elevations = (-90.0, 90.0)


HALVES = {
    "left": Blocked(),
    "right": Blocked(azimuth_deg=(-180.0, 0.0)),
    "upper": Blocked(azimuth_deg=(-180.0, 180.0), elevation_deg=(0.0, 90.0)),
    "lower": Blocked(azimuth_deg=(-180.0, 180.0), elevation_deg=(-90.0, 0.0)),
}
"""Sectors of half a sensor's view, by name."""
MAX_GROUPS = 16
"""Of a sensor: brackets, control units, cables, windows with which it fails."""
MAX_BLOCKED = 8
MAX_RAYS_PER_SENSOR = 1 << 26
Metres = Annotated[float, Field(allow_inf_nan=False, ge=-1e7, le=1e7)]
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0.0)]
Length = Annotated[float, Field(allow_inf_nan=False, ge=1e-3, le=100.0)]
Name = Annotated[str, Field(min_length=1, max_length=200)]
Position = tuple[Metres, Metres, Metres]
Angles3 = tuple[Degrees, Degrees, Degrees]


class Sensor(Frozen):
    """Sensor of any kind; `kind` is fixed by the derived classes."""

    name: Name
    model: str | None = None
    position: Position
    rpy_deg: Angles3 = (0.0, 0.0, 0.0)
    range_m: Annotated[
        tuple[Annotated[float, Field(ge=0.0)], Annotated[float, Field(gt=0.0)]],
        Field(description="from, to; ∞ or inf: up to the end of the region of interest"),
    ] = (0.0, math.inf)
    enabled: bool = True
    mirror_of: Name | None = None
    fails_with: Annotated[tuple[Name, ...], Field(min_length=1, max_length=MAX_GROUPS)] | None = None
    blocked: Annotated[
        tuple[Blocked, ...],
        Field(
            max_length=MAX_BLOCKED,
            title="Blocked zones",
            description="sectors without rays: dirt, a sticker, low sun",
        ),
    ] = ()
    kind: str

    @model_validator(mode="after")
    def _range_rises(self) -> Self:
        low, high = self.range_m
        if math.isnan(low) or math.isnan(high) or math.isinf(low) or not low < high:
            raise ValueError(f"range_m must be [min, max] with 0 <= min < max, found [{low}, {high}]")
        return self

    @property
    @abstractmethod
    def resolution(self) -> tuple[int, int]:
        """Rays in a row of the lattice, and rows."""

    @property
    def idle_fields(self) -> tuple[str, ...]:
        """Fields with a default that decides nothing, because another field stands in for them."""
        return ()

    @property
    def table(self) -> RayTable | None:
        """The file that its rays come from, None for rays that follow from its fields."""
        return None

    @property
    def ray_count(self) -> int:
        """Number of rays of the lattice; some may have no direction, as where a lens has none."""
        rays_in_row, rows = self.resolution
        return rays_in_row * rows

    @property
    def pose(self) -> Pose:
        """Pose of the sensor in the vehicle frame."""
        return Pose(self.position, self.rpy_deg)

    def mirrored(self) -> Self:
        """Return the sensor in the same place with what lies to its left and right exchanged."""
        return self.model_copy(update={"blocked": tuple(sector.mirrored() for sector in self.blocked)})

    def blocked_rays(self, local: Doubles) -> Bools:
        """Return whether directions or places (n, 3) in the sensor frame lie in a blocked sector, (n,)."""
        found = np.zeros(len(local), np.bool_)
        for sector in self.blocked:
            found |= sector.holds(local)
        return found

    def finest(self) -> Self:
        """Return the sensor with all rays that it can cast, whatever its setting."""
        return self

    def with_pose(self, pose: Pose) -> Self:
        """Return the same sensor elsewhere; not validated again, because this happens on every mouse move."""
        return self.model_copy(update={"position": pose.position_m, "rpy_deg": pose.rpy_deg})


_S = TypeVar("_S", bound=Sensor)


_IDENTITY = {"name": "", "model": None, "enabled": True, "mirror_of": None, "fails_with": None}
_PLACE = {"position": (0.0, 0.0, 0.0), "rpy_deg": (0.0, 0.0, 0.0), "range_m": (0.0, math.inf)}


def rays_of(sensor: _S) -> _S:
    """Return the sensor without what decides none of its rays: name, model, pair, groups, and whether it is on."""
    return sensor.model_copy(update=_IDENTITY)


def unplaced(sensor: _S) -> _S:
    """Return what decides the directions of a sensor's rays in its own frame: `rays_of` it without place and range."""
    return sensor.model_copy(update=_IDENTITY | _PLACE)
