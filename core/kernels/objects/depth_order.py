"""Sort the boxes of a frame from near to far, in groups whose order is the same for every ray.

Two boxes that a face of one of them keeps apart, or a sphere around the sensor, are entered in the same order by every
ray. So what rays have met already hides what stands behind, without a distance for each ray; only boxes of one group,
which overlap or surround each other, are compared ray by ray.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.objects.box_frames import Beams, FrameBoxes, half_of, is_inside, reach_of, start_of
from riglens.core.kernels.rays.lattice import Direction, rotated_back
from riglens.core.kernels.runtime.jit import kernel, lean, lean_inlined

_GAP_M = 1e-6
"""Distance between two boxes beyond which rounding cannot change their order."""
_WIDER = 1.0 + 1e-9
_MANY = 64
"""Size of a group beyond which it is not split."""
_FAR_BACK = 4096
"""Largest number of earlier boxes that a box is compared with; beyond it all of them form one group."""
_NEAR, _FAR, _FARTHEST, _X, _Y, _Z, _AWAY, _SINE, _COSINE = range(9)
"""Columns of DepthOrder.sight."""


class DepthOrder(NamedTuple):
    """Boxes of a frame that rays can meet, nearest first: box (k,) their numbers; first (k,): place of the first one of
    the group that each belongs to. sight (k, 9): what is known of each box by `order`, (k,) its places: distance of
    its nearest and farthest point, the farthest of all so far (by place in the depth order), from the sensor to its
    centre and how far, sine and cosine of a cone around it. Of a group that is being split: member (k,) numbers of its
    boxes in it, late (k,): a bit for each of them that a box may not precede."""

    box: np.ndarray
    first: np.ndarray
    order: np.ndarray
    sight: np.ndarray
    late: np.ndarray
    member: np.ndarray


@kernel
def new_depth_order(boxes: int) -> DepthOrder:
    """Return room for `boxes` boxes."""
    return DepthOrder(
        np.empty(boxes, np.int64),
        np.empty(boxes, np.int64),
        np.empty(boxes, np.int64),
        np.empty((boxes, 9)),
        np.empty(boxes, np.uint64),
        np.empty(boxes, np.int64),
    )


@lean
def line_up(traffic: FrameBoxes, beams: Beams, frame: int, depth_order: DepthOrder) -> int:
    """Fill the depth order with the boxes of a frame that rays may meet; return their number up to the last group with
    one that counts. A box around the sensor is left out, and those too far away to hide one that counts."""
    count = _look_round(traffic, beams, frame, depth_order)
    _sort(depth_order, count)
    _settle(traffic, depth_order, count)
    until = 0
    for place in range(count):
        if traffic.counts[depth_order.box[place]]:
            until = place + 1
    while 0 < until < count and depth_order.first[until] < until:
        until += 1
    return until


@lean_inlined
def _look_round(traffic: FrameBoxes, beams: Beams, frame: int, depth_order: DepthOrder) -> int:
    """List the boxes that rays can hit, in the order of the data: numbers in `box`, their geometry in `sight`."""
    count, reach = 0, reach_of(traffic, beams, frame)
    ahead = beams.rotation[:, 0]
    for box in range(traffic.starts[frame], traffic.starts[frame + 1]):
        x, y, z = _to(traffic, beams, box)
        half = half_of(traffic, box)
        radius2, away2 = _square(half[0], half[1], half[2]), _square(x, y, z)
        if away2 > (reach + np.sqrt(radius2)) ** 2 * _WIDER:
            continue
        start = start_of(traffic, beams, box)
        if is_inside(start, half):
            continue
        away, sine, cosine = np.sqrt(away2), 1.0, -1.0  # the sensor may be inside of what is around the box
        if radius2 < away2 * (1.0 - 1e-9):
            sine, cosine = np.sqrt(radius2 / away2), np.sqrt(1.0 - radius2 / away2)
        along = x * ahead[0] + y * ahead[1] + z * ahead[2]
        if _are_apart(along, away, sine, cosine, beams.field[1], beams.field[0]):
            continue
        _note(depth_order, count, box, _nearest(start, half), _farthest(start, half))
        sight = depth_order.sight[count]
        sight[_X], sight[_Y], sight[_Z], sight[_AWAY] = x, y, z, away
        sight[_SINE], sight[_COSINE] = sine, cosine
        count += 1
    return count


@lean_inlined
def _note(depth_order: DepthOrder, place: int, box: int, near: float, far: float) -> None:
    depth_order.box[place], depth_order.order[place] = box, place
    depth_order.sight[place, _NEAR], depth_order.sight[place, _FAR] = near, far


@lean_inlined
def _square(x: float, y: float, z: float) -> float:
    return x * x + y * y + z * z


@lean_inlined
def _to(traffic: FrameBoxes, beams: Beams, box: int) -> Direction:
    centre, origin = traffic.centres[box], beams.origin
    return centre[0] - origin[0], centre[1] - origin[1], centre[2] - origin[2]


@lean_inlined
def _nearest(start: Direction, half: Direction) -> float:
    """Return the distance of a box from a point in its axes."""
    return float(
        np.sqrt(
            _square(
                max(abs(start[0]) - half[0], 0.0),
                max(abs(start[1]) - half[1], 0.0),
                max(abs(start[2]) - half[2], 0.0),
            )
        )
    )


@lean_inlined
def _farthest(start: Direction, half: Direction) -> float:
    """Return the distance of the farthest corner of a box from a point in its axes."""
    return float(np.sqrt(_square(abs(start[0]) + half[0], abs(start[1]) + half[1], abs(start[2]) + half[2])))


@lean_inlined
def _are_apart(
    dot: float, length: float, sine: float, cosine: float, other_sine: float, other_cosine: float
) -> bool:
    """Return whether two cones are certainly apart: dot of their axes, product of the lengths of these, half angles."""
    if cosine < 0.0 or other_cosine < 0.0 or other_sine * cosine + other_cosine * sine < 0.0:
        return False
    return bool(dot < (cosine * other_cosine - sine * other_sine - 1e-9) * length)


@lean_inlined
def _sort(depth_order: DepthOrder, count: int) -> None:
    """Put order and box in the order of the nearest points (Shell sort)."""
    order, sight, gap = depth_order.order, depth_order.sight, count // 2
    while gap > 0:
        for place in range(gap, count):
            one, at = order[place], place
            while at >= gap and sight[order[at - gap], _NEAR] > sight[one, _NEAR]:
                order[at] = order[at - gap]
                at -= gap
            order[at] = one
        gap = 1 if gap == 2 else (5 * gap) // 11
    for place in range(count):
        depth_order.first[place] = depth_order.box[place]
    for place in range(count):
        depth_order.box[place] = depth_order.first[order[place]]


@lean_inlined
def _settle(traffic: FrameBoxes, depth_order: DepthOrder, count: int) -> None:
    """Find the groups: runs of the depth order of which some pair is not known to be in order."""
    order, sight, farthest = depth_order.order, depth_order.sight, 0.0
    for place in range(count):
        near, depth_order.first[place] = sight[order[place], _NEAR], place
        for before in range(place - 1, -1, -1):
            if sight[before, _FARTHEST] < near:
                break
            if place - before > _FAR_BACK:
                depth_order.first[place] = 0
                break
            if not _may_precede(traffic, depth_order, before, place):
                depth_order.first[place] = before
        farthest = max(farthest, sight[order[place], _FAR] * _WIDER)
        sight[place, _FARTHEST] = farthest
    end = count
    while end > 0:
        begin, at = depth_order.first[end - 1], end - 1
        while at > begin:
            at -= 1
            begin = min(begin, depth_order.first[at])
        if end - begin > 1:
            _sort_group(traffic, depth_order, begin, end)
        end = begin


@lean_inlined
def _may_precede(traffic: FrameBoxes, depth_order: DepthOrder, one: int, other: int) -> bool:
    """Return whether no ray enters the second of two boxes, by their places in the depth order, before the first."""
    mine, its = depth_order.sight[depth_order.order[one]], depth_order.sight[depth_order.order[other]]
    if mine[_FAR] * _WIDER < its[_NEAR]:
        return True
    dot = mine[_X] * its[_X] + mine[_Y] * its[_Y] + mine[_Z] * its[_Z]
    if _are_apart(dot, mine[_AWAY] * its[_AWAY], mine[_SINE], mine[_COSINE], its[_SINE], its[_COSINE]):
        return True
    return is_before(traffic, depth_order.box[one], depth_order.box[other], mine, its)


@lean
def _sort_group(traffic: FrameBoxes, depth_order: DepthOrder, begin: int, end: int) -> None:
    """Split a group: what may come before all others goes ahead, what may come after all others goes behind, one by
    one; the rest stays a group, in the order of the data."""
    if end - begin <= _MANY:
        begin, end = _peel(traffic, depth_order, begin, end)
    depth_order.first[begin:end] = begin
    _by_number(depth_order.box, begin, end)


@lean_inlined
def _peel(traffic: FrameBoxes, depth_order: DepthOrder, begin: int, end: int) -> tuple[int, int]:
    """Move boxes that are in order to both ends of a group, as groups of one; return begin and end of the rest."""
    late = depth_order.late
    for one in range(begin, end):
        late[one] = np.uint64(0)
        for other in range(begin, end):
            if one != other and not _may_precede(traffic, depth_order, one, other):
                late[one] |= np.uint64(1) << np.uint64(other - begin)
        depth_order.member[one] = one - begin
    is_found = True
    while is_found and begin < end:
        is_found = False
        for place in range(begin, end):
            if _is_free(depth_order, begin, end, place, True):
                _swap(depth_order, place, begin)
                depth_order.first[begin] = begin
                begin, is_found = begin + 1, True
                break
        for place in range(begin, end):
            if _is_free(depth_order, begin, end, place, False):
                _swap(depth_order, place, end - 1)
                end, is_found = end - 1, True
                depth_order.first[end] = end
                break
    return begin, end


@lean_inlined
def _is_free(depth_order: DepthOrder, begin: int, end: int, place: int, is_first: bool) -> bool:
    """Return whether a box may come before all others of those left of a group, or after all of them."""
    for other in range(begin, end):
        one, behind = (place, other) if is_first else (other, place)
        if other != place and depth_order.late[one] >> np.uint64(depth_order.member[behind]) & np.uint64(1):
            return False
    return True


@lean_inlined
def _swap(depth_order: DepthOrder, one: int, other: int) -> None:
    """Swap two boxes of a group; the geometry for `order` stays with the places."""
    box, late, member = depth_order.box, depth_order.late, depth_order.member
    box[one], box[other] = box[other], box[one]
    late[one], late[other] = late[other], late[one]
    member[one], member[other] = member[other], member[one]


@lean_inlined
def _by_number(box: np.ndarray, begin: int, end: int) -> None:
    """Put the boxes of a group in the order of the data: of two entered at the same distance the earlier one counts."""
    for place in range(begin + 1, end):
        one, at = box[place], place
        while at > begin and box[at - 1] > one:
            box[at] = box[at - 1]
            at -= 1
        box[at] = one


@lean_inlined
def is_before(traffic: FrameBoxes, one: int, other: int, to_one: np.ndarray, to_other: np.ndarray) -> bool:
    """Return whether a face of one of two boxes keeps them apart, with the sensor on the side of the first; to_one,
    to_other: their rows of `DepthOrder.sight`."""
    away = (to_other[_X] - to_one[_X], to_other[_Y] - to_one[_Y], to_other[_Z] - to_one[_Z])
    here = (-to_one[_X], -to_one[_Y], -to_one[_Z])
    there = (-to_other[_X], -to_other[_Y], -to_other[_Z])
    back = (-away[0], -away[1], -away[2])
    return bool(
        _is_kept_apart(traffic, one, other, away, here, True)
        or _is_kept_apart(traffic, other, one, back, there, False)
    )


@lean_inlined
def _is_kept_apart(
    traffic: FrameBoxes, mine: int, other: int, away: Direction, sensor: Direction, is_mine: bool
) -> bool:
    """Return whether a face of a box keeps it and another one apart, with the sensor on the box's own side, or on the
    other's.

    away: from its centre to that of the other; sensor: from there to the sensor.
    """
    turn, far, half, other_half = (
        traffic.rotations[mine],
        traffic.rotations[other],
        traffic.halves[mine],
        traffic.halves[other],
    )
    gap, at = rotated_back(turn, away), rotated_back(turn, sensor)
    for axis in range(3):
        wide = 0.0
        for k in range(3):
            dot = turn[0, axis] * far[0, k] + turn[1, axis] * far[1, k] + turn[2, axis] * far[2, k]
            wide += abs(dot) * other_half[k]
        begin, end = half[axis], abs(gap[axis]) - wide
        if end - begin > _GAP_M:
            s = at[axis] if gap[axis] > 0.0 else -at[axis]
            if (s < end - _GAP_M / 2.0) if is_mine else (s > begin + _GAP_M / 2.0):
                return True
    return False
