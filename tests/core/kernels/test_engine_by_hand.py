"""The engine on a grid of 4 x 4 x 4 voxels of 1 m: what is cast, what is kept, and what a score is made of.

x and y go from -2 m to 2 m, z from 0 to 4 m. A level in which a class is in half of the frames is worth ln 2 a voxel.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from riglens.core.engine.caster import Caster
from riglens.core.engine.engine import Engine, Evaluation
from riglens.core.engine.frustums import make_frustum
from riglens.core.errors import Cancelled
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import MetricSettings
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.columns import unpack
from tests.core.builders import (
    camera,
    field_of,
    grid_of,
    lidar,
    rig_of,
    seen_by,
    seen_ray_by_ray,
    spinning,
    synthetic_pog,
)
from tests.core.kernels.tiny import Voxel, row

GRID = grid_of(4, 4, 4)
FIELD = field_of(GRID)
AHEAD = lidar((-1.5, -1.5, 1.5))
"""One ray through the row y = 0 of level 1."""
ALONG_Y = lidar((-1.5, -1.5, 1.5), azimuths=[90.0])


def layers() -> EntropyField:
    """Cars are in 1, 2, 0, 3 of 4 frames in the levels 0 to 3, bicycles in 2 frames of level 3."""
    counts = np.zeros((4, 4, 4, 3), np.int64)
    counts[..., 0] = [1, 2, 0, 3]
    counts[..., 3, 1] = 2
    return EntropyField.from_pog(synthetic_pog(GRID, counts, 4))


def evaluated(engine: Engine, rig: Rig, settings: MetricSettings | None = None) -> Evaluation:
    """Scores with the paper's settings, or with others."""
    return engine.evaluate(rig, settings or MetricSettings())


def lidar_voxels(answer: Evaluation) -> set[Voxel]:
    """What the LiDARs of a rig see."""
    return {(int(x), int(y), int(z)) for x, y, z in np.argwhere(unpack(GRID, answer.seen["lidar"]))}


def test_a_ray_ahead_sees_its_row() -> None:
    answer = evaluated(Engine(FIELD, 1), rig_of(AHEAD))
    assert lidar_voxels(answer) == row(range(4), 0, 1)
    assert answer.scores.covered_voxels.items() >= {"camera": 0, "lidar": 4, "any": 4}.items()
    assert answer.scores.classes["car"].lidar.seen == 4 / 64
    assert answer.scores.classes["car"].s_ms == pytest.approx(-4.0 * math.log(2.0))


def test_where_the_rays_of_a_camera_drift_apart_each_goes_on_alone() -> None:
    """Voxels up to the depth limit are walked; wherever it falls among the voxels, none behind it is left out."""
    field = field_of(grid_of(40, 3, 3))
    for x in (-19.9, -19.6, -19.3):
        eye = camera((x, 0.02, 1.53), (1.0, 0.4, 0.2), cast=(24, 16), hfov_deg=40.0)
        frustum = make_frustum(eye, Caster(field).rays(eye, "exact"))
        assert frustum is not None and 16.0 <= frustum.depth_limit < 35.0
        assert np.array_equal(seen_by(field, eye), seen_ray_by_ray(field, eye))


def test_a_voxel_counts_once_however_many_sensors_see_it() -> None:
    answer = evaluated(Engine(FIELD, 1), rig_of(AHEAD, ALONG_Y, AHEAD))
    assert answer.scores.covered_voxels["lidar"] == 7


def test_a_sensor_that_is_switched_off_sees_nothing() -> None:
    answer = evaluated(Engine(FIELD, 1), rig_of(AHEAD, ALONG_Y.replace(enabled=False)))
    assert answer.scores.covered_voxels["any"] == 4


def test_hits_count_every_ray() -> None:
    rig = rig_of(lidar((-1.5, -1.5, 1.5), azimuths=[0.0, 0.0, 0.0]))
    answer = evaluated(Engine(FIELD, 1), rig, MetricSettings(reading="hits"))
    assert answer.scores.classes["car"].lidar.s_mig == pytest.approx(-12.0 * math.log(2.0))
    assert answer.scores.covered_voxels["lidar"] == 4


def test_hits_take_the_entropy_of_each_level() -> None:
    """A ray straight up in the middle of a column: levels 0, 1 and 3 are informative."""
    field = layers()
    rig = rig_of(lidar((-0.5, 0.5, 0.25), elevations=[90.0]))
    answer = evaluated(Engine(field, 1), rig, MetricSettings(reading="hits"))
    column = [field.totals_q[cls] / 16 / 2**32 for cls in (0, 1)]
    assert answer.scores.classes["car"].lidar.s_mig == pytest.approx(-column[0], rel=1e-12)
    assert answer.scores.classes["bicycle"].lidar.s_mig == pytest.approx(-column[1], rel=1e-12)


def test_hits_in_one_level_take_the_entropy_of_that_level() -> None:
    answer = evaluated(Engine(layers(), 1), rig_of(AHEAD), MetricSettings(reading="hits"))
    assert answer.scores.classes["car"].lidar.s_mig == pytest.approx(-4.0 * math.log(2.0))
    assert answer.scores.classes["bicycle"].lidar.s_mig == 0.0


RIGS = [
    rig_of(AHEAD, spinning((0.1, 0.2, 1.3), beams=3, count=5)),
    rig_of(AHEAD),
    rig_of(ALONG_Y, spinning((0.1, 0.2, 1.3), beams=3, count=5), camera((-1.9, 0.1, 1.4), cast=(4, 3))),
    rig_of(camera((-1.9, 0.1, 1.4), cast=(4, 3)), AHEAD),
    rig_of(),
    rig_of(spinning((0.1, 0.2, 1.3), beams=3, count=5), AHEAD, ALONG_Y),
]


def test_after_any_edits_scores_are_those_from_scratch() -> None:
    field = layers()
    engine = Engine(field, 1)
    for rig in RIGS:
        answer, fresh = evaluated(engine, rig), evaluated(Engine(field, 1), rig)
        assert answer.scores == fresh.scores
        assert np.array_equal(answer.seen["lidar"], fresh.seen["lidar"])
        assert np.array_equal(answer.seen["camera"], fresh.seen["camera"])


def test_an_engine_for_single_rigs_gives_the_same_scores() -> None:
    field = layers()
    engine = Engine(field, 1, for_edits=False)
    for rig in RIGS:
        assert evaluated(engine, rig).scores == evaluated(Engine(field, 1), rig).scores


@pytest.fixture
def casts(monkeypatch: pytest.MonkeyPatch) -> list[Sensor]:
    """The sensors cast so far."""
    seen: list[Sensor] = []
    mark = Caster.mark

    def counted(caster: Caster, sensor: Sensor, *rest: object) -> bool:
        seen.append(sensor)
        return mark(caster, sensor, *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(Caster, "mark", counted)
    return seen


def test_only_the_sensor_that_moved_is_cast(casts: list[Sensor]) -> None:
    engine, moved = Engine(FIELD, 1), ALONG_Y.replace(position=(0.5, 0.5, 0.5))
    evaluated(engine, rig_of(AHEAD, ALONG_Y))
    assert len(casts) == 2
    evaluated(engine, rig_of(AHEAD, moved))
    assert [sensor.position for sensor in casts[2:]] == [(0.5, 0.5, 0.5)]


def test_a_sensor_that_is_renamed_or_leaves_is_not_cast(casts: list[Sensor]) -> None:
    engine = Engine(FIELD, 1)
    evaluated(engine, rig_of(AHEAD, ALONG_Y))
    evaluated(engine, Rig(sensors=(AHEAD.replace(name="new"), ALONG_Y.replace(name="other"))))
    evaluated(engine, rig_of(ALONG_Y))
    assert len(casts) == 2


def test_an_abandoned_answer_leaves_no_trace() -> None:
    engine = Engine(FIELD, 1)
    evaluated(engine, rig_of(AHEAD))
    asked = iter([False, True])
    with pytest.raises(Cancelled):
        engine.evaluate(rig_of(spinning((0.1, 0.2, 1.3)), ALONG_Y), cancel=lambda: next(asked, True))
    assert lidar_voxels(evaluated(engine, rig_of(AHEAD))) == row(range(4), 0, 1)
    assert evaluated(engine, rig_of(AHEAD, ALONG_Y)).scores.covered_voxels["lidar"] == 7


@pytest.mark.parametrize(
    ("yaw_deg", "rows", "columns"),
    [(0.0, (2, 4), (0, 4)), (180.0, (0, 4), (0, 4)), (90.0, (0, 4), (1, 4)), (-90.0, (0, 4), (0, 4))],
)
def test_a_camera_can_mark_only_on_its_own_side(
    yaw_deg: float, rows: tuple[int, int], columns: tuple[int, int]
) -> None:
    """A camera in the cell (3, 2), with one cell of room behind it."""
    window = Caster(FIELD).window(camera((1.5, 0.5, 1.5), (0.0, 0.0, yaw_deg), hfov_deg=60.0))
    assert (tuple(window[:2]), tuple(window[2:])) == (rows, columns)


@pytest.mark.parametrize(("yaw_deg", "rows", "columns"), [(180.0, (0, 3), (0, 4)), (-90.0, (0, 4), (0, 2))])
def test_a_camera_that_looks_back_or_right_has_one_cell_of_room_too(
    yaw_deg: float, rows: tuple[int, int], columns: tuple[int, int]
) -> None:
    """A camera in the cell (1, 0)."""
    window = Caster(FIELD).window(camera((-0.5, -1.5, 1.5), (0.0, 0.0, yaw_deg), hfov_deg=60.0))
    assert (tuple(window[:2]), tuple(window[2:])) == (rows, columns)


@pytest.mark.parametrize("yaw_deg", range(0, 360, 45))
def test_a_camera_marks_nothing_outside_of_its_window(yaw_deg: float) -> None:
    caster = Caster(FIELD)
    for place in ((0.3, 0.4, 1.7), (1.0, -1.0, 1.0), (-2.4, 0.2, 2.1)):
        sensor = camera(place, (0.0, 20.0, yaw_deg), (6, 5), 60.0)
        window, marks = caster.window(sensor), np.zeros(16, np.uint64)
        caster.mark(sensor, "exact", window, marks)
        everywhere = np.zeros(16, np.uint64)
        caster._mark_rays(caster.rays(sensor, "exact"), everywhere, lambda: False)
        assert np.array_equal(marks, everywhere)
        inside = everywhere.reshape(4, 4)[window[0] : window[1], window[2] : window[3]]
        assert np.count_nonzero(inside) == np.count_nonzero(everywhere)


def test_a_dense_camera_that_pitches_sees_what_its_rays_see() -> None:
    sensor = camera((-1.9, 0.1, 3.4), (0.0, 25.0, 10.0), (60, 60), 40.0)
    caster, marks, alone = Caster(FIELD), np.zeros(16, np.uint64), np.zeros(16, np.uint64)
    caster.mark(sensor, "exact", caster.window(sensor), marks)
    caster._mark_rays(caster.rays(sensor, "exact"), alone, lambda: False)
    assert np.array_equal(marks, alone)
    assert 10 < sum(int(word).bit_count() for word in marks) < 40


def test_beyond_the_depth_limit_a_camera_that_pitches_sees_what_its_rays_see() -> None:
    """With 8 x 7 rays over 20 degrees a voxel is hit for certain up to a depth of 22 voxels, and the grid has 28."""
    long = field_of(grid_of(28, 6, 6))
    sensor = camera((-13.9, 0.1, 3.4), (0.0, 3.0, 1.0), (8, 7), 20.0)
    caster, marks, alone = Caster(long), np.zeros(28 * 6, np.uint64), np.zeros(28 * 6, np.uint64)
    frustum = make_frustum(sensor, caster.rays(sensor, "exact"))
    assert frustum is not None
    assert 22.0 < frustum.depth_limit < 23.0
    caster.mark(sensor, "exact", caster.window(sensor), marks)
    caster._mark_rays(caster.rays(sensor, "exact"), alone, lambda: False)
    assert np.array_equal(marks, alone)


def test_a_range_in_metres_is_a_range_in_voxels() -> None:
    coarse = field_of(grid_of(4, 4, 4, 0.5))  # voxels of 0.5 m from -1 m to 1 m
    answer = evaluated(Engine(coarse, 1), rig_of(lidar((-0.75, -0.75, 0.75), range_m=(0.25, 1.5))))
    assert answer.scores.covered_voxels["lidar"] == 3  # from x = -0.5 m to 0.75 m


def test_cameras_are_weighted_and_lidars_are_not() -> None:
    both = rig_of(AHEAD, camera((-1.5, 1.5, 2.5), cast=(1, 1)))
    car = evaluated(Engine(FIELD, 1), both, MetricSettings(camera_weight=0.25)).scores.classes["car"]
    assert car.camera.s_mig == car.lidar.s_mig == pytest.approx(-4.0 * math.log(2.0))
    assert car.s_ms == pytest.approx(-5.0 * math.log(2.0))
    assert car.any_seen == 8 / 64
