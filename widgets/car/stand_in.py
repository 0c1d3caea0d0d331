"""Draw a plain box of the vehicle's size in place of a missing body, labelled on its roof and sides."""

from __future__ import annotations

from pathlib import PurePath

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from riglens.core.rig.model import Vehicle
from riglens.core.shown_text import visible
from riglens.core.vehicle.surface import rounded_box
from riglens.widgets.car.parts import Parts
from riglens.widgets.drawing.surface import drawn, join, set_normals

_CLEARANCE, _ROUND = 0.12, 0.06
"""Gap below the box and radius of its edges, as shares of the height."""
_INK_M = 0.004
_WIDE, _HIGH = 0.8, 0.5
_MOST_LETTERS = 40
Points = NDArray[np.float64]


def stand_in_parts(vehicle: Vehicle) -> Parts:
    """Return the box and the words on it."""
    half_x, half_y, low, high = (
        vehicle.length / 2,
        vehicle.width / 2,
        _CLEARANCE * vehicle.height,
        vehicle.height,
    )
    box = rounded_box(
        np.array([-half_x, -half_y, low]), np.array([half_x, half_y, high]), _ROUND * vehicle.height
    )
    words = _words(f"stand-in for\n{_short_name(vehicle.body)}")
    ahead, left, up = np.eye(3)
    middle = (low + high) / 2 * up
    faces = (
        (ahead, left, (high + _INK_M) * up, (vehicle.length, vehicle.width)),
        (ahead, up, middle - (half_y + _INK_M) * left, (vehicle.length, high - low)),
        (-ahead, up, middle + (half_y + _INK_M) * left, (vehicle.length, high - low)),
    )
    ink = [_written(words, *face) for face in faces]
    return {"panel": drawn(box), "trim": join(ink)}


def _short_name(body: str) -> str:
    """Return the name of the file that is missing, its end if it is long."""
    name = visible(PurePath(body).name)
    return name if len(name) <= _MOST_LETTERS else "…" + name[1 - _MOST_LETTERS :]


def _words(text: str) -> pv.PolyData:
    """Return letters in the plane of x and y, centred; VTK's letters are those of ASCII."""
    words = pv.Text3D(text.encode("ascii", "replace").decode(), depth=0.0)
    words.points = np.asarray(words.points) - np.asarray(words.center)
    return words


def _written(
    words: pv.PolyData, right: Points, up: Points, centre_m: Points, room_m: tuple[float, float]
) -> pv.PolyData:
    """Return letters on a face: as large as fits into most of its room along `right` and `up`."""
    width, height = np.ptp(np.asarray(words.points)[:, :2], axis=0)
    scale = min(_WIDE * room_m[0] / float(width), _HIGH * room_m[1] / float(height))
    flat = scale * np.asarray(words.points, dtype=np.float64)
    written = pv.PolyData(centre_m + flat[:, :1] * right + flat[:, 1:2] * up, words.faces)
    set_normals(written, np.tile(np.cross(right, up), (written.n_points, 1)))
    return written
