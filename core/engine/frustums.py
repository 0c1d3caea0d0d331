"""Decide whether a camera can be cast by voxel walking, and build its frustum."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.fans import is_plain
from riglens.core.kernels.cameras.frustum import BALL, NO_TILES, SPHERE, TILE, Frustum, count_stopped
from riglens.core.kernels.rays.cast import Cast
from riglens.core.rig.model import Camera
from riglens.core.sensing.image_bins import WIDEST_TANGENT

SHORTEST_DEPTH = 16.0
"""Voxels: with rays so sparse that only nearer voxels are sure to be hit, walking the rays is quicker."""


def make_frustum(camera: Camera, rays: Cast) -> Frustum | None:
    """Make the frustum of a camera in grid units; None if walking its rays is simpler."""
    fx, fy, cx, cy = camera.intrinsics_px()
    (width, height), (columns, rows) = camera.image, camera.resolution
    sides = np.array([[cx, -fx, 0.0], [width - cx, fx, 0.0], [cy, 0.0, -fy], [height - cy, 0.0, fy]])
    widest = max(abs(cx) / fx, abs(width - cx) / fx, abs(cy) / fy, abs(height - cy) / fy)
    step_u, step_v = width / (columns * fx), height / (rows * fy)
    depth_limit = BALL / _farthest_ray(rays.rotation, step_u, step_v)
    if not is_plain(rays) or widest > WIDEST_TANGENT or depth_limit < SHORTEST_DEPTH:
        return None
    image = np.array(
        [cx * columns / width - 0.5, fx * columns / width, cy * rows / height - 0.5, fy * rows / height]
    )
    normals = sides / np.linalg.norm(sides, axis=1, keepdims=True)
    outline = (rays.origin + _corners(normals, depth_limit) @ rays.rotation.T)[:, :2]
    return Frustum(
        rays.rows, rays.planes, rays.origin, rays.rotation, rays.box, rays.shape, normals, image, depth_limit,
        hull(outline), rays.is_stopped, _stopped_before(rays),
    )  # fmt: skip


def _farthest_ray(rotation: NDArray[np.float64], step_u: float, step_v: float) -> float:
    """Return the largest distance, at depth 1, from a place in the image to the nearest ray: along the worst axis of
    the grid, and in total. A ray as far as that from the centre of a voxel is inside while both are below BALL."""
    along_axes = float((np.abs(rotation[:, 1]) * step_u + np.abs(rotation[:, 2]) * step_v).max())
    return 0.5 * min(along_axes, float(np.hypot(step_u, step_v)))


def _stopped_before(rays: Cast) -> NDArray[np.int64]:
    """Return the number of stopped rays in the tiles above and to the left, see `Frustum`."""
    if not rays.is_stopped.size:
        return NO_TILES
    rows, columns = len(rays.rows), len(rays.planes)
    before = np.zeros((-(-rows // TILE) + 1, -(-columns // TILE) + 1), np.int64)
    table: NDArray[np.bool_] = rays.is_stopped.reshape(rows, columns)
    count_stopped(table, np.logical_or.reduce(table, axis=1), before)
    return before


def _corners(normals: NDArray[np.float64], depth_limit: float) -> NDArray[np.float64]:
    """Return the corners (8, 3), in voxels in the camera frame, of the view up to the depth limit, with a margin for
    voxels whose centre is just outside. normals (4, 3): left, right, top, bottom, as in `Frustum.sides`."""
    corners = []
    for x in (-SPHERE, depth_limit):
        left, right, top, bottom = (-(n[0] * x + SPHERE) / (n[1] + n[2]) for n in normals)
        corners += [(x, y, z) for y in (left, right) for z in (top, bottom)]
    return np.array(corners)


def hull(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners of the convex hull of points (n, 2), in order."""
    ordered = sorted(map(tuple, points.tolist()))
    sides: list[list[tuple[float, ...]]] = []
    for way in (ordered, ordered[::-1]):
        side: list[tuple[float, ...]] = []
        for p in way:
            while len(side) > 1 and _turns_right(side[-2], side[-1], p):
                side.pop()
            side.append(p)
        sides.append(side[:-1])
    return np.array(sides[0] + sides[1])


def _turns_right(a: tuple[float, ...], b: tuple[float, ...], c: tuple[float, ...]) -> bool:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) <= 0.0
