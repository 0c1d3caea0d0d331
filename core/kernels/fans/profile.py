"""The profile of an upright sensor: which levels any of its rays is in, by forward distance.

It is the same for all vertical planes of the sensor, so it is made once for each cast (see `kernels.fans.fan`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.runtime.jit import inlined, kernel

TOLERANCE = 1e-8
"""Voxels. Below FARTHEST_ORIGIN voxels, crossings summed step by step are off by at most half of this; what is closer
to a tie is decided exactly."""


class Profile(NamedTuple):
    """Levels in which any ray of a plane is, by forward distance.

    at (events + 1,): ascending distances, then infinity; changes (events,): the level + 1 that begins there, negative
    where it ends; masks uint64 (events + 1, words per column): levels after the first 0, 1, 2... events; begun: how
    many happen at the sensor itself.
    """

    at: np.ndarray
    changes: np.ndarray
    masks: np.ndarray
    begun: int


class Slopes(NamedTuple):
    """Rays of one vertical plane: slopes (rays,), ascending, are dz by forward distance; near, far (rays,): the forward
    distances at which they begin and end; by_near (rays,): the rays in the order in which they begin."""

    slopes: np.ndarray
    near: np.ndarray
    far: np.ndarray
    by_near: np.ndarray


class Events(NamedTuple):
    """Entries and exits of rays into levels, unordered: at (most,) forward distances; changes int32 (most,): the level
    + 1 where a stay begins, negative where it ends."""

    at: np.ndarray
    changes: np.ndarray


@inlined
def _stay(slope: float, near: float, far: float, enters_z: float, leaves_z: float) -> tuple[float, float]:
    """Return the distances between which a ray is between two heights, relative to the sensor, and within its range."""
    if slope == 0.0:
        return near, far
    return max(enters_z / slope, near), min(leaves_z / slope, far)


@kernel
def _add_stays(stays: np.ndarray, found: int, level: int, farthest: float, events: Events, count: int) -> int:
    """Write the first stays, (found, 2), in a level, in the order in which they begin, as events; overlapping ones are
    merged.

    Returns how many events there are now; -1 when a stay is so short that it may be none.
    """
    enters, leaves = np.inf, -np.inf
    for i in range(found):
        here, there = stays[i, 0], stays[i, 1]
        if here > 0.0 and abs(there - here) < TOLERANCE:
            return -1
        if here > farthest or there < here:
            continue
        if here > leaves:
            count = _write((enters, leaves), level, farthest, events, count)
            enters, leaves = here, there
        leaves = max(leaves, there)
    return _write((enters, leaves), level, farthest, events, count)


@inlined
def _write(stay: tuple[float, float], level: int, farthest: float, events: Events, count: int) -> int:
    """Write one stay: where it enters and leaves a level, the latter unless that is too far away."""
    enters, leaves = stay
    if leaves > enters:
        events.at[count], events.changes[count] = enters, level + 1
        count += 1
        if leaves <= farthest:
            events.at[count], events.changes[count] = leaves, -level - 1
            count += 1
    return count


@kernel
def find_stays(rays: Slopes, z0: float, low: int, high: int, farthest: float, events: Events) -> int:
    """Write the distances at which rays that start at the height z0 enter and leave the levels low..high-1, as far as
    `farthest`; all lengths in voxels.

    There are at most 2 (rays + 2) (high - low + 1) events. Returns how many were written, or -1 where the range of a
    ray ends so close to a face that only the exact walk can tell.
    """
    slopes, near, far = rays.slopes, rays.near, rays.far
    count, ray_count = 0, slopes.size
    stays = np.empty((ray_count, 2))
    first_up, first_down = int(np.floor(z0)), int(np.ceil(z0)) - 1
    for level in range(low, high):
        found = 0
        if first_down <= level <= first_up:  # where rays start
            for j in rays.by_near:
                starts = first_down if slopes[j] < 0.0 else first_up
                ends_z = (first_down if slopes[j] < 0.0 else first_up + 1) - z0
                if level == starts:
                    stays[found, 0], stays[found, 1] = _stay(slopes[j], near[j], far[j], 0.0, ends_z)
                    found += 1
        elif level > first_up:
            for j in range(ray_count - 1, -1, -1):  # the steepest first
                if slopes[j] > 0.0:
                    stays[found, 0], stays[found, 1] = _stay(
                        slopes[j], near[j], far[j], level - z0, level + 1.0 - z0
                    )
                    found += 1
                    if stays[found - 1, 0] > farthest:
                        break
        else:
            for j in range(ray_count):
                if slopes[j] < 0.0:
                    stays[found, 0], stays[found, 1] = _stay(
                        slopes[j], near[j], far[j], level + 1.0 - z0, level - z0
                    )
                    found += 1
                    if stays[found - 1, 0] > farthest:
                        break
        count = _add_stays(stays, found, level, farthest, events, count)
        if count < 0:
            return -1
    return count


@kernel
def masks_of(changes: np.ndarray, depth: int) -> np.ndarray:
    """Return the levels in use after 0, 1, 2... events, uint64 (events + 1, depth); changes as in `Profile`."""
    masks = np.zeros((changes.size + 1, depth), np.uint64)
    for i in range(changes.size):
        for part in range(depth):
            masks[i + 1, part] = masks[i, part]
        level = abs(changes[i]) - 1
        masks[i + 1, level >> 6] ^= np.uint64(1) << np.uint64(level & 63)
    return masks
