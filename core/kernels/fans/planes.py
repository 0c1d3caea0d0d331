"""The rays of an upright sensor by vertical planes, where they are cast, and those left to the exact walk."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.fans.profile import Profile
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.runtime.jit import inlined, kernel

ALL = -1
"""Stand-in for a row: all rows of a plane."""


class Fan(NamedTuple):
    """A fan: what is known of the rays of an upright sensor beside the `Cast` itself.

    headings (planes, 2) unit vectors in x and y of the vehicle; slopes (rays,), ascending, are dz by forward
    distance, which is scales (planes,) times the distance along the heading; near, far (rays,): forward distances
    at which they begin and end; row_of (rays,): table row of each slope; steep (k,): other rows. Where some rays are
    stopped, spans (k, 2) are the runs of slopes that are not, first and last, those of a plane
    span_starts[plane]..span_starts[plane + 1]; has_bounds: whether spans may be laid over planes (see
    `kernels.fans.spans`).
    """

    headings: np.ndarray
    scales: np.ndarray
    slopes: np.ndarray
    near: np.ndarray
    far: np.ndarray
    row_of: np.ndarray
    steep: np.ndarray
    span_starts: np.ndarray
    spans: np.ndarray
    has_bounds: bool


class FanWork(NamedTuple):
    """Work space of one worker: way to the next column crossed, int32 (columns,); place of each event among the
    columns, int32 (events + 1,); what changes in a column, levels that begin there, and levels that begin or end,
    uint64 (words per column, columns)."""

    ways: np.ndarray
    places: np.ndarray
    begins: np.ndarray
    toggles: np.ndarray


class LeftoverRays(NamedTuple):
    """Rays of a worker's planes that are left to the exact walk: rays int32 (most, 6), plane, row (ALL for all rows)
    and the columns to walk through, [lx hx ly hy); noted int64 (1,), their number; more than `most` if too many."""

    rays: np.ndarray
    noted: np.ndarray


@inlined
def clip_side(g: float, h: float, low: int, high: int, s_in: float, s_out: float) -> tuple[float, float]:
    """Return the distances s_in, s_out along a heading, in voxels, narrowed to where a plane is between the faces low
    and high of an axis; g: its place on that axis at distance 0, h: its drift along the axis by distance."""
    first, last = (float(low), float(high)) if h > 0.0 else (float(high), float(low))
    return max(s_in, (first - g) / h), min(s_out, (last - g) / h)


@inlined
def is_limited(fan: Fan, plane: int) -> bool:
    """Return whether some rays of a plane are stopped."""
    if fan.span_starts.size == 0:
        return False
    first, end = fan.span_starts[plane], fan.span_starts[plane + 1]
    return bool(end - first != 1 or fan.spans[first, 0] > 0 or fan.spans[first, 1] < fan.slopes.size - 1)


@kernel
def work_for(rays: Cast, profile: Profile) -> FanWork:
    """Return work space for the planes of a fan."""
    depth, crossed = profile.masks.shape[1], rays.shape[0] + rays.shape[1] + 3
    return FanWork(
        np.empty(crossed, np.int32),
        np.empty(profile.at.size, np.int32),
        np.empty((depth, crossed), np.uint64),
        np.empty((depth, crossed), np.uint64),
    )


@inlined
def leave_over(leftover: LeftoverRays, plane: int, row: int, box: np.ndarray) -> None:
    """Note a ray, or all of a plane, for the exact walk through a box of cells, int64 (6,)."""
    at = leftover.noted[0]
    leftover.noted[0] += 1
    if at < leftover.rays.shape[0]:
        leftover.rays[at, 0], leftover.rays[at, 1] = plane, row
        for side in range(4):
            leftover.rays[at, 2 + side] = box[side]
