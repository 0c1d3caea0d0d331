"""The detection range of a rig, against what can be worked out with a pencil."""

import math

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets import detection_range_making as module
from riglens.core.targets.detection_range import SIZES_M, Case, RangePlan, Reach, around
from riglens.core.targets.detection_range_making import (
    _poses,
    detection_range_of,
    heights_px,
    lattice_steps_deg,
    reach_of,
)
from riglens.core.targets.detection_range_table import range_document, range_lines
from riglens.core.targets.detection_range_text import bearing_text
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import EXACT
from riglens.core.vehicle.solid import Solid
from tests.core.builders import rig_of, spinning
from tests.core.targets.cases import traffic as traffic_with
from tests.core.vehicle.solids import plate

AHEAD = RangePlan(bearings_deg=(0.0,), to_m=60.0).with_body("ignored")


def rows(ranges):
    return {(row.cls, row.heading_deg, row.bearing_deg): row for row in ranges.rows}


def one_beam(height_m, step_deg, **more):
    """A single level beam all around, so that rows of points are columns of azimuths."""
    count = round(360 / step_deg)
    azimuths = LinearAngles.model_validate({"from": -180.0, "to": 180.0, "count": count})
    return Lidar(
        name="L", position=(0.0, 0.0, height_m), elevations_deg=(0.0,), azimuths_deg=azimuths, **more
    )


@pytest.mark.parametrize(("cls", "heading_deg", "across_m", "along_m"), [
    ("car", 90.0, 4.6, 1.86), ("car", 0.0, 1.86, 4.6), ("pedestrian", 0.0, 0.6, 0.5),
])  # fmt: skip
def test_one_level_beam_on_a_plate(cls, heading_deg, across_m, along_m):
    """The near face, w wide at d - l / 2, takes the azimuths within 2 atan(w / 2(d - l / 2)): n of them at every place
    in the lattice while the angle is at least n steps, and never more than n - 1 below n - 1 steps."""
    step_deg, n = 0.5, 5
    row = rows(detection_range_of(rig_of(one_beam(1.0, step_deg)), AHEAD))[cls, heading_deg, 0.0]
    distances = AHEAD.distances_m()
    angle_deg = np.degrees(2 * np.arctan(across_m / 2 / (distances - along_m / 2)))
    sure = distances[angle_deg >= n * step_deg * (1 + 1e-9)]
    never = distances[angle_deg < (n - 1) * step_deg * (1 - 1e-9)]
    assert row.lidar.least_m > sure.max()
    assert row.lidar.most_m <= (never.min() if never.size else math.inf)
    assert row.lidar.least_m <= row.lidar.median_m <= row.lidar.most_m


def test_a_beam_over_the_roof_never_meets_a_road_user():
    ranges = detection_range_of(rig_of(one_beam(1.9, 0.5)), AHEAD)
    assert {row.lidar for row in ranges.rows} == {Reach(0.0, 0.0, 0.0, 0.0)}
    assert all(ranges.stops_from_kmh(row, row.lidar) == 0.0 for row in ranges.rows)


def test_a_range_limit_ends_the_detection_range():
    """The near face of a car end on lies 2.3 m before its centre; hits end where that is beyond 20 m."""
    row = rows(detection_range_of(rig_of(one_beam(1.0, 0.05, range_m=(0.0, 20.0))), AHEAD))["car", 0.0, 0.0]
    assert row.lidar.least_m == row.lidar.most_m == 23.0


def test_what_is_never_lost_is_beyond_all_that_was_tried():
    row = rows(detection_range_of(rig_of(one_beam(1.0, 0.05)), AHEAD))["car", 90.0, 0.0]
    assert row.lidar == Reach(math.inf, math.inf, math.inf, 5.0)
    assert detection_range_of(rig_of(one_beam(1.0, 0.05)), AHEAD).stops_from_kmh(row, row.lidar) == math.inf


def test_the_gap_between_beams_is_luck():
    """Two beams 4 deg apart around the horizon, seen from 1 m up: a pedestrian of 1.72 m meets one for sure while it
    spans 4 deg, at 24 m or less; with luck it keeps one up to the last distance at which its width has 5 azimuths."""
    lidar = one_beam(1.0, 0.1).model_copy(update={"elevations_deg": (-2.0, 2.0)})
    ranges = detection_range_of(rig_of(lidar), AHEAD)
    reach = rows(ranges)["pedestrian", 0.0, 0.0].lidar
    assert ranges.gap_deg == 4.0
    spans_m = 1.72 / math.tan(math.radians(4.0))
    assert spans_m - 1.0 <= reach.least_m <= spans_m * (1 + 1 / module.RISES) + 1.0
    assert reach.most_m > 1.8 * reach.least_m


@pytest.mark.parametrize("bearing", [0.0, 30.0, 90.0, 180.0, -120.0])
def test_counts_are_those_of_the_engine_at_every_place(bearing, monkeypatch):
    """The worst place, from the engine asked road user by road user."""
    monkeypatch.setattr(module, "RISES", 3)
    plan = RangePlan(bearings_deg=(bearing,), to_m=30.0, min_points=7).with_body("ignored")
    rig = rig_of(
        spinning((0.3, -0.2, 1.7), beams=9, count=300),
    )
    ranges = detection_range_of(rig, plan)
    gap_deg, step_deg = lattice_steps_deg(rig.enabled_lidars())
    for row in ranges.rows[:3]:
        first = []
        for turn in (0.25, 0.75):
            for rise in (1 / 6, 1 / 2, 5 / 6):
                case = Case(row.cls, row.heading_deg, bearing)
                place = _poses(plan, case, turn * step_deg, (rise - 0.5) * gap_deg)
                counts = []
                for centre, yaw in zip(place.centre_m, place.yaw_rad, strict=True):
                    box = (0, CLASSES.index(row.cls), tuple(centre), SIZES_M[row.cls], float(yaw))
                    found = TargetEngine(traffic_with([box])).evaluate(rig, EXACT).objects
                    counts.append(int(found.all_points[0]))
                first.append(reach_of(plan.distances_m(), np.array([counts]) >= 7).least_m)
        assert (row.lidar.least_m, row.lidar.most_m) == (min(first), max(first))


def test_a_camera_sees_height_over_distance():
    """f h / d for a level pinhole: 1000 px, a car 1.52 m tall whose near face is d - 2.3 away."""
    camera = Camera(
        name="C", position=(0.0, 0.0, 0.76), image=(1000, 1000), hfov_deg=2 * math.degrees(math.atan(0.5))
    )
    heights = heights_px([camera], _poses(AHEAD, Case("car", 0.0, 0.0)), SIZES_M["car"])
    distances = AHEAD.distances_m()
    np.testing.assert_allclose(heights, 1000 * 1.52 / (distances - 2.3), rtol=1e-9)
    plan = RangePlan(min_height_px=40.0, bearings_deg=(0.0, 180.0), to_m=60.0).with_body("ignored")
    row = rows(detection_range_of(rig_of(camera), plan))["car", 0.0, 0.0]
    assert row.camera.least_m == distances[1000 * 1.52 / (distances - 2.3) < 40.0][0] == 41.0
    behind = heights_px([camera], _poses(AHEAD, Case("car", 0.0, 180.0)), SIZES_M["car"])
    assert not behind.any()


@pytest.mark.parametrize("roll_deg", [0.0, 180.0])
def test_a_camera_sees_what_the_own_car_leaves(roll_deg):
    """A wall a metre ahead, up to just below the camera: the upper half of the road user is left, to the pixel."""
    camera = Camera(
        name="C", position=(0.0, 0.0, 0.76), rpy_deg=(roll_deg, 0.0, 0.0), image=(1000, 1000),
        hfov_deg=2 * math.degrees(math.atan(0.5)),
    )  # fmt: skip
    poses, size = _poses(AHEAD, Case("car", 0.0, 0.0)), SIZES_M["car"]
    whole = heights_px([camera], poses, size)
    for top_m, left in ((-9.0, 1.0), (0.7599, 0.5), (9.0, 0.0)):
        wall = plate(1.0)
        wall[..., 2] = np.where(wall[..., 2] > 0.0, top_m, -50.0)
        np.testing.assert_allclose(heights_px([camera], poses, size, Solid.of(wall)), left * whole, rtol=1e-9)
    np.testing.assert_array_equal(heights_px([camera], poses, size, Solid.of(np.zeros((0, 3, 3)))), whole)


def test_the_solid_car_shortens_the_detection_range_of_a_sensor_at_its_side_and_of_none_high_above():
    plan = RangePlan(bearings_deg=(90.0, -90.0), to_m=12.0).with_body("ignored")
    blocks = plan.with_body("blocks")
    camera = Camera(
        name="C", position=(0.0, 1.0, 0.9), rpy_deg=(0.0, 0.0, -90.0), hfov_deg=90.0, cast=(352, 128)
    )
    low = rig_of(spinning((0.0, 1.0, 0.9), beams=9, count=90), camera)
    free, cut = (rows(detection_range_of(low, each, threads=1)) for each in (plan, blocks))
    assert cut["pedestrian", 0.0, 90.0] == free["pedestrian", 0.0, 90.0]
    right = cut["pedestrian", 0.0, -90.0]
    assert right.lidar.most_m == right.camera.most_m == 0.0 < free["pedestrian", 0.0, -90.0].camera.least_m
    high = rig_of(spinning((0.0, 0.0, 4.0), beams=9, count=90))
    assert detection_range_of(high, plan, threads=1).rows == detection_range_of(high, blocks, threads=1).rows


def test_a_picture_is_cut_at_the_edge_of_the_image():
    camera = Camera(name="C", position=(0.0, 0.0, 0.76), image=(1000, 20), cast=(50, 10), hfov_deg=53.0)
    assert heights_px([camera], _poses(AHEAD, Case("car", 0.0, 0.0)), SIZES_M["car"]).max() == 20.0


def test_directions_lie_evenly_around_the_car():
    texts = [bearing_text(bearing) for bearing in around(8)]
    assert texts == ["ahead", "45° left", "left", "135° left", "behind", "135° right", "right", "45° right"]
    assert bearing_text(-180.0) == "behind"
    assert around(8) == (0.0, 45.0, 90.0, 135.0, 180.0, -135.0, -90.0, -45.0) == RangePlan().bearings_deg
    assert around(1) == (0.0,)


def test_stopping_distances():
    plan = RangePlan(reaction_s=1.5, deceleration_mps2=4.0)
    assert plan.stopping_m(72.0) == pytest.approx(20.0 * 1.5 + 400.0 / 8.0)
    assert plan.stops_from_kmh(plan.stopping_m(72.0)) == pytest.approx(72.0)
    assert plan.stops_from_kmh(-1.0) == 0.0
    ranges = detection_range_of(rig_of(one_beam(1.0, 0.5)), AHEAD)
    row = rows(ranges)["car", 0.0, 0.0]
    way_m = row.lidar.least_m - 4.6 / 2 - 4.6 / 2
    assert ranges.stops_from_kmh(row, row.lidar) == pytest.approx(AHEAD.stops_from_kmh(way_m))


def test_far_away_is_not_found_again():
    enough = np.array([[False, True, True, False, True], [False] * 5, [True] * 5])
    reach = reach_of(np.array([2.0, 3.0, 4.0, 5.0, 6.0]), enough)
    assert reach == Reach(0.0, 5.0, math.inf, 3.0)
    assert reach_of(np.array([2.0, 3.0]), np.zeros((4, 2), np.bool_)) == Reach(0.0, 0.0, 0.0, 0.0)


def test_threads_and_a_rig_without_sensors_change_nothing():
    plan = RangePlan(bearings_deg=(0.0, 90.0), to_m=20.0)
    rig = rig_of(spinning((0.0, 0.0, 2.0)), Camera(name="C", position=(0.0, 0.0, 1.0), hfov_deg=90.0))
    ranges = [
        detection_range_of(rig, plan, threads=1),
        detection_range_of(rig, plan, threads=3),
    ]
    assert ranges[0].rows == ranges[1].rows
    empty = detection_range_of(Rig(), plan)
    assert all(row.lidar.most_m == row.camera.most_m == 0.0 for row in empty.rows) and empty.gap_deg == 0.0


class Enough(Exception):
    """Raised to cancel."""


@pytest.mark.parametrize(
    "sensors", [(spinning((0.0, 0.0, 2.0)),), (Camera(name="C", position=(0.0, 0.0, 1.0), hfov_deg=90.0),)]
)
def test_progress_goes_up_to_one_and_what_it_raises_ends_the_work(sensors):
    plan, told = RangePlan(bearings_deg=(0.0, 90.0), to_m=8.0), []
    detection_range_of(Rig(sensors=sensors), plan, 1, told.append)
    assert (
        told == sorted(told) and (told[0], told[-1]) == (0.0, 1.0) and len(set(told)) == len(plan.cases()) + 1
    )

    def stop(share):
        if share > 0.0:
            raise Enough

    with pytest.raises(Enough):
        detection_range_of(Rig(sensors=sensors), plan, 1, stop)


def test_plain_data_say_what_is_unknown():
    ranges = detection_range_of(rig_of(one_beam(1.0, 0.05)), AHEAD)
    row = range_document(ranges)["rigs"][0]["rows"][1]
    assert (row["class"], row["heading_deg"], row["bearing_deg"]) == ("car", 90.0, 0.0)
    assert row["lidar"]["first_below_m"] == {"min": None, "median": None, "max": None}
    assert row["lidar"]["enough_from_m"] == 5.0 and row["lidar"]["stops_from_kmh"] is None
    assert row["camera"] == {
        "enough_from_m": None, "first_below_m": {"min": 0.0, "median": 0.0, "max": 0.0}, "stops_from_kmh": 0.0,
    }  # fmt: skip
    line = range_lines(ranges)[2]
    assert (line["kind"], line["heading_deg"], line["first_below_min_m"]) == ("lidar", 90.0, "")


@pytest.mark.parametrize("wrong", [
    {"min_points": 0}, {"min_height_px": 0.0}, {"bearings_deg": ()}, {"bearings_deg": (math.nan,)}, {"to_m": 1e9},
    {"deceleration_mps2": 0.0}, {"reaction_s": -1.0}, {"speeds_kmh": (0.0,)}, {"bearings_deg": (0.0,) * 100},
])  # fmt: skip
def test_numbers_out_of_range_are_refused(wrong):
    with pytest.raises(InputError, match="must be"):
        RangePlan(**wrong)
