"""Planes of a fan in which some rays are stopped by the car's body: only the levels that free rays reach are marked.

A separate kernel, because most rigs are first scored without a solid body, and this one takes long to compile.
"""

from __future__ import annotations

import numba
import numpy as np

from riglens.core.kernels.fans.fan import LAID, UNDECIDED, Laid, finish_plane, lay_plane, place_changes
from riglens.core.kernels.fans.planes import Fan, FanWork, LeftoverRays, Space, is_limited, work_for
from riglens.core.kernels.fans.profile import Profile
from riglens.core.kernels.fans.spans import limit_levels, limits_for
from riglens.core.kernels.runtime.jit import inlined, kernel, parallel_kernel


@inlined
def _mark_allowed(
    profile: Profile, laid: Laid, work: FanWork, allowed: np.ndarray, marks: np.ndarray
) -> None:
    """Mark the levels of the profile in the columns crossed, as far as they are allowed there, uint64 (words per
    column, columns)."""
    depth = profile.masks.shape[1]
    place_changes(profile, laid, work)
    for part in range(depth):
        levels, word = profile.masks[laid.first, part], np.int64(laid.start * depth + part)
        for i in range(laid.columns):
            marks[word] |= (levels | work.begins[part, i]) & allowed[part, i]
            levels ^= work.toggles[part, i]
            word += np.int64(work.ways[i]) * depth


@kernel
def _mark_slab(
    fan: Fan, space: Space, profile: Profile, planes: tuple[int, int], rows: np.ndarray, leftover: LeftoverRays,
    marks: np.ndarray,
) -> int:  # fmt: skip
    """As `kernels.fans.fan._mark_slab`, for planes with stopped rays."""
    work, box = work_for(space, profile), space.box.copy()
    limits = limits_for(profile.masks.shape[1], work.ways)
    box[0], box[1] = max(box[0], rows[0]), min(box[1], rows[1])
    for plane in range(planes[0], planes[1] if box[0] < box[1] else planes[0]):
        if not is_limited(fan, plane):
            continue
        before, is_marked = leftover.noted[0], True
        if fan.span_starts[plane] < fan.span_starts[plane + 1]:
            laid = lay_plane(fan, space, profile, plane, box, work, leftover)
            is_marked = laid.outcome != UNDECIDED
            if laid.outcome == LAID:
                is_marked = limit_levels(fan, space, plane, laid.start, laid.columns, laid.near, box, limits)
                if is_marked:
                    _mark_allowed(profile, laid, work, limits.allowed, marks)
        if not finish_plane(fan, plane, is_marked, before, box, leftover):
            return plane
    return planes[1]


@parallel_kernel
def mark_limited(
    fan: Fan, space: Space, profile: Profile, end: int, slabs: np.ndarray, done: np.ndarray, rays: np.ndarray,
    counts: np.ndarray, marks: np.ndarray,
) -> None:  # fmt: skip
    """As `kernels.fans.fan.mark_fan`, for planes with stopped rays."""
    for worker in numba.prange(slabs.shape[0]):
        leftover = LeftoverRays(rays[worker], counts[worker : worker + 1])
        done[worker] = _mark_slab(fan, space, profile, (done[worker], end), slabs[worker], leftover, marks)
