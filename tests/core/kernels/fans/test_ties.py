"""Rays that change their level right at the face between two columns.

The sensor stands at x = 0.5 and looks along x with slope 1. From the height 1.5 its ray reaches the height 2 exactly
at the face x = 1 and the height 3 at x = 2; from a little higher or lower it does so a little before or behind them.
"""

from __future__ import annotations

import pytest

from riglens.core.kernels.fans import ties
from riglens.core.kernels.fans.fan import LEAST
from riglens.core.kernels.fans.planes import work_for
from riglens.core.kernels.fans.profile import TOLERANCE
from riglens.core.kernels.fans.ties import Start
from tests.core.kernels.tiny import (
    AHEAD,
    BACK,
    BOX,
    ENDLESS,
    Voxel,
    fan_of,
    heading,
    rays_in_planes,
    room_for_alone,
    seen_alone,
    seen_by_fan,
    seen_ray_by_ray,
)

AT_THE_FACES: set[Voxel] = {(0, 0, 1), (1, 0, 2), (2, 0, 3)}


@pytest.mark.parametrize(
    ("place", "side"),
    [
        (0.5, 0),
        (2.0, -1),  # the face behind is too close
        (2.0 + 5e-9, -1),
        (2.0 - 5e-9, 1),  # the face ahead is too close
        (2.0 + 2e-8, 0),
        (2.0 - 2e-8, 0),
        (5e-9, 0),  # the plane starts there: no face behind
        (1.0 - 5e-9, 1),
        (1.0, -1),
    ],
)
def test_a_place_is_too_close_to_a_face_within_the_tolerance(place: float, side: int) -> None:
    assert ties._side(place) == side


def test_levels_that_change_exactly_at_the_faces_are_met_on_one_side_only() -> None:
    assert seen_by_fan(rays_in_planes((0.5, 0.5, 1.5), [1.0])) == AT_THE_FACES


@pytest.mark.parametrize("higher", [1e-13, 1e-10, 3e-9])
def test_levels_that_begin_a_little_before_the_faces_are_met_before_them(higher: float) -> None:
    before = {(0, 0, 2), (1, 0, 3)}
    assert seen_by_fan(rays_in_planes((0.5, 0.5, 1.5 + higher), [1.0])) == AT_THE_FACES | before


@pytest.mark.parametrize("lower", [1e-13, 1e-10, 3e-9])
def test_levels_that_end_a_little_behind_the_faces_are_met_behind_them(lower: float) -> None:
    behind = {(1, 0, 1), (2, 0, 2), (3, 0, 3)}
    assert seen_by_fan(rays_in_planes((0.5, 0.5, 1.5 - lower), [1.0])) == AT_THE_FACES | behind


def test_backwards_the_same_holds() -> None:
    rays = rays_in_planes((3.5, 0.5, 1.5 + 1e-10), [1.0], [BACK])
    assert seen_by_fan(rays) == {(3, 0, 1), (3, 0, 2), (2, 0, 2), (2, 0, 3), (1, 0, 3)}


def test_the_later_of_two_rays_is_found_although_one_walk_serves_both() -> None:
    """The second ray is at the height 2 by 5e-11 behind the face: it is still in level 1 there. Both end at x = 1.7."""
    rays = rays_in_planes((0.5, 0.5, 1.5), [1.0, 1.0 - 1e-10], reach=(0.0, 1.2))
    assert seen_by_fan(rays) == {(0, 0, 1), (1, 0, 2), (1, 0, 1)}


def test_steep_rays_whose_ties_lie_apart_are_each_walked() -> None:
    """Rays from the height 1 at 0.002 before the face: the second one reaches the height 2 by 5e-9 behind it, where
    the first one is higher by 2.5e-6."""
    rays = rays_in_planes((0.998, 0.5, 1.0), [500.0, 500.0 * (1.0 - 2.5e-6)])
    assert (1, 0, 1) in seen_ray_by_ray(rays)
    assert seen_by_fan(rays) == seen_ray_by_ray(rays)


def test_a_range_that_begins_or_ends_at_a_face_is_a_tie() -> None:
    """Level rays from the face x = 1 or just beside it to the face x = 3 or just beside it."""
    for near in (0.5 - 1e-9, 0.5, 0.5 + 1e-9):
        for far in (2.5 - 1e-9, 2.5, 2.5 + 1e-9):
            rays = rays_in_planes((0.5, 0.5, 1.5), [0.0], reach=(near, far))
            columns = range(0 if near < 0.5 else 1, 4 if far > 2.5 else 3)
            assert seen_by_fan(rays) == {(ix, 0, 1) for ix in columns}


@pytest.mark.parametrize("degrees", [0.0, 30.0, 45.0, 90.0, 143.13010235415598, 180.0, 225.0, 270.0])
@pytest.mark.parametrize("place", [(1.0, 1.0, 1.0), (1.5, 2.5, 1.5), (2.0, 1.5, 2.0), (1.25, 1.75, 1.0)])
def test_at_round_places_fans_mark_what_each_ray_marks_alone(
    degrees: float, place: tuple[float, float, float]
) -> None:
    slopes = [-2.0, -1.0, -0.5, 0.0, 0.25, 0.5, 1.0, 2.0]
    rays = rays_in_planes(place, slopes, [heading(degrees), AHEAD])
    assert seen_by_fan(rays) == seen_ray_by_ray(rays)


def untied(z: float, start: Start) -> tuple[bool, list[int], set[Voxel]]:
    """What is decided about the events of a ray of slope 1: whether it is, their places, and the voxels walked."""
    fan, rays, profile = fan_of(rays_in_planes((0.5, 0.5, z), [1.0], reach=ENDLESS))
    work, leftover = work_for(rays, profile), room_for_alone()
    events = (profile.begun, profile.at.size - 2)
    decided = ties.untie(fan, rays, profile, events, 0, start, BOX, work, leftover)
    return decided, work.places[: events[1] - events[0]].tolist(), seen_alone(rays, leftover)


def along_x(columns: int, drift: float = LEAST, beside: float = 0.5) -> Start:
    """A plane along x from the middle of the first column."""
    return Start(0, 0, 1, 1, 0.5, beside, 1.0, drift, columns)


def test_what_begins_at_a_face_is_placed_behind_it_and_what_ends_there_before_it() -> None:
    """At x = 1 level 1 ends and level 2 begins, at x = 2 level 2 ends and level 3 begins."""
    decided, places, walked = untied(1.5, along_x(4))
    assert decided
    assert places == [0, 1, 1, 2]
    assert walked == AT_THE_FACES


def test_the_same_within_the_tolerance_before_the_face() -> None:
    decided, places, walked = untied(1.5 + TOLERANCE / 4.0, along_x(4))
    assert decided
    assert places == [0, 1, 1, 2]
    assert walked == AT_THE_FACES | {(0, 0, 2), (1, 0, 3)}


def test_clear_of_the_faces_nothing_is_walked() -> None:
    decided, places, walked = untied(1.25, along_x(4))  # heights 2 and 3 at x = 1.25 and 2.25
    assert decided
    assert places == [1, 1, 2, 2]
    assert walked == set()


def test_at_two_faces_at_once_nothing_can_be_said() -> None:
    assert not untied(1.5, along_x(7, drift=1.0))[0]


def test_behind_the_last_column_nothing_can_be_said() -> None:
    assert not untied(1.5, along_x(2))[0]
    assert untied(1.5, along_x(3))[0]
