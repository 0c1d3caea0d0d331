"""One ray through a grid of 4 x 4 x 4: faces belong to the positive side, touching does not count."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.kernels.rays import walk
from riglens.core.kernels.rays.walk import FARTHEST, IRREGULAR, Ray
from tests.core.kernels.tiny import BOX, SIDE, Voxel, row
from tests.core.oracle import bresenham

Place = tuple[float, float, float]
HEIGHT = 1.25


def walked(g: Place, d: Place, near: float = 0.0, far: float = FARTHEST) -> list[Voxel]:
    """The voxels in the order in which they are met, by column; levels of a column from the ground up."""
    runs = np.empty((2 * SIDE + 3, 3), np.int32)
    count = walk.walk_exact(Ray(g, d, near, far), BOX, SIDE, runs)
    return [
        (int(column) // SIDE, int(column) % SIDE, level)
        for column, low, high in runs[:count]
        for level in range(low, high + 1)
    ]


def test_along_an_axis_a_ray_meets_one_voxel_after_the_other() -> None:
    assert walked((0.5, 1.5, HEIGHT), (1.0, 0.0, 0.0)) == [(0, 1, 1), (1, 1, 1), (2, 1, 1), (3, 1, 1)]
    assert walked((3.5, 1.5, HEIGHT), (-1.0, 0.0, 0.0)) == [(3, 1, 1), (2, 1, 1), (1, 1, 1), (0, 1, 1)]


def test_straight_up_a_ray_stays_in_its_column() -> None:
    assert walked((0.5, 1.5, HEIGHT), (0.0, 0.0, 1.0)) == [(0, 1, 1), (0, 1, 2), (0, 1, 3)]
    assert walked((0.5, 1.5, HEIGHT), (0.0, 0.0, -1.0)) == [(0, 1, 0), (0, 1, 1)]


@pytest.mark.parametrize("along", [1.0, -1.0])
def test_a_ray_in_a_face_belongs_to_the_positive_side(along: float) -> None:
    start = 0.5 if along > 0.0 else 3.5
    assert set(walked((start, 2.0, HEIGHT), (along, 0.0, 0.0))) == row(range(4), 2, 1)
    assert set(walked((start, 1.5, 2.0), (along, 0.0, 0.0))) == row(range(4), 1, 2)


def test_the_upper_faces_of_the_grid_are_outside_of_it() -> None:
    assert walked((0.5, 4.0, HEIGHT), (1.0, 0.0, 0.0)) == []
    assert walked((0.5, 1.5, 4.0), (1.0, 0.0, 0.0)) == []
    assert len(walked((0.5, 0.0, 0.0), (1.0, 0.0, 0.0))) == 4


def test_through_an_edge_both_axes_are_stepped_at_once() -> None:
    assert walked((0.5, 0.5, HEIGHT), (1.0, 1.0, 0.0)) == [(0, 0, 1), (1, 1, 1), (2, 2, 1), (3, 3, 1)]
    assert walked((0.5, 3.5, HEIGHT), (1.0, -1.0, 0.0)) == [(0, 3, 1), (1, 2, 1), (2, 1, 1), (3, 0, 1)]


def test_through_a_corner_all_axes_are_stepped_at_once() -> None:
    assert walked((0.5, 0.5, 0.5), (1.0, 1.0, 1.0)) == [(0, 0, 0), (1, 1, 1), (2, 2, 2), (3, 3, 3)]
    assert walked((3.5, 3.5, 3.5), (-1.0, -1.0, -1.0)) == [(3, 3, 3), (2, 2, 2), (1, 1, 1), (0, 0, 0)]


def test_beside_an_edge_by_one_double_the_voxel_between_is_met() -> None:
    below = float(np.nextafter(0.5, 0.0))
    assert walked((0.5, below, HEIGHT), (1.0, 1.0, 0.0))[:3] == [(0, 0, 1), (1, 0, 1), (1, 1, 1)]
    assert walked((below, 0.5, HEIGHT), (1.0, 1.0, 0.0))[:3] == [(0, 0, 1), (0, 1, 1), (1, 1, 1)]


def test_a_level_that_ends_at_a_face_between_columns_ends_there() -> None:
    """From height 1.5 with slope 1 the ray is at height 2 where it is at x = 1."""
    assert walked((0.5, 0.5, 1.5), (1.0, 0.0, 1.0)) == [(0, 0, 1), (1, 0, 2), (2, 0, 3)]
    assert walked((0.5, 0.5, 1.5), (1.0, 0.0, -1.0)) == [(0, 0, 1), (1, 0, 0)]


def test_a_steep_ray_meets_several_levels_of_a_column() -> None:
    assert walked((0.5, 0.5, 0.25), (1.0, 0.0, 4.0)) == [
        (0, 0, 0),
        (0, 0, 1),
        (0, 0, 2),
        (1, 0, 2),
        (1, 0, 3),
    ]


def test_a_range_from_face_to_face_holds_the_voxels_between() -> None:
    assert walked((0.5, 0.5, HEIGHT), (1.0, 0.0, 0.0), 0.5, 2.5) == [(1, 0, 1), (2, 0, 1)]
    just_more = walked((0.5, 0.5, HEIGHT), (1.0, 0.0, 0.0), np.nextafter(0.5, 0.0), np.nextafter(2.5, 3.0))
    assert just_more == [(0, 0, 1), (1, 0, 1), (2, 0, 1), (3, 0, 1)]


def test_a_range_that_is_empty_or_behind_the_grid_holds_nothing() -> None:
    assert walked((0.5, 0.5, HEIGHT), (1.0, 0.0, 0.0), 1.0, 1.0) == []
    assert walked((0.5, 0.5, HEIGHT), (1.0, 0.0, 0.0), 3.5, 9.0) == []


def test_a_ray_from_outside_enters_at_the_face() -> None:
    assert walked((-1.5, 0.5, HEIGHT), (1.0, 0.0, 0.0)) == [(0, 0, 1), (1, 0, 1), (2, 0, 1), (3, 0, 1)]
    assert walked((-1.5, 0.5, HEIGHT), (-1.0, 0.0, 0.0)) == []


def test_a_ray_that_touches_the_grid_at_an_edge_meets_nothing() -> None:
    assert walked((-1.0, 3.0, HEIGHT), (1.0, 1.0, 0.0)) == []


def test_a_denormal_direction_is_left_to_rational_arithmetic() -> None:
    runs = np.empty((11, 3), np.int32)
    assert walk.walk_exact(Ray((0.5, 0.5, 0.5), (1.0, 5e-324, 0.0), 0.0, 9.0), BOX, SIDE, runs) == IRREGULAR


@pytest.mark.parametrize(
    ("cell", "is_hit"), [((0, 0, 1), True), ((1, 1, 1), True), ((1, 0, 1), False), ((0, 1, 1), False)]
)
def test_a_voxel_is_hit_over_a_length_and_not_in_an_edge(cell: Voxel, is_hit: bool) -> None:
    ray = Ray((0.5, 0.5, HEIGHT), (1.0, 1.0, 0.0), 0.0, FARTHEST)
    assert walk.hits_cell(ray, cell) == is_hit


def test_bresenham_takes_one_voxel_for_each_step_of_the_longest_axis() -> None:
    runs = np.empty((11, 3), np.int32)
    ray = Ray((0.5, 0.5, HEIGHT), (1.0, 0.4, 0.0), 0.0, FARTHEST)
    count = walk.walk_bresenham(ray, BOX, SIDE, runs)
    assert [divmod(int(column), SIDE) for column in runs[:count, 0]] == [(0, 0), (1, 0), (2, 1), (3, 1)]


@pytest.mark.parametrize("d", [(-1.0, -0.4, 0.3), (0.3, -1.0, 0.6), (-0.2, 0.5, 1.0)])
def test_bresenham_draws_the_line_of_the_textbooks_from_any_voxel(d: Place) -> None:
    g, runs = (2.1, 1.9, 2.2), np.empty((11, 3), np.int32)
    count = walk.walk_bresenham(Ray(g, d, 0.0, FARTHEST), BOX, SIDE, runs)
    line = bresenham((2, 1, 2), walked(g, d)[-1])
    assert [(*divmod(int(column), SIDE), int(low)) for column, low, _ in runs[:count]] == line
