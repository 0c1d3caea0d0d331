"""One frame as a rig meets it: points on road users, and why one of them gets too few."""

from __future__ import annotations

import numpy as np
import pytest

from riglens.core.rig.model import Lidar, Rig
from riglens.core.scene.boxes import rotations_from_yaw
from riglens.core.vehicle.solid import Solid
from riglens.core.view.frame_scene import frame_scene, why_missed
from riglens.core.view.frames import FrameBoxes
from riglens.core.view.hits import BODY, GROUND
from tests.core.builders import lidar, rig_of

NOTHING = Solid.of(np.zeros((0, 3, 3)))
LEVEL = [0.5 * k - 5.0 for k in range(21)]
FAN = lidar((0.0, 0.0, 1.0), azimuths=LEVEL)
"""Beams within 5 degrees of straight ahead, level, one metre above the ground."""


def boxes(*places: tuple[float, float, float], size_m: float = 2.0) -> FrameBoxes:
    count = len(places)
    return FrameBoxes(
        np.zeros(count, np.uint8), np.array(places, np.float64).reshape(-1, 3), np.full((count, 3), size_m),
        rotations_from_yaw(np.zeros(count)),
    )  # fmt: skip


def plate(x_m: float) -> Solid:
    """A square plate across the x axis, 4 m wide and high."""
    a, b, c, d = ([x_m, y, z] for y, z in ((-2, 0), (2, 0), (2, 4), (-2, 4)))
    return Solid.of(np.array([[a, b, c], [a, c, d]], np.float64))


def rays_that_meet(face_m: float, half_m: float) -> int:
    return sum(abs(np.tan(np.radians(angle))) * face_m < half_m for angle in LEVEL)


def test_points_are_the_rays_that_meet_the_face() -> None:
    found = frame_scene(rig_of(FAN), 7, boxes((21.0, 0.0, 1.0)), NOTHING)
    assert found.frame == 7
    assert found.points.tolist() == [rays_that_meet(20.0, 1.0)]
    on_box = found.places_m[found.box == 0]
    assert on_box[:, 0] == pytest.approx(np.full(len(on_box), 20.0), abs=1e-5)


def test_what_stands_before_takes_the_points() -> None:
    found = frame_scene(rig_of(FAN), 0, boxes((41.0, 0.0, 1.0), (11.0, 0.0, 1.0)), NOTHING)
    assert found.points.tolist() == [0, rays_that_meet(10.0, 1.0)]


def test_rays_that_end_on_the_body_are_no_points() -> None:
    found = frame_scene(rig_of(FAN), 0, boxes((21.0, 0.0, 1.0)), plate(1.0))
    assert found.points.tolist() == [0] and not (found.box == BODY).any()


def test_of_very_many_rays_a_part_is_cast_and_stands_for_all() -> None:
    every = frame_scene(rig_of(FAN), 0, boxes((3.0, 0.0, 1.0), size_m=4.0), NOTHING)
    some = frame_scene(rig_of(FAN), 0, boxes((3.0, 0.0, 1.0), size_m=4.0), NOTHING, most=11)
    assert every.points.tolist() == [len(LEVEL)] and some.thinned == 2
    assert len(some.places_m) == 11 and some.points.tolist() == [22]


def test_a_frame_without_boxes_and_a_rig_without_lidars_are_empty() -> None:
    assert not frame_scene(Rig(), 0, boxes((3.0, 0.0, 1.0)), NOTHING).points.any()
    assert not len(frame_scene(rig_of(FAN), 0, FrameBoxes.none(), NOTHING).points)


def test_nobody_is_seen_without_lidars() -> None:
    assert why_missed(Rig(), boxes((3.0, 0.0, 1.0)), 0, NOTHING, 5).verdict == "no LiDARs"


def test_beyond_the_range_is_out_of_range() -> None:
    near: Lidar = FAN.replace(range_m=(0.0, 10.0))
    assert why_missed(rig_of(near), boxes((21.0, 0.0, 1.0)), 0, NOTHING, 5).verdict == "out of range"


def test_behind_another_road_user_is_hidden_by_it() -> None:
    found = why_missed(rig_of(FAN), boxes((41.0, 0.0, 1.0), (11.0, 0.0, 1.0)), 0, NOTHING, 3)
    assert (found.verdict, found.by, found.points) == ("hidden", 1, 0)
    assert found.alone == rays_that_meet(40.0, 1.0)


def test_behind_the_own_body_is_hidden_by_it() -> None:
    found = why_missed(rig_of(FAN), boxes((21.0, 0.0, 1.0)), 0, plate(1.0), 3)
    assert (found.verdict, found.by) == ("hidden", BODY)


def test_a_road_user_between_the_beams_is_told_so() -> None:
    found = why_missed(rig_of(FAN), boxes((21.0, 0.0, 3.0)), 0, NOTHING, 1)
    assert (found.verdict, found.alone, found.by) == ("between beams", 0, None)


def test_the_ground_hides_what_stands_below_it() -> None:
    down = lidar((0.0, 0.0, 1.0), elevations=[-10.0], azimuths=LEVEL)
    found = why_missed(rig_of(down), boxes((11.0, 0.0, -1.5)), 0, NOTHING, 3)
    assert (found.verdict, found.by) == ("hidden", GROUND)
