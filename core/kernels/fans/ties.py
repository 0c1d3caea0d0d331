"""Resolve ties of a fan: rays that change their level, begin or end exactly at the face between two columns.

At a round position many do. What begins there is placed behind the face and what ends there before it, which is
certain; and the rays concerned are walked exactly through the two columns beside the face (see
`kernels.fans.fan`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.fans.planes import Fan, FanWork, LeftoverRays, leave_over
from riglens.core.kernels.fans.profile import TOLERANCE, Profile
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.runtime.jit import inlined, kernel

AROUND = 1e-6
"""Voxels around an event within which rays that change their level are walked one by one: far more than TOLERANCE."""
TOGETHER = 1e-10
"""Distance of events that one walk resolves: at the slope STEEPEST still within AROUND of each other's level."""


class Start(NamedTuple):
    """Start of a plane: its column, the direction along each axis (1 or -1), and the place within the column in voxels,
    counted towards the faces crossed; speeds: faces crossed by forward distance in voxels; columns: the number
    crossed."""

    ix: int
    iy: int
    step_x: int
    step_y: int
    ox: float
    oy: float
    speed_x: float
    speed_y: float
    columns: int


@inlined
def _side(place: float) -> int:
    """Return -1 or 1 where the face behind or ahead is too close to tell on which side of it a place is, else 0."""
    past = place - np.floor(place)
    if past < TOLERANCE and place >= 1.0 - TOLERANCE:
        return -1
    return 1 if past > 1.0 - TOLERANCE else 0


@kernel
def _leave_pair(
    fan: Fan, rays: Cast, plane: int, start: Start, at: float, box: np.ndarray, leftover: LeftoverRays
) -> None:
    """Leave the rays that change their level, begin or end about the distance `at` to the exact walk through the
    columns around it."""
    x, y = start.ox + at * start.speed_x, start.oy + at * start.speed_y
    pair = box.copy()
    for axis, cell, step, place in ((0, start.ix, start.step_x, x), (1, start.iy, start.step_y, y)):
        here = cell + step * int(np.floor(place))
        there = here + step * _side(place)
        pair[2 * axis] = max(pair[2 * axis], min(here, there))
        pair[2 * axis + 1] = min(pair[2 * axis + 1], max(here, there) + 1)
    for j in range(fan.slopes.size):
        z = rays.origin[2] + fan.slopes[j] * at
        ends = min(abs(fan.near[j] - at), abs(fan.far[j] - at))
        if min(abs(z - np.rint(z)), ends) < AROUND:
            leave_over(leftover, plane, fan.row_of[j], pair)


@kernel
def untie(
    fan: Fan,
    rays: Cast,
    profile: Profile,
    events: tuple[int, int],
    plane: int,
    start: Start,
    box: np.ndarray,
    work: FanWork,
    leftover: LeftoverRays,
) -> bool:
    """Decide the events from..to close to a face: levels begin after it and end before it, and the rays concerned are
    left to the exact walk through the columns on both sides. False where this is not enough.

    Writes the place of each event among the columns crossed to work.places.
    """
    opened, walked = np.zeros(64 * profile.masks.shape[1], np.int64), -1.0
    for event in range(events[0], events[1]):
        at, change = profile.at[event], profile.changes[event]
        x, y = start.ox + at * start.speed_x, start.oy + at * start.speed_y
        side_x, side_y, place = _side(x), _side(y), int(np.floor(x)) + int(np.floor(y))
        if side_x != 0 or side_y != 0:
            before = place - int(side_x + side_y < 0)
            if (side_x != 0 and side_y != 0) or before < 0 or before + 1 >= start.columns:
                return False
            place = before + 1 if change > 0 else before
            if at - walked > TOGETHER:
                _leave_pair(fan, rays, plane, start, at, box, leftover)
                walked = at
        work.places[event - events[0]] = place
        level = abs(change) - 1
        if change > 0:
            opened[level] = place
        elif place < opened[level]:
            return False
    return True
