"""The accuracy study: which way the approximations err, thinner lattices, the Pareto front, the figures."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from riglens.core.errors import InputError
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.columns import unpack
from riglens.core.sensing.rays import sensor_rays
from riglens.core.study import accuracy_cases
from riglens.core.study.accuracy import (
    AccuracyStudy,
    Point,
    ScoreError,
    Wrong,
    pareto_front,
    study_accuracy,
    wrong_voxels,
)
from riglens.core.study.accuracy_cases import (
    Answer,
    Case,
    has_all_pixels,
    plain_case,
    timed,
    voxel_case,
    with_lattice,
)
from riglens.core.study.simple_methods import VoxelTests
from tests.core.builders import camera, evaluate, field_of, grid_of, random_field, rig_of, spinning
from tests.core.study.small_studies import QUICK, small_accuracy_study

GRID = grid_of(24, 20, 10)
CAMERA_BIT, LIDAR_BIT = 1, 2

positions = st.tuples(st.floats(-14.0, 14.0), st.floats(-12.0, 12.0), st.floats(-2.0, 12.0)).map(
    lambda place: tuple(round(p, 6) for p in place)  # the shortcuts are not made for distances of 1e-129 m
)
whole_positions = st.tuples(st.integers(-12, 12), st.integers(-10, 10), st.integers(0, 10))
angles = st.floats(-180.0, 180.0) | st.sampled_from([0.0, 45.0, 90.0, -90.0, 180.0])
rpy = st.tuples(st.just(0.0) | angles, st.just(0.0) | angles, angles)
ranges = st.just((0.0, float("inf"))) | st.tuples(st.floats(0.0, 4.0), st.floats(5.0, 15.0))
cameras = st.builds(
    camera,
    positions | whole_positions,
    rpy,
    st.tuples(st.integers(1, 12), st.integers(1, 9)),
    st.floats(20.0, 150.0),
    ranges,
)
turns = st.builds(
    lambda start, width, count: LinearAngles(from_=start, to=start + width, count=count),
    st.floats(-180.0, 0.0),
    st.floats(1.0, 360.0),
    st.integers(1, 30),
)
elevations = st.lists(st.floats(-90.0, 90.0), min_size=1, max_size=6).map(tuple)
lidars = st.builds(
    lambda position, angles_deg, range_m, beams, turn: Lidar(
        name="L",
        position=tuple(map(float, position)),
        rpy_deg=angles_deg,
        range_m=range_m,
        elevations_deg=beams,
        azimuths_deg=turn,
    ),
    positions | whole_positions,
    rpy,
    ranges,
    elevations,
    turns,
)
FIELD = field_of(GRID)


def exact_flags(field, rig):
    """Bits of the informative voxels that the exact engine finds."""
    result = evaluate(field, rig, threads=1)
    i, j, k = field.index.ijk().T
    cameras_see, lidars_see = (
        unpack(field.grid, w)[i, j, k] for w in (result.seen["camera"], result.seen["lidar"])
    )
    return CAMERA_BIT * cameras_see.astype(np.uint8) + LIDAR_BIT * lidars_see.astype(np.uint8)


@settings(max_examples=25)
@given(cameras | lidars)
def test_bounding_rectangles_never_miss_a_voxel(sensor):
    rig = rig_of(sensor)
    found = VoxelTests(FIELD, 1).bounding_rectangles(rig)
    assert not (exact_flags(FIELD, rig) & ~found).any()


@pytest.mark.parametrize("sensor", [camera((0.0, 0.0, 5.0), (0.0, 0.0, 30.0)), spinning((0.3, 0.2, 4.6))])
def test_bounding_rectangles_add_voxels_that_no_ray_meets(sensor):
    rig = rig_of(sensor)
    wrong = wrong_voxels(exact_flags(FIELD, rig), VoxelTests(FIELD, 1).bounding_rectangles(rig))
    assert wrong.missed == 0.0 < wrong.extra


def in_image(seen: Camera, points):
    """Whether points of the sensor's frame lie in its native image, by the pinhole formula."""
    fx_px, fy_px, cx_px, cy_px = seen.intrinsics_px()
    ahead = points[:, 0] > 0.0
    w = cx_px - fx_px * points[:, 1] / np.where(ahead, points[:, 0], 1.0)
    h = cy_px - fy_px * points[:, 2] / np.where(ahead, points[:, 0], 1.0)
    return ahead & (w >= 0) & (w <= seen.image[0]) & (h >= 0) & (h <= seen.image[1])


def in_beams(seen: Lidar, points):
    """Whether points of the sensor's frame lie between its outer beams, by their elevation."""
    elevation_deg = np.degrees(np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1])))
    return (elevation_deg >= seen.elevations().min()) & (elevation_deg <= seen.elevations().max())


@pytest.mark.parametrize(
    "sensor, in_view",
    [
        (camera((0.31, 0.17, 5.23), (3.0, -7.0, 30.0)), in_image),
        (spinning((0.31, 0.17, 4.63), (5.0, 8.0, 20.0)), in_beams),
    ],
)
def test_centres_in_view_are_the_voxels_whose_centre_the_field_of_view_holds(sensor, in_view):
    centres = np.stack([FIELD.grid.centres_m(axis)[FIELD.index.ijk()[:, axis]] for axis in range(3)], axis=1)
    local = (centres - np.array(sensor.position)) @ sensor.pose.rotation()
    found = VoxelTests(FIELD, 1).centres_in_view(rig_of(sensor)) != 0
    assert 0 < found.sum() < found.size
    assert np.array_equal(found, in_view(sensor, local))


def test_centres_in_view_depend_on_the_sector_of_azimuths_and_not_on_the_number_of_rays():
    few = spinning((0.3, 0.2, 5.1), beams=2, count=3)
    many = spinning((0.3, 0.2, 5.1), beams=9, count=200)
    left = many.replace(azimuths_deg=LinearAngles(from_=0.0, to=180.0, count=50))
    tests = VoxelTests(FIELD, 1)
    whole = tests.centres_in_view(rig_of(many))
    half = tests.centres_in_view(rig_of(left))
    assert np.array_equal(whole, tests.centres_in_view(rig_of(few)))
    on_the_left = FIELD.grid.centres_m(1)[FIELD.index.ijk()[:, 1]] > 0.2
    assert np.array_equal(half != 0, (whole != 0) & on_the_left)


def test_the_range_of_a_sensor_holds_for_the_approximations():
    near = spinning((0.3, 0.2, 5.1)).replace(range_m=(0.0, 4.0))
    centres = np.stack([FIELD.grid.centres_m(axis)[FIELD.index.ijk()[:, axis]] for axis in range(3)], axis=1)
    distance_m = np.linalg.norm(centres - np.array(near.position), axis=1)
    tests = VoxelTests(FIELD, 1)
    assert distance_m[tests.centres_in_view(rig_of(near)) != 0].max() <= 4.0
    assert distance_m[tests.bounding_rectangles(rig_of(near)) != 0].max() <= 4.0 + np.sqrt(0.75)


def test_centres_in_view_of_a_sector_are_those_of_its_azimuths_beams_and_range_beside_other_sensors():
    """A sector over the seam behind the sensor, which others were marked before, and what two of them see."""
    wide = spinning((0.3, 0.2, 5.1), (4.0, -6.0, 20.0), beams=5, count=40)
    sector = wide.replace(azimuths_deg=LinearAngles(from_=120.0, to=250.0, count=40), range_m=(2.0, 9.0))
    centres = np.stack([FIELD.grid.centres_m(axis)[FIELD.index.ijk()[:, axis]] for axis in range(3)], axis=1)
    local = (centres - np.array(sector.position)) @ sector.pose.rotation()
    first_deg, last_deg = sector.turn_ends_deg
    azimuth_deg = (np.degrees(np.arctan2(local[:, 1], local[:, 0])) - first_deg) % 360.0
    distance_m = np.linalg.norm(local, axis=1)
    seen = in_beams(sector, local) & (azimuth_deg <= last_deg - first_deg)
    seen &= (distance_m >= 2.0) & (distance_m <= 9.0)
    tests, ahead = VoxelTests(FIELD, 2), camera((0.31, 0.17, 5.23), (3.0, -7.0, 150.0))
    alone = tests.centres_in_view(rig_of(sector))
    assert np.array_equal(alone, LIDAR_BIT * seen) and 0 < seen.sum() < in_beams(sector, local).sum() / 2
    other = wide.replace(name="other", azimuths_deg=LinearAngles(from_=0.0, to=30.0, count=4))
    for find in (tests.centres_in_view, tests.bounding_rectangles):
        by_sensor = [find(rig_of(one)) for one in (ahead, other, sector)]
        assert np.array_equal(find(rig_of(ahead, other, sector)), np.bitwise_or.reduce(by_sensor))
        assert all(found.any() for found in by_sensor) and (by_sensor[0] & ~by_sensor[2]).any()


def test_all_pixels_are_tried_only_where_some_camera_casts_fewer():
    full = camera((0.0, 0.0, 5.0), cast=(8, 6)).replace(image=(8, 6))
    fewer = full.replace(name="other", cast=(4, 6))
    assert [has_all_pixels(rig) for rig in (rig_of(), rig_of(full), rig_of(spinning((0.0, 0.0, 5.0))))] == [
        True
    ] * 3
    assert not has_all_pixels(rig_of(full, fewer))
    assert has_all_pixels(rig_of(full, fewer.replace(enabled=False))), "it casts nothing"


@given(cameras | lidars)
def test_plain_dda_in_doubles_finds_nearly_the_exact_set(sensor):
    rig = rig_of(sensor)
    found = plain_case(FIELD, rig, 0.1, np.float64).answered().seen
    exact = exact_flags(FIELD, rig)
    on_faces = set(map(float, sensor.position)) <= set(map(float, range(-12, 13)))
    assert on_faces or (found != exact).sum() <= 3 * sensor.ray_count


def test_all_ways_agree_on_the_score_of_a_voxel_set():
    field = random_field(GRID, np.random.default_rng(5))
    rig = rig_of(camera((0.31, 0.17, 5.23), (0.0, 3.0, 30.0)), spinning((-0.27, 0.41, 4.63)))
    scores = evaluate(field, rig, MetricSettings(camera_weight=0.3)).scores
    answer = plain_case(field, rig, 0.3, np.float64).answered()
    assert np.array_equal(answer.seen, exact_flags(field, rig))
    assert answer.s_ms == pytest.approx([scores.classes[cls].s_ms for cls in CLASSES], rel=1e-6)
    tests = VoxelTests(field, 1)
    sums = tests.sums(exact_flags(field, rig))
    assert sums[0].tolist() == [-scores.classes[cls].camera.s_mig for cls in CLASSES]
    assert sums[1].tolist() == [-scores.classes[cls].lidar.s_mig for cls in CLASSES]


@pytest.mark.parametrize("lattice, share", [("1/2", 2), ("1/4", 4), ("1/8", 8)])
def test_a_thinner_lattice_has_some_of_the_rays_and_covers_some_of_the_voxels(lattice, share):
    rig = rig_of(
        camera((0.31, 0.17, 5.23), (0.0, 3.0, 30.0), cast=(16, 8)), spinning((-0.27, 0.41, 4.63), count=24)
    )
    thinner = with_lattice(rig, lattice)
    for full, thin in zip(rig.sensors, thinner.sensors, strict=True):
        every, some = sensor_rays(full).directions, sensor_rays(thin).directions
        assert len(some) * share == len(every)
        nearest = np.abs(some[:, None] - every[None]).max(axis=2).min(axis=1)
        assert nearest.max() < 1e-12
    wrong = wrong_voxels(exact_flags(FIELD, rig), exact_flags(FIELD, thinner))
    assert wrong.extra == 0.0 < wrong.missed


def test_a_camera_of_few_pixels_keeps_one():
    tiny = Camera(name="c", position=(0.0, 0.0, 5.0), hfov_deg=60.0, image=(3, 2))
    assert with_lattice(rig_of(tiny), "1/4").enabled_cameras()[0].resolution == (1, 1)


def test_a_lattice_of_all_pixels_casts_one_ray_per_pixel():
    rig = with_lattice(rig_of(camera((0.0, 0.0, 5.0)), spinning((0.0, 0.0, 5.0))), "all pixels")
    assert rig.enabled_cameras()[0].resolution == rig.enabled_cameras()[0].image
    assert rig.enabled_lidars()[0].ray_count == spinning((0.0, 0.0, 5.0)).ray_count


costs = st.lists(
    st.tuples(st.integers(0, 6).map(float), st.integers(0, 6).map(float)), min_size=1, max_size=25
)


@given(costs)
def test_the_pareto_front_is_what_nothing_beats(pairs):
    front = pareto_front(pairs)
    for (ms, error), on in zip(pairs, front, strict=True):
        beaten = any(a <= ms and b <= error and (a < ms or b < error) for a, b in pairs)
        assert on is not beaten
    assert front[pairs.index(min(pairs))]


@given(costs)
def test_everything_off_the_pareto_front_is_beaten_by_something_on_it(pairs):
    best = [pair for pair, on in zip(pairs, pareto_front(pairs), strict=True) if on]
    for ms, error in pairs:
        assert any(a <= ms and b <= error for a, b in best)


def test_wrong_voxels_count_cameras_and_lidars_apart():
    exact = np.array([1, 1, 1, 1, 2, 3, 0, 0], np.uint8)
    found = np.array([1, 1, 1, 0, 3, 1, 2, 2], np.uint8)
    assert wrong_voxels(exact, found) == Wrong(1 / 5, 1 / 2, 2 / 7, 1 / 5, 2 / 2, 3 / 7)


@pytest.fixture(scope="module")
def study() -> AccuracyStudy:
    return small_accuracy_study()


def test_the_study_has_every_method_and_exact_ones_err_nowhere(study):
    by_method = {
        point.method: point for point in study.points if point.lattice == "own" and point.voxel_m == 1.0
    }
    assert {point.lattice for point in study.points} == {"own", *QUICK.lattices}
    assert len(by_method) == 8
    for method in ("exact", "edit-camera", "edit-lidar"):
        assert by_method[method].voxel_error == 0.0
        assert by_method[method].s_ms == by_method["exact"].s_ms
        assert {error.shortcut_error for error in by_method[method].errors.values()} == {0.0}
    assert by_method["bresenham"].wrong.missed > 0.0
    assert by_method["centres"].wrong.extra > 0.0
    assert by_method["rectangles"].wrong.missed == 0.0


def test_scores_are_held_to_the_exact_ones_on_the_finest_grid(study):
    assert study.finest_m == 0.5
    assert study.finest.score_error == 0.0
    assert study.finest.wrong is None
    own, finest = (point.errors["car"].share for point in (study.own, study.finest))
    assert study.own.errors["car"].grid_error == pytest.approx(abs(own / finest - 1.0))
    assert study.own.errors["car"].raw_error == pytest.approx(
        abs(study.own.s_ms["car"] / study.finest.s_ms["car"] - 1.0)
    )


def test_errors_of_grid_and_shortcut_add_up_where_both_are_known():
    assert ScoreError(0.4, 0.25, 0.125, 1.0).both == 0.375
    assert ScoreError(0.4, None, 0.125, 1.0).both is ScoreError(0.4, 0.25, None, 1.0).both is None


def test_edits_are_not_on_the_fronts(study):
    assert any(point.on_voxel_front for point in study.points)
    assert any(point.on_score_front for point in study.points)
    for point in study.points:
        assert point.from_scratch or not (point.on_voxel_front or point.on_score_front)


def test_one_class_without_boxes_and_one_kind_of_sensor_make_no_trouble():
    field = field_of(grid_of(8, 8, 4), np.zeros((8, 8, 4), np.bool_))
    study = study_accuracy({1.0: field}, 1.0, rig_of(spinning((0.3, 0.2, 2.2))), QUICK)
    assert {point.method for point in study.points}.isdisjoint({"edit-camera"})
    assert all(point.score_error == 0.0 for point in study.points if isinstance(point, Point))


def test_a_rig_without_sensors_is_refused():
    with pytest.raises(InputError, match="no sensor is enabled"):
        study_accuracy({1.0: FIELD}, 1.0, Rig(name="bare"), QUICK)


def test_voxel_cases_time_and_answer_the_same_cover():
    rig = rig_of(spinning((0.3, 0.2, 5.1)))
    tests = VoxelTests(FIELD, 1)
    answer = voxel_case(tests, rig, 0.1, "rectangles").answered()
    assert np.array_equal(answer.seen, tests.bounding_rectangles(rig))


@pytest.mark.parametrize(("slow_ms", "runs"), [(-1.0, 2), (float("inf"), 4)])
def test_what_takes_long_is_timed_once_after_the_round_that_warms_up(
    monkeypatch: pytest.MonkeyPatch, slow_ms: float, runs: int
) -> None:
    monkeypatch.setattr(accuracy_cases, "SLOW_MS", slow_ms)
    ran: list[int] = []
    case = Case(lambda: len(ran), ran.append, lambda _: Answer((0.0,) * len(CLASSES), np.zeros(0, np.uint8)))
    answers, times = timed([case], 3)
    assert len(ran) == runs and len(answers) == 1 and len(times[0]) == runs - 1
