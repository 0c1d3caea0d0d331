"""Sensors that look into sectors, limits in azimuth and elevation, which they fill with even rays.

Sensor frame: x along the view, y left, z up. Every sector has the same rows and columns, so a narrow one is denser.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from riglens.core.sensors.base import Sector, Sensor
from riglens.core.sensors.lattice import Ids

Doubles = NDArray[np.float64]
Reach = Annotated[float, Field(gt=0.0, le=1000.0)]
FINEST_DEG = 0.25
"""Between the rays that test objects: an object that is narrower than its gap may fall between them."""


class Sectored(Sensor):
    """A sensor that looks into sectors."""

    step_deg: Annotated[
        float,
        Field(
            ge=FINEST_DEG,
            le=10.0,
            title="Ray spacing",
            description="at most, between the rays that cover voxels; objects are tested with 0.25°",
        ),
    ] = 2.0

    @property
    @abstractmethod
    def sectors(self) -> Sequence[Sector]:
        """The sectors, one or more."""

    def rows_of_sector(self) -> int:
        """Return the rows of the lattice that each sector has."""
        return _steps(self, "elevation_deg")

    @property
    def resolution(self) -> tuple[int, int]:
        """Columns, and the rows of all sectors."""
        return _steps(self, "azimuth_deg"), self.rows_of_sector() * len(self.sectors)

    def finest(self) -> Self:
        """Return the sensor with the rays that test objects."""
        return self if self.step_deg == FINEST_DEG else self.model_copy(update={"step_deg": FINEST_DEG})


def _steps(sensor: Sectored, field: str) -> int:
    widest: float = max(high - low for low, high in (getattr(sector, field) for sector in sensor.sectors))
    return math.ceil(widest / sensor.step_deg - 1e-9) + 1


def directions(sensor: Sectored, rays: Ids) -> Doubles:
    """Return directions (n, 3) in the sensor frame of rays by number: sector by sector, row by row, from the lowest."""
    (columns, _), rows = sensor.resolution, sensor.rows_of_sector()
    ends = np.array([(*sector.azimuth_deg, *sector.elevation_deg) for sector in sensor.sectors])
    right, left, low, high = np.radians(ends[rays // (rows * columns)]).T
    azimuth = right + (left - right) * (rays % columns) / (columns - 1)
    elevation = low + (high - low) * (rays // columns % rows) / (rows - 1)
    flat = np.cos(elevation)
    return np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=-1)


def view_deg(sensor: Sectored) -> tuple[float, float]:
    """Return the widest and the tallest span of any sector in degrees."""
    spans = [[high - low for low, high in (s.azimuth_deg, s.elevation_deg)] for s in sensor.sectors]
    wide, tall = (max(span) for span in zip(*spans, strict=True))
    return wide, tall


def extent_rows(sensor: Sectored) -> list[tuple[str, str]]:
    """Return the rows of a summary about rays and field of view."""
    wide, tall = view_deg(sensor)
    columns, rows = sensor.resolution
    return [
        ("Rays", f"{sensor.ray_count:,}  =  {columns} × {rows}"),
        ("Field of view", f"{wide:.4g}° × {tall:.4g}°"),
    ]
