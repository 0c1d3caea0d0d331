"""The profile: at which forward distances the rays of a plane enter and leave each level.

The sensor stands at the height 1.5, in the middle of level 1, unless a test says otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from riglens.core.kernels.fans import profile
from riglens.core.kernels.fans.profile import Events, Slopes
from tests.core.kernels.tiny import ENDLESS, fan_of, rays_in_planes

Event = tuple[float, int]
LOST = None


def events_of(
    slopes: Sequence[float],
    z0: float = 1.5,
    near: float = 0.0,
    far: float = math.inf,
    farthest: float = 10.0,
    levels: tuple[int, int] = (0, 4),
) -> list[Event] | None:
    """Distance and change of each event, in order: +z where level z begins, as (distance, z + 1), ends are negative."""
    count = len(slopes)
    rays = Slopes(np.array(slopes), np.full(count, near), np.full(count, far), np.arange(count))
    events = Events(np.empty(99), np.empty(99, np.int32))
    found = profile.find_stays(rays, z0, *levels, farthest, events)
    if found < 0:
        return LOST
    assert found <= 2 * (count + 2) * (levels[1] - levels[0] + 1)
    return sorted((float(events.at[i]), int(events.changes[i])) for i in range(found))


def begins(level: int) -> int:
    """How the profile writes that a level begins."""
    return level + 1


def ends(level: int) -> int:
    """How the profile writes that a level ends."""
    return -level - 1


def test_a_rising_ray_goes_through_the_levels_one_by_one() -> None:
    """With slope 0.5 it rises by one level on two voxels: height 2 at 1, height 3 at 3, height 4 at 5."""
    assert events_of([0.5]) == [
        (0.0, begins(1)),
        (1.0, ends(1)),
        (1.0, begins(2)),
        (3.0, ends(2)),
        (3.0, begins(3)),
        (5.0, ends(3)),
    ]


def test_a_falling_ray_goes_down_to_the_ground() -> None:
    assert events_of([-0.5]) == [(0.0, begins(1)), (1.0, ends(1)), (1.0, begins(0)), (3.0, ends(0))]


def test_a_level_ray_stays_in_its_level() -> None:
    assert events_of([0.0]) == [(0.0, begins(1))]


def test_levels_outside_of_the_box_are_left_out() -> None:
    assert events_of([0.5], levels=(2, 3)) == [(1.0, begins(2)), (3.0, ends(2))]


def test_stays_that_overlap_are_one() -> None:
    """In level 2 the ray of slope 1 is from 0.5 to 1.5, the ray of slope 0.5 from 1 to 3."""
    found = events_of([0.5, 1.0], levels=(2, 3))
    assert found == [(0.5, begins(2)), (3.0, ends(2))]


def test_a_stay_within_another_changes_nothing() -> None:
    """In level 2 from 0.25 to 0.75, from 0.5 to 1.5, from 1 to 3; and slope 0.9 within these."""
    assert events_of([0.5, 0.9, 1.0, 2.0], levels=(2, 3)) == [(0.25, begins(2)), (3.0, ends(2))]


def test_a_level_is_left_when_the_last_ray_leaves_it_in_whatever_order_they_do() -> None:
    """From the height 1.5 the rays leave level 1 at 1, 0.5 and 0.25, upwards and downwards."""
    assert events_of([0.5, 1.0, 2.0], levels=(1, 2)) == [(0.0, begins(1)), (1.0, ends(1))]
    assert events_of([-2.0, -1.0, -0.5], levels=(1, 2)) == [(0.0, begins(1)), (1.0, ends(1))]


def test_stays_apart_are_two() -> None:
    """In level 2 the ray of slope 4 is from 0.125 to 0.375, the ray of slope 0.5 from 1 to 3."""
    assert events_of([0.5, 4.0], levels=(2, 3)) == [
        (0.125, begins(2)),
        (0.375, ends(2)),
        (1.0, begins(2)),
        (3.0, ends(2)),
    ]


def test_stays_apart_below_the_sensor_too() -> None:
    assert events_of([-4.0, -0.5], levels=(0, 1)) == [
        (0.125, begins(0)),
        (0.375, ends(0)),
        (1.0, begins(0)),
        (3.0, ends(0)),
    ]


def test_at_a_face_rays_begin_in_the_level_that_they_look_into() -> None:
    assert events_of([0.0], z0=2.0) == [(0.0, begins(2))]
    assert events_of([1.0], z0=2.0, levels=(1, 3)) == [(0.0, begins(2)), (1.0, ends(2))]
    assert events_of([-1.0], z0=2.0, levels=(1, 3)) == [(0.0, begins(1)), (1.0, ends(1))]


def test_a_range_cuts_stays() -> None:
    assert events_of([0.0], near=2.0, far=5.0) == [(2.0, begins(1)), (5.0, ends(1))]
    assert events_of([0.5], near=2.0, far=4.0) == [
        (2.0, begins(2)),
        (3.0, ends(2)),
        (3.0, begins(3)),
        (4.0, ends(3)),
    ]


@pytest.mark.parametrize("beside", [0.0, 2e-9, -2e-9, 9e-9, -9e-9])
def test_a_range_that_ends_within_the_tolerance_of_a_level_is_left_to_the_exact_walk(beside: float) -> None:
    assert events_of([0.5], far=1.0 + beside) is LOST
    assert events_of([0.5], near=3.0 + beside) is LOST


@pytest.mark.parametrize("beside", [2e-8, -2e-8])
def test_a_range_that_ends_clear_of_a_level_is_not(beside: float) -> None:
    found = events_of([0.5], far=1.0 + beside)
    assert found is not None
    assert [change for _, change in found] == (
        [begins(1), ends(1), begins(2), ends(2)] if beside > 0.0 else [begins(1), ends(1)]
    )
    assert events_of([0.5], near=3.0 + beside) is not LOST


def test_stays_that_begin_apart_are_joined_in_the_order_in_which_they_begin() -> None:
    """Rays from the height 0.5 in level 0: one between 0.9 and 1.2, the other between 0.2 and 1."""
    rays = Slopes(np.array([0.1, 0.2]), np.array([0.9, 0.2]), np.array([1.2, 1.0]), np.array([1, 0]))
    events = Events(np.empty(9), np.empty(9, np.int32))
    assert profile.find_stays(rays, 0.5, 0, 1, 10.0, events) == 2
    assert (events.at[:2].tolist(), events.changes[:2].tolist()) == ([0.2, 1.2], [begins(0), ends(0)])


def test_nothing_is_written_beyond_the_farthest_distance() -> None:
    assert events_of([0.5], farthest=4.0) == [
        (0.0, begins(1)),
        (1.0, ends(1)),
        (1.0, begins(2)),
        (3.0, ends(2)),
        (3.0, begins(3)),
    ]
    assert events_of([0.5], farthest=2.0) == [(0.0, begins(1)), (1.0, ends(1)), (1.0, begins(2))]


def test_an_event_at_the_farthest_distance_is_written() -> None:
    assert events_of([0.5], farthest=1.0) == [(0.0, begins(1)), (1.0, ends(1)), (1.0, begins(2))]


def test_masks_hold_the_levels_in_use_after_each_event() -> None:
    changes = np.array([begins(1), ends(1), begins(2), begins(0)], np.int32)
    assert profile.masks_of(changes, 1)[:, 0].tolist() == [0, 0b010, 0, 0b100, 0b101]


def test_masks_of_high_levels_lie_in_the_second_word() -> None:
    changes = np.array([begins(63), begins(64), ends(63)], np.int32)
    assert profile.masks_of(changes, 2).tolist() == [[0, 0], [1 << 63, 0], [1 << 63, 1], [0, 1]]


def test_the_profile_of_a_sensor_is_sorted_and_ends_with_infinity() -> None:
    _, _, made = fan_of(rays_in_planes((0.5, 0.5, 1.5), [-0.5, 0.5]))
    assert made.at.tolist() == [0.0, 1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 5.0, math.inf]
    assert made.begun == 1
    assert made.masks[1, 0] == 0b0010
    assert made.masks[4, 0] == 0b0101
    assert made.masks[7, 0] == 0b1000
    assert made.masks[8, 0] == 0


def test_a_range_in_voxels_along_the_ray_is_shorter_along_the_ground() -> None:
    """A ray of elevation 60 degrees and length 4 ends at the forward distance 2."""
    rays = rays_in_planes((0.5, 0.5, 0.5), [0.0], reach=ENDLESS)
    sixty = np.array([[0.5, math.sqrt(0.75)]])
    _, _, made = fan_of(rays._replace(rows=sixty, reach=np.array([0.0, 4.0])))
    assert made.at[-2] == pytest.approx(2.0)
