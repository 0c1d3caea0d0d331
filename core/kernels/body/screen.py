"""Bound the rays of a lattice that can pass a ball by windows of rows and columns, never too small.

Rows and columns of a lattice are bounded by one number each: sines of elevations and azimuths of a LiDAR, places on
the image plane of a camera. A finder says how many rows or columns lie before such a number, or
some fewer or more, without a search.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.beams.cones import A_TURN, azimuth_of
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.rays.lattice import rotated_back
from riglens.core.kernels.rays.predicates import Vector
from riglens.core.kernels.runtime.jit import lean_inlined
from riglens.core.kernels.voxels.bits import FULL_WORD

BEARING = 4e-5
"""Radians: more than azimuths by a polynomial are off."""
BLUR = 1e-9
"""Windows are wider than computed by this, in sines and slopes: far above any rounding."""


class Screen(NamedTuple):
    """Rays of a lattice by rows and columns in rising order of their bounds: sines of elevations and azimuths in [0, 2
    pi) of a LiDAR, -z and -y on the image plane of a camera.

    rows, columns (m + 1,): how many of them are before scale[0] + k / scale[1], with row_scale and column_scale (2,);
    row_of, column_of: their numbers in the lattice; shift (rows,) or (0,): what is added to the azimuths of a row, in
    [0, 2 pi); heights (rows,): z by distance from the axis, or on the image plane; longest: length of the longest
    direction (1, y, z) of a camera, 1 for a LiDAR.
    """

    is_camera: bool
    rows: np.ndarray
    columns: np.ndarray
    row_scale: np.ndarray
    column_scale: np.ndarray
    row_of: np.ndarray
    column_of: np.ndarray
    shift: np.ndarray
    heights: np.ndarray
    longest: float


class Window(NamedTuple):
    """Rows first..end-1, and columns from `left` over `width` (radians, or on the image plane)."""

    first: int
    end: int
    left: float
    width: float


@lean_inlined
def before(finder: np.ndarray, scale: np.ndarray, place: float) -> int:
    """Return the number of rows or columns before a place, or fewer."""
    return int(finder[int(min(max((place - scale[0]) * scale[1], 0.0), finder.size - 1.0))])


@lean_inlined
def upto(finder: np.ndarray, scale: np.ndarray, place: float) -> int:
    """Return the number of rows or columns up to a place, or more."""
    return int(finder[int(min(max((place - scale[0]) * scale[1] + 1.0, 0.0), finder.size - 1.0))])


@lean_inlined
def bearing(u: float, v: float) -> float:
    """Return atan2(v, u) in [0, 2 pi), within half of BEARING."""
    angle = azimuth_of(u, v)
    return angle if angle >= 0.0 else angle + A_TURN


@lean_inlined
def angle_on_line(y: float) -> float:
    """Return the angle to a place on the line x = 1, within half of BEARING."""
    return bearing(1.0, y) if y >= 0.0 else -bearing(1.0, -y)


@lean_inlined
def in_sensor_axes(rays: Cast, place: Vector) -> Vector:
    """Return a place of the vehicle frame as the sensor sees it."""
    g = rays.origin
    return rotated_back(rays.rotation, (place[0] - g[0], place[1] - g[1], place[2] - g[2]))


@lean_inlined
def _turn_window(screen: Screen, place: Vector, radius: float) -> Window:
    """Return the window of a ball at a place in the frame of a LiDAR."""
    x, y, z = place
    flat2 = x * x + y * y
    far2 = flat2 + z * z
    if radius * radius >= far2 * (1.0 - BLUR):
        return Window(0, screen.row_of.size, 0.0, A_TURN)
    far, flat = np.sqrt(far2), np.sqrt(flat2)
    wide, sine, cosine = radius / far, z / far, flat / far
    narrow = np.sqrt(1.0 - wide * wide)
    low = sine * narrow - cosine * wide if -sine < narrow else -1.0
    high = sine * narrow + cosine * wide if sine < narrow else 1.0
    first = before(screen.rows, screen.row_scale, low - BLUR)
    end = upto(screen.rows, screen.row_scale, high + BLUR)
    if radius >= flat * (1.0 - BLUR):
        return Window(first, end, 0.0, A_TURN)
    share = radius / flat
    half = share * (1.0 + 0.571 * share * share) + BEARING  # no less than the arc sine
    left = bearing(x, y) - half
    return Window(first, end, left + A_TURN if left < 0.0 else left, min(2.0 * half, A_TURN))


@lean_inlined
def slopes_of(x: float, y: float, radius: float) -> tuple[float, float]:
    """Return the span of a disc at (x, y) on the line x = 1 (empty: from > to)."""
    rest = x * x + y * y - radius * radius
    if rest <= BLUR * radius * radius:
        return -np.inf, np.inf
    along = np.sqrt(rest)
    x_low, x_high = x * along + y * radius, x * along - y * radius
    if x_low <= 0.0 and x_high <= 0.0:
        return 1.0, 0.0
    low = (y * along - x * radius) / x_low if x_low > 0.0 else -np.inf
    high = (y * along + x * radius) / x_high if x_high > 0.0 else np.inf
    return low - BLUR * (1.0 + abs(low)), high + BLUR * (1.0 + abs(high))


@lean_inlined
def _image_window(screen: Screen, place: Vector, radius: float) -> Window:
    """Return the window of a ball at a place in the frame of a camera."""
    low, high = slopes_of(place[0], -place[2], radius)
    left, right = slopes_of(place[0], -place[1], radius)
    if low > high or left > right:
        return Window(0, 0, 0.0, 0.0)
    first, end = before(screen.rows, screen.row_scale, low), upto(screen.rows, screen.row_scale, high)
    left, right = max(left, -1e9), min(right, 1e9)
    return Window(first, end, left, max(right - left, 0.0))


@lean_inlined
def window_of(screen: Screen, place: Vector, radius: float) -> Window:
    """Return the window of a ball at a place in the frame of the sensor."""
    return _image_window(screen, place, radius) if screen.is_camera else _turn_window(screen, place, radius)


@lean_inlined
def columns_of(screen: Screen, window: Window, row: int) -> tuple[int, int, int]:
    """Return the first and end of the columns of a row in a window, and the end of those after a full turn."""
    left = window.left
    if screen.shift.size > 0:
        left -= screen.shift[row]
        left = left + A_TURN if left < 0.0 else left
    right = left + window.width
    start = before(screen.columns, screen.column_scale, left)
    end, again = upto(screen.columns, screen.column_scale, right), 0
    if not screen.is_camera and right > A_TURN:
        again = min(start, upto(screen.columns, screen.column_scale, right - A_TURN))
    return start, end, again


@lean_inlined
def _bits_of(first: int, end: int, word: int) -> np.uint64:
    """Return the bits of the columns first..end-1, of which it holds some, in a word."""
    low, high = max(first - 64 * word, 0), min(end - 1 - 64 * word, 63)
    return (FULL_WORD << np.uint64(low)) & (FULL_WORD >> np.uint64(63 - high))


@lean_inlined
def has_all(words: np.ndarray, first: int, end: int) -> bool:
    """Return whether the bits first..end-1 of a row are set."""
    if first < end:
        for word in range(first >> 6, ((end - 1) >> 6) + 1):
            if ~words[word] & _bits_of(first, end, word) != 0:
                return False
    return True


@lean_inlined
def set_all(words: np.ndarray, first: int, end: int) -> None:
    """Set the bits first..end-1 of a row."""
    if first < end:
        for word in range(first >> 6, ((end - 1) >> 6) + 1):
            words[word] |= _bits_of(first, end, word)
