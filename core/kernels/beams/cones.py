"""The beams of a spinning LiDAR as cones over the grid, and whether any of its rays hits a voxel.

All azimuths of a beam lie on one cone about the sensor's axis. Over the columns of the grid a cone that is not too
steep is a height: seen from its tip, z = fall q + rise sqrt(q² + open ρ²), where q is the lean of the axis along (x, y)
and ρ the distance in plan. The root is a norm of (x, y), so the height is convex above the sensor and concave below.

Lengths are in voxels, positions in grid coordinates; beams are sorted by elevation.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.rays.cast import NONE_STOPPED
from riglens.core.kernels.rays.lattice import Direction, direction, rotated
from riglens.core.kernels.rays.walk import Cell, Ray, hits_cell
from riglens.core.kernels.runtime.codes import LISTED
from riglens.core.kernels.runtime.jit import lean, lean_inlined

NO_BEAMS = np.zeros((0, 0), np.int32)
SPHERE = 0.8661
"""A little more than the radius of a voxel's circumscribed ball."""
SLACK = 1e-6
"""Tolerance of heights and angles: rounding is far below, so decisions beyond it are certain."""
CLEAR = 1e-7
"""Times along a ray that differ by more are in their true order."""
LONGEST = 1e5
"""Times beyond this are not compared in doubles."""
HALF_COLUMN = 0.7072
"""A little more than half the diagonal of a column."""
A_TURN = 2.0 * np.pi
FINDER = 2048
BEARING = 2e-5
"""Radians: error of azimuths that only say which rays come into question."""
ROUND = 1.0
"""Voxels in plan within which a cone turns too much for its corners to bound it."""


class Beams(NamedTuple):
    """Cones of the beams by ascending elevation above `Spinner.axis`, (beams,) each: elevation in radians, sine and
    cosine; fall, rise, open: of the height (see above); slope: the steepest; bend: the largest curvature times ρ, inf
    for a cone that is too steep to be a height; number: row of the beam in the table of rays; offset of its azimuths
    in radians; sides (beams, 4): cosine and sine of its first and its last azimuth; radius: in plan, of the tiles in
    which a beam is looked at as a sheet, beyond which its rays are walked; finder (FINDER,): how many beams
    have a smaller sine than each of so many, from -1 to 1.
    """

    elevation: np.ndarray
    sine: np.ndarray
    cosine: np.ndarray
    fall: np.ndarray
    rise: np.ndarray
    open: np.ndarray
    slope: np.ndarray
    bend: np.ndarray
    number: np.ndarray
    offset: np.ndarray
    sides: np.ndarray
    radius: np.ndarray
    finder: np.ndarray


class Spinner(NamedTuple):
    """A spinning LiDAR: tables of `kernels.rays.lattice`, origin (3,) in grid units, rotation (3, 3), reach
    (2,), box (6,) cells, shape (3,) of the grid; axis (3,): about which the beams turn, the end that points up.

    azimuths (n,) in radians, ascending over at most one turn, and turns (n,): the number of each in the table; step:
    the widest gap between them; is_sector: whether they leave out what is behind the last and before the first.
    is_stopped (rays,) as in `kernels.rays.cast.Cast`; stopped_before (beams, n + 1): how many of the first
    azimuths of a beam are stopped, in the order of beams and azimuths; both empty where none is.
    """

    kind: int
    rows: np.ndarray
    planes: np.ndarray
    origin: np.ndarray
    rotation: np.ndarray
    reach: np.ndarray
    box: np.ndarray
    shape: np.ndarray
    axis: np.ndarray
    azimuths: np.ndarray
    turns: np.ndarray
    step: float
    is_sector: bool
    is_stopped: np.ndarray = NONE_STOPPED
    stopped_before: np.ndarray = NO_BEAMS


@lean_inlined
def height(axis: np.ndarray, beams: Beams, beam: int, x: float, y: float) -> float:
    """Return the height of a cone above its tip at a place in plan, seen from the tip."""
    q = axis[0] * x + axis[1] * y
    root = np.sqrt(q * q + beams.open[beam] * (x * x + y * y))
    return float(beams.fall[beam] * q + beams.rise[beam] * root)


@lean_inlined
def _overlaps(s: Spinner, beams: Beams, beam: int, cell: Cell) -> bool:
    """Return whether a cone may pass through a voxel; False is certain."""
    x, y, z = cell[0] - s.origin[0], cell[1] - s.origin[1], cell[2] - s.origin[2]
    distance = np.sqrt((x + 0.5) * (x + 0.5) + (y + 0.5) * (y + 0.5)) - HALF_COLUMN
    if distance < ROUND:
        return True
    a, b = height(s.axis, beams, beam, x, y), height(s.axis, beams, beam, x + 1.0, y)
    c, d = height(s.axis, beams, beam, x, y + 1.0), height(s.axis, beams, beam, x + 1.0, y + 1.0)
    room = 0.25 * beams.bend[beam] / distance + SLACK
    return bool(min(min(a, b), min(c, d)) - room <= z + 1.0 and max(max(a, b), max(c, d)) + room >= z)


@lean_inlined
def axis_times(g: float, pace: float, low: int, t_in: float, t_out: float) -> tuple[float, float]:
    """Return the times narrowed to those within one cell along an axis; pace: time for a voxel."""
    a, b = (low - g) * pace, (low + 1.0 - g) * pace
    return max(t_in, min(a, b)), min(t_out, max(a, b))


@lean_inlined
def is_cast(s: Spinner, row: int, turn: int) -> bool:
    """Return whether the ray of a row of beams and a turn is not stopped."""
    return s.is_stopped.size == 0 or not s.is_stopped[row * s.azimuths.size + turn]


@lean_inlined
def ray_direction(s: Spinner, row: int, turn: int) -> Direction:
    """Return the direction of the ray of a row of beams and a turn, in the frame of the grid."""
    if s.kind == LISTED:
        return rotated(s.rotation, direction(s.kind, s.rows[row * s.azimuths.size + turn], s.planes[0]))
    return rotated(s.rotation, direction(s.kind, s.rows[row], s.planes[turn]))


@lean_inlined
def ray_hits(s: Spinner, row: int, turn: int, cell: Cell) -> bool:
    """Return whether the ray of a row of beams and a turn is cast and traverses a voxel: in doubles where they suffice,
    else exactly."""
    if not is_cast(s, row, turn):
        return False
    d = ray_direction(s, row, turn)
    if d[0] != 0.0 and d[1] != 0.0 and d[2] != 0.0:
        t_in, t_out = axis_times(s.origin[0], 1.0 / d[0], cell[0], s.reach[0], s.reach[1])
        t_in, t_out = axis_times(s.origin[1], 1.0 / d[1], cell[1], t_in, t_out)
        t_in, t_out = axis_times(s.origin[2], 1.0 / d[2], cell[2], t_in, t_out)
        if abs(t_out - t_in) > CLEAR and abs(t_in) < LONGEST and abs(t_out) < LONGEST:
            return bool(t_out > t_in)
    g = (s.origin[0], s.origin[1], s.origin[2])
    return hits_cell(Ray(g, d, s.reach[0], s.reach[1]), cell)


@lean_inlined
def azimuth_of(u: float, v: float) -> float:
    """Return atan2(v, u) within BEARING, by a polynomial in half an octant (Hastings 1955): much faster."""
    low, high = min(abs(u), abs(v)), max(abs(u), abs(v))
    t = low / high if high > 0.0 else 0.0
    square = t * t
    rest = 0.1801410 + square * (-0.0851330 + square * 0.0208351)
    angle = t * (0.9998660 + square * (-0.3302995 + square * rest))
    angle = angle if abs(v) <= abs(u) else 0.5 * np.pi - angle
    angle = angle if u >= 0.0 else np.pi - angle
    return angle if v >= 0.0 else -angle


@lean_inlined
def _half_width(beams: Beams, beam: int, sine: float, cosine: float, narrow: float) -> float:
    """Return the azimuths to either side at which rays of a beam are within an angle, of that cosine, of a direction of
    some elevation, a little more; negative: there are none."""
    scale = cosine * beams.cosine[beam]
    rest = scale + sine * beams.sine[beam] - narrow
    if rest < -SLACK * SLACK:
        return -1.0
    if rest < 0.45 * scale:  # 1 - cos a > 0.45 a² as long as that is so little
        return float(np.sqrt(max(rest, 0.0) / (0.45 * scale))) + SLACK
    return np.pi if rest >= 2.0 * scale else float(np.arccos(1.0 - rest / scale)) + SLACK


@lean_inlined
def place_of(s: Spinner, past: float) -> int:
    """Return the number of azimuths less than `past` behind the first one; past: from 0 to a turn."""
    count, first = s.azimuths.size, s.azimuths[0]
    place = min(int(past / s.step), count)
    while place > 0 and s.azimuths[place - 1] - first >= past:
        place -= 1
    while place < count and s.azimuths[place] - first < past:
        place += 1
    return place


@lean_inlined
def _stopped_about(s: Spinner, beams: Beams, beam: int, azimuth: float, half: float) -> tuple[int, int]:
    """Count the rays of a beam to either side of an azimuth, and those of them that are stopped."""
    before, count = s.stopped_before[beam], s.azimuths.size
    if half >= 0.5 * np.pi or before[count] == 0:
        return count, int(before[count])
    left = azimuth - half - beams.offset[beam] - s.azimuths[0]
    left -= np.floor(left / A_TURN) * A_TURN
    right = left + 2.0 * half
    first, end = place_of(s, left), place_of(s, min(right, A_TURN))
    rays, stopped = end - first, int(before[end] - before[first])
    if right > A_TURN:
        again = min(place_of(s, right - A_TURN), first)
        return rays + again, stopped + int(before[again])
    return rays, stopped


@lean_inlined
def _are_stopped(s: Spinner, beams: Beams, beam: int, azimuth: float, half: float) -> bool:
    """Return whether all rays of a beam about an azimuth are stopped."""
    rays, stopped = _stopped_about(s, beams, beam, azimuth, half + BEARING)
    return rays == stopped


@lean_inlined
def stopped_among(
    s: Spinner, beams: Beams, beam: int, place: tuple[float, float, float], around: float
) -> tuple[int, int]:
    """Count the rays of a beam that may pass a ball at a place on its cone, and those of them that are stopped."""
    x, y, z = place
    r = s.rotation
    u = r[0, 0] * x + r[1, 0] * y + r[2, 0] * z
    v = r[0, 1] * x + r[1, 1] * y + r[2, 1] * z
    flat = np.sqrt(u * u + v * v)
    if around >= 0.9 * flat:
        return _stopped_about(s, beams, beam, 0.0, np.pi)
    share = around / flat
    half = share * (1.0 + 0.571 * share * share) + 2.0 * BEARING  # no less than the arc sine
    return _stopped_about(s, beams, beam, azimuth_of(u, v), half)


@lean_inlined
def around(place: int, count: int) -> tuple[int, float]:
    """Return an index into the azimuths, at most one turn off, and its angle around the axis."""
    if place >= count:
        return place - count, A_TURN
    return (place, 0.0) if place >= 0 else (place + count, -A_TURN)


@lean_inlined
def _beam_hits(s: Spinner, beams: Beams, beam: int, azimuth: float, width: float, cell: Cell) -> bool:
    """Return whether a ray of a beam with an azimuth within a width of the given one traverses a voxel; the nearest
    azimuths first, as these most likely do."""
    count, row, first = s.azimuths.size, beams.number[beam], s.azimuths[0]
    middle = azimuth - beams.offset[beam] - first
    middle -= np.floor(middle / A_TURN) * A_TURN
    width = min(width, np.pi)
    after = place_of(s, middle)
    before = after - 1
    here, turn = around(after, count)
    there, back = around(before, count)
    for _ in range(count):
        ahead, behind = s.azimuths[here] - first + turn - middle, middle - (s.azimuths[there] - first + back)
        if min(ahead, behind) > width:
            return False
        is_ahead = ahead <= behind
        if ray_hits(s, row, s.turns[here if is_ahead else there], cell):
            return True
        if is_ahead:
            after += 1
            here, turn = around(after, count)
        else:
            before -= 1
            there, back = around(before, count)
    return False


@lean_inlined
def _first_beam(beams: Beams, sine: float) -> int:
    """Return the number of beams with a smaller sine of their elevation."""
    place = int(min(max((sine + 1.0) * (0.5 * FINDER), 0.0), FINDER - 1.0))
    first = int(beams.finder[place])
    while first < beams.sine.size and beams.sine[first] < sine:
        first += 1
    return first


@lean
def any_ray_hits(s: Spinner, beams: Beams, cell: Cell) -> bool:
    """Return whether any ray of the sensor traverses a voxel, exactly."""
    x, y, z = cell[0] + 0.5 - s.origin[0], cell[1] + 0.5 - s.origin[1], cell[2] + 0.5 - s.origin[2]
    distance = np.sqrt(x * x + y * y + z * z)
    if distance - SPHERE > s.reach[1] or distance + SPHERE < s.reach[0]:
        return False
    wide = SPHERE / max(distance, SPHERE) + SLACK
    narrow = np.sqrt(1.0 - wide * wide) if wide < 1.0 else -1.0
    sine = min(max((s.axis[0] * x + s.axis[1] * y + s.axis[2] * z) / max(distance, SPHERE), -1.0), 1.0)
    cosine = np.sqrt(1.0 - sine * sine)
    lowest = sine * narrow - cosine * wide if -sine < narrow else -1.0
    highest = sine * narrow + cosine * wide if sine < narrow else 1.0
    azimuth, is_known = 0.0, False
    for beam in range(_first_beam(beams, lowest - SLACK), beams.sine.size):
        if beams.sine[beam] > highest + SLACK:
            return False
        if not _overlaps(s, beams, beam, cell):
            continue
        if not is_known:
            r = s.rotation
            u = r[0, 0] * x + r[1, 0] * y + r[2, 0] * z
            azimuth = azimuth_of(u, r[0, 1] * x + r[1, 1] * y + r[2, 1] * z)
            is_known = True
        width = np.pi if narrow < 0.0 else _half_width(beams, beam, sine, cosine, narrow)
        if width < 0.0 or (s.is_stopped.size > 0 and _are_stopped(s, beams, beam, azimuth, width + BEARING)):
            continue
        if _beam_hits(s, beams, beam, azimuth, width + BEARING, cell):
            return True
    return False
