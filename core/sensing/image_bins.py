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
    across, up = rows[:, 1] / rows[:, 0], rows[:, 2] / rows[:, 0]
    if np.hypot(across, up).max() > WIDEST_TANGENT:
        return None
    count = np.array([max(size // RAYS_PER_BIN, 1) for size in camera.resolution])
    corner, far = (np.array([end(across), end(up)]) for end in (np.min, np.max))
    scale = count / np.maximum(far - corner, 1e-9)
    least = np.min_scalar_type(int(count.max()))  # numpy sorts small numbers by their digits
    column, row = (
        np.minimum(((place - corner[axis]) * scale[axis]).astype(np.int64), count[axis] - 1).astype(least)
        for axis, place in enumerate((across, up))
    )
    order = np.lexsort((row, column)).astype(np.int32)
    number = column * count[1] + row
    first = np.concatenate([[0], np.cumsum(np.bincount(number, minlength=int(count.prod())))])
    return Bins(corner, scale, count, first, order, np.stack([across[order], up[order]], axis=1))
