"""Sectors of 45 degrees around the car."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Doubles = NDArray[np.float64]
SECTORS = ("front", "front-left", "left", "rear-left", "rear", "rear-right", "right", "front-right")
"""Sectors of 45 degrees around the origin of the vehicle frame, the first one centred on straight ahead."""


def sector_of(x_m: Doubles | float, y_m: Doubles | float) -> NDArray[np.uint8]:
    """Return the place in SECTORS of points of the vehicle frame."""
    turn = np.degrees(np.arctan2(y_m, x_m)) / 45.0
    return np.asarray(np.floor(turn + 0.5) % len(SECTORS), np.uint8)
