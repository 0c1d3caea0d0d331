"""LiDARs: rotating beams, each with its own elevation, fired at azimuths, or rays along a scan pattern."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from riglens.core.kernels.runtime import codes
from riglens.core.plain import Frozen
from riglens.core.sensors.base import MAX_RAYS_PER_SENSOR, Sensor
from riglens.core.sensors.kind import HitMeasure, Occlusion, Placement, SensorKind
from riglens.core.sensors.lattice import MAX_LISTED_RAYS, Ids, Lattice
from riglens.core.sensors.mounting import upright_rpy_deg
from riglens.core.sensors.scan import Azimuth, Elevation, Pattern, RayTable


class LinearAngles(Frozen):
    """`count` evenly spaced angles in degrees; whether `to` is included depends on where they are used."""

    from_: Azimuth = Field(alias="from")
    to: Azimuth = Field(title="to")
    count: Annotated[int, Field(ge=1, le=100_000, title="×")]

    @model_validator(mode="after")
    def _rising(self) -> Self:
        if self.to < self.from_:
            raise ValueError(f"'to' ({self.to}) must not be below 'from' ({self.from_})")
        return self

    def both_ends_deg(self) -> NDArray[np.float64]:
        """Return the angles with both ends included, (count,); one angle is `from`."""
        if self.count == 1:
            return np.array([self.from_])
        return self.from_ + np.arange(self.count) * (self.to - self.from_) / (self.count - 1)

    def open_end_deg(self) -> NDArray[np.float64]:
        """Return the angles from + i (to - from) / count, (count,): a full turn has no duplicate end."""
        return self.from_ + np.arange(self.count) * (self.to - self.from_) / self.count


TURN = LinearAngles(from_=-180.0, to=180.0, count=360)


class Lidar(Sensor):
    """Spinning LiDAR; `elevations_deg` with both ends, `azimuths_deg` with an open end (paper, eq. 2).

    `azimuth_offsets_deg`, one per beam, are added to the azimuths of that beam (positive turns left). `rays` give its
    rays one by one instead; what knows only beams and azimuths then takes it for an even raster of about as many rays
    over the same field of view.
    """

    kind: Literal["lidar"] = "lidar"
    elevations_deg: LinearAngles | Annotated[tuple[Elevation, ...], Field(min_length=1)] | None = None
    azimuths_deg: LinearAngles | Annotated[tuple[Azimuth, ...], Field(min_length=1)] = TURN
    azimuth_offsets_deg: Annotated[
        tuple[Azimuth, ...] | None,
        Field(description="one angle per beam, added to its azimuths; positive turns left"),
    ] = None
    rays: Pattern | None = None

    @model_validator(mode="after")
    def _beams_or_pattern(self) -> Self:
        if self.rays is None and self.elevations_deg is None:
            raise PydanticCustomError(
                "absent_field", "elevations_deg is missing", {"field": "elevations_deg"}
            )
        for field, none in (("elevations_deg", None), ("azimuths_deg", TURN), ("azimuth_offsets_deg", None)):
            if self.rays is not None and getattr(self, field) != none:
                raise ValueError(f"{field} must be left out where rays are given")
        return self

    @model_validator(mode="after")
    def _angles_sensible(self) -> Self:
        if not 0 < self.ray_count <= MAX_RAYS_PER_SENSOR:
            raise ValueError(f"a LiDAR must cast 1 to {MAX_RAYS_PER_SENSOR} rays (got {self.ray_count})")
        if self.rays is not None:
            return self
        beams, turn = self.elevations_deg, self.azimuths_deg
        if isinstance(beams, LinearAngles) and (beams.from_ < -90.0 or beams.to > 90.0):
            raise ValueError(f"elevations_deg must be within [-90, 90] (got {beams.from_} to {beams.to})")
        span_deg = turn.to - turn.from_ if isinstance(turn, LinearAngles) else max(turn) - min(turn)
        if span_deg > 360.0:
            raise ValueError(f"azimuths_deg must span at most 360 degrees (got {span_deg})")
        return self

    @model_validator(mode="after")
    def _offsets_fit(self) -> Self:
        offsets, beams = self.azimuth_offsets_deg, self.beam_count
        if offsets is not None and len(offsets) != beams:
            raise ValueError(
                f"azimuth_offsets_deg must hold one offset per beam, {beams} (got {len(offsets)})"
            )
        if offsets is not None and self.ray_count > MAX_LISTED_RAYS:
            raise ValueError(
                f"azimuth_offsets_deg are limited to {MAX_LISTED_RAYS} rays (got {self.ray_count})"
            )
        return self

    def elevations(self) -> NDArray[np.float64]:
        """Return the beam elevations in degrees, (beams,)."""
        if self.rays is not None:
            return _raster(self.rays)[0]
        angles = self.elevations_deg
        return (
            angles.both_ends_deg() if isinstance(angles, LinearAngles) else np.array(angles, dtype=np.float64)
        )

    def azimuths(self) -> NDArray[np.float64]:
        """Return the azimuths in degrees, (azimuths,)."""
        if self.rays is not None:
            return _raster(self.rays)[1]
        angles = self.azimuths_deg
        return (
            angles.open_end_deg() if isinstance(angles, LinearAngles) else np.array(angles, dtype=np.float64)
        )

    @property
    def beam_count(self) -> int:
        """Number of beams: of lasers where a scan pattern says so."""
        beams = self.elevations_deg
        if self.rays is not None or beams is None:
            return 1 if self.rays is None else self.rays.rows
        return beams.count if isinstance(beams, LinearAngles) else len(beams)

    @property
    def resolution(self) -> tuple[int, int]:
        """Azimuths and beams."""
        turn = self.azimuths_deg
        if self.rays is not None:
            return self.rays.ray_count // self.rays.rows, self.rays.rows
        return turn.count if isinstance(turn, LinearAngles) else len(turn), self.beam_count

    def raster(self) -> Self:
        """Return the LiDAR with rows and columns of rays: an even raster in place of a scan pattern."""
        if self.rays is None:
            return self
        elevations, azimuths = (tuple(angles.tolist()) for angles in _raster(self.rays))
        return self.model_copy(update={"elevations_deg": elevations, "azimuths_deg": azimuths, "rays": None})

    @property
    def table(self) -> RayTable | None:
        """The file that its rays come from."""
        return self.rays if isinstance(self.rays, RayTable) else None

    @property
    def idle_fields(self) -> tuple[str, ...]:
        """Azimuths decide nothing beside `rays`."""
        return ("azimuths_deg",) if self.rays is not None else ()

    @property
    def turn_ends_deg(self) -> tuple[float, float]:
        """The azimuths between which the beams sweep, the open end included where they are evenly spaced."""
        turn = self.azimuths_deg
        if self.rays is None and isinstance(turn, LinearAngles):
            return turn.from_, turn.to
        listed = self.azimuths() if self.rays is None else self.rays.ray_rows().azimuth_deg
        return float(listed.min()), float(listed.max())


@lru_cache(maxsize=16)
def _raster(rays: Pattern) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return elevations and azimuths of an even raster of about as many rays as a pattern over its field of view."""
    listed = rays.ray_rows()
    low, right = float(listed.elevation_deg.min()), float(listed.azimuth_deg.min())
    high, wide = float(listed.elevation_deg.max()) - low, float(listed.azimuth_deg.max()) - right
    count = listed.time_s.size
    rows = min(max(1, round(math.sqrt(count * high / max(wide, 1e-9)))), count) if high > 0.0 else 1
    columns = max(1, count // rows)
    return np.linspace(low, low + high, rows), np.linspace(right, right + wide, columns)


def beam_lattice(lidar: Lidar) -> Lattice:
    """Return directions (cos e cos a, cos e sin a, sin e), beam by beam (paper, eq. 2, as its text means it)."""
    elevation, azimuth = np.radians(lidar.elevations()), np.radians(lidar.azimuths())
    rows = np.stack([np.cos(elevation), np.sin(elevation)], axis=1)
    return Lattice(codes.LIDAR, rows, np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1))


def lattice(lidar: Lidar) -> Lattice | None:
    """Return its rays in rows and columns; None for beams with azimuth offsets and for scan patterns."""
    return beam_lattice(lidar) if lidar.azimuth_offsets_deg is None and lidar.rays is None else None


def directions(lidar: Lidar, rays: Ids) -> NDArray[np.float64]:
    """Return directions in the sensor frame of rays by number, beam * azimuths + azimuth, (n, 3)."""
    if lidar.rays is not None:
        rows = lidar.rays.ray_rows()
        elevation, azimuth = np.radians(rows.elevation_deg[rays]), np.radians(rows.azimuth_deg[rays])
    elif lidar.azimuth_offsets_deg is None:
        return beam_lattice(lidar).directions(rays)
    else:
        azimuths = lidar.azimuths()
        beam, turn = rays // azimuths.size, rays % azimuths.size
        elevation = np.radians(lidar.elevations()[beam])
        azimuth = np.radians(azimuths[turn] + np.array(lidar.azimuth_offsets_deg)[beam])
    flat = np.cos(elevation)
    return np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=-1)


def _turn_deg(lidar: Lidar) -> float:
    right, left = lidar.turn_ends_deg
    return left - right


def _view_deg(lidar: Lidar) -> tuple[float, float]:
    beams = lidar.elevations()
    return _turn_deg(lidar), float(beams.max() - beams.min())


def _summary(lidar: Lidar) -> list[tuple[str, str]]:
    beams, turn = lidar.elevations(), lidar.azimuths()
    offsets, (columns, rows) = lidar.azimuth_offsets_deg, lidar.resolution
    of = "beams" if lidar.rays is None else "lasers"
    return [
        ("Rays", f"{lidar.ray_count:,}  =  {rows} {of} × {columns:,}"),
        ("Field of view", f"{_turn_deg(lidar):.4g}° × {np.ptp(beams):.4g}°"),
        ("Resolution", f"{_gaps(turn)} × {_gaps(beams)}" if lidar.rays is None else _pattern(lidar.rays)),
        (
            "Azimuth offsets",
            "none" if offsets is None else f"{min(offsets):.3g}° to {max(offsets):.3g}°, by beam",
        ),
    ]


def _pattern(rays: Pattern) -> str:
    of = f"table {rays.file}" if isinstance(rays, RayTable) else f"pattern of {rays.integration_s:g} s"
    return f"along a scan {of}"


def _gaps(angles_deg: NDArray[np.float64]) -> str:
    """Describe the distance between neighbouring angles, or its smallest and largest value."""
    if len(angles_deg) < 2:
        return "—"
    gaps = np.diff(np.sort(angles_deg))
    low, high = f"{gaps.min():.3g}", f"{gaps.max():.3g}"
    return f"{low}°" if low == high else f"{low}–{high}°"


# The radius of the housing is our choice, and so is that glass stops LiDARs: near infrared light passes coated
# windscreens badly, and at a slant hardly at all.
LIDAR = SensorKind(
    name="lidar",
    title="LiDAR",
    plural="LiDARs",
    model=Lidar,
    lattice=lattice,
    directions=directions,
    view_deg=_view_deg,
    brief=lambda lidar: f"{lidar.beam_count} ch",
    size=("beams", lambda lidar: f"{lidar.beam_count}"),
    summary=_summary,
    occlusion=Occlusion(housing_radius_m=0.105),
    placement=Placement(above_roof_m=0.35, rpy_deg=upright_rpy_deg),
    hits=HitMeasure("points", threshold=5, label="points", unit="points"),
    spelled_out={"elevations_deg": Lidar.elevations, "azimuths_deg": Lidar.azimuths},
    library_figures=("azimuth_step_deg", "range_at", "range_probability"),
    score_weight=1.0,
    has_range_law=True,
    spins=True,
    coarse_power=0.5,  # in the measurements of docs/voxel-choice.md
)
