"""The rays of a sensor by rows and columns, for kernels that look for the few of them that can pass a place."""

from __future__ import annotations

from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.beams.cones import A_TURN
from riglens.core.kernels.body.screen import Screen
from riglens.core.rig.model import Camera, Lidar, Sensor
from riglens.core.sensing.kept import RAYS
from riglens.core.sensors.base import unplaced
from riglens.core.sensors.camera import image_lattice

Doubles = NDArray[np.float64]
_PLACES = 8192
"""Places that a finder knows: about as many as the rows and columns of any sensor."""


def screen_of(sensor: Sensor) -> Screen | None:
    """Return the rows and columns of a sensor's lattice; None for one that has none, as a lens with distortion."""
    return None if sensor.blocked else _screen(unplaced(sensor))


@RAYS.of
def _screen(sensor: Sensor) -> Screen | None:
    """Return the screen of a sensor without its position, the same one throughout a drag."""
    return _made(sensor)


@singledispatch
def _made(_: Sensor) -> Screen | None:
    return None


@_made.register
def _of_lidar(lidar: Lidar) -> Screen | None:
    if lidar.rays is not None:
        return None
    elevation, azimuth = np.radians(lidar.elevations()), np.radians(lidar.azimuths()) % A_TURN
    row_of, column_of = np.argsort(np.sin(elevation), kind="stable"), np.argsort(azimuth, kind="stable")
    rows, row_scale = _finder(np.sin(elevation)[row_of], -1.0, 1.0)
    columns, column_scale = _finder(azimuth[column_of], 0.0, A_TURN)
    offsets = lidar.azimuth_offsets_deg
    shift = np.zeros(0) if offsets is None else np.radians(np.array(offsets))[row_of] % A_TURN
    return Screen(
        False, rows, columns, row_scale, column_scale, row_of, column_of, shift, np.tan(elevation)[row_of], 1.0
    )  # fmt: skip


@_made.register
def _of_camera(camera: Camera) -> Screen | None:
    if camera.distortion is not None:
        return None
    table = image_lattice(camera)
    z, y = table.rows[:, 0].copy(), table.planes[:, 0]  # in a piece, as a LiDAR's: the same kernels for both
    rows, row_scale = _finder(-z, float(-z[0]), float(-z[-1]))
    columns, column_scale = _finder(-y, float(-y[0]), float(-y[-1]))
    longest = float(np.sqrt(1.0 + np.abs(z).max() ** 2 + np.abs(y).max() ** 2))
    return Screen(
        True, rows, columns, row_scale, column_scale, np.arange(len(z)), np.arange(len(y)), np.zeros(0), z, longest
    )  # fmt: skip


def _finder(places: Doubles, low: float, high: float) -> tuple[NDArray[np.int64], Doubles]:
    """Return the number of sorted places in [low, high] below low + k / pace for each k, and (low, pace)."""
    pace = _PLACES / (high - low) if high > low else 1.0
    known = np.searchsorted(places, low + np.arange(_PLACES + 1) / pace)
    return np.append(known, len(places)), np.array([low, pace])
