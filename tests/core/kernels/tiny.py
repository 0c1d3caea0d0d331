"""A grid of 4 x 4 x 4 voxels, rays in vertical planes, and sets of voxels that can be read: for cases checked by hand.

Distances and heights are in voxels. A column is one word, so level z of the column (x, y) is bit z of word 4 x + y.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.fans import make_fan, make_profile, mark_planes
from riglens.core.kernels.fans.leftover_rays import mark_alone
from riglens.core.kernels.fans.planes import ALL, Fan, LeftoverRays, leave_over
from riglens.core.kernels.fans.profile import Profile
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.runtime.codes import LIDAR

Words = NDArray[np.uint64]
Voxel = tuple[int, int, int]
SIDE = 4
BOX = np.array([0, SIDE, 0, SIDE, 0, SIDE], np.int64)
SHAPE = np.array([SIDE, SIDE, SIDE], np.int64)
ENDLESS = (0.0, 1e30)
AHEAD, LEFT, BACK, RIGHT = (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)


def words(*values: int) -> Words:
    """An array of words."""
    return np.array(values, np.uint64)


def no_voxels() -> Words:
    """The empty set."""
    return np.zeros(SIDE * SIDE, np.uint64)


def voxels_of(marks: Words) -> set[Voxel]:
    """The voxels of a set of the grid 4 x 4 x 4."""
    return {
        (word // SIDE, word % SIDE, level)
        for word in range(marks.size)
        for level in range(64)
        if int(marks[word]) >> level & 1
    }


def row(x: Sequence[int], y: int, z: int) -> set[Voxel]:
    """Voxels side by side along x."""
    return {(ix, y, z) for ix in x}


def rays_in_planes(
    origin: Sequence[float],
    slopes: Sequence[float],
    headings: Sequence[tuple[float, float]] = (AHEAD,),
    reach: tuple[float, float] = ENDLESS,
) -> Cast:
    """A ray (heading x, heading y, slope) for each slope and heading; distances are those along the heading."""
    rows = np.array([(1.0, slope) for slope in slopes])
    return Cast(
        LIDAR, rows, np.array(headings), np.array(origin), np.eye(3), np.array(reach), BOX, SHAPE, False,
        np.zeros(0),
    )  # fmt: skip


def fan_of(rays: Cast) -> tuple[Fan, Cast, Profile]:
    """What the kernels of a fan need for some rays."""
    fan = make_fan(rays)
    profile = make_profile(fan, rays)
    assert profile is not None
    return fan, rays, profile


def seen_by_fan(rays: Cast, slabs: Sequence[tuple[int, int]] = ((0, SIDE),)) -> set[Voxel]:
    """The voxels that the planes mark, walked by one worker or by several."""
    fan, _, profile = fan_of(rays)
    marks = no_voxels()
    mark_planes(fan, rays, profile, 0, len(rays.planes), np.array(slabs, np.int64), marks)
    return voxels_of(marks)


def seen_ray_by_ray(rays: Cast) -> set[Voxel]:
    """The voxels of the same rays, each walked exactly on its own."""
    leftover = room_for_alone(len(rays.planes))
    for plane in range(len(rays.planes)):
        leave_over(leftover, plane, ALL, BOX)
    return seen_alone(rays, leftover)


def room_for_alone(most: int = 64) -> LeftoverRays:
    """An empty list of rays left over."""
    return LeftoverRays(np.empty((most, 6), np.int32), np.zeros(1, np.int64))


def seen_alone(rays: Cast, leftover: LeftoverRays) -> set[Voxel]:
    """The voxels of the rays left over."""
    marks = no_voxels()
    mark_alone(rays, leftover.rays[None], leftover.noted, marks)
    return voxels_of(marks)


def heading(degrees: float) -> tuple[float, float]:
    """Unit vector at an angle from x towards y."""
    return math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
