"""The sides of a part of a box, as a sensor sees it."""

from __future__ import annotations

import numpy as np

from riglens.core.kernels.objects.box_frames import Faces
from riglens.core.kernels.rays.tiles import SIDE_BLUR, Sides
from riglens.core.kernels.runtime.jit import lean_inlined


@lean_inlined
def set_sides(near: float, far: float, faces: Faces) -> int:
    """Write the sides of a part for rays with a range, metres: they are where `nearest.find_entries` compares one
    number with another; return how many there are."""
    count, least, sides = 0, 1.0 / far, faces.sides
    for axis in range(3):
        enter = faces.enter[axis]
        if enter == 0.0:  # between these two faces
            continue
        if least > 0.0:
            count = _add_plane(faces.turn, axis, enter, axis, 0.0, -least, sides, count)
        for other in range(3):
            if other == axis:
                continue
            count = _add_plane(faces.turn, axis, enter, other, faces.leave[other], 0.0, sides, count)
            if faces.enter[other] == 0.0:
                count = _add_plane(faces.turn, axis, enter, other, faces.other[other], 0.0, sides, count)
    if near > 0.0:
        most = 1.0 / near
        for axis in range(3):
            count = _add_plane(faces.turn, axis, 0.0, axis, faces.leave[axis], most, sides, count)
            if faces.enter[axis] == 0.0:
                count = _add_plane(faces.turn, axis, 0.0, axis, faces.other[axis], most, sides, count)
    return count


@lean_inlined
def _add_plane(
    turn: np.ndarray, one: int, enter: float, other: int, leave: float, rest: float, sides: Sides, count: int
) -> int:  # fmt: skip
    """Add the side on which a[one] enter - a[other] leave + rest > 0, a = turn d, by numbers of at most 1."""
    most = max(abs(enter), abs(leave), abs(rest))
    p, q = enter / most, leave / most
    for k in range(3):
        sides.plane[count, k] = p * turn[one, k] - q * turn[other, k]
    sides.plane[count, 3], sides.plane[count, 4] = rest / most, SIDE_BLUR
    return count + 1
