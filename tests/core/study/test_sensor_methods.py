"""The accuracy study of sensors: points on rays, the exact walk as the reference, what is measured and refused."""

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.errors import InputError
from riglens.core.kernels.rays import plain
from riglens.core.metric.scores import PAPER_SETTINGS
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Rig
from riglens.core.study.accuracy_cases import engine_case, plain_case, walk_case
from riglens.core.study.sensor_methods import POSES_DEG, sensors_at
from tests.core.builders import camera, field_of, grid_of, random_field, rig_of, spinning
from tests.core.study.small_studies import small_sensor_study

FIELD = random_field(grid_of(24, 20, 10), np.random.default_rng(3))
FLAT = field_of(grid_of(6, 6, 1))


def sampled(directions, step, near=0.0, far=np.inf):
    """Voxels that points on rays from the middle of the first column of a flat grid find."""
    seen = np.zeros((6, 6, 1), np.uint8)
    plain.walk_sampled(np.array([0.5, 0.5, 0.5]), np.array(directions), near, far, step, seen)
    return {(int(x), int(y)) for x, y, _ in np.argwhere(seen)}


def test_points_on_a_ray_leave_out_the_corners_that_it_cuts():
    slanted = [[0.8, 0.6, 0.0]]
    assert sampled(slanted, 1.0) == {(0, 0), (1, 1), (2, 1), (2, 2), (3, 2), (4, 3), (5, 4), (6 - 1, 5)} - {
        (5, 5)
    }
    every = sampled(slanted, 1e-3)
    assert sampled(slanted, 1.0) < every
    assert (1, 0) in every


def test_points_are_taken_within_the_range_and_in_the_grid_only():
    along = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
    assert sampled(along, 1.0, near=2.0, far=4.0) == {(2, 0), (3, 0)}
    assert sampled(along, 0.25) == {(x, 0) for x in range(6)}


@pytest.mark.parametrize("sensor", [spinning((0.3, 0.2, 4.6), (2.0, -3.0, 8.0)), camera((0.3, 0.2, 4.6))])
def test_points_are_in_voxels_that_the_rays_traverse_and_finer_steps_find_more(sensor):
    found = []
    for step in (1.0, 0.25, None):
        case = plain_case(FIELD, rig_of(sensor), 0.1, np.float64, step_voxels=step)
        found.append(case.answered().seen != 0)
    coarse, fine, walked = found
    assert not (coarse & ~walked).any() and not (fine & ~walked).any()
    assert coarse.sum() < fine.sum() < walked.sum()


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("sensor", [spinning((0.3, 0.2, 4.6), (2.0, -3.0, 8.0)), camera((0.3, 0.2, 4.6))])
def test_the_exact_walk_gives_the_bits_of_the_engine(sensor, threads):
    rig = rig_of(sensor)
    walked = walk_case(FIELD, rig.sensors[0], PAPER_SETTINGS, threads).answered()
    found = engine_case(FIELD, rig, PAPER_SETTINGS, 1).answered()
    assert walked.s_ms == found.s_ms
    assert np.array_equal(walked.seen, found.seen)


@pytest.mark.parametrize("voxels", [5, 8, 27])
def test_the_sum_over_a_dense_grid_leaves_no_voxel_out(voxels):
    rng = np.random.default_rng(voxels)
    seen = (rng.random((2, voxels)) < 0.4).astype(np.uint8)
    h, sums = rng.random((voxels, 3)).astype(np.float32), np.zeros((3, 3))
    plain.sum_dense(seen, h, sums)
    rows = (seen[0], seen[1], seen[0] | seen[1])
    assert sums == pytest.approx(np.stack([row @ h.astype(np.float64) for row in rows]))


def test_every_model_is_measured_in_every_pose_and_the_fast_way_is_exact():
    study = small_sensor_study()
    assert [(r.model, r.pose) for r in study.results] == [
        (model, pose) for model in ("velodyne-vlp-16", "bent") for pose in POSES_DEG
    ]
    for result in study.results:
        assert result.is_exact and result.voxels > 0
        assert result.sensor.rpy_deg[:2] == POSES_DEG[result.pose]
        assert result.point("bresenham").missed > 0.0
        assert result.point("sampled", "1").missed >= result.point("sampled", "1/8").missed
    lidar, bent = study.results[0], study.results[-1]
    assert lidar.point("rectangles").missed == 0.0
    assert bent.point("thinned", "1/8").missed >= bent.point("thinned", "1/2").missed > 0.0
    assert {point.method for point in bent.points}.isdisjoint({"rectangles", "centres"})


def test_a_fast_way_that_errs_is_not_called_exact():
    result = small_sensor_study().results[0]
    points = tuple(replace(p, missed=1e-6) if p.method == "fast" else p for p in result.points)
    assert not replace(result, points=points).is_exact


def test_sensors_take_the_place_and_heading_of_the_first_of_their_kind():
    rig = rig_of(
        camera((1.0, 2.0, 3.0)), spinning((0.5, -0.5, 2.0), (0.0, 5.0, 30.0)), spinning((9.0, 0.0, 2.0))
    )
    found = sensors_at(rig, ["velodyne-vlp-16", "pandaset-wide"])
    assert [sensor.position for sensor in found] == [(0.5, -0.5, 2.0), (1.0, 2.0, 3.0)]
    assert found[0].rpy_deg == (0.0, 0.0, 30.0)


def test_what_cannot_be_measured_is_refused_by_name():
    rig = rig_of(spinning((0.5, -0.5, 2.0)))
    names = [entry.name for entry in default_library().entries("lidar")]
    for models, message in (
        (["nonsense"], "unknown sensor model 'nonsense'"),
        (["pandaset-wide"], "has no camera whose place"),
        (["velodyne-vlp-16"] * 2, "sensor must name each model once"),
        (names[:13], "sensor must name at most 12 models"),
    ):
        with pytest.raises(InputError, match=message):
            sensors_at(rig, models)
    with pytest.raises(InputError, match="has no lidar"):
        sensors_at(Rig(name="bare"), ["velodyne-vlp-16"])
