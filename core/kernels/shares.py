"""Cutting the rows of the grid so that every worker has as much of a fan to walk."""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.jit import kernel
from riglens.core.kernels.planes import Fan, Space, clip_side
from riglens.core.kernels.profile import Profile

PLANES_LOOKED_AT = 32
EVENTS_LOOKED_AT = 32
EVENT_COST = 1.0
"""Of an event of the profile, in columns crossed."""


@kernel
def work_by_row(fan: Fan, space: Space, profile: Profile) -> np.ndarray:
    """About how much there is to walk in each row of the grid along x, (rows,): a few planes stand for all."""
    work = np.zeros(space.shape[0])
    gx, gy, box = space.origin[0], space.origin[1], space.box
    events = profile.at.size - 1
    stride = max(1, events // EVENTS_LOOKED_AT)
    for plane in range(0, fan.scales.size, max(1, fan.scales.size // PLANES_LOOKED_AT)):
        hx, hy, scale = fan.headings[plane, 0], fan.headings[plane, 1], fan.scales[plane]
        s_in, s_out = clip_side(gx, hx, box[0], box[1], 0.0, np.inf)
        s_in, s_out = clip_side(gy, hy, box[2], box[3], s_in, s_out)
        if not s_in < s_out:
            continue
        a, b = gx + s_in * hx, gx + s_out * hx
        first, last = max(int(min(a, b)), box[0]), min(int(max(a, b)), box[1] - 1)
        work[first : last + 1] += (s_out - s_in) * (abs(hx) + abs(hy)) / (last + 1 - first)
        for event in range(0, events, stride):
            s = profile.at[event] / scale
            if s_in < s < s_out:
                work[min(max(int(gx + s * hx), box[0]), box[1] - 1)] += EVENT_COST * stride
    return work
