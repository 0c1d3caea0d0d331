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
    AXIS, BY_COLUMN, BY_ROW, BEND, LONGEST, ROW, COLUMN, ROWS, COLUMNS, AFTER, IS_FULL, OWN_RAYS, COSINE, SINE
) = 0, 3, 6, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19  # fmt: skip
"""Places in a tile (FIELDS,). A ray of it, some multiple of its direction between 1 and LONGEST, is AXIS + BY_COLUMN
(columns from the middle) + BY_ROW (rows from the middle) and at most BEND more. ROW, COLUMN: its first ones; ROWS,
COLUMNS: how many; AFTER: the tile to go on with where this one is left out; IS_FULL: whether the lens has all of its
rays; OWN_RAYS: how many it has of its own, 0 where it stands for the tiles behind it up to AFTER; COSINE, SINE of a
cone around AXIS that holds all rays, times the length of AXIS."""
FIELDS = 20
TILE_ROWS = 16
"""Rows of a tile that has rays of its own, at most."""
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
    """Room for the sides of something seen from a sensor: plane (k, 5): a ray d of the sensor's own axes, a unit
    vector where the fourth number is not 0, is inside where plane[:3] d + plane[3] > 0, surely so above plane[4], and
    surely not below -plane[4]; of those that cut a tile, cut (k, 5): the number at its middle, its steps by row and by
    column, 1 / the latter, and the room around 0 in which it decides nothing. span (4, TILE_ROWS), of the rows of the
    tile: first and end column that may be inside, and that surely are."""

    plane: np.ndarray
    cut: np.ndarray
    span: np.ndarray


@kernel
def new_sides() -> Sides:
    """Return room for MOST_SIDES sides."""
    return Sides(np.empty((MOST_SIDES, 5)), np.empty((MOST_SIDES, 5)), np.zeros((4, TILE_ROWS)))


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
def set_spans(tile: np.ndarray, rows: tuple[int, int], cuts: int, sides: Sides) -> None:
    """Write the spans of rows of a tile, from one to before another, by their places in it."""
    cut, columns, first, end = sides.cut, tile[COLUMNS], np.uint64(rows[0]), np.uint64(rows[1])
    first_may, end_may, first_does, end_does = sides.span[0], sides.span[1], sides.span[2], sides.span[3]
    centre, middle = 0.5 * (columns - 1.0), 0.5 * (tile[ROWS] - 1.0)
    for row in range(first, end):
        first_may[row] = first_does[row] = 0.0
        end_may[row] = end_does[row] = columns
    for k in range(cuts):
        begin, slope, inverse, room = cut[k, 0], cut[k, 1], cut[k, 3], cut[k, 4]
        if cut[k, 2] > 0.0:
            for row in range(first, end):
                at = begin + (np.int32(row) - middle) * slope
                near, far = (
                    np.floor(centre - (at + room) * inverse) + 1.0, np.floor(centre - (at - room) * inverse) + 1.0
                )  # fmt: skip
                first_may[row] = near if near > first_may[row] else first_may[row]
                first_does[row] = far if far > first_does[row] else first_does[row]
        else:
            for row in range(first, end):
                at = begin + (np.int32(row) - middle) * slope
                near, far = np.ceil(centre - (at + room) * inverse), np.ceil(centre - (at - room) * inverse)
                end_may[row] = near if near < end_may[row] else end_may[row]
                end_does[row] = far if far < end_does[row] else end_does[row]
    for row in range(first, end):
        first_may[row] = first_may[row] if first_may[row] < columns else columns
        end_may[row] = end_may[row] if end_may[row] > 0.0 else 0.0
        is_none = not first_does[row] < end_does[row]  # for sure
        first_does[row] = end_may[row] if is_none else first_does[row]
        end_does[row] = end_may[row] if is_none else end_does[row]


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
