"""Render what a camera sees in one frame, pixel by pixel: objects, occluders, ground, own car and sky.

Serial, for processes that run side by side. The same boxes and the same search as for sweeps, so that pictures, labels
and points agree.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.objects.box_frames import (
    Beams,
    Canvas,
    FrameBoxes,
    bounds_of,
    box_of,
    is_glass,
    local_direction,
    new_faces,
    turned,
)
from riglens.core.kernels.objects.counts import wipe
from riglens.core.kernels.objects.images import is_stopped
from riglens.core.kernels.objects.nearest import meet_frame
from riglens.core.kernels.objects.sweeps import GROUND, STATIC, Surface, ground_at, set_frames
from riglens.core.kernels.rays.lattice import Direction, rotated
from riglens.core.kernels.rays.phases import mixed, unit
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined

SKY, OWN_CAR, NO_RAY = -3, -4, -5
"""Codes of a pixel besides GROUND, STATIC and objects; NO_RAY: the lens has none there."""
LIGHT = (0.36, 0.48, 0.8)
HAZE_M = 220.0
PATCH_M = 0.4
"""Edge of the patches of which the ground is made."""


class Paint(NamedTuple):
    """Colours (…, 3), 0 to 255: of each box (n, 3), of glass, road, own car, zenith and horizon (3,); `users`: number
    of objects, which come first among the boxes."""

    users: int
    boxes: np.ndarray
    glass: np.ndarray
    road: np.ndarray
    own: np.ndarray
    zenith: np.ndarray
    horizon: np.ndarray


class Image(NamedTuple):
    """Output of a picture: what (rows, columns) int32, depth along the axis of the camera in metres, inf: none, and rgb
    (rows, columns, 3); seen (users, 5) of each object: pixels, then first and last column and row."""

    what: np.ndarray
    depth: np.ndarray
    rgb: np.ndarray
    seen: np.ndarray


@lean_inlined
def _face_light(traffic: FrameBoxes, box: int, part: int, start: np.ndarray, along: Direction) -> float:
    """Return the brightness of the face by which a ray enters a part, 0.35 to 1."""
    middle, half = bounds_of(traffic, part)
    last, axis_of, sign = -np.inf, 2, 1.0
    for axis in range(3):
        from_middle = start[axis] - middle[axis]
        s = abs(from_middle) - half[axis]
        if s > 0.0 and s / abs(along[axis]) > last:
            last, axis_of = s / abs(along[axis]), axis
            sign = 1.0 if from_middle > 0.0 else -1.0
    turn = traffic.rotations[box]
    facing = sign * (turn[0, axis_of] * LIGHT[0] + turn[1, axis_of] * LIGHT[1] + turn[2, axis_of] * LIGHT[2])
    return float(0.6 + 0.4 * facing if facing > 0.0 else 0.6 + 0.25 * facing)


@lean_inlined
def _patch_light(x: float, y: float) -> float:
    """Return the brightness of a patch of the ground: a little different from its neighbours."""
    i, j = np.int64(np.floor(x / PATCH_M)), np.int64(np.floor(y / PATCH_M))
    return 0.96 + 0.08 * unit(mixed(mixed(np.uint64(1), np.uint64(i)), np.uint64(j)))


@lean_inlined
def _dab(colour: np.ndarray, light: float, t: float, paint: Paint, to: np.ndarray) -> None:
    """Paint a pixel in a colour, paler the farther it is."""
    clear = np.exp(-t / HAZE_M)
    for k in range(3):
        value = colour[k] * light * clear + paint.horizon[k] * (1.0 - clear)
        to[k] = np.uint8(min(max(value, 0.0), 255.0))


@lean_inlined
def _sky(up: float, paint: Paint, to: np.ndarray) -> None:
    share = min(max(up, 0.0), 1.0) ** 0.6
    for k in range(3):
        to[k] = np.uint8(paint.horizon[k] * (1.0 - share) + paint.zenith[k] * share)


@lean_inlined
def _note_seen(seen: np.ndarray, row: int, column: int) -> None:
    if seen[0] == 0:
        seen[1] = seen[2] = column
        seen[3] = seen[4] = row
    seen[0] += 1
    seen[1], seen[2] = min(seen[1], column), max(seen[2], column)
    seen[3], seen[4] = min(seen[3], row), max(seen[4], row)


@lean
def _paint(
    traffic: FrameBoxes, surface: Surface, beams: Beams, paint: Paint, canvas: Canvas, turns: np.ndarray,
    starts: np.ndarray, to: Image,
) -> None:  # fmt: skip
    for place in range(beams.row_of.size):
        row = beams.row_of[place]
        for place_of_column in range(beams.columns):
            column, slot = beams.column_of[place_of_column], place * beams.columns + place_of_column
            local, part = local_direction(beams, place, place_of_column), canvas.owner[slot]
            length = np.sqrt(local[0] * local[0] + local[1] * local[1] + local[2] * local[2])
            pixel = to.rgb[row, column]
            to.depth[row, column] = np.inf
            if length == 0.0:
                to.what[row, column] = NO_RAY
                continue
            d = rotated(beams.rotation, local)
            t = 1.0 / canvas.inverse[slot] if part >= 0 else ground_at(surface, beams.origin, d)
            inverse = 1.0 / t if part < 0 else canvas.inverse[slot]
            if beams.ends.size > 0 and is_stopped(beams, place, place_of_column, inverse):
                end = beams.ends[row * beams.columns + column]
                if end < np.inf:
                    to.what[row, column], to.depth[row, column] = OWN_CAR, end / length * local[0]
                    _dab(paint.own, 0.75 + 0.25 * d[2] / length, 0.0, paint, pixel)
                    continue
            if not t < np.inf:
                to.what[row, column] = SKY
                _sky(d[2] / length, paint, pixel)
                continue
            to.depth[row, column] = t * local[0]
            if part < 0:
                to.what[row, column] = GROUND
                x, y = beams.origin[0] + t * d[0], beams.origin[1] + t * d[1]
                _dab(paint.road, _patch_light(x, y), t * length, paint, pixel)
                continue
            box = box_of(part)
            to.what[row, column] = box if box < paint.users else STATIC
            if box < paint.users:
                _note_seen(to.seen[box], row, column)
            colour = paint.glass if is_glass(traffic, part) else paint.boxes[box]
            light = _face_light(traffic, box, part, starts[box], turned(turns[box], local))
            _dab(colour, light, t * length, paint, pixel)


@kernel
def paint_frame(
    traffic: FrameBoxes,
    surface: Surface,
    beams: Beams,
    paint: Paint,
    canvas: Canvas,
    alone: np.ndarray,
    to: Image,
) -> None:
    """Paint the only frame of `traffic` as a camera sees it; alone (boxes,) takes the pixels that each box would have
    without occlusion, and must be 0 before. The canvas is left empty."""
    boxes = traffic.centres.shape[0]
    faces, key = new_faces(), np.uint64(0)
    meet_frame(traffic, beams, 0, beams.rotation, key, faces, np.empty((8, 3)), np.empty(3), canvas, alone)
    turns, starts = np.empty((boxes, 3, 3)), np.empty((boxes, 3))
    set_frames(traffic, beams, beams.rotation, turns, starts)
    _paint(traffic, surface, beams, paint, canvas, turns, starts, to)
    canvas.last[:] = -1
    wipe(beams.columns, canvas)
