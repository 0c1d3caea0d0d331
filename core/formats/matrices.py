"""Transforms that files give as matrices, and the axes of an IMU, which no such file says."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from riglens.core.formats.frames import ROUNDED_OFF_RAD, Matrix, from_optical, nearest_rotation, se3
from riglens.core.formats.mounts import Mounting
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source, Value

SHORTEST_PX = 1e-3
"""Focal lengths below this belong to no camera: our choice."""
_UPRIGHT = math.cos(math.radians(60.0))
_WORDS = (("forward", "backward"), ("left", "right"), ("up", "down"))


def rigid(value: Value, about: str, notes: Notes) -> Matrix:
    """Return a transform (4, 4) given as four rows, as 16 numbers, or as OpenCV writes either: rows, cols, data."""
    data = value
    if value.is_mapping:
        for side in ("rows", "cols"):
            if side in value:
                value.item(side).whole(4, 4)
        data = value.item("data")
    elements = data.elements()
    if len(elements) == 16 or (value.is_mapping and not (elements and elements[0].is_list)):
        matrix = np.array(data.numbers(16)).reshape(4, 4)
    else:
        matrix = data.matrix(4, 4)
    return rigid_of(value, matrix, notes, about)


def rigid_of(value: Value, matrix: Matrix, notes: Notes, about: str = "") -> Matrix:
    """Return the transform (4, 4) of a matrix (3, 3), (3, 4) or (4, 4), whose rotation is the nearest one."""
    position = matrix[:3, 3] if matrix.shape[1] > 3 else np.zeros(3)
    return se3(rotation_of(value, matrix[:3, :3], notes, about), position)


def quoted_matrix(file: Source, rows: int, columns: int) -> tuple[Value, Matrix]:
    """Return the matrix that a text file holds, row by row, and the file's words."""
    value = Value(file.text.split()[:100], file.where)
    return value, quoted_numbers(value, rows, columns)


def quoted_numbers(value: Value, rows: int, columns: int) -> Matrix:
    """Return a matrix given as a list of words, row by row."""
    numbers = [word.number(quoted=True) for word in value.elements(rows * columns)]
    return np.array(numbers).reshape(rows, columns)


def rotation_of(value: Value, matrix: Matrix, notes: Notes, about: str = "") -> Matrix:
    """Return the rotation nearest to a matrix (3, 3); reject other matrices, and report differences beyond rounding."""
    rotation, error = nearest_rotation(value, matrix)
    if error > ROUNDED_OFF_RAD:
        notes.approximated(
            "rotation matrix not orthonormal: the nearest one that is", about or value.place[1]
        )
    return rotation


def projected(value: Value, projection: Matrix) -> Matrix:
    """Return the pose (4, 4) of the camera of a projection matrix K [I | t], (3, 4), or of K alone, (3, 3)."""
    k, last = projection[:, :3], projection[:, 3:]
    has_focus = min(k[0, 0], k[1, 1]) >= SHORTEST_PX and abs(k[2, 2] - 1.0) < 1e-6
    if not has_focus or np.abs(np.tril(k, -1)).max() > 1e-6:
        value.refuse("a projection matrix K [I | t] with focal lengths", "another matrix")
    centre = np.linalg.solve(k, last[:, 0] if last.size else np.zeros(3))
    return se3(np.eye(3), np.array(-centre, np.float64))


def add_by_imu(cameras: Mapping[str, tuple[Matrix, dict[str, Any]]], mounting: Mounting) -> Matrix:
    """Add cameras by their optical frames in an IMU's axes, with their fields; return how those axes are turned."""
    turn = level_axes((pose for pose, _ in cameras.values()), mounting.notes)
    for name, (pose, fields) in cameras.items():
        mounting.add("camera", name, from_optical(turn @ pose), **fields)
    return turn


def level_axes(imu_SE3_optical: Iterable[Matrix], notes: Notes) -> Matrix:
    """Return the transform (4, 4) from an IMU's axes to x forward, y left, z up.

    The axes are taken as that already. Where the cameras would be tipped by more than 60 degrees (our choice), they are
    taken as those in which the cameras stand upright and look forward.
    """
    poses = list(imu_SE3_optical)
    down, ahead = (np.sum([pose[:3, column] for pose in poses], axis=0) for column in (1, 2))
    if not poses or -down[2] >= _UPRIGHT * np.linalg.norm(down):
        notes.approximated("the IMU's axes are taken as x forward, y left, z up")
        return np.eye(4)
    up = _nearest_axis(-down)
    forward = _nearest_axis(np.where(up == 0.0, ahead, np.nan))
    vehicle_R_imu = np.stack([forward, np.cross(up, forward), up])
    words = [_WORDS[row][int(axis[row] < 0.0)] for axis in vehicle_R_imu.T for row in np.flatnonzero(axis)]
    notes.approximated(
        f"the IMU's axes are taken as x {words[0]}, y {words[1]}, z {words[2]}: "
        "as x forward, y left, z up the cameras would not stand upright"
    )
    return se3(vehicle_R_imu, np.zeros(3))


def _nearest_axis(direction: Matrix) -> Matrix:
    """Return the unit vector along the axis nearest to a direction (3,); NaN excludes an axis."""
    axis = int(np.nanargmax(np.abs(direction)))
    unit = np.zeros(3)
    unit[axis] = math.copysign(1.0, direction[axis])
    return unit
