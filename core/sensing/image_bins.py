"""The rays of a lens with distortion by their place in the image plane of a pinhole."""

from __future__ import annotations

from functools import singledispatch

import numpy as np

from riglens.core.kernels.rays.bins import Bins
from riglens.core.rig.model import Camera, Sensor
from riglens.core.sensing.kept import RAYS
from riglens.core.sensing.rays import lattice
from riglens.core.sensors.base import unplaced

RAYS_PER_BIN = 4
"""Along each axis of the image, in the mean."""
WIDEST_TANGENT = 20.0
"""Rays and image borders beyond atan(20) = 87 degrees: too wide for places in the image plane."""


@singledispatch
def bins_of(_: Sensor) -> Bins | None:
    """Return the rays of a camera in bins; None if there are none, or one points backwards or too far to the side."""
    return None


@bins_of.register
def _bins_of(camera: Camera) -> Bins | None:
    return _bins(unplaced(camera))


@RAYS.of
def _bins(camera: Camera) -> Bins | None:
    """Return the bins of a camera without its position, the same ones throughout a drag."""
    rows = lattice(camera).rows
    if not len(rows) or not (rows[:, 0] > 0.0).all():
        return None
    place = rows[:, 1:] / rows[:, :1]
    if np.hypot(*place.T).max() > WIDEST_TANGENT:
        return None
    count = np.array([max(size // RAYS_PER_BIN, 1) for size in camera.resolution])
    corner, far = place.min(axis=0), place.max(axis=0)
    scale = count / np.maximum(far - corner, 1e-9)
    at = np.minimum(np.floor((place - corner) * scale).astype(np.int64), count - 1)
    number = at[:, 0] * count[1] + at[:, 1]
    first = np.concatenate([[0], np.cumsum(np.bincount(number, minlength=int(count.prod())))])
    order = np.argsort(number, kind="stable").astype(np.int32)
    return Bins(corner, scale, count, first, order, np.ascontiguousarray(place[order]))
