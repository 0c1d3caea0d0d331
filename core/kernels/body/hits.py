"""Find the first hits of rays with oriented boxes and the ground z = 0 (`solid` handles triangles).

For pictures of what a sensor sees; the metric has no occlusion. Serial kernels, so that any thread may call them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from riglens.core.kernels.body.solid import slab
from riglens.core.kernels.runtime.codes import GROUND
from riglens.core.kernels.runtime.jit import kernel


class Boxes(NamedTuple):
    """Oriented boxes in metres, vehicle frame: centres (m, 3), half sizes (m, 3), rotations (m, 3, 3) from the frame of
    the box."""

    centres: np.ndarray
    halves: np.ndarray
    rotations: np.ndarray


class Nearest(NamedTuple):
    """First hit of each ray so far: distance (n,) in metres; what (n,): the number of a box or one of the codes of
    `kernels.runtime.codes`."""

    distance: np.ndarray
    what: np.ndarray


@kernel
def hit_boxes(origin: np.ndarray, directions: np.ndarray, boxes: Boxes, nearest: Nearest) -> None:
    """Note the boxes that are nearer than what was met so far. origin (3,); directions (n, 3) unit vectors.

    A box around the origin hides nothing.
    """
    distance, what = nearest.distance, nearest.what
    for box in range(boxes.centres.shape[0]):
        turn, half = boxes.rotations[box], boxes.halves[box]
        to = boxes.centres[box] - origin
        reach2 = half[0] * half[0] + half[1] * half[1] + half[2] * half[2]
        far2 = to[0] * to[0] + to[1] * to[1] + to[2] * to[2]
        start = np.empty(3)
        for axis in range(3):
            start[axis] = -(turn[0, axis] * to[0] + turn[1, axis] * to[1] + turn[2, axis] * to[2])
        for ray in range(directions.shape[0]):
            d = directions[ray]
            ahead = d[0] * to[0] + d[1] * to[1] + d[2] * to[2]
            if far2 - ahead * ahead > reach2 or ahead + np.sqrt(reach2) < 0.0:
                continue
            t0, t1 = -np.inf, distance[ray]
            for axis in range(3):
                along = turn[0, axis] * d[0] + turn[1, axis] * d[1] + turn[2, axis] * d[2]
                t0, t1 = slab(start[axis], along, -half[axis], half[axis], t0, t1)
            if 0.0 <= t0 <= t1 and t0 < distance[ray]:
                distance[ray], what[ray] = t0, box


@kernel
def hit_ground(height_m: float, directions: np.ndarray, nearest: Nearest) -> None:
    """Note the plane z = 0 where it is nearer than what was met so far, for rays that start above it and look down."""
    distance, what, height = nearest.distance, nearest.what, height_m
    for ray in range(directions.shape[0]):
        down = -directions[ray, 2]
        if height > 0.0 and down * distance[ray] > height:
            distance[ray], what[ray] = height / down, GROUND
