"""Find the share of an object's silhouette that lies inside a camera's picture, as solid angles.

A silhouette is that of the parts of a box without anything before it, outside the picture too: a pinhole's image plane
has no measure of what lies beside or behind it, so directions are counted, not pixels. Where an object may cross the
edge of the picture, directions are spread evenly over a window around it, by a Fibonacci lattice of 377 points.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.objects.box_frames import (
    Beams,
    Faces,
    FrameBoxes,
    bounds_of,
    half_of,
    new_faces,
    parts_of,
    set_centre,
    set_faces,
    set_turn,
    start_of,
)
from riglens.core.kernels.objects.part_sides import set_sides
from riglens.core.kernels.objects.windows import TURN, corners_of, window_of_turn
from riglens.core.kernels.rays.lattice import Direction
from riglens.core.kernels.runtime.jit import kernel, lean_inlined

POINTS, _STEP = 377, 233
_FINE = 16
"""Azimuths in a row that are turned from the first of them, without sines and cosines of their own."""
_STEEPEST = 1e9
UNKNOWN = -1.0


class Rays(NamedTuple):
    """Room for the directions of the lattice: their heights (POINTS,), 0 to 1 across the window, by azimuth; cosine and
    sine of a few steps (2, _FINE); x, y, z in the sensor frame, and by how much each lies inside of one part and of the
    part where it is most so, (POINTS,)."""

    height: np.ndarray
    turn: np.ndarray
    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    within: np.ndarray
    most: np.ndarray


@kernel
def new_rays() -> Rays:
    """Return room for one object at a time."""
    # _STEP times itself is 1 (mod POINTS): the number of a point from the place of its azimuth, and the other way round
    height = (np.arange(POINTS) * _STEP % POINTS + 0.5) / POINTS
    x, y, z, within, most = np.empty((5, POINTS))
    return Rays(height, np.empty((2, _FINE)), x, y, z, within, most)


@lean_inlined
def _set_rays(low: float, high: float, left: float, right: float, axes: np.ndarray, rays: Rays) -> None:
    """Write the directions of the lattice over a window around axes (3, 3)."""
    step, turn = (right - left) / POINTS, rays.turn
    for place in range(_FINE):
        turn[0, place], turn[1, place] = np.cos(place * step), np.sin(place * step)
    for first in range(0, POINTS, _FINE):
        azimuth = left + (first + 0.5) * step
        cos, sin = np.cos(azimuth), np.sin(azimuth)
        for place in range(np.uint64(min(_FINE, POINTS - first))):
            point = np.uint64(first) + place
            up = low + rays.height[point] * (high - low)
            flat = np.sqrt(max(1.0 - up * up, 0.0))
            a = flat * (cos * turn[0, place] - sin * turn[1, place])
            b = flat * (sin * turn[0, place] + cos * turn[1, place])
            rays.x[point] = a * axes[0, 0] + b * axes[1, 0] + up * axes[2, 0]
            rays.y[point] = a * axes[0, 1] + b * axes[1, 1] + up * axes[2, 1]
            rays.z[point] = a * axes[0, 2] + b * axes[1, 2] + up * axes[2, 2]


@lean_inlined
def _set_most(traffic: FrameBoxes, box: int, start: Direction, faces: Faces, rays: Rays) -> None:
    """Write by how much each direction lies inside of the parts of a box."""
    x, y, z, within, most = rays.x, rays.y, rays.z, rays.within, rays.most
    most[:] = -np.inf
    for part in range(*parts_of(traffic, box)):
        middle, half = bounds_of(traffic, part)
        set_faces((start[0] - middle[0], start[1] - middle[1], start[2] - middle[2]), half, faces)
        within[:] = np.inf
        for side in range(set_sides(0.0, np.inf, faces)):
            plane = faces.sides.plane[side]
            p, q, r = plane[0], plane[1], plane[2]
            for point in range(POINTS):
                inner = p * x[point] + q * y[point] + r * z[point]
                within[point] = inner if inner < within[point] else within[point]
        for point in range(POINTS):
            most[point] = within[point] if within[point] > most[point] else most[point]


@lean_inlined
def _sine(slope: float) -> float:
    """Return the sine of an elevation from its slope, which may be infinite."""
    if abs(slope) > _STEEPEST:
        return float(np.sign(slope))
    return float(slope / np.sqrt(1.0 + slope * slope))


@lean_inlined
def _set_axes(centre: np.ndarray, axes: np.ndarray) -> None:
    """Write axes (3, 3), rows in the sensor frame, whose first looks at a centre (3,)."""
    length = np.sqrt(centre[0] ** 2 + centre[1] ** 2 + centre[2] ** 2)
    for k in range(3):
        axes[0, k] = centre[k] / length
    flat = np.sqrt(axes[0, 0] ** 2 + axes[0, 1] ** 2)
    if flat > 1e-6:
        axes[1, 0], axes[1, 1], axes[1, 2] = -axes[0, 1] / flat, axes[0, 0] / flat, 0.0
    else:
        axes[1, 0], axes[1, 1], axes[1, 2] = 0.0, 1.0, 0.0
    axes[2, 0] = axes[0, 1] * axes[1, 2] - axes[0, 2] * axes[1, 1]
    axes[2, 1] = axes[0, 2] * axes[1, 0] - axes[0, 0] * axes[1, 2]
    axes[2, 2] = axes[0, 0] * axes[1, 1] - axes[0, 1] * axes[1, 0]


@lean_inlined
def _is_whole(corners: np.ndarray, edges: np.ndarray, safe_cos: float) -> bool:
    """Return whether all corners (8, 3) of a box, and so all of it, lie inside the picture for certain."""
    in_cone = between = True
    for corner in range(8):
        x, y, z = corners[corner, 0], corners[corner, 1], corners[corner, 2]
        in_cone &= x >= safe_cos * np.sqrt(x * x + y * y + z * z)
        between &= _is_between(x, y, z, edges)
    return in_cone or between


@lean_inlined
def _is_between(x: float, y: float, z: float, edges: np.ndarray) -> bool:
    """Return whether a direction lies between slopes, as the picture of a pinhole has them at its edges."""
    return bool(
        (x > 0.0) & (edges[0] * x <= y) & (y <= edges[1] * x) & (edges[2] * x <= z) & (z <= edges[3] * x)
    )


@lean_inlined
def _window_of_parts(
    traffic: FrameBoxes, box: int, start: Direction, turn: np.ndarray, axes: np.ndarray, corners: np.ndarray,
    centre: np.ndarray,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Return the least and greatest sine of elevation, and azimuth, of the parts of a box around axes (3, 3) that look
    at it; corners (8, 3) and centre (3,) are overwritten."""
    low, high, left, right = 1.0, -1.0, TURN, -TURN
    for part in range(*parts_of(traffic, box)):
        middle, half = bounds_of(traffic, part)
        set_centre((start[0] - middle[0], start[1] - middle[1], start[2] - middle[2]), turn, centre)
        corners_of(centre, turn, half, corners)
        for corner in range(8):
            x, y, z = corners[corner, 0], corners[corner, 1], corners[corner, 2]
            for k in range(3):
                corners[corner, k] = axes[k, 0] * x + axes[k, 1] * y + axes[k, 2] * z
        window = window_of_turn(corners, False)
        low, high = min(low, _sine(window.low)), max(high, _sine(window.high))
        first = window.left if window.left < np.pi else window.left - TURN
        left, right = min(left, first), max(right, first + window.width)
    return low, high, left, min(right, left + TURN)


@kernel
def silhouettes(
    traffic: FrameBoxes, beams: Beams, boxes: np.ndarray, is_pinhole: bool, edges: np.ndarray, safe_cos: float,
    share: np.ndarray, hits: np.ndarray, directions: np.ndarray,
) -> int:  # fmt: skip
    """Write share (k,) of the silhouette of each of boxes (k,) inside a camera's picture.

    edges (4,): least and greatest slope to the left, then upwards, of a pinhole's picture, which has straight edges;
    of another lens those of a rectangle that its picture holds, as it does a cone around x of that cosine. Of objects
    that may cross its edge, the share is UNKNOWN, hits (k,) takes how many directions of the lattice meet them, and
    directions (m, 3) these, in the sensor frame, one object after the other. Return how many objects have been done:
    fewer than k where `directions` is full.
    """
    faces, axes, centre = new_faces(), np.empty((3, 3)), np.empty(3)
    corners, rays, filled = np.empty((8, 3)), new_rays(), 0
    for one in range(boxes.size):
        box, turn = boxes[one], faces.turn
        start = start_of(traffic, beams, box)
        set_turn(traffic, beams.rotation, box, turn)
        set_centre(start, turn, centre)
        corners_of(centre, turn, half_of(traffic, box), corners)
        share[one], hits[one] = 1.0, 0
        if _is_whole(corners, edges, safe_cos):
            continue
        if not is_pinhole and filled + POINTS > directions.shape[0]:
            return one
        _set_axes(centre, axes)
        low, high, left, right = _window_of_parts(traffic, box, start, turn, axes, corners, centre)
        _set_rays(low, high, left, right, axes, rays)
        _set_most(traffic, box, start, faces, rays)
        met = 0
        for point in range(POINTS):
            met += rays.most[point] > 0.0
        if is_pinhole:
            inside = 0
            for point in range(POINTS):
                is_shown = _is_between(rays.x[point], rays.y[point], rays.z[point], edges)
                inside += is_shown & (rays.most[point] > 0.0)
            share[one] = inside / met if met > 0 else 1.0
            continue
        if met > 0:
            share[one], hits[one] = UNKNOWN, met
        for point in range(POINTS):
            if rays.most[point] > 0.0:
                directions[filled, 0], directions[filled, 1] = rays.x[point], rays.y[point]
                directions[filled, 2] = rays.z[point]
                filled += 1
    return int(boxes.size)
