"""The curve of one field near its value: how hit coverage changes while the rest of the rig stays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from riglens.core.errors import InputError
from riglens.core.figures.figure import SE_FACTOR
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sweep.fields import RigField, value_of, with_values
from riglens.core.sweep.rows import Sweeper

POINTS, FRAMES = 21, 100
SPANS = {"m": 0.5, "°": 15.0}
"""Reach of a curve on both sides, by unit; half of the value without one."""
_DIGITS = 9


class CurvePoint(NamedTuple):
    """A value of the field, and by class the change of the figure from the rig as it is and its noise: two standard
    errors, and the noise floor once it is known."""

    value: float
    changes: Mapping[str, tuple[float, float]]


def nearby_values(rig: Rig, field: RigField) -> tuple[float, ...]:
    """Return evenly spaced values around that of the rig, which is among them, without those that do not fit."""
    now = value_of(rig, field)
    span = SPANS.get(field.unit, abs(now) / 2.0)
    steps = np.linspace(-span, span, POINTS)
    found = {now}
    for value in np.round(now + (np.round(steps) if isinstance(now, int) else steps), _DIGITS).tolist():
        try:
            with_values(rig, {field: value})
        except InputError:
            continue
        found.add(value)
    near = {value for value in found if value == now or abs(value - now) > 10.0**-_DIGITS}
    return tuple(sorted(near))


def figure_of(rig: Rig, field: RigField) -> str:
    """Return the figure of an object class that a field moves first: hit coverage, or that of the sensor's kind."""
    kind = LIDAR.name if field.sensor is None else rig.sensor(field.sensor).kind
    known = {LIDAR.name: "on_target", CAMERA.name: "share_25px"}
    return f"{kind}.{known.get(kind, 'share')}"


def curve(rig: Rig, field: RigField, values: Sequence[float], sweeper: Sweeper) -> Iterator[CurvePoint]:
    """Yield a point for each value; raise InputError where all sensors of the field's kind are off."""
    figure, before = figure_of(rig, field), sweeper.row(rig)
    if f"{CLASSES[0]}.{figure}" not in before:
        raise InputError(f"{field.name}: nothing changes with it while the sensor is off; enable it")
    for value in values:
        row = sweeper.row(with_values(rig, {field: value}))
        columns = {name: f"{name}.{figure}" for name in CLASSES}
        yield CurvePoint(
            value,
            {
                name: (row[one] - before[one], SE_FACTOR * row.get(f"{one}_change_se", 0.0))
                for name, one in columns.items()
            },
        )


def with_floor(
    points: Sequence[CurvePoint], figure: str, floor: Mapping[str, float]
) -> tuple[CurvePoint, ...]:
    """Return the points with the noise floor of a figure added to their noise, as in the chart of a sweep."""

    def noisy(point: CurvePoint) -> CurvePoint:
        changes = point.changes.items()
        return CurvePoint(
            point.value,
            {name: (change, noise + floor[f"{name}.{figure}"]) for name, (change, noise) in changes},
        )

    return tuple(map(noisy, points))
