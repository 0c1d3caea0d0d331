"""Find where the rays of a distorted lens end at a solid, triangle by triangle.

The same as `kernels.body.shadow`, for rays that have no rows and columns but lie in bins of the image plane: the tree
is traversed front to back, a box is skipped where all rays of the bins that its ball touches are finished, and a
triangle is tested against the rays of the bins that it touches. Rays that hit something inside the empty box are
finished.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from riglens.core.kernels.body.face import (
    DOUBT,
    WIDEST,
    Sides,
    ball_around,
    bounds_of,
    set_normals,
    sides_of,
    sides_of_box,
    size_of,
    view_of,
)
from riglens.core.kernels.body.screen import in_sensor_axes, slopes_of
from riglens.core.kernels.body.shadow import Barring, end_at, is_in_whole, near2, verdict_of
from riglens.core.kernels.body.solid import Tree
from riglens.core.kernels.rays.bins import Bins, bin_of
from riglens.core.kernels.rays.cast import Cast, ray_direction
from riglens.core.kernels.rays.lattice import rotated
from riglens.core.kernels.rays.predicates import Vector
from riglens.core.kernels.runtime.jit import lean, lean_inlined, parallel_kernel, serial


class LensEnds(NamedTuple):
    """State of the rays: at (rays,) metres, the first hit outside of the empty box; has_end, is_over (rays,): rays with
    a hit, and finished rays; still (bins,): unfinished rays of each bin."""

    at: np.ndarray
    has_end: np.ndarray
    is_over: np.ndarray
    still: np.ndarray


class Patch(NamedTuple):
    """First and last bin along both axes."""

    from_i: int
    to_i: int
    from_j: int
    to_j: int


@lean_inlined
def _sides_of_box(rays: Cast, b: np.ndarray) -> Sides:
    """Return the bounds (1, y, z) of a box of low and high corner (6,)."""
    middle, radius = ball_around((b[0], b[1], b[2]), (b[3], b[4], b[5]))
    place = in_sensor_axes(rays, middle)
    if radius >= WIDEST * place[0]:
        return _sides_of_ball(place, radius)
    return sides_of_box(rays, b, place, 1.0, 0.0)


@lean_inlined
def _patch_between(bins: Bins, bar: Barring, sides: Sides) -> Patch:
    """Return the bins between some places, of the columns in question."""
    if sides.left > sides.right:
        return Patch(0, -1, 0, -1)
    from_i, to_i = max(bin_of(bins, 0, sides.left), bar.first), min(bin_of(bins, 0, sides.right), bar.end - 1)
    from_j, to_j = max(bin_of(bins, 1, sides.low), 0), min(bin_of(bins, 1, sides.high), bins.sizes[1] - 1)
    return Patch(from_i, to_i, from_j, to_j)


@lean_inlined
def _sides_of_ball(place: Vector, radius: float) -> Sides:
    """Return the bounds (1, y, z) of a ball at a place in the frame of the camera."""
    left, right = slopes_of(place[0], place[1], radius)
    low, high = slopes_of(place[0], place[2], radius)
    return Sides(left, right, low, high) if low <= high else Sides(1.0, 0.0, 1.0, 0.0)


@lean_inlined
def _has_open(bins: Bins, patch: Patch, still: np.ndarray) -> bool:
    """Return whether some ray in some bins is not finished."""
    for i in range(patch.from_i, patch.to_i + 1):
        for j in range(patch.from_j, patch.to_j + 1):
            if still[i * bins.sizes[1] + j] > 0:
                return True
    return False


@lean_inlined
def _meet_ray(rays: Cast, ray: int, c: np.ndarray, bar: Barring, ends: LensEnds) -> bool:
    """Test a triangle against one ray, by the formula; return whether the ray is finished now."""
    t, is_over = end_at(rays, ray_direction(rays, ray), c, bar)
    if not is_over and t < np.inf and (not ends.has_end[ray] or t < ends.at[ray]):
        ends.at[ray], ends.has_end[ray] = t, True
    return is_over


@lean
def _offer(rays: Cast, bins: Bins, c: np.ndarray, bar: Barring, normals: np.ndarray, ends: LensEnds) -> None:
    """Test a triangle of corners (3, 3) against all rays that can hit it; normals (3, 3): work space."""
    low, high = bounds_of(c)
    middle, radius = ball_around(low, high)
    place = in_sensor_axes(rays, middle)
    view = view_of(rays, c)
    sides = sides_of(view, radius, place[0], 1.0, 0.0)
    if sides.left > sides.right:
        sides = _sides_of_ball(place, radius)
    patch, doubt = _patch_between(bins, bar, sides), -1.0
    is_in_empty_box = is_in_whole(bar, low, high) and size_of(place) - radius > bar.start
    for i in range(patch.from_i, patch.to_i + 1):
        for j in range(patch.from_j, patch.to_j + 1):
            here = i * bins.sizes[1] + j
            for at in range(bins.first[here], bins.first[here + 1] if ends.still[here] > 0 else 0):
                ray, y, z = bins.rays[at], bins.places[at, 0], bins.places[at, 1]
                if not (sides.left <= y <= sides.right and sides.low <= z <= sides.high) or ends.is_over[ray]:
                    continue
                if doubt < 0.0:
                    doubt = DOUBT * set_normals(view, normals)
                row = rays.rows[ray]
                verdict = verdict_of(rotated(normals, (row[0], row[1], row[2])), doubt, is_in_empty_box)
                if verdict > 0 or (verdict == 0 and _meet_ray(rays, ray, c, bar, ends)):
                    ends.is_over[ray] = True
                    ends.still[here] -= 1


@lean
def _offer_tree(
    rays: Cast, bins: Bins, bar: Barring, normals: np.ndarray, stack: np.ndarray, ends: LensEnds
) -> None:
    """Offer all triangles that stop rays, the nearer boxes first; normals (3, 3), stack (128,): work space."""
    tree = bar.tree
    stack[0], waiting = 0, min(1, tree.skip.size)
    while waiting > 0:
        waiting -= 1
        node = stack[waiting]
        sides = _sides_of_box(rays, tree.bounds[node])
        if not _has_open(bins, _patch_between(bins, bar, sides), ends.still):
            continue
        if tree.leaf[node, 1] == 0:
            near, far = node + 1, tree.skip[node + 1]
            if near2(rays.origin, tree.bounds[far]) < near2(rays.origin, tree.bounds[near]):
                near, far = far, near
            stack[waiting], stack[waiting + 1] = far, near
            waiting += 2
            continue
        for triangle in range(tree.leaf[node, 0], tree.leaf[node, 0] + tree.leaf[node, 1]):
            if bar.stops[tree.number[triangle]]:
                _offer(rays, bins, tree.corners[triangle], bar, normals, ends)


@parallel_kernel
def find_lens_ends(
    rays: Cast,
    bins: Bins,
    tree: Tree,
    stops: np.ndarray,
    start: float,
    empty_box: np.ndarray,
    workers: int,
    at: np.ndarray,
    has_end: np.ndarray,
    is_over: np.ndarray,
    still: np.ndarray,
) -> None:
    """Write where listed rays, in metres, first meet a solid beyond `start` (see `LensEnds` and `Barring`); none
    has an end before, and `still` has all rays of each bin. Workers share strips of bins."""
    strips = min(bins.sizes[0], 1 if workers == 1 else 4 * workers)
    for worker in numba.prange(workers):
        normals, stack = np.empty((3, 3)), np.empty(128, np.int64)
        for strip in range(worker, strips, workers):
            first, end = bins.sizes[0] * strip // strips, bins.sizes[0] * (strip + 1) // strips
            bar = Barring(tree, stops, start, empty_box, first, end)
            _offer_tree(rays, bins, bar, normals, stack, LensEnds(at, has_end, is_over, still))


find_lens_ends_serial = serial(find_lens_ends)
