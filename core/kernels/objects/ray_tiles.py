"""Bound the rays of a lattice without straight rows that can enter a part, tile by tile.

Seen from the sensor, a part is what lies on the inner side of a few planes, its sides, and within a tile the directions
of rays are nearly linear in row and column. So a side leaves a tile out, holds all of it, or cuts its rows, each at one
place, known up to what the lens bends within the tile.
"""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.objects.box_frames import Beams, Faces, Sides
from riglens.core.kernels.runtime.jit import lean_inlined

(
    AXIS, BY_COLUMN, BY_ROW, BEND, LONGEST, ROW, COLUMN, ROWS, COLUMNS, AFTER, IS_FULL, IS_LEAF
) = 0, 3, 6, 9, 10, 11, 12, 13, 14, 15, 16, 17  # fmt: skip
"""Places in a tile (FIELDS,) of `Beams.tiles`. A ray of it, some multiple of its direction between 1 and LONGEST, is
AXIS + BY_COLUMN (columns from the middle) + BY_ROW (rows from the middle) and at most BEND more. ROW, COLUMN: its
first ones; ROWS, COLUMNS: how many; AFTER: the tile to go on with where this one is left out; IS_FULL: whether the lens
has all of its rays; IS_LEAF: whether it holds rays, not only the tiles behind it up to AFTER."""
FIELDS = 18

_SQRT2 = 1.4142135623730954
_BLUR = 1e-9
"""Rays nearer than this to a side are tried one by one: far above any rounding."""
_FLAT = 1e-200
"""Stand-in for a slope of zero, a divisor."""


@lean_inlined
def set_sides(beams: Beams, faces: Faces) -> int:
    """Write the sides of a part, which are where `nearest.find_entries` compares one number with another; return how
    many there are."""
    count, least, sides = 0, 1.0 / beams.reach[1], faces.sides
    for axis in range(3):
        enter = faces.enter[axis]
        if enter == 0.0:  # between these two faces
            continue
        if least > 0.0:
            count = _add_plane(faces.turn, axis, enter, axis, 0.0, -least, sides, count)
        for other in range(3):
            if other == axis:
                continue
            count = _add_plane(faces.turn, axis, enter, other, faces.leave[other], 0.0, sides, count)
            if faces.enter[other] == 0.0:
                count = _add_plane(faces.turn, axis, enter, other, faces.other[other], 0.0, sides, count)
    if beams.reach[0] > 0.0:
        most = 1.0 / beams.reach[0]
        for axis in range(3):
            count = _add_plane(faces.turn, axis, 0.0, axis, faces.leave[axis], most, sides, count)
            if faces.enter[axis] == 0.0:
                count = _add_plane(faces.turn, axis, 0.0, axis, faces.other[axis], most, sides, count)
    return count


@lean_inlined
def _add_plane(
    turn: np.ndarray, one: int, enter: float, other: int, leave: float, rest: float, sides: Sides, count: int
) -> int:  # fmt: skip
    """Add the side on which a[one] enter - a[other] leave + rest > 0, a = turn d, by numbers of at most 1."""
    most = max(abs(enter), abs(leave), abs(rest))
    p, q = enter / most, leave / most
    for k in range(3):
        sides.plane[count, k] = p * turn[one, k] - q * turn[other, k]
    sides.plane[count, 3] = rest / most
    return count + 1


@lean_inlined
def cuts_of(tile: np.ndarray, count: int, sides: Sides) -> int:
    """Write the cuts of a tile by sides; return how many, or -1 where one of them leaves all of the tile out."""
    cuts, plane, cut = 0, sides.plane, sides.cut
    columns, rows, bend = 0.5 * (tile[COLUMNS] - 1.0), 0.5 * (tile[ROWS] - 1.0), _SQRT2 * tile[BEND] + _BLUR
    for side in range(count):
        x, y, z, rest = plane[side, 0], plane[side, 1], plane[side, 2], plane[side, 3]
        middle = x * tile[AXIS] + y * tile[AXIS + 1] + z * tile[AXIS + 2]
        by_column = x * tile[BY_COLUMN] + y * tile[BY_COLUMN + 1] + z * tile[BY_COLUMN + 2]
        by_row = x * tile[BY_ROW] + y * tile[BY_ROW + 1] + z * tile[BY_ROW + 2]
        room = bend
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
