"""A camera before a grid of 4 x 4 x 4 voxels: which voxels are sure to be hit, which are tested, and which are not hit.

The camera stands at (-1, 2, 2) and looks along x, unless a test says otherwise; its image reaches as far to the side
as ahead (tangent 1), so at x = 0 it sees y and z from 1 to 3, and from x = 1 on everything.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from riglens.core.kernels.cameras import frustum as kernel
from riglens.core.kernels.cameras.frustum import BALL, SPHERE, Frustum
from riglens.core.kernels.rays.walk import FARTHEST, Ray, hits_cell
from tests.core.kernels.tiny import BOX, SHAPE, SIDE, Voxel, no_voxels, voxels_of

EVERYTHING = np.full(SIDE * SIDE, 0b1111, np.uint64)
GRID = [(x, y, z) for x in range(SIDE) for y in range(SIDE) for z in range(SIDE)]
PLACE = (-1.0, 2.0, 2.0)


def frustum_of(
    rays: int,
    place: Sequence[float] = PLACE,
    tangent: float = 1.0,
    pitch_deg: float = 0.0,
    depth_limit: float | None = None,
) -> Frustum:
    """A camera of rays x rays rays, its image of half width `tangent` at the distance 1; positive pitch looks down."""
    half = rays / (2.0 * tangent)  # pixels by tangent
    places = -(np.arange(rays) + 0.5 - rays / 2.0) / half
    table = np.stack([places, np.zeros(rays)], axis=1)
    side = math.hypot(1.0, tangent)
    sides = np.array([[tangent, -1.0, 0.0], [tangent, 1.0, 0.0], [tangent, 0.0, -1.0], [tangent, 0.0, 1.0]])
    a = math.radians(pitch_deg)
    turn = np.array([[math.cos(a), 0.0, math.sin(a)], [0.0, 1.0, 0.0], [-math.sin(a), 0.0, math.cos(a)]])
    limit = depth_limit or BALL / (math.hypot(1.0 / half, 1.0 / half) / 2.0)
    image = np.array([rays / 2.0 - 0.5, half, rays / 2.0 - 0.5, half])
    everywhere = np.array([[-1.0, -1.0], [5.0, -1.0], [5.0, 5.0], [-1.0, 5.0]])
    return Frustum(
        table, table, np.array(place), turn, BOX, SHAPE, sides / side, image, limit, everywhere
    )  # fmt: skip


def seen_by(f: Frustum, keep: NDArray[np.uint64] = EVERYTHING, workers: int = 1) -> set[Voxel]:
    """The voxels that voxel walking marks."""
    marks = no_voxels()
    kernel.mark_frustum(f, 0, SIDE, keep, workers, marks)
    return voxels_of(marks)


def hit(f: Frustum) -> set[Voxel]:
    """The voxels that any ray hits, each ray against each voxel."""
    return {
        voxel
        for voxel in GRID
        for u in range(len(f.planes))
        for v in range(len(f.rows))
        if kernel._hits(f, u, v, voxel)
    }


def depth(f: Frustum, voxel: Voxel) -> float:
    """Forward distance of the centre of a voxel."""
    return kernel._to_camera(f, voxel[0] + 0.5, voxel[1] + 0.5, voxel[2] + 0.5)[0]


def test_a_dense_camera_sees_all_that_lies_in_its_image() -> None:
    """With the tangent 0.5 it sees y and z from 1 to 3 at x = 1, and from 0.5 to 3.5 at x = 2."""
    f = frustum_of(24, tangent=0.5)
    seen = seen_by(f)
    assert seen == {(x, y, z) for x, y, z in GRID if x > 0 or {y, z} <= {1, 2}} == hit(f)


def test_a_narrow_camera_sees_the_voxels_ahead() -> None:
    """With the tangent 0.1 it sees 0.5 to either side at the far end of the grid."""
    f = frustum_of(8, tangent=0.1)
    assert seen_by(f) == {(x, y, z) for x, y, z in GRID if {y, z} <= {1, 2}} == hit(f)


def test_a_camera_that_looks_down_sees_the_ground_before_it() -> None:
    f = frustum_of(10, (0.2, 1.7, 3.9), 0.5, pitch_deg=60.0)
    seen = seen_by(f)
    assert seen == {voxel for voxel in hit(f) if depth(f, voxel) <= f.depth_limit}
    assert (1, 1, 2) in seen
    assert (3, 1, 3) not in seen


@pytest.mark.parametrize("pitch_deg", [-35.0, 0.0, 12.5])
@pytest.mark.parametrize("place", [PLACE, (2.0, 2.0, 2.0), (0.31, 3.2, 0.7)])
@pytest.mark.parametrize("tangent", [0.2, 1.0])
def test_up_to_the_depth_limit_voxels_are_marked_that_a_ray_hits(
    place: tuple[float, float, float], pitch_deg: float, tangent: float
) -> None:
    f = frustum_of(7, place, tangent, pitch_deg)
    near = {voxel for voxel in GRID if depth(f, voxel) <= f.depth_limit}
    assert seen_by(f) & near == hit(f) & near


def test_beyond_the_depth_limit_nothing_is_marked() -> None:
    f = frustum_of(24, depth_limit=2.0)  # x = 1
    assert {x for x, _, _ in seen_by(f)} == {0}
    assert {x for x, _, _ in seen_by(f._replace(depth_limit=2.5))} == {0, 1}  # the centres at x = 1.5


def test_voxels_that_are_not_informative_are_not_tested() -> None:
    sparse = frustum_of(3, tangent=1.0)
    assert seen_by(sparse, no_voxels()) == set()


def test_workers_mark_together_what_one_marks_alone() -> None:
    f = frustum_of(9, pitch_deg=10.0)
    assert seen_by(f, workers=3) == seen_by(f)


def test_a_ray_through_the_centre_is_within_the_ball_and_a_corner_within_the_sphere() -> None:
    assert BALL < 0.5
    assert math.sqrt(3.0) / 2.0 < SPHERE


# ---------------------------------------------------------------- the steps


def test_a_point_of_the_grid_in_the_camera_frame() -> None:
    ahead = frustum_of(4)
    assert kernel._to_camera(ahead, 0.0, 2.5, 1.0) == (1.0, 0.5, -1.0)
    down = frustum_of(4, pitch_deg=90.0)  # the view goes down, its upper edge is ahead
    assert kernel._to_camera(down, -1.0, 2.0, 1.0) == pytest.approx((1.0, 0.0, 0.0))
    assert kernel._to_camera(down, 1.0, 2.0, 2.0) == pytest.approx((0.0, 0.0, 2.0))


@pytest.mark.parametrize(
    ("value", "slope", "interval"),
    [
        (1.0, 1.0, (-1.0, 9.0)),  # 1 + k >= 0
        (1.0, -0.5, (-9.0, 2.0)),  # 1 - k / 2 >= 0
        (0.0, 0.0, (-9.0, 9.0)),
        (-0.1, 0.0, (1.0, 0.0)),  # never
    ],
)
def test_an_inequality_cuts_a_column(value: float, slope: float, interval: tuple[float, float]) -> None:
    assert kernel._narrow(value, slope, -9.0, 9.0) == interval


def test_the_levels_of_a_column_in_view_lie_between_the_image_borders() -> None:
    f = frustum_of(24)
    low, high = kernel._levels_within(f, *kernel._to_camera(f, 0.5, 2.5, 0.5), 0.0)
    assert (low, high) == pytest.approx((0.0, 3.0))  # at the distance 1.5: heights 0.5 to 3.5


def test_room_around_the_view_is_measured_at_right_angles_to_its_borders() -> None:
    f = frustum_of(24)
    low, high = kernel._levels_within(f, *kernel._to_camera(f, 0.5, 2.5, 0.5), 1.0)
    assert (low, high) == pytest.approx((-math.sqrt(2.0), 3.0 + math.sqrt(2.0)))


@pytest.mark.parametrize(("x", "span"), [(1.0, (1.0, 3.0)), (0.0, (2.0, 2.0)), (2.0, (0.0, 4.0))])
def test_an_outline_is_crossed_from_side_to_side(x: float, span: tuple[float, float]) -> None:
    diamond = np.array([[0.0, 2.0], [2.0, 0.0], [4.0, 2.0], [2.0, 4.0]])
    assert kernel.columns_in_row(diamond, x) == pytest.approx(span)


def test_an_outline_is_not_crossed_beside_it() -> None:
    low, high = kernel.columns_in_row(np.array([[0.0, 2.0], [2.0, 0.0], [4.0, 2.0]]), -0.1)
    assert low > high


def test_the_outline_of_a_voxel_in_an_image_row() -> None:
    """A cube of edge 2 seen from straight ahead: four corners near, four far, u and v from 1 to 3."""
    corners = np.array([[1.0 + 2.0 * (k >> 1 & 1), 1.0 + 2.0 * (k >> 2)] for k in range(8)])
    assert kernel._outline_in_row(corners, 2.0) == pytest.approx((1.0, 3.0), abs=1e-5)
    assert kernel._outline_in_row(corners, 1.0) == pytest.approx((1.0, 3.0), abs=1e-5)


def test_an_outline_is_never_too_narrow() -> None:
    corners = np.array([[1.0 + 2.0 * (k >> 1 & 1), 1.0 + 2.0 * (k >> 2)] for k in range(8)])
    low, high = kernel._outline_in_row(corners, 2.0)
    assert low < 1.0
    assert high > 3.0
    assert kernel._outline_in_row(corners, 3.0 + 5e-7)[0] < 1.0  # a row that touches it but for rounding


@pytest.mark.parametrize("v", [-5.0, 0.5, 3.5, 1e6])
def test_a_row_that_misses_an_outline_holds_nothing_of_it(v: float) -> None:
    corners = np.array([[1.0 + 2.0 * (k >> 1 & 1), 1.0 + 2.0 * (k >> 2)] for k in range(8)])
    low, high = kernel._outline_in_row(corners, v)
    assert math.ceil(low) > math.floor(high)


def test_corners_outside_of_one_border_mean_that_no_ray_hits() -> None:
    f, corners = frustum_of(24), np.empty((8, 3))
    assert kernel._corners(f, (1, 1, 1), corners)
    assert corners[0].tolist() == [2.0, -1.0, -1.0]
    assert corners[7].tolist() == [3.0, 0.0, 0.0]
    assert not kernel._corners(f._replace(origin=np.array([-1.0, 9.0, 2.0])), (0, 0, 1), corners)
    assert not kernel._corners(f._replace(origin=np.array([5.0, 2.0, 2.0])), (1, 1, 1), corners)  # behind it


def test_a_ray_of_the_lattice_hits_a_voxel_over_a_length() -> None:
    f = frustum_of(2, (0.5, 1.5, 1.5), tangent=1.0)  # four rays at tangents of half to either side
    hits = {voxel for voxel in GRID if kernel._hits(f, 0, 0, voxel)}
    assert hits == {(0, 1, 1), (1, 1, 1), (1, 2, 2), (2, 2, 2), (3, 2, 2), (3, 3, 3)}
    straight = Ray((0.5, 1.5, 1.5), (2.0, 1.0, 1.0), 0.0, FARTHEST)
    assert hits == {voxel for voxel in GRID if hits_cell(straight, voxel)}
