"""Table with one row per object, in the order of the data: its box and each sensor's hits on it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import kind_named
from riglens.core.targets.scores import TargetScores
from riglens.core.targets.traffic import Traffic

Columns = dict[str, list[Any]]
_DIGITS = 9
"""Decimals of place, size and yaw, which went through an origin and a rotation."""


def object_table(traffic: Traffic, scores: TargetScores) -> Columns:
    """Return columns by name, one entry per object that counts in the frames used, in the order of the data.

    `points_NAME` rays of a LiDAR that reach it first, `pixels_NAME` native pixels of a camera that show it; `points`
    and `cells` of all LiDARs together. Raise InputError when two columns would have the same name.
    """
    objects = scores.objects
    order = np.argsort(traffic.row[objects.box], kind="stable")
    box = objects.box[order]
    columns = _places(traffic, box)
    by_lidar = dict(zip(objects.lidars, objects.points[order].T, strict=True))
    by_camera = dict(zip(objects.cameras, objects.pixels[order].T, strict=True))
    by_returns = {
        name: (kind.hits.label, counts)
        for kind, found in ((kind_named(name), found) for name, found in objects.returns.items())
        if kind is not None
        for name, counts in zip(found.names, found.counts[order].T, strict=True)
    }
    for sensor in scores.rig.sensors:
        if sensor.name in by_lidar:
            _add(columns, f"points_{sensor.name}", by_lidar[sensor.name])
        elif sensor.name in by_camera:
            _add(columns, f"pixels_{sensor.name}", by_camera[sensor.name])
        elif sensor.name in by_returns:
            label, counts = by_returns[sensor.name]
            _add(columns, f"{label}_{sensor.name}", counts)
    _add(columns, "points", objects.all_points[order])
    _add(columns, "cells", objects.cells[order])
    return columns


def _places(traffic: Traffic, box: NDArray[np.int64]) -> Columns:
    """Return seq, frame, class and box of the boxes (k,); a frame without a name has its number in the data."""
    number = traffic.frame[traffic.frame_of_box[box]]
    labels, turn = traffic.data.labels, traffic.rotation[box]
    named = [("", int(frame)) if labels is None else labels.of(frame) for frame in number]
    columns: Columns = {
        "seq": [name for name, _ in named],
        "frame": [frame for _, frame in named],
        "cls": [CLASSES[cls] for cls in traffic.cls[box]],
    }
    for axis, name in enumerate("xyz"):
        columns[name] = _rounded(traffic.centre_m[box, axis])
    for axis, name in enumerate(("length", "width", "height")):
        columns[name] = _rounded(traffic.size_m[box, axis])
    columns["yaw"] = _rounded(np.arctan2(turn[:, 1, 0], turn[:, 0, 0]))
    return columns


def _rounded(values: NDArray[np.float64]) -> list[float]:
    return [round(value, _DIGITS) for value in values.tolist()]


def _add(columns: Columns, name: str, values: NDArray[np.generic]) -> None:
    if name in columns:
        raise InputError(
            f"two columns of the object table would be called '{name}'; give the sensors other names"
        )
    columns[name] = values.tolist()
