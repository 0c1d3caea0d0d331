"""Which rows and columns of a ray lattice can meet a box at all: never too few, often a little too many."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.jit import inlined, kernel
from riglens.core.kernels.shapes import turned_into

MARGIN = 1e-9
"""Windows are wider than computed by this (radians, or on the image plane at distance 1): far above any rounding."""
TURN = 2.0 * np.pi


class Window(NamedTuple):
    """Bounds of a box as the sensor sees it: rows low..high (elevation in radians, or z on the image plane), columns
    from `left` (azimuth in radians in [0, 2 pi), or y on the image plane) over `width`; `width` < 0: not in view."""

    low: float
    high: float
    left: float
    width: float


NOWHERE = Window(0.0, 0.0, 0.0, -1.0)


@kernel
def corners_of(
    offset: np.ndarray, rotation: np.ndarray, turn: np.ndarray, half: np.ndarray, to: np.ndarray
) -> None:
    """Corners (8, 3) in the axes of the sensor, of a box at `offset` (3,) from it in the vehicle frame.

    rotation: sensor to vehicle frame, turn: box to vehicle frame, both (3, 3); half (3,).
    """
    for corner in range(8):
        x = half[0] if corner & 1 else -half[0]
        y = half[1] if corner & 2 else -half[1]
        z = half[2] if corner & 4 else -half[2]
        p = (
            offset[0] + turn[0, 0] * x + turn[0, 1] * y + turn[0, 2] * z,
            offset[1] + turn[1, 0] * x + turn[1, 1] * y + turn[1, 2] * z,
            offset[2] + turn[2, 0] * x + turn[2, 1] * y + turn[2, 2] * z,
        )
        to[corner, 0], to[corner, 1], to[corner, 2] = turned_into(rotation, p)


@kernel
def window_of_turn(corners: np.ndarray) -> Window:
    """Elevations and azimuths of a box around a spinning sensor."""
    ux, uy = 0.0, 0.0
    for corner in range(8):
        ux, uy = ux + corners[corner, 0], uy + corners[corner, 1]
    low, high = np.inf, -np.inf
    for corner in range(8):
        x, y = corners[corner, 0], corners[corner, 1]
        angle = np.arctan2(ux * y - uy * x, ux * x + uy * y)
        low, high = min(low, angle), max(high, angle)
    middle = np.arctan2(uy, ux) + 0.5 * (low + high)
    is_around = (ux == 0.0 and uy == 0.0) or not high - low < np.pi - MARGIN
    cos, sin = np.cos(middle), np.sin(middle)
    near, far, bottom, top = np.inf, 0.0, np.inf, -np.inf
    for corner in range(8):
        x, y, z = corners[corner, 0], corners[corner, 1], corners[corner, 2]
        near, far = min(near, x * cos + y * sin), max(far, np.hypot(x, y))
        bottom, top = min(bottom, z), max(top, z)
    near = 0.0 if is_around else max(0.0, near - MARGIN)
    up = np.arctan2(top, near if top > 0.0 else far)
    down = np.arctan2(bottom, near if bottom < 0.0 else far)
    if is_around:
        return Window(down - MARGIN, up + MARGIN, 0.0, TURN)
    left = (middle - 0.5 * (high - low) - MARGIN) % TURN
    return Window(down - MARGIN, up + MARGIN, left, high - low + 2.0 * MARGIN)


@inlined
def _widened(window: Window, x: float, y: float, z: float) -> Window:
    """A window that takes in a point before the image plane; `width` is the right end until it is complete."""
    y, z = y / x, z / x
    return Window(min(window.low, z), max(window.high, z), min(window.left, y), max(window.width, y))


@kernel
def window_of_image(corners: np.ndarray, least: float) -> Window:
    """Rectangle of the image plane around a box, cut where it comes nearer than `least` to the plane of the sensor."""
    window = Window(np.inf, -np.inf, np.inf, -np.inf)
    for corner in range(8):
        x = corners[corner, 0]
        if x >= least:
            window = _widened(window, x, corners[corner, 1], corners[corner, 2])
        for axis in range(3):
            other = corner ^ (1 << axis)
            far = corners[other, 0]
            if x < least < far:
                share = (least - x) / (far - x)
                y = corners[corner, 1] + share * (corners[other, 1] - corners[corner, 1])
                z = corners[corner, 2] + share * (corners[other, 2] - corners[corner, 2])
                window = _widened(window, least, y, z)
    if not window.low <= window.high:
        return NOWHERE
    blur = MARGIN * (1.0 + max(abs(window.low), abs(window.high), abs(window.left), abs(window.width)))
    width = window.width - window.left + 2.0 * blur
    return Window(window.low - blur, window.high + blur, window.left - blur, width)
