"""Bound the rays of a lattice without straight rows that can meet something convex, tile by tile.

Seen from the sensor, it is what lies on the inner side of a few planes, its sides, and within a tile the directions of
rays are nearly linear in row and column. So a side leaves a tile out, holds all of it, or cuts its rows, each at one
place, known up to what the lens bends within the tile.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.runtime.jit import kernel, lean_inlined

(
    AXIS, BY_COLUMN, BY_ROW, BEND, LONGEST, ROW, COLUMN, ROWS, COLUMNS, AFTER, IS_FULL, OWN_RAYS
) = 0, 3, 6, 9, 10, 11, 12, 13, 14, 15, 16, 17  # fmt: skip
"""Places in a tile (FIELDS,). A ray of it, some multiple of its direction between 1 and LONGEST, is
AXIS + BY_COLUMN (columns from the middle) + BY_ROW (rows from the middle) and at most BEND more. ROW, COLUMN: its
first ones; ROWS, COLUMNS: how many; AFTER: the tile to go on with where this one is left out; IS_FULL: whether the lens
has all of its rays; OWN_RAYS: how many it has of its own, 0 where it stands for the tiles behind it up to AFTER."""
FIELDS = 18
MOST_SIDES = 32

_SQRT2 = 1.4142135623730954
SIDE_BLUR = 1e-9
"""Least room of a side: far above any rounding."""
_FLAT = 1e-200
"""Stand-in for a slope of zero, a divisor."""


class TiledRays(NamedTuple):
    """Rays of a lattice: tiles (t, FIELDS) of it, those of a group behind a tile around all of them; the number of its
    columns; numbers (slots,) of the listed rays at its slots, below 0 for missing ones, (0,) where all exist."""

    tiles: np.ndarray
    columns: int
    numbers: np.ndarray


class Sides(NamedTuple):
    """Room for the sides of something seen from a sensor: plane (k, 5): a ray d of the sensor's own axes, a unit vector
    where the fourth number is not 0, is inside where plane[:3] d + plane[3] > 0, surely so above plane[4], and surely
    not below -plane[4]; of those that cut a tile, cut (k, 5): the number at its middle, its steps by row and by column,
    1 / the latter, and the room around 0 in which it decides nothing. span (4,), of a row of the tile: first and end
    column that may be inside, and that surely are."""

    plane: np.ndarray
    cut: np.ndarray
    span: np.ndarray


@kernel
def new_sides() -> Sides:
    """Return room for MOST_SIDES sides."""
    return Sides(np.empty((MOST_SIDES, 5)), np.empty((MOST_SIDES, 5)), np.zeros(4, np.int64))


@lean_inlined
def cuts_of(tile: np.ndarray, count: int, sides: Sides) -> int:
    """Write the cuts of a tile by sides; return how many, or -1 where one of them leaves all of the tile out."""
    cuts, plane, cut = 0, sides.plane, sides.cut
    columns, rows, bend = 0.5 * (tile[COLUMNS] - 1.0), 0.5 * (tile[ROWS] - 1.0), _SQRT2 * tile[BEND]
    for side in range(count):
        x, y, z, rest = plane[side, 0], plane[side, 1], plane[side, 2], plane[side, 3]
        middle = x * tile[AXIS] + y * tile[AXIS + 1] + z * tile[AXIS + 2]
        by_column = x * tile[BY_COLUMN] + y * tile[BY_COLUMN + 1] + z * tile[BY_COLUMN + 2]
        by_row = x * tile[BY_ROW] + y * tile[BY_ROW + 1] + z * tile[BY_ROW + 2]
        room = bend + plane[side, 4]
        if rest != 0.0:
            middle += 0.5 * rest * (1.0 + tile[LONGEST])
            room += 0.5 * abs(rest) * (tile[LONGEST] - 1.0)
        wide = abs(by_column) * columns + abs(by_row) * rows + room
        if middle + wide <= 0.0:
            return -1
        if middle - wide <= 0.0:
            slope = by_column if abs(by_column) > _FLAT else _FLAT
            cut[cuts, 0], cut[cuts, 1], cut[cuts, 2] = middle, by_row, slope
            cut[cuts, 3], cut[cuts, 4] = 1.0 / slope, room
            cuts += 1
    return cuts


@lean_inlined
def span_of(tile: np.ndarray, row: int, cuts: int, sides: Sides) -> None:
    """Write the span of a row of a tile, by its place in it."""
    cut, end = sides.cut, tile[COLUMNS]
    first_may, end_may, first_does, end_does = 0.0, end, 0.0, end
    centre, up = 0.5 * (end - 1.0), row - 0.5 * (tile[ROWS] - 1.0)
    for k in range(cuts):
        at, inverse, room = cut[k, 0] + up * cut[k, 1], cut[k, 3], cut[k, 4]
        near, far = centre - (at + room) * inverse, centre - (at - room) * inverse
        if cut[k, 2] > 0.0:
            first_may, first_does = max(first_may, np.floor(near) + 1.0), max(first_does, np.floor(far) + 1.0)
        else:
            end_may, end_does = min(end_may, np.ceil(near)), min(end_does, np.ceil(far))
    span = sides.span
    span[0], span[1] = int(min(first_may, end)), int(max(end_may, 0.0))
    span[2], span[3] = int(min(first_does, end)), int(max(end_does, 0.0))
    if span[2] >= span[3]:  # none for sure
        span[2] = span[3] = span[1]


@lean_inlined
def rows_of(tile: np.ndarray, cuts: int, sides: Sides) -> tuple[int, int]:
    """Return the first and end row of a tile, by their places in it, in which rays may be inside of all that cuts
    it."""
    cut, first, end = sides.cut, 0.0, tile[ROWS]
    middle, wide = 0.5 * (tile[ROWS] - 1.0), 0.5 * (tile[COLUMNS] - 1.0)
    for k in range(cuts):
        most, up = cut[k, 0] + abs(cut[k, 2]) * wide + cut[k, 4], cut[k, 1]
        if up > 0.0:
            first = max(first, np.floor(middle - most / up))
        elif up < 0.0:
            end = min(end, np.ceil(middle - most / up) + 1.0)
    return int(min(first, tile[ROWS])), int(max(end, 0.0))
