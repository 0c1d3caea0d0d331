"""Bound the rows and columns of a ray lattice that can meet a box: never too few, often a little too many."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.rays.lattice import Direction
from riglens.core.kernels.runtime.jit import lean, lean_inlined

MARGIN = 1e-9
"""Windows are wider than computed by this (radians, or slopes): far above any rounding."""
TURN = 2.0 * np.pi


class Window(NamedTuple):
    """Bounds of a box as the sensor sees it: rows low..high (slope z over distance from the axis, or z on the image
    plane), columns from `left` (azimuth in radians in [0, 2 pi), or y on the image plane) over `width`; `width` < 0:
    not in view. near, far: distances from the axis of a spinning sensor between which it lies, metres."""

    low: float
    high: float
    left: float
    width: float
    near: float
    far: float


NOWHERE = Window(0.0, 0.0, 0.0, -1.0, 0.0, 0.0)


@lean_inlined
def corners_of(centre: np.ndarray, turn: np.ndarray, half: Direction, to: np.ndarray) -> None:
    """Corners (8, 3) in the axes of the sensor of a box at `centre` (3,) there; turn (3, 3): sensor's to box's axes."""
    for corner in range(8):
        x = half[0] if corner & 1 else -half[0]
        y = half[1] if corner & 2 else -half[1]
        z = half[2] if corner & 4 else -half[2]
        for axis in range(3):
            to[corner, axis] = centre[axis] + turn[0, axis] * x + turn[1, axis] * y + turn[2, axis] * z


@lean
def window_of_turn(corners: np.ndarray, is_upright: bool) -> Window:
    """Return the slopes and azimuths of a box around a spinning sensor; of one that is upright in its axes the upper
    four corners are where the lower ones are."""
    ux, uy, count = 0.0, 0.0, 4 if is_upright else 8
    for corner in range(count):
        ux, uy = ux + corners[corner, 0], uy + corners[corner, 1]
    first, last, low, high = 0, 0, np.inf, -np.inf
    is_beside = False
    for corner in range(count):
        x, y = corners[corner, 0], corners[corner, 1]
        ahead, aside = ux * x + uy * y, ux * y - uy * x
        is_beside |= not ahead > 0.0
        angle = aside / ahead if ahead > 0.0 else np.arctan2(aside, ahead)
        if angle < low:
            low, first = angle, corner
        if angle > high:
            high, last = angle, corner
    if is_beside:
        return _window_beside(corners, ux, uy)
    return _window_between(corners, first, last, count)


@lean
def _window_beside(corners: np.ndarray, ux: float, uy: float) -> Window:
    """Return the window of a box that reaches to both sides of the sensor, or around it."""
    first, last, low, high = 0, 0, np.inf, -np.inf
    for corner in range(8):
        x, y = corners[corner, 0], corners[corner, 1]
        angle = np.arctan2(ux * y - uy * x, ux * x + uy * y)
        if angle < low:
            low, first = angle, corner
        if angle > high:
            high, last = angle, corner
    if (ux != 0.0 or uy != 0.0) and high - low < np.pi - 1e-6:
        return _window_between(corners, first, last, 8)
    return _with_slopes(corners, 0.0, TURN, 0.0)


@lean_inlined
def _window_between(corners: np.ndarray, first: int, last: int, count: int) -> Window:
    """Return the window of a box whose outermost corners, less than half a turn apart, are known."""
    ax, ay = corners[first, 0], corners[first, 1]
    bx, by = corners[last, 0], corners[last, 1]
    left, width = np.arctan2(ay, ax), np.arctan2(ax * by - ay * bx, ax * bx + ay * by)
    a, b = np.sqrt(ax * ax + ay * ay), np.sqrt(bx * bx + by * by)
    mx, my = ax * b + bx * a, ay * b + by * a
    m = np.sqrt(mx * mx + my * my)
    near = np.inf
    for corner in range(count):
        near = min(near, (corners[corner, 0] * mx + corners[corner, 1] * my) / m)
    left -= MARGIN
    left = left + TURN if left < 0.0 else left
    return _with_slopes(corners, left, width + 2.0 * MARGIN, max(0.0, near * (1.0 - MARGIN)))


@lean_inlined
def _with_slopes(corners: np.ndarray, left: float, width: float, near: float) -> Window:
    """Return the window of a box whose azimuths are known and whose distance from the axis is at least `near`."""
    far2, bottom, top = 0.0, np.inf, -np.inf
    for corner in range(8):
        x, y, z = corners[corner, 0], corners[corner, 1], corners[corner, 2]
        far2 = max(far2, x * x + y * y)
        bottom, top = min(bottom, z), max(top, z)
    far = np.sqrt(far2)
    low, high = slopes_between(bottom, top, near, far)
    return Window(low, high, left, width, near, far)


@lean_inlined
def slopes_between(bottom: float, top: float, near: float, far: float) -> tuple[float, float]:
    """Return the lowest and highest slope of what lies between two heights and two distances from the axis."""
    low, high = bottom / (near if bottom < 0.0 else far), top / (near if top > 0.0 else far)
    return low - MARGIN * (1.0 + abs(low)), high + MARGIN * (1.0 + abs(high))


@lean_inlined
def place_at(at: np.ndarray, value: float) -> int:
    """Return the first place of rising numbers that is not below a value, their number if all are; at once where the
    steps are even."""
    count = at.size
    if count == 0 or value <= at[0]:
        return 0
    if not value <= at[count - 1]:
        return int(count)
    place = int((value - at[0]) * ((count - 1) / (at[count - 1] - at[0])))  # 0 <= place < count
    if at[place] < value:
        place += 1
    if at[place - 1] < value <= at[place]:
        return place
    return int(np.searchsorted(at, value))


@lean_inlined
def _widened(window: Window, x: float, y: float, z: float) -> Window:
    """Return a window that takes in a point before the image plane; `width` is the right end until it is complete."""
    y, z = y / x, z / x
    low, high, left, right = (
        min(window.low, z), max(window.high, z), min(window.left, y), max(window.width, y)
    )  # fmt: skip
    return Window(low, high, left, right, 0.0, 0.0)


@lean
def window_of_image(corners: np.ndarray, least: float) -> Window:
    """Return the rectangle of the image plane around a box, cut where it comes nearer than `least` to the plane of the
    sensor."""
    window = Window(np.inf, -np.inf, np.inf, -np.inf, 0.0, 0.0)
    is_cut = False
    for corner in range(8):
        x = corners[corner, 0]
        if x >= least:
            window = _widened(window, x, corners[corner, 1], corners[corner, 2])
        else:
            is_cut = True
    if is_cut:
        window = _with_cut_edges(corners, least, window)
    if not window.low <= window.high:
        return NOWHERE
    blur = MARGIN * (1.0 + max(abs(window.low), abs(window.high), abs(window.left), abs(window.width)))
    width = window.width - window.left + 2.0 * blur
    return Window(window.low - blur, window.high + blur, window.left - blur, width, 0.0, 0.0)


@lean
def _with_cut_edges(corners: np.ndarray, least: float, window: Window) -> Window:
    """Return a window that takes in the points at which edges of the box come as near as `least`."""
    for corner in range(8):
        x = corners[corner, 0]
        for axis in range(3):
            other = corner ^ (1 << axis)
            far = corners[other, 0]
            if x < least < far:
                share = (least - x) / (far - x)
                y = corners[corner, 1] + share * (corners[other, 1] - corners[corner, 1])
                z = corners[corner, 2] + share * (corners[other, 2] - corners[corner, 2])
                window = _widened(window, least, y, z)
    return window
