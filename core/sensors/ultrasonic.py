"""Ultrasonic sensors: a sector up to a range that depends on how wide an object is.

No cross talk, no soft or slanted surfaces, no wind, no triangulation by neighbours.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from riglens.core.sensors.base import Azimuths, Elevations, Sector
from riglens.core.sensors.kind import Echo, HitMeasure, Occlusion, Placement, SensorKind
from riglens.core.sensors.mounting import outwards_rpy_deg
from riglens.core.sensors.sectors import Reach, Sectored, directions, extent_rows, view_deg

Doubles = NDArray[np.float64]
POLE_M, WALL_M = 0.075, 1.0
"""Width of the pole and of the wall that ranges are given for: the tube of ISO 17386, and our choice."""


class Ultrasonic(Sectored):
    """Ultrasonic sensor; between the widths of a pole and of a wall the range grows in proportion (our choice)."""

    kind: Literal["ultrasonic"] = "ultrasonic"
    azimuth_deg: Azimuths = (-60.0, 60.0)
    elevation_deg: Elevations = (-30.0, 30.0)
    pole_range_m: Annotated[
        Reach, Field(description="for a pole 75 mm wide, and for objects of unknown width")
    ] = 2.5
    wall_range_m: Annotated[Reach, Field(description="for what is 1 m wide or wider")] = 5.5

    @model_validator(mode="after")
    def _sensible(self) -> Self:
        Sector(azimuth_deg=self.azimuth_deg, elevation_deg=self.elevation_deg)
        if self.wall_range_m < self.pole_range_m:
            raise ValueError(
                f"wall_range_m must be at least pole_range_m, {self.pole_range_m:g} (got {self.wall_range_m:g})"
            )
        return self

    def mirrored(self) -> Self:
        """Return it with its sector mirrored as well."""
        return super().mirrored().model_copy(update={"azimuth_deg": self.sectors[0].mirrored().azimuth_deg})

    @property
    def sectors(self) -> tuple[Sector]:
        """The one sector."""
        return (Sector.model_construct(azimuth_deg=self.azimuth_deg, elevation_deg=self.elevation_deg),)


def reach_m(sensor: Ultrasonic, echo: Echo) -> float:
    """Return how far a sensor detects an object of that width; of unknown width as if it were a pole."""
    width = POLE_M if echo.width_m is None else echo.width_m
    return float(np.interp(width, [POLE_M, WALL_M], [sensor.pole_range_m, sensor.wall_range_m]))


def limits_m(sensor: Ultrasonic, echo: Echo) -> Doubles:
    """Return how far each row of the lattice reaches."""
    return np.full(sensor.rows_of_sector(), reach_m(sensor, echo))


def in_field(sensor: Ultrasonic, local_m: Doubles, distance_m: Doubles, echo: Echo) -> NDArray[np.bool_]:
    """Return whether places (n, 3) in the sensor frame lie in the sector and within the range for an object."""
    return sensor.sectors[0].holds(local_m) & (distance_m <= reach_m(sensor, echo))


def _summary(sensor: Ultrasonic) -> list[tuple[str, str]]:
    ranges = f"pole {sensor.pole_range_m:.3g} m, wall {sensor.wall_range_m:.3g} m"
    return [*extent_rows(sensor), ("Range", ranges)]


ULTRASONIC = SensorKind(
    name="ultrasonic",
    title="ultrasonic sensor",
    plural="ultrasonic sensors",
    model=Ultrasonic,
    directions=directions,
    view_deg=view_deg,
    brief=lambda sensor: f"{sensor.wall_range_m:.3g} m",
    size=("range", lambda sensor: f"{sensor.wall_range_m:.3g} m"),
    summary=_summary,
    occlusion=Occlusion(housing_radius_m=0.02, passes_within_m=0.05),  # our choice: flush with the bumper
    # in bumpers, as Tesla's ("Model 3 Owner's Manual", About Autopilot); the heights are our choice
    placement=Placement(
        above_roof_m=0.02, rpy_deg=outwards_rpy_deg, away_when_level=True, in_bumpers_m=(0.35, 0.75)
    ),
    hits=HitMeasure("returns", threshold=1, label="returns", unit="returns"),
    limits_m=limits_m,
    in_field=in_field,
)
