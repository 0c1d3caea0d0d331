"""Tables of every objective: monotone, submodular where bounds rely on it, and worth what the engines say."""

from dataclasses import replace

import numpy as np
import pytest

from riglens.core.engine.engine import Engine
from riglens.core.errors import InputError
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.predicted import FOUND
from riglens.core.metric.scores import MetricSettings
from riglens.core.optimise.additions import Additions
from riglens.core.optimise.chances import Chances
from riglens.core.optimise.guard import ObjectSampler
from riglens.core.optimise.makers import TableMaker, maker_of
from riglens.core.optimise.objectives import WORST, objective_named, objectives
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.tables import UNIT, CoverTable
from riglens.core.optimise.weights import EVEN, Weights
from riglens.core.review.mounts import MountLimits
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.calibration import Calibration, shipped, shipped_recall
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import Traffic
from tests.core.builders import grid_of, random_field
from tests.core.optimise.problems import proposed
from tests.core.targets.cases import random_rig, random_traffic

NONE = np.zeros(0, np.int32)
WITH_TABLES = (
    "on_target",
    "share_25px",
    "seen",
    "seen_lidar",
    "seen_camera",
    "s_ms",
    "blind_m2",
)
ANYWHERE = MountLimits(height_m=(0.4, 100.0), spacing_m=0.25, keep_out=())
ADDED = Additions(("generic-16",), rules=ANYWHERE, spots_m=0.9, tilts_deg=(0.0,))


@pytest.fixture(scope="module")
def traffic() -> Traffic:
    """Objects in 40 frames."""
    return random_traffic(np.random.default_rng(2), 40)


def problem_of(name: str, traffic: Traffic, rig: Rig, weights: Weights = EVEN) -> Problem:
    """A problem of an objective; the sensors of the rig are what its tables are made of."""
    goal = objective_named(name)
    is_of_voxels = goal.figure.needs == "voxels"
    voxels = random_field(grid_of(40, 30, 8, 0.8), np.random.default_rng(0)) if is_of_voxels else None
    models = {("camera",): "nuscenes-front"}.get(goal.kinds, "generic-16")
    return Problem(
        rig,
        traffic,
        replace(ADDED, models=(models,)),
        name,
        frames=6,
        weights=weights,
        voxels=voxels,
        held_out=8,
    )


def tables(name: str, traffic: Traffic, seed: int) -> tuple[Problem, TableMaker, CoverTable, Rig]:
    """The maker of an objective, and its table for the sensors of a random rig."""
    rig = random_rig(np.random.default_rng(seed), 9).replace(self_occlusion=False)
    problem = problem_of(name, traffic, rig, Weights({"pedestrian": 2.0}, {(0.0, 20.0): 3.0}))
    maker = maker_of(problem, (), ObjectSampler(problem.traffic, 1), 1)
    assert isinstance(maker, TableMaker)
    cells = [maker.cells_of([sensor]) for sensor in problem.goal.sensors_of(rig)]
    return problem, maker, maker.table(NONE, cells), rig


@pytest.mark.parametrize(
    ("name", "seed"),
    [
        (name, seed)
        for name in WITH_TABLES
        for seed in ((1,) if name == "blind_m2" else range(3))  # rays without end on a fine grid
    ],
)
def test_tables_are_monotone_and_those_that_bounds_rely_on_submodular(
    name: str, seed: int, traffic: Traffic
) -> None:
    _, maker, table, rig = tables(name, traffic, seed)
    rng, above = np.random.default_rng(seed), table.above()
    ids = np.arange(table.size)
    sensors = objective_named(name).sensors_of(rig)
    chosen: list[int] = []
    before = above.gains([], ids)
    for one in rng.permutation(table.size).tolist():
        assert (table.gains(chosen, ids) >= 0).all()
        chosen.append(one)
        gains = above.gains(chosen, ids)
        assert (gains <= before).all()
        assert above.value(chosen) >= table.value(chosen)
        covered = maker.cells_of([sensors[place] for place in chosen])
        assert table.value(chosen) == maker.table(covered, []).value([])
        before = gains
    assert 0 < table.value(chosen) <= UNIT * (1.0 + 1e-9)
    assert above is table


@pytest.mark.parametrize("name", ["on_target", "share_25px"])
@pytest.mark.parametrize("seed", range(3))
def test_the_value_of_objects_is_that_of_the_engine_by_weights(
    name: str, seed: int, traffic: Traffic
) -> None:
    problem, _, table, rig = tables(name, traffic, seed)
    counted = TargetEngine(traffic, 1).evaluate(rig, problem.settings, 6)
    objects, figure = counted.objects, problem.goal.figure
    assert isinstance(figure, ObjectFigure)
    values = figure.values(counted)
    known = ~np.isnan(values)
    cls, ring = traffic.cls[objects.box], np.where(traffic.distance_m[objects.box] < 20.0, 3.0, 1.0)
    sums = weights = 0.0
    for number, class_name in enumerate(CLASSES):
        mine = known & (cls == number)
        if mine.any():
            weight = 2.0 if class_name == "pedestrian" else 1.0
            sums += weight * np.average(values[mine], weights=ring[mine])
            weights += weight
    value = sums / weights
    assert table.value(range(table.size)) / UNIT == pytest.approx(value, abs=1e-9)
    sampled = ObjectSampler(traffic, 1, problem.goal, problem.weights)(rig, problem.settings, (0, 6))
    assert sampled.value == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_voxels_seen_are_those_of_the_scores(seed: int, traffic: Traffic) -> None:
    problem, _, table, rig = tables("seen_lidar", traffic, seed)
    _, _, by_any, _ = tables("seen", traffic, seed)
    _, _, sums, _ = tables("s_ms", traffic, seed)
    assert problem.voxels is not None
    scores = Engine(problem.voxels, 1).evaluate(rig, MetricSettings(body="ignored"), False).scores
    by_class = {"pedestrian": 2.0}
    there = [name for name in CLASSES if scores.classes[name].h_total]
    total = sum(by_class.get(name, 1.0) for name in there)
    value = sum(by_class.get(name, 1.0) * scores.classes[name].lidar.seen for name in there) / total
    assert table.value(range(table.size)) / UNIT == pytest.approx(value, abs=1e-7)
    any_seen = sum(by_class.get(name, 1.0) * scores.classes[name].any_seen for name in there) / total
    assert by_any.value(range(by_any.size)) / UNIT == pytest.approx(any_seen, abs=1e-7)
    entropy = sum(scores.classes[name].h_total for name in CLASSES)
    seen = sum(scores.classes[name].h_total * scores.classes[name].lidar.seen for name in CLASSES)
    assert sums.value(range(sums.size)) / UNIT == pytest.approx(seen / entropy, abs=1e-7)


def test_the_worst_failure_is_that_of_the_engine_and_its_bound_holds(traffic: Traffic) -> None:
    own = random_rig(np.random.default_rng(1), 3).enabled_lidars()[:1]
    problem = problem_of(WORST, traffic, Rig(sensors=own))
    problem = replace(problem, additions=replace(problem.additions, count=2, spots_m=1.2))
    found = proposed(problem)
    sampler, plain = ObjectSampler(traffic, 1, problem.goal), ObjectSampler(traffic, 1)
    best = found.best.rig
    assert found.best.value == sampler(best, problem.settings, (0, 6)).value
    without = [
        best.model_copy(update={"sensors": tuple(s for s in best.sensors if s is not lost)})
        for lost in best.sensors
    ]
    assert found.best.value == min(plain(rig, problem.settings, (0, 6)).value for rig in without)
    assert found.bound is not None and found.bound.kind == "cuts"
    added = {sensor.name: sensor for one in found.best.added for sensor in one.sensors}
    assert len(added) == 4
    fewer = proposed(replace(problem, additions=replace(problem.additions, count=1)))
    assert found.bound_value is not None and found.bound_value >= found.best.value >= fewer.best.value


def test_objectives_are_listed_without_reading_a_calibration(monkeypatch: pytest.MonkeyPatch) -> None:
    """The window lists them before its first picture."""

    def unread(*_: object) -> Calibration:
        raise AssertionError("read")

    monkeypatch.setattr("riglens.core.targets.calibration.read_calibration", unread)
    shipped.cache_clear(), shipped_recall.cache_clear()
    assert {"predicted", "found", "missed"} <= objectives().keys()


def test_an_objective_of_recall_takes_no_calibration_of_precision() -> None:
    with pytest.raises(InputError, match="calibration must be one of recall"):
        Chances.of(FOUND, TargetSettings(calibration=shipped()))


def test_what_an_objective_lacks_is_refused_in_one_line(traffic: Traffic) -> None:
    problem = problem_of("on_target", traffic, Rig())
    for wrong, said in (
        ({"objective": "seen"}, "needs a scene of voxels"),
        ({"objective": "share_25px"}, "generic-16 must be a camera"),
        ({"objective": "median_points"}, "objective must be one of predicted, share_5, "),
    ):
        with pytest.raises(InputError, match=said) as caught:
            replace(problem, **wrong)
        assert "\n" not in str(caught.value)
    for wrong_weights, said in (
        (({"lorry": 1.0},), "must name one of car"),
        (({"car": -1.0},), "car must be at least 0"),
        ((dict.fromkeys(CLASSES, 0.0),), "must leave a class"),
        (({}, {(0.0, 20.0): 1.0, (10.0, 30.0): 2.0}), "must not overlap"),
    ):
        with pytest.raises(InputError, match=said):
            Weights(*wrong_weights)
