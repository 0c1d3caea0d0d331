"""Decide whether a camera with lens distortion can be cast by voxel walking, and build the mesh of its rays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.engine.fans import farthest, is_near, is_well_scaled
from riglens.core.engine.frustums import SHORTEST_DEPTH, hull
from riglens.core.kernels.cameras.frustum import BALL
from riglens.core.kernels.cameras.lens_mesh import NO_BINS, SECTORS, WIDEST, Mesh, count_before, lay_border
from riglens.core.kernels.cameras.triangles import SIZES, measure_triangles
from riglens.core.kernels.rays.bins import Bins
from riglens.core.kernels.rays.cast import Cast
from riglens.core.kernels.runtime.codes import LISTED
from riglens.core.rig.model import Camera
from riglens.core.sensing.image_bins import bins_of
from riglens.core.sensing.kept import RAYS
from riglens.core.sensing.rays import lattice, rotate
from riglens.core.sensors.base import unplaced

OVERHEAD = 1e-6
"""Directions of the border closer to the vertical have no bearing."""
LONGEST = 2.0
"""Longest side of a triangle in diagonals between rays, of which nine in ten are shorter. Where a lens spreads its last
rays far apart they are cast one by one, as triangles count only as near as the largest of them is small; a lens without
distortion spreads them most in the middle, where most rays are. Our choice; in the library it concerns one lens."""
SAMPLE = 1 << 12
"""Diagonals that are measured for it."""
ROOM = 2.0
"""Margin in voxels around the outline of the view: more than a column takes."""
Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]


@dataclass(frozen=True)
class RayMesh:
    """The rays of a camera joined to triangles, in its own frame: `border` (n, 2), edges with the mesh on their left,
    as numbers of rays; `loose`, rays that belong to no triangle; `bins`: rays by place in the image.

    A place in a triangle is no farther than `radius` from one of its corners, and from one no farther than steps (3,)
    along each axis. In the image plane its corners are no farther than apart (2,) from it along each axis.
    """

    border: Ids
    loose: Ids
    radius: float
    steps: Doubles
    apart: Doubles
    bins: Bins


class CameraMesh(NamedTuple):
    """A camera for `kernels.cameras.lens_mesh`, and its rays outside of the mesh."""

    view: Mesh
    bins: Bins
    loose: Ids


def make_mesh(camera: Camera, rays: Cast) -> CameraMesh | None:
    """Make the mesh of a distorted camera in grid units; None if walking its rays is simpler."""
    endless = rays.reach[0] == 0.0 and rays.reach[1] > farthest(rays) + 1.0
    if rays.kind != LISTED or not (endless and is_near(rays) and is_well_scaled(rays.rotation, rays.origin)):
        return None
    joined = ray_mesh(unplaced(camera))
    if joined is None:
        return None
    border = rotate(rays.rotation, rays.rows[joined.border.ravel()])
    if np.hypot(border[:, 0], border[:, 1]).min() < OVERHEAD:
        return None
    inside, around = np.empty((SECTORS, 2)), np.empty((2, WIDEST, SECTORS))
    lay_border(border.reshape(-1, 2, 3), inside, around)
    for wide in range(1, WIDEST):
        for gather, side in ((np.minimum, around[0]), (np.maximum, around[1])):
            side[wide] = gather(side[wide - 1], np.roll(side[wide - 1], -(1 << (wide - 1))))
    along_axes = float((np.abs(rays.rotation) @ joined.steps).max()) / np.sqrt(1.0 - joined.radius**2)
    limit = BALL / min(joined.radius, along_axes)
    reach = np.stack([border.min(axis=0), border.max(axis=0)], axis=1)
    outline = _outline(rays.origin[:2], border, limit)
    view = Mesh(
        rays.rows, rays.origin, rays.rotation, rays.box, rays.shape, limit, inside, around, reach, outline,
        joined.apart, rays.is_stopped, _before(joined.bins, rays.is_stopped),
    )  # fmt: skip
    return CameraMesh(view, joined.bins, joined.loose)


def _before(bins: Bins, is_stopped: NDArray[np.bool_]) -> Ids:
    """Return `Mesh.before` of rays that are stopped."""
    if not is_stopped.size:
        return NO_BINS
    before = np.zeros((2, bins.sizes[0] + 1, bins.sizes[1] + 1), np.int64)
    count_before(bins, is_stopped, before)
    return before


def outermost_directions(camera: Camera) -> Doubles:
    """Return directions (n, 3) in the vehicle frame between which all rays of a distorted camera lie."""
    joined, local = ray_mesh(unplaced(camera)), lattice(camera).rows
    if joined is not None:
        local = local[np.concatenate([joined.border[:, 0], joined.loose])]
    return rotate(camera.pose.rotation(), local)


@RAYS.of
def ray_mesh(camera: Camera) -> RayMesh | None:
    """Return the mesh of a camera without its position, the same one throughout a drag; None if rays diverge, are
    too far to the side, or do not form a surface."""
    table = lattice(camera)
    columns, rows = camera.resolution
    assert table.exists is not None
    bins = bins_of(camera)
    if min(rows, columns) < 2 or bins is None:
        return None
    exists = table.exists.reshape(rows, columns)
    numbers = (np.cumsum(table.exists) - 1).reshape(rows, columns)
    lower = exists[:-1, :-1] & exists[1:, :-1] & exists[1:, 1:]
    upper = exists[:-1, :-1] & exists[1:, 1:] & exists[:-1, 1:]
    widest = _widest(table.rows, numbers, lower, upper)
    if widest is None or BALL / widest[0] < SHORTEST_DEPTH or not is_well_scaled(table.rows):
        return None
    joined = np.zeros((rows, columns), np.bool_)
    for triangles, corners in ((lower, _LOWER), (upper, _UPPER)):
        for down, right in corners:
            joined[down : rows - 1 + down, right : columns - 1 + right] |= triangles
    loose = numbers[exists & ~joined]
    return RayMesh(_border(numbers, lower, upper), loose, *widest, bins)


_LOWER, _UPPER = ((0, 0), (1, 1), (1, 0)), ((1, 1), (0, 0), (0, 1))
"""Corners of the two triangles between four rays, as steps down and to the right; from outside they turn left. From the
last one it is one step of the lattice to each of the others."""


def _widest(
    rows: Doubles, numbers: Ids, lower: NDArray[np.bool_], upper: NDArray[np.bool_]
) -> tuple[float, Doubles, Doubles] | None:
    """Return `RayMesh.radius`, `steps` and `apart`, and take out triangles that are far larger than most; None if a
    triangle is turned over, or there is none.

    A place in a triangle is its last corner and shares of the two steps that begin there, together at most one. So it
    is at most half of each step away from one of the corners.
    """
    sizes, some = np.zeros(SIZES), np.flatnonzero(lower)
    if not some.size:
        return None
    i, j = np.unravel_index(some[:: 1 + some.size // SAMPLE], lower.shape)
    diagonals = np.linalg.norm(rows[numbers[i, j]] - rows[numbers[i + 1, j + 1]], axis=1)
    longest = LONGEST * float(np.quantile(diagonals, 0.9))
    if not measure_triangles(rows, numbers, lower, upper, longest, sizes) or not sizes[0]:
        return None
    return float(sizes[0]), sizes[1:4], sizes[4:] * (1.0 + 1e-9)


def _border(numbers: Ids, lower: NDArray[np.bool_], upper: NDArray[np.bool_]) -> Ids:
    """Return the edges that belong to one triangle only, (n, 2), in the direction in which they go round it."""
    low, up = np.pad(lower, 1), np.pad(upper, 1)
    beside_down, beside_right = numbers[1:, :], numbers[:, 1:]
    edges = [
        (numbers[:-1, :-1], numbers[1:, 1:], low[1:-1, 1:-1], up[1:-1, 1:-1]),
        (numbers[:-1, :], beside_down, up[1:-1, :-1], low[1:-1, 1:]),
        (numbers[:, :-1], beside_right, up[1:, 1:-1], low[:-1, 1:-1]),
    ]
    found = []
    for start, end, along, against in edges:
        found.append(np.stack([start[along & ~against], end[along & ~against]], axis=1))
        found.append(np.stack([end[against & ~along], start[against & ~along]], axis=1))
    return np.concatenate(found)


def _outline(origin: Doubles, border: Doubles, limit: float) -> Doubles:
    """Return the corners, in plan and in order, of an outline that holds all that is seen up to the limit."""
    middle = border[:, :2].mean(axis=0)
    ahead, across = border[:, :2] @ middle, border[:, :2] @ np.array([-middle[1], middle[0]])
    angles = np.arctan2(across, ahead)
    low, high = float(angles.min()), float(angles.max())
    reach = limit + 2.0 * ROOM
    if high - low > 2.5:
        return np.asarray(origin + reach * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]))
    steps = np.linspace(low, high, 9) + np.arctan2(middle[1], middle[0])
    arc = (limit / np.cos((high - low) / 16.0)) * np.stack([np.cos(steps), np.sin(steps)], axis=1)
    around = ROOM * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    points = (np.concatenate([np.zeros((1, 2)), arc])[:, None] + around).reshape(-1, 2)
    return np.ascontiguousarray(origin + hull(points))
