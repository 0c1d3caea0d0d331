"""Scan patterns of LiDARs that fire no rows of beams: a formula of swings, or a table of rays from a file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Discriminator, Field, PrivateAttr, Tag, ValidationInfo, model_validator

from riglens.core.plain import Degrees, Frozen
from riglens.core.sensors.lattice import MAX_LISTED_RAYS

Doubles = NDArray[np.float64]
MAX_SWINGS, MAX_LASERS = 8, 256
LONGEST_S = 10.0
Elevation = Annotated[float, Field(allow_inf_nan=False, ge=-90.0, le=90.0)]
Azimuth = Annotated[float, Field(allow_inf_nan=False, ge=-360.0, le=360.0)]
Seconds = Annotated[float, Field(gt=0.0, le=LONGEST_S)]


@dataclass(frozen=True)
class RayRows:
    """Rays in the order of the lattice, (n,) each: angles in the sensor frame in degrees, and times in seconds, zero
    where a table has none. sha256: of the file that they come from."""

    azimuth_deg: Doubles = field(compare=False, repr=False)
    elevation_deg: Doubles = field(compare=False, repr=False)
    time_s: Doubles = field(compare=False, repr=False)
    sha256: str = ""


class Swing(Frozen):
    """One motion of the beam: a sine adds azimuth_deg cos(p) and elevation_deg sin(p), p = 360 rate_hz t + phase_deg; a
    ramp adds both times a saw tooth that rises from -1 to 1 in each period."""

    rate_hz: Annotated[
        float,
        Field(
            allow_inf_nan=False, ge=-1e5, le=1e5, title="Rate, Hz", description="negative turns the other way"
        ),
    ]
    azimuth_deg: Azimuth = 0.0
    elevation_deg: Elevation = 0.0
    phase_deg: Degrees = 0.0
    wave: Literal["sine", "ramp"] = "sine"

    def added(self, time_s: Doubles) -> tuple[Doubles, Doubles]:
        """Return what it adds to azimuth and elevation at some times, degrees (n,) each."""
        turns = self.rate_hz * time_s + self.phase_deg / 360.0
        if self.wave == "ramp":
            tooth = 2.0 * (turns - np.floor(turns)) - 1.0
            return self.azimuth_deg * tooth, self.elevation_deg * tooth
        angle = 2.0 * math.pi * turns
        return self.azimuth_deg * np.cos(angle), self.elevation_deg * np.sin(angle)


class Scan(Frozen):
    """Scan pattern: lasers that fire in turn at even intervals, along a sum of swings."""

    points_per_s: Annotated[
        float,
        Field(gt=0.0, le=1e8, title="Points a second", description="by all lasers together"),
    ]
    integration_s: Annotated[
        Seconds, Field(title="Integration", description="how long a frame collects points")
    ]
    swings: Annotated[
        tuple[Swing, ...],
        Field(min_length=1, max_length=MAX_SWINGS, description="motions of the beam, which add up"),
    ]
    lasers_deg: Annotated[
        tuple[tuple[Azimuth, Elevation], ...], Field(min_length=1, max_length=MAX_LASERS)
    ] = ((0.0, 0.0),)

    @model_validator(mode="after")
    def _sensible(self) -> Self:
        if not self.rows <= self.ray_count <= MAX_LISTED_RAYS:
            raise ValueError(
                f"points_per_s and integration_s must give 1 shot of each laser to {MAX_LISTED_RAYS} rays"
                f" (got {self.points_per_s * self.integration_s:g})"
            )
        highest = max(abs(up) for _, up in self.lasers_deg) + sum(abs(s.elevation_deg) for s in self.swings)
        if highest > 90.0:
            raise ValueError(
                f"swings and lasers_deg must stay within ±90 degrees of elevation (got {highest:g})"
            )
        return self

    @property
    def rows(self) -> int:
        """Number of lasers, the rows of the lattice."""
        return len(self.lasers_deg)

    @property
    def ray_count(self) -> int:
        """Number of rays; each laser has as many."""
        return int(self.points_per_s * self.integration_s / self.rows + 1e-9) * self.rows

    def ray_rows(self) -> RayRows:
        """Return the rays, laser by laser."""
        return _ray_rows(self)


@lru_cache(maxsize=16)
def _ray_rows(scan: Scan) -> RayRows:
    lasers = scan.rows
    shot, laser = np.arange(scan.ray_count // lasers), np.arange(lasers)
    time_s = (shot * lasers + laser[:, None]).ravel() / scan.points_per_s
    azimuth, elevation = np.repeat(np.array(scan.lasers_deg), shot.size, axis=0).T.copy()
    for swing in scan.swings:
        across, up = swing.added(time_s)
        azimuth, elevation = azimuth + across, elevation + up
    return RayRows(within_half_a_turn(azimuth), elevation, time_s)


def within_half_a_turn(azimuth_deg: Doubles) -> Doubles:
    """Return azimuths wrapped to at most 180 degrees on either side."""
    beyond = np.abs(azimuth_deg) > 180.0
    return np.where(beyond, 180.0 - np.mod(180.0 - azimuth_deg, 360.0), azimuth_deg)


Reader = Callable[[str], RayRows]
"""From the name of a file, as a rig gives it, to its rays; raise ValueError where it cannot be read."""
READER = "rays"
"""Key of the `Reader` in pydantic's context."""


class RayTable(Frozen):
    """Rays from a CSV or Parquet file beside the rig."""

    file: Annotated[str, Field(min_length=1, max_length=500)]
    integration_s: Annotated[
        Seconds | None,
        Field(title="Integration", description="rays fired within this time; without it all of the file"),
    ] = None
    _every: RayRows = PrivateAttr()
    _ray_rows: RayRows = PrivateAttr()

    @model_validator(mode="after")
    def _read(self, info: ValidationInfo) -> Self:
        if "_ray_rows" in (self.__pydantic_private__ or {}):  # a part of a sensor that is validated again
            return self
        reader: Reader | None = (info.context or {}).get(READER)
        if reader is None:
            raise ValueError(f"file {self.file!r:.60} cannot be read without the folder of a rig file")
        every = reader(self.file)
        early = every.time_s < (math.inf if self.integration_s is None else self.integration_s)
        if not 0 < np.count_nonzero(early) <= MAX_LISTED_RAYS:
            raise ValueError(
                f"file {self.file!r:.60} must hold 1 to {MAX_LISTED_RAYS} rays within the integration time"
                f" (got {np.count_nonzero(early)})"
            )
        columns = (every.azimuth_deg[early], every.elevation_deg[early], every.time_s[early])
        self._every, self._ray_rows = every, RayRows(*columns, every.sha256)
        return self

    def replace(self, **changes: object) -> Self:
        """Return a validated copy with some fields changed; the file is not read again."""
        fields = {name: getattr(self, name) for name in type(self).model_fields} | changes
        return type(self).model_validate(fields, context={READER: self.read_again})

    def read_again(self, file: str) -> RayRows:
        """Return the rays of the file as they have been read; raise ValueError for another file."""
        if file != self.file:
            raise ValueError(f"file {file!r:.60} has not been read")
        return self._every

    @property
    def rows(self) -> int:
        """One: who fired a ray is not known."""
        return 1

    @property
    def ray_count(self) -> int:
        """Number of rays."""
        return self._ray_rows.time_s.size

    def ray_rows(self) -> RayRows:
        """Return the rays in the order of the file."""
        return self._ray_rows


def _way(value: Any) -> str:
    """Return which of the two some fields mean."""
    if isinstance(value, Mapping):
        return "table" if "file" in value else "scan"
    return "table" if isinstance(value, RayTable) else "scan"


Pattern = Annotated[
    Annotated[Scan, Tag("scan")] | Annotated[RayTable, Tag("table")],
    Discriminator(_way),
]
