"""Cases small enough for a pencil."""

import hashlib
import math
from dataclasses import replace

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.kernels.objects.counts import COLUMNS
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import LinearAngles, Rig, Sensor
from riglens.core.targets.beams import azimuth_step_rad
from riglens.core.targets.contribution import Contribution, phases_rad
from riglens.core.targets.counts import Counted
from riglens.core.targets.draws import sensor_key
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.groups import standard_error
from riglens.core.targets.range_law import anchors_of, law_of, range_for
from riglens.core.targets.settings import EXACT, TargetSettings
from riglens.core.targets.shapes import (
    GLASS_PASSES,
    GLASS_RETURNS,
    LOW_M,
    REFLECTIVITY,
    TALL_M,
    WIDTH,
)
from riglens.core.targets.traffic import NO_CLASS
from tests.core.builders import camera, lidar, rig_of, spinning
from tests.core.targets.cases import Box, parts, traffic
from tests.core.targets.parts import parts_of

CAR, BICYCLE, PEDESTRIAN = 0, 1, 2
CUBE_M = (2.0, 2.0, 2.0)


def count(boxes: list[Box], *sensors: Sensor, settings: TargetSettings = EXACT) -> Counted:
    frames = max((box[0] for box in boxes), default=0) + 1
    return TargetEngine(traffic(boxes, frames)).evaluate(rig_of(*sensors), settings)


def box(x: float, y: float = 0.0, size=CUBE_M, yaw: float = 0.0, frame: int = 0, z: float = 1.0) -> Box:
    return (frame, CAR, (x, y, z), size, yaw)


def points(boxes: list[Box], *sensors: Sensor) -> list[int]:
    return count(boxes, *sensors).objects.all_points.tolist()


ONE_RAY = lidar((0.0, 0.0, 1.0))
"""Straight ahead, one metre above the ground."""


def test_contributions_of_frames_that_follow_keep_their_cells() -> None:
    one = Contribution(1, np.zeros((COLUMNS, 2), np.int32), np.array([1, 0]), np.array([7, 8, 9]))
    more = Contribution(2, np.ones((COLUMNS, 1), np.int32), np.array([0]), np.array([5, 6]))
    both = one.joined(more)
    assert (both.frames, both.found[0].tolist()) == (3, [0, 0, 1])
    assert both.cell_starts.tolist() == [1, 0, 3] and both.cells.tolist() == [7, 8, 9, 5, 6]


def test_draws_depend_on_the_seed_and_on_the_sensor() -> None:
    assert len({sensor_key(seed, name) for seed in (0, 1) for name in ("a", "b")}) == 4
    assert sensor_key(1, "a") == int.from_bytes(hashlib.sha256(b"1 a").digest()[:8], "little")


def test_phases_are_drawn_within_a_step_or_none() -> None:
    turning, frames = spinning((0.0, 0.0, 1.9)), np.arange(50)
    drawn = phases_rad(turning, TargetSettings(phase="random"), frames)
    assert 0.0 < drawn.min() < drawn.max() < azimuth_step_rad(turning)
    assert not phases_rad(turning, TargetSettings(phase="0"), frames).any()
    assert not phases_rad(camera((0.0, 0.0, 1.0)), TargetSettings(phase="random"), frames).any()


def test_bounds_of_cars_change_with_their_height_without_a_step() -> None:
    heights = np.linspace(1.2, 3.6, 2401)
    sizes = np.column_stack([np.full_like(heights, 4.5), np.full_like(heights, 1.9), heights])
    parts = parts_of("class", np.full(len(heights), CAR, np.uint8), sizes)
    assert (np.diff(parts.starts) == 3).all() and parts.is_glass[:3].tolist() == [False, True, False]
    for bounds in (parts.offset_m, parts.half_m):
        assert np.abs(np.diff(bounds.reshape(-1, 3, 3), axis=0)).max() < 0.005
    cabin = parts.half_m[1::3, 0]
    assert np.ptp(cabin[heights <= LOW_M]) == 0.0 and np.ptp(cabin[heights >= TALL_M]) == 0.0
    assert (np.diff(cabin[(heights > LOW_M) & (heights < TALL_M)]) > 0.0).all()


def test_a_bicycle_is_lower_without_its_rider() -> None:
    parts = parts_of("class", np.full(2, BICYCLE, np.uint8), np.array([[1.8, 0.6, 1.1], [1.8, 0.6, 1.7]]))
    tops = ((parts.offset_m + parts.half_m)[:, 2] / [0.55, 0.55, 0.85, 0.85]).reshape(2, 2)
    assert tops.max(axis=1) == pytest.approx([0.8, 0.9])


def test_the_first_box_takes_the_ray_whatever_the_order_in_the_data():
    assert points([box(10.0), box(20.0)], ONE_RAY) == [1, 0]
    assert points([box(20.0), box(10.0)], ONE_RAY) == [0, 1]


def test_alone_counts_what_the_ray_would_meet_without_the_others():
    found = count([box(20.0), box(10.0)], ONE_RAY).objects
    assert found.points_alone.tolist() == [1, 1]


def test_a_wall_of_columns_at_a_distance():
    """Rays at 0, 5, ... 45 degrees: a face 9 m away that reaches 4 m to the left is hit up to atan(4 / 9) = 24 deg."""
    wall = box(10.0, 2.0, (2.0, 4.0, 2.0))
    rays = lidar((0.0, 0.0, 1.0), azimuths=[5.0 * k + 1.0 for k in range(10)])
    assert points([wall], rays) == [sum(math.tan(math.radians(5.0 * k + 1.0)) * 9.0 < 4.0 for k in range(10))]


def test_running_along_a_face_or_an_edge_is_not_entering():
    assert points([box(10.0, 1.0)], ONE_RAY) == [0]
    assert points([box(10.0, 1.0, z=0.0), box(20.0)], ONE_RAY) == [0, 1]


def test_boxes_entered_at_the_same_distance_count_for_the_earlier_one():
    assert points([box(10.0), box(10.0, size=(2.0, 4.0, 2.0))], ONE_RAY) == [1, 0]


def test_two_boxes_that_share_a_face_hide_each_other():
    assert points([box(12.0), box(10.0)], ONE_RAY) == [0, 1]


def test_the_box_around_the_sensor_does_not_count_and_hides_nothing():
    assert points([box(0.0, size=(4.0, 2.0, 2.0)), box(10.0)], ONE_RAY) == [0, 1]


def test_a_ray_begins_at_the_minimum_and_ends_at_the_maximum_of_its_range():
    reach = lidar((0.0, 0.0, 1.0), range_m=(8.0, 20.0))
    assert points([box(5.0), box(15.0)], reach) == [0, 1]  # 4..6 m: over before the range begins
    assert points([box(8.0)], reach) == [1]  # 7..9 m: the ray begins inside
    assert points([box(21.5)], reach) == [0]
    assert points([box(20.5)], reach) == [1]


def test_far_boxes_hide_but_do_not_count():
    scores = count([box(70.0), box(61.5, size=(4.0, 2.0, 2.0)), box(59.0, 30.0)], ONE_RAY)
    assert scores.objects.all_points.tolist() == [] and parts(scores)["car"].total.objects == 0
    # its front face is before that of the object that counts
    long = (20.0, 2.0, 2.0)
    assert points([box(61.0, size=long), box(59.0)], ONE_RAY) == [0]


def test_cells_are_counted_once_for_all_lidars_and_hits():
    rays = lidar((0.0, 0.0, 1.0), azimuths=[0.1, 0.2, 5.0])
    # at 9 m: y = 0.016, 0.031, 0.787 m, all at z = 0: cells 0 and 3 across
    both = count([box(10.0)], rays, rays).objects
    assert (both.all_points.tolist(), both.cells.tolist()) == ([6], [2])
    assert count([box(10.0)], rays).objects.cells.tolist() == [2]


def test_a_cell_is_that_of_the_point_a_millimetre_inside():
    """Two rays 0.1 mm apart on the two sides of a border between cells; then both a little further to the left."""
    for aside_mm, cells in ((0.0, 2), (0.2, 1)):
        y = [(aside_mm - 0.1) * 1e-3, (aside_mm + 0.1) * 1e-3]
        rays = [lidar((0.0, at, 1.05)) for at in y]
        assert count([box(10.0)], *rays).objects.cells.tolist() == [cells]


def test_what_does_not_count_changes_nothing_of_what_does():
    """A thing between two cars in distance that hides neither of them."""
    near, far, thing = box(8.0), box(-20.0), (0, NO_CLASS, (0.0, 14.0, 1.0), CUBE_M, 0.0)
    sensors = (
        spinning((0.0, 0.0, 1.0), beams=16, count=360),
        camera((0.0, 0.0, 1.0)),
        camera((0.0, 0.0, 1.0), (0.0, 0.0, 90.0)),
    )
    alone, beside = (count(boxes, *sensors).objects for boxes in ([near, far], [near, far, thing]))
    assert beside.all_points.tolist() == alone.all_points.tolist() and (alone.all_points > 0).all()
    assert beside.pixels.tolist() == alone.pixels.tolist() and alone.pixels.sum() > 0.0
    assert beside.cells.tolist() == alone.cells.tolist()


def test_on_target_is_the_mean_over_objects():
    scores = count([box(10.0), box(20.0)], ONE_RAY)
    assert parts(scores)["car"].total.on_target.value == pytest.approx(
        (1.0 - math.exp(-1 / 5)) / 2, abs=1e-15
    )
    assert parts(scores)["pedestrian"].total.objects == 0


def test_native_pixels_height_and_visible_share_of_a_camera():
    """90 degrees, 1600 x 800 pixels, 160 x 80 rays: 10 native pixels each way; a face 2 m x 2 m 8 m away is 200 px."""
    view = camera((0.0, 0.0, 1.0), cast=(160, 80), hfov_deg=90.0).replace(image=(1600, 800))
    alone = count([box(9.0)], view).objects
    assert (alone.pixels[0, 0], alone.height_px[0], alone.visible[0]) == (40_000.0, 200.0, 1.0)
    hidden = count([box(9.0), box(4.0, -0.5, (2.0, 1.0, 4.0), 0.0)], view).objects  # its right half
    assert (hidden.pixels[0, 0], hidden.height_px[0], hidden.visible[0]) == (20_000.0, 200.0, 0.5)


def test_rings_and_thresholds():
    boxes = [box(10.0), box(9.0, frame=1), box(30.0, frame=2), box(60.0, frame=3)]
    scores = count(
        boxes, lidar((0.0, 0.0, 1.0), azimuths=[0.0, 0.5, -0.5]), settings=replace(EXACT, min_points=3)
    )
    rings = parts(scores)["car"].rings
    assert [ring.objects for ring in rings] == [1, 1, 0, 1, 0, 1]
    assert rings[0].share_min_points.value == rings[0].share_1.value == 1.0 and rings[0].share_5.value == 0.0


def test_nothing_at_all():
    scores = TargetEngine(traffic([], 3)).evaluate(Rig())
    assert scores.frames_used == 3 and parts(scores)["car"].total.on_target.value == 0.0
    assert parts(TargetEngine(traffic([box(10.0)])).evaluate(Rig()))["car"].total.missed.value == 1.0
    full = TargetEngine(traffic([], 3)).evaluate(rig_of(spinning((0.0, 0.0, 2.0)), camera((0.0, 0.0, 2.0))))
    assert full.objects.points.shape == (0, 1)


def test_a_box_around_the_car_and_one_inside_it():
    around, inside = box(0.0, size=(8.0, 8.0, 8.0)), box(1.5, size=(0.5, 0.5, 0.5))
    assert points([around, inside], ONE_RAY) == [0, 1]


def test_very_far_and_very_large():
    far = traffic([box(1e6, size=(1e3, 1e3, 1e3))]).within(1e6)
    assert TargetEngine(far).evaluate(rig_of(ONE_RAY), EXACT).objects.points.tolist() == [[1]]


def test_bad_settings_say_what_is_accepted():
    with pytest.raises(InputError, match=r"^within_m must be above 0"):
        traffic([box(1.0)]).within(-1.0)
    with pytest.raises(InputError, match=r"^min_points must be"):
        TargetSettings(min_points=0)
    with pytest.raises(InputError, match=r"^seed must be an integer"):
        TargetSettings(seed=-1)


def test_a_single_azimuth_has_no_phase_and_a_sector_shifts_by_less_than_a_step():
    from riglens.core.targets.contribution import phases_rad

    frames = np.arange(1000)
    assert not phases_rad(lidar(), TargetSettings(), frames).any()
    sector = lidar().replace(azimuths_deg=LinearAngles(from_=-60.0, to=60.0, count=60))
    phases = phases_rad(sector, TargetSettings(), frames)
    assert phases.min() >= 0.0 and phases.max() < math.radians(2.0)
    assert np.histogram(phases, 4, (0.0, math.radians(2.0)))[0].min() > 200


GLASS_AT = 1.45 * 0.8
"""Height of the side windows of a car 1.45 m tall."""


def test_glass_of_a_car_returns_nothing_but_hides_and_a_ray_passes_below():
    car = (0, CAR, (10.0, 0.0, 0.725), (4.5, 1.8, 1.45), 0.0)
    behind = (0, PEDESTRIAN, (20.0, 0.0, 0.9), (0.7, 0.7, 1.8), 0.0)
    rays = [lidar((0.0, 0.0, z)) for z in (0.1, 0.5, GLASS_AT, 1.7)]
    found = count([car, behind], *rays, settings=replace(EXACT, shape="class")).objects
    assert found.points.tolist() == [[0, 1, 0, 0], [1, 0, 0, 1]]
    view = camera((0.0, 0.0, GLASS_AT), cast=(1, 1), hfov_deg=1.0).replace(image=(1, 1))
    seen = count([car, behind], view, settings=replace(EXACT, shape="class")).objects
    assert seen.pixels[:, 0].tolist() == [1.0, 0.0]


def test_some_rays_return_from_glass_and_some_pass_through_it():
    """A bus and, behind its windows, a pedestrian, both as large as needed."""
    bus = (0, CAR, (10.0, 0.0, 0.0), (2.0, 20.0, 100.0), 0.0)
    behind = (0, PEDESTRIAN, (30.0, 0.0, 20.0), (0.5, 100.0, 5.0), 0.0)
    rays = lidar((0.0, 0.0, 20.0), azimuths=np.linspace(-20.0, 20.0, 4000))
    found = count([bus, behind], rays, settings=TargetSettings(phase="0")).objects.all_points / 4000.0
    assert found.tolist() == pytest.approx([GLASS_RETURNS, GLASS_PASSES], abs=0.015)
    assert not count([bus, behind], rays, settings=replace(EXACT, shape="class")).objects.all_points.any()


def test_parts_stand_in_their_boxes_and_boxes_of_no_class_are_whole():
    rng = np.random.default_rng(0)
    cls, size = rng.integers(0, 4, 500).astype(np.uint8), rng.uniform(0.3, 4.0, (500, 3))
    parts = parts_of("class", cls, size)
    assert (np.abs(parts.offset_m) + parts.half_m <= size[parts.box] / 2.0 + 1e-12).all()
    other = np.flatnonzero(cls == 3)
    assert (np.diff(parts.starts)[other] == 1).all()
    np.testing.assert_array_equal(parts.half_m[parts.starts[other]], size[other] / 2.0)


def test_the_range_law_takes_half_of_the_rays_at_its_range_and_fewer_at_a_slant():
    """A large wall at the range of its class: half of the rays that meet it squarely come back."""
    rays = lidar(
        (0.0, 0.0, 0.0),
        elevations=np.linspace(-2, 2, 60),
        azimuths=np.linspace(-2, 2, 60),
        range_m=(0.0, 100.0),
    )
    reach = 100.0 * math.sqrt(REFLECTIVITY[CAR] / 0.8)
    law = replace(EXACT, range_law=True)
    shares = []
    for distance, yaw in ((0.5 * reach, 0.0), (reach, 0.0), (reach, math.radians(60.0)), (2.2 * reach, 0.0)):
        wall = (0, CAR, (distance + 0.005, 0.0, 0.0), (0.01, 60.0, 60.0), yaw)
        found = TargetEngine(traffic([wall]).within(1e3)).evaluate(rig_of(rays), law).objects
        shares.append(found.all_points[0] / found.points_alone[0])
    assert shares[0] == pytest.approx(1.0 / (1.0 + math.exp(-0.5 / WIDTH)), abs=0.03)
    assert shares[1] == pytest.approx(0.5, abs=0.04) and shares[3] < 0.03
    slant = 1.0 / (1.0 + math.exp((1.0 / math.sqrt(0.5) - 1.0) / WIDTH))
    assert shares[2] == pytest.approx(slant, abs=0.04)


def test_where_ranges_come_from():
    gen1 = sensor_from_model("ouster-os1-64", "L", Pose())
    assert anchors_of(gen1) == ((0.1, 40.0), (0.8, 120.0))
    assert range_for(0.1, anchors_of(gen1)) == 40.0
    rev7, at_90 = sensor_from_model("ouster-os1-128-rev7", "a", Pose()), (1.0 - 0.08 * math.log(9.0))
    assert anchors_of(rev7) == ((0.1, 90.0 / at_90), (0.8, 170.0 / at_90))
    rev6 = sensor_from_model("ouster-os1-128", "a", Pose())  # 45 m and 100 m with 90 %
    stated = [metres * at_90 for _, metres in anchors_of(rev6)]
    assert stated == pytest.approx([45.0, 100.0], rel=0.02)
    assert range_for(0.2, anchors_of(gen1)) == pytest.approx(40.0 * math.sqrt(2.0))
    assert range_for(0.4, anchors_of(gen1)) == pytest.approx(120.0 * math.sqrt(0.5))
    assert anchors_of(lidar(range_m=(0.0, 90.0))) == ((0.8, 90.0),)
    assert anchors_of(lidar()) == () and law_of(lidar(), TargetSettings()).size == 0
    assert law_of(camera((0.0, 0.0, 1.0)), TargetSettings()).size == 0


def test_errors_of_a_sample_are_those_of_a_ratio_over_frames() -> None:
    misses = np.array([[1.0, 0.0], [-1.0, 0.5], [2.0, -0.5]])  # three of ten frames
    by_hand = [math.sqrt(6.0 / 2 * 0.7 * 3) / 5, math.sqrt(0.5 / 2 * 0.7 * 3) / 4]
    np.testing.assert_allclose(standard_error(misses, [5, 4], 10), by_hand, rtol=1e-15)
    assert standard_error(misses, [5, 4], 3).tolist() == [0.0, 0.0]
    assert standard_error(misses[:1], [5, 4], 10).tolist() == [0.0, 0.0], "one frame says nothing"
