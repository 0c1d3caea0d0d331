"""The car seen from above, as regulations measure from it: its outermost points, sectors and bands of distance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Vehicle

Doubles = NDArray[np.float64]
BANDS_M = (0.0, 1.0, 2.0, 5.0, 10.0, 20.0)
"""Edges of the bands of distance from the car's outline, including the end of the last one: our choice."""


@dataclass(frozen=True)
class Outline:
    """The rectangle around the car, metres in the vehicle frame. Door mirrors of the built-in bodies stick out of it,
    as they do in a registration document."""

    rear_m: float
    front_m: float
    right_m: float
    left_m: float

    @classmethod
    def of(cls, vehicle: Vehicle) -> Outline:
        """Return the outline of a vehicle: length by width around the origin, or the extent of the mesh of a file."""
        if vehicle.body_mesh is None:
            half_length, half_width = vehicle.length / 2, vehicle.width / 2
            return cls(-half_length, half_length, -half_width, half_width)
        points = vehicle.body_mesh.placed(vehicle.mesh).points
        low, high = points.min(axis=0), points.max(axis=0)
        return cls(float(low[0]), float(high[0]), float(low[1]), float(high[1]))

    @property
    def length_m(self) -> float:
        """From rear to front."""
        return self.front_m - self.rear_m

    @property
    def width_m(self) -> float:
        """From right to left."""
        return self.left_m - self.right_m

    def distance_m(self, x_m: Doubles, y_m: Doubles) -> Doubles:
        """Return the distance along the ground to the rectangle, 0 within it."""
        dx = np.maximum(np.maximum(self.rear_m - x_m, x_m - self.front_m), 0.0)
        dy = np.maximum(np.maximum(self.right_m - y_m, y_m - self.left_m), 0.0)
        return np.hypot(dx, dy)
