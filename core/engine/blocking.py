"""Find the rays of a sensor that the car's own body stops: those not cast at all, and those cast up to the body."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.body.empty_box import grow_empty_box
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.runtime.codes import LISTED
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Method
from riglens.core.rig.model import Sensor
from riglens.core.sensing.body_ends import NO_EMPTY_BOX, Shadow, barrier_shadow
from riglens.core.sensors.lattice import Lattice
from riglens.core.vehicle.solid import Barrier

INSET_M = 1e-6
"""The empty box ends this far inside of its voxels: far more than the rounding of where a ray is."""


def empty_box_around(field: EntropyField, sensor: Sensor, barrier: Barrier) -> NDArray[np.float64]:
    """Return a box in metres (6,) around a sensor, as large as the car, in which no voxel is informative;
    `NO_EMPTY_BOX` where there is none. Beyond the grid there are no voxels, so at its border the box has no end."""
    grid = field.grid
    shape, place = np.array(grid.shape, np.int64), np.array(sensor.position)
    cell = np.floor(grid.to_grid(sensor.position)).astype(np.int64)
    if not len(barrier.tree.bounds) or (cell < 0).any() or (cell >= shape).any():
        return NO_EMPTY_BOX
    body = barrier.tree.bounds[0]
    first = np.floor(grid.to_grid((body[0], body[1], body[2]))).astype(np.int64)
    last = np.floor(grid.to_grid((body[3], body[4], body[5]))).astype(np.int64)
    limits = np.empty(6, np.int64)
    limits[0::2] = np.clip(np.minimum(first, cell) - 1, 0, None)
    limits[1::2] = np.clip(np.maximum(last, cell) + 2, None, shape)
    box = grow_empty_box(field.index.words, shape, cell, limits)
    origin, edge = np.array(grid.origin_m), grid.voxel_m
    low = np.where(box[0::2] == 0, -np.inf, origin + box[0::2] * edge + INSET_M)
    high = np.where(box[1::2] == shape, np.inf, origin + box[1::2] * edge - INSET_M)
    return np.concatenate([low, high]) if ((low < place) & (place < high)).all() else NO_EMPTY_BOX


def blocked(
    rays: Cast, field: EntropyField, sensor: Sensor, method: Method, barrier: Barrier, workers: int
) -> tuple[Cast, Cast]:
    """Return the rays of a sensor that no barrier stops, and those that end at one, without rays that meet nothing
    informative before it."""
    empty_box = empty_box_around(field, sensor, barrier) if method == "exact" else NO_EMPTY_BOX
    shadow = barrier_shadow(sensor, barrier, empty_box, workers, Lattice(rays.kind, rays.rows, rays.planes))
    free = rays._replace(is_stopped=shadow.is_stopped) if shadow.is_stopped.any() else rays
    return free, _cut(rays, shadow, field.grid.voxel_m)


def _cut(rays: Cast, shadow: Shadow, voxel_m: float) -> Cast:
    """Return rays that end at the body, or earlier at their own limit, each with its own direction and end."""
    ends = shadow.cut_m / voxel_m
    if rays.ends.size:
        ends = np.minimum(ends, rays.ends[shadow.cut])
    directions = Lattice(rays.kind, rays.rows, rays.planes).directions(shadow.cut)
    return rays._replace(
        kind=LISTED,
        rows=np.ascontiguousarray(directions),
        planes=np.zeros((1, 2)),
        ends=ends,
    )
