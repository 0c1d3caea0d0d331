"""Radars: scans as data sheets give them, each up to a range for a reference cross section.

A radar detects an object of which a visible part lies in a scan within its range. By the radar equation that range
grows with the fourth root of the radar cross section: R = R_ref (sigma / sigma_ref)^(1/4). No multipath, no clutter, no
interference, no Doppler: a standing object counts like a moving one.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from riglens.core.sensors.base import Sector
from riglens.core.sensors.kind import Echo, HitMeasure, Occlusion, Placement, SensorKind
from riglens.core.sensors.mounting import outwards_rpy_deg
from riglens.core.sensors.sectors import Reach, Sectored, directions, extent_rows, view_deg

Doubles = NDArray[np.float64]
Dbsm = Annotated[float, Field(allow_inf_nan=False, ge=-50.0, le=60.0)]
MAX_SCANS = 4
_CLASSES = ("car", "bicycle", "pedestrian")


class RadarScan(Sector):
    """One scan: its sector, its range for the reference cross section, and what it tells apart."""

    range_m: Annotated[Reach, Field(title="Range", description="for the reference cross section")]
    resolution_deg: Annotated[
        float,
        Field(gt=0.0, le=180.0, title="Angle cell", description="azimuth by which it tells objects apart"),
    ] = 4.0
    resolution_m: Annotated[
        float,
        Field(gt=0.0, le=100.0, title="Range cell", description="distance by which it tells objects apart"),
    ] = 0.5


class Radar(Sectored):
    """Radar; the first scan that holds an object tells it from its neighbours, so fine scans come first.

    Cross sections in dBsm: 10 for a car and for the reference, 0 for a bicycle with its rider, -8 for a pedestrian. Our
    choice: measurements at 77 GHz scatter by 10 dB and more with the aspect.
    """

    kind: Literal["radar"] = "radar"
    scans: Annotated[tuple[RadarScan, ...], Field(min_length=1, max_length=MAX_SCANS)]
    cross_sections_dbsm: Annotated[
        tuple[Dbsm, Dbsm, Dbsm],
        Field(title="RCS (dBsm)", description="radar cross sections of car, bicycle, pedestrian"),
    ] = (10.0, 0.0, -8.0)
    reference_dbsm: Annotated[
        Dbsm,
        Field(title="Reference (dBsm)", description="cross section to which the ranges of the scans refer"),
    ] = 10.0

    def mirrored(self) -> Self:
        """Return it with its scans mirrored as well."""
        return super().mirrored().model_copy(update={"scans": tuple(scan.mirrored() for scan in self.scans)})

    @property
    def sectors(self) -> tuple[RadarScan, ...]:
        """The scans."""
        return self.scans


def range_share(radar: Radar, echo: Echo) -> float:
    """Return the range for an object over that for the reference; an object of no class is taken for the reference."""
    if echo.cls not in _CLASSES:
        return 1.0
    over_db = radar.cross_sections_dbsm[_CLASSES.index(echo.cls)] - radar.reference_dbsm
    return float(10.0 ** (over_db / 40.0))


def limits_m(radar: Radar, echo: Echo) -> Doubles:
    """Return how far each row of the lattice reaches."""
    ranges = np.array([scan.range_m for scan in radar.scans])
    return np.repeat(ranges * range_share(radar, echo), radar.rows_of_sector())


def in_field(radar: Radar, local_m: Doubles, distance_m: Doubles, echo: Echo) -> NDArray[np.bool_]:
    """Return whether places (n, 3) in the sensor frame lie in a scan and within its range for an object."""
    share = range_share(radar, echo)
    held = [scan.holds(local_m) & (distance_m <= scan.range_m * share) for scan in radar.scans]
    return np.asarray(np.logical_or.reduce(held))


def cells(radar: Radar, local_m: Doubles) -> NDArray[np.int64]:
    """Return the resolution cells (n, 3) of places in the sensor frame: scan, steps of azimuth, steps of distance."""
    distance = np.linalg.norm(local_m, axis=1)
    held = np.array([scan.holds(local_m) & (distance <= scan.range_m) for scan in radar.scans])
    scan = held.argmax(axis=0)
    steps = np.array([(each.resolution_deg, each.resolution_m) for each in radar.scans])[scan]
    azimuth = np.degrees(np.arctan2(local_m[:, 1], local_m[:, 0]))
    return np.stack([scan, np.floor(azimuth / steps[:, 0]), np.floor(distance / steps[:, 1])], axis=1).astype(
        np.int64
    )


def _summary(radar: Radar) -> list[tuple[str, str]]:
    longest = max(scan.range_m for scan in radar.scans)
    ranges = (f"{cls} {longest * range_share(radar, Echo(cls)):.0f} m" for cls in _CLASSES)
    return [*extent_rows(radar), ("Longest range", ", ".join(ranges))]


# Our choice: what is that near, a bumper's skin or a badge, lets 77 GHz pass; glass farther off does not.
RADAR = SensorKind(
    name="radar",
    title="radar",
    plural="radars",
    model=Radar,
    directions=directions,
    view_deg=view_deg,
    brief=lambda radar: f"{max(scan.range_m for scan in radar.scans):.4g} m",
    size=("scans", lambda radar: f"{len(radar.scans)}"),
    summary=_summary,
    occlusion=Occlusion(housing_radius_m=0.08, passes_within_m=0.25),
    # behind bumpers, as Tesla's ("Model 3 Owner's Manual", About Autopilot), not below 0.4 m (Autoliv, "Installation
    # Specifications, Radar Sensor 24 GHz", 5.3.8); the upper end is our choice
    placement=Placement(
        above_roof_m=0.1, rpy_deg=outwards_rpy_deg, away_when_level=True, in_bumpers_m=(0.4, 0.75)
    ),
    hits=HitMeasure("returns", threshold=1, label="returns", unit="returns"),
    limits_m=limits_m,
    in_field=in_field,
    cells=cells,
    blocks=lambda radar: len(radar.scans),
)
