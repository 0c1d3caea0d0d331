"""The rays of an upright sensor by vertical planes, where they are cast, and how one of them is walked alone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.bits import mark_levels
from riglens.core.kernels.jit import inlined, kernel
from riglens.core.kernels.lattice import direction, rotated
from riglens.core.kernels.walk import Ray, walk_exact


class Fan(NamedTuple):
    """Rays of an upright sensor by plane: tables of `riglens.core.kernels.lattice` and what the fans need beside them.

    headings (planes, 2) unit vectors in x and y of the vehicle; slopes (rays,), ascending, are dz by forward
    distance, which is scales (planes,) times the distance along the heading; near, far (rays,): forward distances
    at which they begin and end, reach (2,) the distances along the rays; row_of (rays,): table row of each slope;
    steep (k,): other rows. is_stopped as in `riglens.core.kernels.cast.Cast`; where some are, spans (k, 2) are the runs
    of slopes that are not, first and last, those of a plane span_starts[plane]..span_starts[plane + 1]; has_bounds:
    whether spans may be laid over planes (see `riglens.core.kernels.spans`).
    """

    kind: int
    rows: np.ndarray
    planes: np.ndarray
    headings: np.ndarray
    scales: np.ndarray
    slopes: np.ndarray
    near: np.ndarray
    far: np.ndarray
    reach: np.ndarray
    row_of: np.ndarray
    steep: np.ndarray
    is_stopped: np.ndarray
    span_starts: np.ndarray
    spans: np.ndarray
    has_bounds: bool


class Space(NamedTuple):
    """Where a sensor casts: origin (3,) in grid units, rotation (3, 3), box (6,): first cell and end along x, y, z;
    shape (3,) of the grid in cells."""

    origin: np.ndarray
    rotation: np.ndarray
    box: np.ndarray
    shape: np.ndarray


class FanWork(NamedTuple):
    """Work space of one worker: way to the next column crossed, int32 (columns,); place of each event among the
    columns, int32 (events + 1,); what changes in a column, levels that begin there, and levels that begin or end,
    uint64 (words per column, columns); runs of a ray walked alone, int32 (columns, 3); lowest and highest level that a
    span reaches, int32 (2, columns), and the levels that all spans of a plane reach, uint64 (words per column,
    columns)."""

    ways: np.ndarray
    places: np.ndarray
    begins: np.ndarray
    toggles: np.ndarray
    runs: np.ndarray
    limits: np.ndarray
    allowed: np.ndarray


@inlined
def clip_side(g: float, h: float, low: int, high: int, s_in: float, s_out: float) -> tuple[float, float]:
    """Distances s_in, s_out along a heading, in voxels, narrowed to where a plane is between the faces low and high of
    an axis; g: its place on that axis at distance 0, h: its drift along the axis by distance."""
    first, last = (float(low), float(high)) if h > 0.0 else (float(high), float(low))
    return max(s_in, (first - g) / h), min(s_out, (last - g) / h)


@kernel
def walk_alone(
    fan: Fan, space: Space, plane: int, row: int, box: np.ndarray, marks: np.ndarray, runs: np.ndarray
) -> None:
    """Walk one ray, unless it is stopped, exactly through a box of cells, int64 (6,), and mark the voxels it meets."""
    if fan.is_stopped.size > 0 and fan.is_stopped[row * fan.planes.shape[0] + plane]:
        return
    d = rotated(space.rotation, direction(fan.kind, fan.rows[row], fan.planes[plane]))
    g = (space.origin[0], space.origin[1], space.origin[2])
    depth = (space.shape[2] + 63) // 64
    for r in range(walk_exact(Ray(g, d, fan.reach[0], fan.reach[1]), box, space.shape[1], runs)):
        mark_levels(marks, np.int64(runs[r, 0]) * depth, np.int64(runs[r, 1]), np.int64(runs[r, 2]))
