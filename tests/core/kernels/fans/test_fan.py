"""Planes laid over the columns of a grid of 4 x 4 x 4: which columns they cross, and which levels these get."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.engine import fans
from riglens.core.engine.fans import is_upright, make_fan, share_rows
from riglens.core.kernels.fans import fan
from riglens.core.kernels.fans.fan import Course
from riglens.core.kernels.fans.planes import ALL, LeftoverRays, leave_over
from riglens.core.kernels.fans.profile import TOLERANCE
from tests.core.kernels.tiny import (
    AHEAD,
    BACK,
    LEFT,
    RIGHT,
    SIDE,
    Voxel,
    fan_of,
    heading,
    no_voxels,
    rays_in_planes,
    room_for_alone,
    row,
    seen_alone,
    seen_by_fan,
    seen_ray_by_ray,
    voxels_of,
)

SLANTED = (0.8, 0.6)
"""From (0.5, 0.5) it meets x = 1, 2, 3, 4 at 0.625, 1.875, 3.125, 4.375 and y = 1, 2, 3 at 0.83, 2.5, 4.17."""
SLANTED_COLUMNS = [(0, 0), (1, 0), (1, 1), (2, 1), (2, 2), (3, 2), (3, 3)]


@pytest.mark.parametrize(
    ("along", "columns"),
    [
        (AHEAD, {(1, 2), (2, 2), (3, 2)}),
        (BACK, {(1, 2), (0, 2)}),
        (LEFT, {(1, 2), (1, 3)}),
        (RIGHT, {(1, 2), (1, 1), (1, 0)}),
    ],
)
def test_a_level_ray_along_an_axis_meets_its_row(
    along: tuple[float, float], columns: set[tuple[int, int]]
) -> None:
    assert seen_by_fan(rays_in_planes((1.5, 2.5, 1.5), [0.0], [along])) == {(x, y, 1) for x, y in columns}


def test_a_slanted_plane_meets_the_columns_that_its_line_crosses() -> None:
    assert seen_by_fan(rays_in_planes((0.5, 0.5, 1.5), [0.0], [SLANTED])) == {
        (x, y, 1) for x, y in SLANTED_COLUMNS
    }


def test_a_column_gets_the_levels_in_use_where_it_begins_and_those_that_begin_in_it() -> None:
    """A ray of slope 0.5 is at the height 2 at x = 1.75 and at the height 3 at x = 3.75."""
    seen = seen_by_fan(rays_in_planes((0.75, 0.5, 1.5), [0.5]))
    assert seen == {(0, 0, 1), (1, 0, 1), (1, 0, 2), (2, 0, 2), (3, 0, 2), (3, 0, 3)}


def test_a_level_that_two_rays_share_is_left_when_the_last_one_leaves_it() -> None:
    """One ray is at the height 2 at x = 0.81 and at the height 3 at x = 1.92, the other at the height 2 at x = 1.92."""
    seen = seen_by_fan(rays_in_planes((0.25, 0.5, 1.5), [0.3, 0.9]))
    levels = [{level for column, _, level in seen if column == x} for x in range(3)]
    assert levels == [{1, 2}, {1, 2, 3}, {2, 3}]


@pytest.mark.parametrize("along", [AHEAD, BACK])
def test_a_plane_in_a_face_belongs_to_the_positive_side(along: tuple[float, float]) -> None:
    start = 0.5 if along == AHEAD else 3.5
    assert seen_by_fan(rays_in_planes((start, 2.0, 1.5), [0.0], [along])) == row(range(4), 2, 1)


@pytest.mark.parametrize("beside", [1e-13, -1e-13, 3e-9, -3e-9])
def test_a_plane_beside_a_face_keeps_to_its_side(beside: float) -> None:
    side = 2 if beside > 0.0 else 1
    assert seen_by_fan(rays_in_planes((0.5, 2.0 + beside, 1.5), [0.0])) == row(range(4), side, 1)


def test_a_plane_through_the_edges_between_columns_meets_only_those_on_its_way() -> None:
    diagonal = (0.7071067811865476, 0.7071067811865476)
    assert seen_by_fan(rays_in_planes((0.5, 0.5, 1.5), [0.0], [diagonal])) == {(i, i, 1) for i in range(4)}


def test_a_plane_beside_the_edges_by_one_double_meets_the_columns_between() -> None:
    diagonal = (0.7071067811865476, 0.7071067811865476)
    seen = seen_by_fan(rays_in_planes((0.5, float(np.nextafter(0.5, 0.0)), 1.5), [0.0], [diagonal]))
    assert seen == {(i, i, 1) for i in range(4)} | {(i + 1, i, 1) for i in range(3)}


def test_a_sensor_outside_sees_what_its_planes_meet_of_the_grid() -> None:
    assert seen_by_fan(rays_in_planes((-1.5, 1.5, 1.5), [0.0])) == row(range(4), 1, 1)
    assert seen_by_fan(rays_in_planes((-1.5, 1.5, 1.5), [0.0], [BACK])) == set()
    assert seen_by_fan(rays_in_planes((-1.5, 9.5, 1.5), [0.0])) == set()
    assert seen_by_fan(rays_in_planes((-2.0, 1.5, 0.5), [0.5])) == {
        (0, 1, 1),
        (1, 1, 2),
        (2, 1, 2),
        (3, 1, 3),
    }


def test_a_plane_that_touches_the_grid_at_an_edge_meets_nothing() -> None:
    assert (
        seen_by_fan(rays_in_planes((-1.0, 3.0, 1.5), [0.0], [(0.7071067811865476, 0.7071067811865476)]))
        == set()
    )


def test_rays_too_steep_for_a_plane_are_walked_alone() -> None:
    rays = rays_in_planes((1.5, 1.5, 1.5), [0.0, 1e4, -1e4])
    assert fan_of(rays)[0].steep.tolist() == [2, 1]
    assert seen_by_fan(rays) == row(range(1, 4), 1, 1) | {(1, 1, z) for z in range(4)}


def test_a_slope_at_the_limit_is_not_too_steep() -> None:
    made = fan_of(rays_in_planes((1.5, 1.5, 1.5), [fan.STEEPEST, -fan.STEEPEST, 1.001 * fan.STEEPEST]))[0]
    assert made.row_of.tolist() == [1, 0]
    assert made.steep.tolist() == [2]


@pytest.mark.parametrize("slabs", [[(0, 2), (2, 4)], [(0, 1), (1, 1), (1, 4)], [(0, 4)]])
def test_workers_mark_together_what_one_marks_alone(slabs: list[tuple[int, int]]) -> None:
    rays = rays_in_planes((0.5, 0.5, 1.5), [-0.4, 0.3], [SLANTED, AHEAD, LEFT, heading(70.0)])
    assert seen_by_fan(rays, slabs) == seen_by_fan(rays)


def test_a_worker_marks_its_own_rows_only() -> None:
    rays = rays_in_planes((0.5, 0.5, 1.5), [0.0], [SLANTED])
    assert {x for x, _, _ in seen_by_fan(rays, [(1, 3)])} == {1, 2}


@pytest.mark.parametrize("place", [(0.31, 0.47, 1.53), (2.71, 3.14, 0.2), (-0.9, 1.7, 2.9), (4.6, 5.1, 4.4)])
def test_at_odd_places_fans_mark_what_each_ray_marks_alone(place: tuple[float, float, float]) -> None:
    headings = [heading(degrees) for degrees in range(0, 360, 17)]
    rays = rays_in_planes(place, [-3.0, -0.9, -0.33, -0.02, 0.11, 0.6, 1.7], headings)
    assert seen_by_fan(rays) == seen_ray_by_ray(rays)


@pytest.mark.parametrize("reach", [(0.0, 1.7), (0.9, 2.6), (1.3, 9.0)])
def test_a_range_cuts_the_rays_of_a_fan(reach: tuple[float, float]) -> None:
    rays = rays_in_planes((1.31, 1.47, 1.53), [-0.9, 0.02, 0.6], [SLANTED, heading(200.0)], reach)
    assert seen_by_fan(rays) == seen_ray_by_ray(rays)


# ---------------------------------------------------------------- the steps of one plane


def test_the_ways_from_column_to_column_follow_the_faces() -> None:
    ways = np.zeros(9, np.int32)
    assert fan._cross_columns(Course(0.5, 0.5, *SLANTED), (10, 1), 3, 7, ways)
    assert ways[:6].tolist() == [10, 1, 10, 1, 10, 1]


def test_ways_through_an_edge_are_not_certain() -> None:
    assert not fan._cross_columns(Course(0.5, 0.5, 0.7, 0.7), (10, 1), 3, 7, np.zeros(9, np.int32))
    assert not fan._cross_columns(Course(0.5, 0.5 + 5e-9, 0.7, 0.7), (10, 1), 3, 7, np.zeros(9, np.int32))
    assert fan._cross_columns(Course(0.5, 0.5 + 5e-8, 0.7, 0.7), (10, 1), 3, 7, np.zeros(9, np.int32))


def test_events_are_placed_in_the_column_of_their_distance() -> None:
    places = np.zeros(4, np.int32)
    assert fan._place_events(Course(0.5, 0.5, *SLANTED), np.array([0.1, 0.7, 2.0, 4.2]), 1.0, places)
    assert places.tolist() == [0, 1, 3, 6]


def test_a_stretch_tells_the_distance_along_the_heading_from_the_forward_distance() -> None:
    places = np.zeros(1, np.int32)
    assert fan._place_events(Course(0.5, 0.5, *SLANTED), np.array([1.0]), 2.0, places)
    assert places.tolist() == [3]


@pytest.mark.parametrize(
    ("distance", "is_certain"),
    [(0.5, False), (0.5 + 5e-9, False), (0.5 - 5e-9, False), (0.5 + 2e-8, True), (0.5 - 2e-8, True)],
)
def test_an_event_within_the_tolerance_of_a_face_is_not_certain(distance: float, is_certain: bool) -> None:
    places = np.zeros(1, np.int32)
    assert fan._place_events(Course(0.5, 0.3, 1.0, 0.01), np.array([distance]), 1.0, places) == is_certain
    assert fan._place_events(Course(0.3, 0.5, 0.01, 1.0), np.array([distance]), 1.0, places) == is_certain


@pytest.mark.parametrize(
    ("past", "is_close"),
    [(0.0, 1), (5e-9, 1), (2e-8, 0), (0.5, 0), (1.0 - 2e-8, 0), (1.0 - 5e-9, 1)],
)
def test_close_is_within_the_tolerance_of_either_face(past: float, is_close: int) -> None:
    assert fan._is_close(past) == is_close


def test_a_plane_starts_in_the_column_that_it_looks_into() -> None:
    assert fan._start_cell(2.0, 1.0, 0.0, 0, SIDE) == (2.0, True)
    assert fan._start_cell(2.0, -1.0, 0.0, 0, SIDE) == (1.0, True)
    assert fan._start_cell(2.5, -1.0, 0.0, 0, SIDE) == (2.0, True)


def test_a_plane_from_outside_starts_behind_the_face_of_the_box() -> None:
    assert fan._start_cell(-1.0, 1.0, 1.0, 0, SIDE) == (0.0, True)
    assert fan._start_cell(5.0, -1.0, 1.0, 0, SIDE) == (3.0, True)
    assert fan._start_cell(1.2, 0.5, 1.0, 0, SIDE) == (1.0, True)
    assert not fan._start_cell(1.5, 0.5, 1.0, 0, SIDE)[1]  # at the face x = 2
    assert not fan._start_cell(1.5 + TOLERANCE / 2.0, 0.5, 1.0, 0, SIDE)[1]


def test_a_plane_along_an_axis_is_straight_where_no_face_is_close() -> None:
    assert fan._stays_between(1.5, 0.0)
    assert fan._stays_between(1.5, 6e-17)
    assert not fan._stays_between(1.5, 1e-12)
    assert not fan._stays_between(2.0, 0.0)
    assert not fan._stays_between(2.0 - TOLERANCE / 2.0, 0.0)


def test_a_heading_almost_along_an_axis_is_left_to_the_exact_walk() -> None:
    for drift, is_decided in ((0.0, True), (5e-4, False), (5e-3, True)):
        rays = rays_in_planes((0.5, 1.5, 1.5), [0.0], [(1.0, drift)])
        made, rays, profile = fan_of(rays)
        marks = no_voxels()
        leftover = room_for_alone()
        fan._mark_slab(made, rays, profile, None, (0, 1), np.array([0, SIDE]), leftover, marks)
        assert voxels_of(marks) == (row(range(4), 1, 1) if is_decided else set())
        assert left(leftover) == ([] if is_decided else [(0, ALL)])


@pytest.mark.parametrize(
    ("beyond", "is_decided", "met"),
    [
        (-1.0, True, set()),
        (-TOLERANCE / 4.0, False, set()),
        (0.0, False, set()),
        (TOLERANCE / 4.0, False, set()),
        (0.2, True, {(0, 0, 1)}),
    ],
)
def test_a_plane_that_grazes_the_corner_of_the_grid_is_left_to_the_exact_walk(
    beyond: float, is_decided: bool, met: set[Voxel]
) -> None:
    """Planes from (-1, 1) to the right and ahead, through the corner (0, 0) or beside it."""
    made, rays, profile = fan_of(rays_in_planes((-1.0, 1.0 + beyond, 1.5), [0.0], [heading(-45.0)]))
    marks, leftover = no_voxels(), room_for_alone()
    fan._mark_slab(made, rays, profile, None, (0, 1), np.array([0, SIDE]), leftover, marks)
    assert left(leftover) == ([] if is_decided else [(0, ALL)])
    assert voxels_of(marks) == met


def left(leftover: LeftoverRays) -> list[tuple[int, int]]:
    """Plane and row of the rays left to the exact walk."""
    return [(int(plane), int(row)) for plane, row in leftover.rays[: leftover.noted[0], :2]]


LEFT_OVER = [AHEAD, (1.0, 5e-4), LEFT, (1.0, 6e-4), BACK]
"""The second and the fourth plane cannot be decided."""


@pytest.mark.parametrize(
    ("most", "halts", "noted"),
    [
        (64, [5], [[(0, 2), (1, ALL), (2, 2), (3, ALL), (4, 2)]]),
        (3, [3, 5], [[(0, 2), (1, ALL), (2, 2)], [(3, ALL), (4, 2)]]),
        (1, [1, 2, 3, 4, 5], [[(0, 2)], [(1, ALL)], [(2, 2)], [(3, ALL)], [(4, 2)]]),
    ],
)
def test_a_full_list_halts_the_planes_and_they_go_on_with_an_empty_one(
    most: int, halts: list[int], noted: list[list[tuple[int, int]]]
) -> None:
    """One ray of each plane, in row 2, is too steep for it."""
    made, rays, profile = fan_of(rays_in_planes((1.5, 1.5, 1.5), [0.0, 0.1, 1e4], LEFT_OVER))
    leftover, marks, plane = room_for_alone(most), no_voxels(), 0
    for halt, those in zip(halts, noted, strict=True):
        leftover.noted[0] = 0
        plane = fan._mark_slab(made, rays, profile, None, (plane, 5), np.array([0, SIDE]), leftover, marks)
        assert plane == halt
        assert left(leftover) == those


def test_a_plane_with_more_rays_left_alone_than_any_list_holds_is_left_as_a_whole() -> None:
    made, rays, profile = fan_of(rays_in_planes((1.5, 1.5, 1.5), [0.0, 1e4, -1e4]))
    leftover, marks = room_for_alone(1), no_voxels()
    assert fan._mark_slab(made, rays, profile, None, (0, 1), np.array([0, SIDE]), leftover, marks) == 1
    assert left(leftover) == [(0, ALL)]


def test_a_plane_that_does_not_fit_any_more_is_walked_again() -> None:
    made, rays, profile = fan_of(rays_in_planes((1.5, 1.5, 1.5), [0.0, 1e4, -1e4], [AHEAD, LEFT]))
    leftover, marks = room_for_alone(3), no_voxels()
    assert fan._mark_slab(made, rays, profile, None, (0, 2), np.array([0, SIDE]), leftover, marks) == 1
    assert left(leftover) == [(0, 2), (0, 1)]


def test_rays_left_alone_are_walked_through_their_columns_only() -> None:
    rays = rays_in_planes((0.5, 0.5, 1.5), [0.0])
    leftover = room_for_alone()
    leave_over(leftover, 0, 0, np.array([1, 3, 0, 1, 0, SIDE]))
    assert seen_alone(rays, leftover) == row((1, 2), 0, 1)


@pytest.mark.parametrize("most", [1, 2, 7])
def test_short_lists_change_nothing(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rays = rays_in_planes((1.0, 1.5, 1.0), [-1.0, 0.5, 1.0, 1e4], [AHEAD, (1.0, 5e-4), LEFT, BACK])
    seen = seen_by_fan(rays)
    monkeypatch.setattr(fans, "LEFT_ALONE_MOST", most)
    assert seen_by_fan(rays, [(0, 2), (2, SIDE)]) == seen == seen_ray_by_ray(rays)


# ---------------------------------------------------------------- the tables of a fan


def test_slopes_ascend_and_know_their_rows() -> None:
    made = fan_of(rays_in_planes((0.5, 0.5, 1.5), [0.5, -1.0, 0.0]))[0]
    assert made.slopes.tolist() == [-1.0, 0.0, 0.5]
    assert made.row_of.tolist() == [1, 2, 0]


def test_a_sensor_that_yaws_turns_its_headings() -> None:
    rays = rays_in_planes((0.5, 0.5, 1.5), [0.0], [AHEAD, LEFT])
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    made = make_fan(rays._replace(rotation=quarter))
    assert made.headings.tolist() == [[0.0, 1.0], [-1.0, 0.0]]


def test_only_a_sensor_that_neither_rolls_nor_pitches_is_upright() -> None:
    assert is_upright(np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    assert not is_upright(np.array([[1.0, 0.0, 1e-9], [0.0, 1.0, 0.0], [-1e-9, 0.0, 1.0]]))
    assert not is_upright(np.diag([1.0, -1.0, -1.0]))


def test_rows_are_shared_by_the_work_in_them() -> None:
    assert share_rows(np.array([1.0, 1.0, 1.0, 1.0]), 0, 4, 2).tolist() == [[0, 1], [1, 4]]
    assert share_rows(np.array([0.0, 0.0, 5.0, 1.0]), 0, 4, 2).tolist() == [[0, 2], [2, 4]]
