"""Whole runs in small traffic: what is proposed, its bound, its guard, and what is refused."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from riglens.core.blind.zones import BlindEngine, BlindSettings
from riglens.core.errors import Cancelled, InputError
from riglens.core.figures.evaluated import EvaluationSettings, Evaluator
from riglens.core.metric.scores import MetricSettings
from riglens.core.optimise.additions import Additions, Move, counts_of
from riglens.core.optimise.candidates import choices_of, rules_for
from riglens.core.optimise.guard import (
    HELD_OUT,
    GuardResult,
    ObjectSampler,
    cases_of,
    guard,
    sampled_cases,
    verdict,
)
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.results import OptimiseResult, Progress
from riglens.core.optimise.run import optimise, skin_gains, solved
from riglens.core.optimise.space import cast
from riglens.core.review.mounts import MountLimits, violations
from riglens.core.rig.edits import mirrored_pose, with_mirror_image
from riglens.core.rig.model import Lidar, LinearAngles, Rig
from riglens.core.rig.yaml.file import load_rig
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.targets.traffic import NO_CLASS, Traffic
from tests.core.builders import grid_of, random_field
from tests.core.optimise.problems import proposed
from tests.core.targets.cases import random_traffic

ANYWHERE = MountLimits(height_m=(0.4, 100.0), spacing_m=0.25, keep_out=())
ADDED = Additions(("generic-16",), 2, rules=ANYWHERE, spots_m=0.7, tilts_deg=(0.0, 15.0))
OWN = Lidar(
    name="own",
    position=(0.0, 0.0, 1.8),
    elevations_deg=LinearAngles(from_=-20.0, to=5.0, count=4),
    azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=90),
)
RIG = Rig(name="car", sensors=(OWN,))


@pytest.fixture(scope="module")
def traffic() -> Traffic:
    """Objects in 60 frames."""
    return random_traffic(np.random.default_rng(0), 60)


@pytest.fixture(scope="module")
def result(traffic: Traffic) -> OptimiseResult:
    """Two pairs added to one LiDAR, with a front."""
    return optimise(Problem(RIG, traffic, ADDED, frames=12, held_out=40, blind_m=0.3), 2)


def test_the_proposal_keeps_the_rig_and_its_value_is_that_of_the_engine(
    result: OptimiseResult, traffic: Traffic
) -> None:
    best = result.best
    assert best.rig.sensors[0] == OWN
    assert len(best.rig.sensors) == 1 + 2 * len(best.added) == 5
    objects = TargetEngine(traffic, 1).evaluate(best.rig, TargetSettings(body="blocks"), 12).objects
    cls = traffic.cls[objects.box]
    classes = [objects.on_target[cls == one].mean() for one in np.unique(cls)]
    assert best.value == pytest.approx(float(np.mean(classes)))
    assert result.bound_value is not None
    assert result.before < result.reference_value <= best.value <= result.bound_value
    assert best.cost == 4.0


def test_the_bound_is_said_in_one_sentence(result: OptimiseResult) -> None:
    assert result.bound is not None and result.bound.kind == "proven"
    assert result.gap == 0.0
    sentence = result.sentence()
    assert f"no set of 2 pairs on these {result.candidates} mounts is better" in sentence
    loose = replace(result, bound=replace(result.bound, kind="cuts", value=result.bound.value * 1.02))
    assert loose.gap == pytest.approx(0.02)
    assert "by more than 2." in loose.sentence()


def test_the_front_begins_with_the_best_and_leaves_less_blind(result: OptimiseResult) -> None:
    assert result.front[0] == 0
    assert result.before_blind_m2 is not None and result.best.blind_m2 is not None
    assert result.best.blind_m2 < result.before_blind_m2
    engine = BlindEngine(result.best.rig.vehicle, BlindSettings())
    unseen = float(engine.evaluate(result.best.rig).area_m2(0.3).sum())
    assert result.best.blind_m2 == pytest.approx(unseen)


def test_the_guard_covers_every_case_and_the_json_says_all(result: OptimiseResult) -> None:
    cases = [one.case for one in result.best.guard]
    assert cases[0] == HELD_OUT
    assert len(set(cases)) == len(cases) >= 5
    document = result.to_dict()
    assert {"objective", "before", "candidates", "frames", "seed", "bound", "proposals", "front"} <= set(
        document
    )
    assert set(document["bound"]) == {"value", "kind", "gap"}
    assert set(document["proposals"][0]["guard"][0]) == {"case", "gain", "se", "share"}
    assert [point["proposal"] for point in document["front"]] == list(result.front)


def test_proposals_are_saved_as_rigs(result: OptimiseResult, tmp_path: Path) -> None:
    *rigs, table = result.save(tmp_path / "out")
    assert [load_rig(path).rig for path in rigs] == [one.rig for one in result.proposals]
    assert len(table.read_text(encoding="utf-8").splitlines()) == 1 + len(rigs)
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="must be a folder"):
        result.save(tmp_path / "file")


def test_the_result_does_not_depend_on_the_number_of_threads(traffic: Traffic) -> None:
    problem = Problem(RIG, traffic, replace(ADDED, count=1), frames=8, held_out=10)
    one, two = (optimise(problem, threads).to_dict() for threads in (1, 2))
    assert one == two


def test_a_run_ends_when_nobody_waits_any_more(traffic: Traffic) -> None:
    seen: list[Progress] = []
    with pytest.raises(Cancelled):
        optimise(Problem(RIG, traffic, ADDED, frames=8), 1, seen.append, lambda: bool(seen))
    assert len(seen) == 1


def test_gains_over_a_rig_of_ones_own(traffic: Traffic) -> None:
    problem = Problem(RIG, traffic, replace(ADDED, count=1), frames=8, held_out=10, reference=RIG)
    found = proposed(problem)
    assert found.reference_value == found.before
    assert found.best.guard[0].gain > 0.0


def test_a_shopping_list_has_its_numbers_within_one_budget(traffic: Traffic) -> None:
    counts = {"generic-16": (1, 1), "velodyne-vlp-16": (2, 4), "hesai-qt64": (0, 2)}
    costs = {"generic-16": 1.0, "velodyne-vlp-16": 2.0, "hesai-qt64": 30.0}
    added = replace(ADDED, models=tuple(counts), costs=costs, budget=9.5, counts=counts)
    problem = Problem(RIG, traffic, added, frames=8, held_out=10)
    found = proposed(problem)
    models = [sensor.model for sensor in found.best.rig.sensors[1:]]
    assert models.count("generic-16") == 1 and models.count("velodyne-vlp-16") in (2, 4)
    assert "hesai-qt64" not in models and found.best.cost <= 9.5
    (single,) = (one for one in found.best.added if len(one.sensors) == 1)
    assert single.places_m[0, 1] == 0.0, "an odd one stands on the middle plane"
    assert found.bound_value is not None and found.best.value <= found.bound_value
    sampler = ObjectSampler(traffic, 1, problem.goal)
    for one, adds in zip(found.best.added, found.best.adds, strict=True):
        gone = {sensor.name for sensor in one.sensors}
        rest = found.best.rig.only(s for s in found.best.rig.sensors if s.name not in gone)
        without = sampler(rest, problem.settings, (0, 8)).value
        assert adds == pytest.approx(found.best.value - without, abs=1e-9)
    sensors = found.to_dict()["proposals"][0]["sensors"]
    assert sum(one["cost"] for one in sensors) == pytest.approx(found.best.cost)
    assert all(one["adds"] > 0.0 for one in sensors)


@pytest.mark.parametrize("seed", range(3))
def test_no_choice_within_the_numbers_of_a_list_is_better(seed: int, traffic: Traffic) -> None:
    """Brute force over all sets of few candidates of mixed models."""
    counts = {"generic-16": (0, 2), "velodyne-vlp-16": (1, 3)}
    rules = ANYWHERE.model_copy(update={"height_m": (0.7, 100.0)})
    added = Additions(
        tuple(counts), rules=rules, spots_m=0.9, tilts_deg=(0.0,), counts=counts, budget=5.0,
        costs={"generic-16": 0.8},
    )  # fmt: skip
    problem = Problem(RIG, traffic, added, frames=6, held_out=10, seed=seed)
    space = cast(problem, choices_of(problem.rig, problem.additions, problem.seed, moves=problem.moves), 1)
    assert 4 <= len(space.choices.candidates) <= 14
    best = 0
    for number in range(1 << len(space.choices.candidates)):
        some = [one for one in range(len(space.choices.candidates)) if number >> one & 1]
        sensors = [s.model for one in some for s in space.choices.candidates[one].sensors]
        if space.choices.limits.allow(some) and "velodyne-vlp-16" in sensors:
            assert sensors.count("velodyne-vlp-16") <= 3 and sensors.count("generic-16") <= 2
            best = max(best, space.figure.value(some))
    (chosen, *_), bound, _ = solved(space)
    assert space.figure.value(chosen) <= best
    assert bound is not None and bound.value >= best
    if bound.kind == "proven":
        assert space.figure.value(chosen) == best


def test_numbers_of_a_list_are_read_and_checked(traffic: Traffic) -> None:
    assert counts_of(("a", "b:2", "c:0-4")) == (("a", "b", "c"), {"b": (2, 2), "c": (0, 4)})
    for words, said in ((("a:x",), "MODEL:FROM-TO"), (("a", "a:2"), "once")):
        with pytest.raises(InputError, match=said):
            counts_of(words)
    for low, high in ((3, 2), (0, 0), (0, 21)):
        with pytest.raises(InputError, match="generic-16 must be from 0 to 20"):
            replace(ADDED, counts={"generic-16": (low, high)})
    many = replace(ADDED, counts={"generic-16": (20, 20)}, spots_m=2.0)
    with pytest.raises(InputError, match="generic-16 has mounts for"):
        optimise(Problem(RIG, traffic, many, frames=8), 1)


def test_a_camera_turns_to_where_it_sees_most(traffic: Traffic) -> None:
    """Brute force over all poses of one camera."""
    added = Additions(
        ("nuscenes-front",), mirrored=False, rules=ANYWHERE, spots_m=0.9, tilts_deg=(0.0, 10.0),
        yaw_deg=(-60.0, -30.0, 0.0, 30.0, 60.0),
    )  # fmt: skip
    bare = Rig(name="bare")
    problem = Problem(bare, traffic, added, "share_25px", frames=8, held_out=10)
    found = proposed(problem)
    sampler = ObjectSampler(traffic, 1, problem.goal)
    listed = choices_of(bare, added).candidates
    yaws = {round(one.sensors[0].rpy_deg[2] % 360.0) for one in listed if one.tilt_deg == 0.0}
    assert len(listed) >= 100 and len(yaws) > 20
    best = max(sampler(bare.replace(sensors=one.sensors), problem.settings, (0, 8)).value for one in listed)
    assert found.best.value == pytest.approx(best, abs=1e-12)


def test_requirements_are_met_by_another_set_where_there_is_one(traffic: Traffic) -> None:
    problem = Problem(RIG, traffic, replace(ADDED, count=1), frames=8, held_out=10)
    free = proposed(problem)
    best = free.best.added[0].places_m[0]

    def unmet(rig: Rig) -> tuple[str, ...]:
        return ("elsewhere",) if np.allclose(rig.sensors[-2].position, best) else ()

    found = proposed(replace(problem, unmet=unmet))
    assert free.unmet is None and found.unmet == ()
    assert not np.allclose(found.best.added[0].places_m[0], best)
    assert found.best.value < free.best.value == pytest.approx(found.bound_value)
    never = proposed(replace(problem, unmet=lambda _: ("a", "b")))
    assert never.unmet == ("a", "b")
    assert never.best == replace(free.best)


def test_what_is_worth_least_makes_room_for_what_is_required(traffic: Traffic) -> None:
    few = replace(ADDED, spots_m=1.5, tilts_deg=(0.0,))
    problem = Problem(RIG, traffic, few, frames=4, held_out=2)
    best = [one.places_m[0] for one in proposed(problem).best.added]
    alone = proposed(replace(problem, additions=replace(few, count=1))).best.added[0].places_m[0]

    def unmet(rig: Rig) -> tuple[str, ...]:
        places = [sensor.position for sensor in rig.sensors]
        return ("other",) if all(any(np.allclose(p, q) for p in places) for q in best) else ()

    found = [one.places_m[0] for one in proposed(replace(problem, unmet=unmet)).best.added]
    assert len(best) == 2
    for places in (best, found):
        assert any(np.allclose(alone, place) for place in places)


def pair(x_m: float) -> Rig:
    """A car with a LiDAR on the roof, and a mirror pair beside it."""
    left = OWN.replace(name="left", position=(x_m, 0.6, 1.55))
    whole = with_mirror_image(RIG.replace(sensors=(OWN, left)), "left", "right")
    return whole.replace(name="car with a pair")


def test_a_sensor_improves_with_its_partner_and_no_other_sensor_moves(traffic: Traffic) -> None:
    rig = pair(-1.0)
    problem = Problem(rig, traffic, frames=8, held_out=10, moves=(Move("right", 0.8),))
    found = proposed(problem)
    best = found.best.rig
    assert [one.name for one in best.sensors] == ["own", "left", "right"]
    assert best.sensor("own") == OWN
    left, right = best.sensor("left"), best.sensor("right")
    assert right.pose == mirrored_pose(left.pose)
    assert left.pose != rig.sensor("left").pose
    assert math.dist(left.position, rig.sensor("left").position) < 1.1
    assert found.before == found.reference_value < found.best.value <= found.bound_value
    assert "no other mount of right on these" in found.sentence()
    assert violations(best, rules_for(rig, problem.additions.rules)) == ()


def test_a_sensor_without_a_better_mount_stays(traffic: Traffic) -> None:
    rig = pair(-1.0)
    first = proposed(Problem(rig, traffic, frames=8, held_out=10, moves=(Move("left", 0.8),))).best.rig
    again = proposed(Problem(first, traffic, frames=8, held_out=10, moves=(Move("left", 0.0),)))
    assert again.best.value >= again.before
    stays = Problem(first, traffic, frames=8, moves=(Move("left", 0.0, (), (0.0,)),))
    with pytest.raises(InputError, match="no mount"):
        optimise(stays, 1)


def test_sensors_move_are_exchanged_and_added_at_once(traffic: Traffic) -> None:
    moves = (Move("own", models=("generic-16",)), Move("left", 0.0, ("generic-16",), (0.0,)))
    problem = Problem(pair(-1.0), traffic, replace(ADDED, count=1), frames=8, held_out=10, moves=moves)
    found = proposed(problem)
    best = found.best.rig
    assert [one.name for one in best.sensors][:3] == ["own", "left", "right"]
    assert len(best.sensors) == 5
    assert {one.model for one in best.sensors} <= {None, "generic-16"}
    assert best.sensor("left").pose == problem.rig.sensor("left").pose


def test_gains_on_the_skin_are_those_of_the_engine_for_any_rig(traffic: Traffic) -> None:
    problem = Problem(RIG, traffic, ADDED, frames=8)
    skin = skin_gains(problem, 1)
    moved = RIG.replace(sensors=(OWN.replace(position=(0.5, 0.2, 1.9)),))
    evaluator = ObjectSampler(traffic)

    def value(rig: Rig) -> float:
        return evaluator(rig, problem.settings, (0, 8)).value

    for rig in (RIG, moved, RIG):
        gains = skin.gains(rig)
        for one in (0, 7, len(gains) - 1):
            more = rig.replace(sensors=(*rig.sensors, *skin.candidates[one].sensors))
            assert gains[one] == pytest.approx(value(more) - value(rig), abs=1e-9)
    colours = skin.by_spot(skin.gains(RIG))
    assert colours.shape == (len(skin.points_m),) == (len(skin.normals),)
    assert colours.max() == skin.gains(RIG).max()


@pytest.mark.parametrize("is_mirrored", [True, False])
def test_gains_on_the_skin_stand_on_both_sides_for_pairs_alone(traffic: Traffic, is_mirrored: bool) -> None:
    skin = skin_gains(Problem(RIG, traffic, replace(ADDED, mirrored=is_mirrored, spots_m=1.5), frames=8), 1)
    spots = {one.spot for one in skin.candidates}
    assert len(skin.points_m) == len(skin.normals) == (2 if is_mirrored else 1) * len(spots)


def test_progress_brackets_the_result(traffic: Traffic) -> None:
    seen: list[Progress] = []
    found = optimise(Problem(RIG, traffic, ADDED, frames=8, held_out=10), 1, seen.append)
    proving = [one for one in seen if one.stage == "proving"]
    assert proving
    for one in proving:
        assert one.value is not None and one.bound is not None
        assert one.value <= found.best.value + 1e-9 <= one.bound + 2e-9
    checking = [one.result for one in seen if one.result is not None]
    assert [len(one.best.guard) for one in checking] == list(range(1, len(found.best.guard) + 1))
    assert checking[-1] == found


def test_what_cannot_be_is_refused_in_one_line(traffic: Traffic) -> None:
    for wrong, said in (
        ({"objective": "beauty"}, "objective must be one of predicted, share_5, "),
        ({"frames": 1}, "frames"),
        ({"frames": 59}, "frames must be at most 58"),
        ({"held_out": 1}, "held_out"),
        ({"blind_m": math.nan}, "blind_m"),
        ({"seed": -1}, "seed"),
        ({"additions": Additions(())}, "add must name at least one"),
        ({"additions": Additions(("nuscenes-front",))}, "must be a LiDAR"),
        ({"additions": Additions(("velodyne-vlp-61",))}, "unknown sensor model"),
        ({"additions": Additions(("generic-16",), costs={"other": 2.0})}, "cost other"),
        ({"moves": (Move("nobody"),)}, "move must name an enabled LiDAR of the rig: own"),
        ({"moves": (Move("own"), Move("own", 0.5))}, "once"),
        ({"moves": (Move("own", models=("nuscenes-front",)),)}, "must be a LiDAR"),
    ):
        with pytest.raises(InputError, match=said) as caught:
            Problem(RIG, traffic, **{"additions": ADDED, "frames": 8, **wrong})
        assert "\n" not in str(caught.value)


def stack(turns_deg: tuple[float, ...]) -> Rig:
    """Four LiDARs in one place, each turned."""
    sensors = [
        Lidar(
            name=f"L{number}",
            position=(0.0, 0.0, 2.0),
            rpy_deg=(0.0, 0.0, turn),
            elevations_deg=LinearAngles(from_=-25.0, to=15.0, count=8),
            azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=120),
        )
        for number, turn in enumerate(turns_deg)
    ]
    return Rig(self_occlusion=False, sensors=tuple(sensors))


def test_a_stagger_that_lives_on_a_fixed_phase_is_not_resolved(traffic: Traffic) -> None:
    """Azimuths of four LiDARs interleave only as long as nobody turns them."""
    staggered, aligned = stack((0.0, 0.75, 1.5, 2.25)), stack((0.0,) * 4)
    settings = TargetSettings(phase="0", body="ignored")
    cases = sampled_cases(staggered, aligned, ObjectSampler(traffic), settings, 20, 60)
    kept = list(guard(cases))
    assert cases[0].gain()[0] > 0.0
    assert verdict(kept, 0.01) == "not resolved"
    assert next(one for one in kept if one.case == "fixed phase").share > 0.5


def test_a_pose_polished_on_a_sample_is_not_resolved(traffic: Traffic) -> None:
    """Small turns of LiDARs in their place fit phases and lost rays of the frames by which they are chosen."""
    rng, start = np.random.default_rng(4), stack((0.0, 0.0))
    evaluator, settings = ObjectSampler(traffic), TargetSettings(body="ignored")
    best, value = start, evaluator(start, settings, (0, 8)).value
    for _ in range(60):
        sensor = best.sensors[int(rng.integers(2))]
        turn = tuple((np.array(sensor.rpy_deg) + rng.normal(0.0, 0.3, 3)).tolist())
        tried = best.with_sensor(sensor.name, sensor.replace(rpy_deg=turn))
        found = evaluator(tried, settings, (0, 8)).value
        if found > value:
            best, value = tried, found
    cases = sampled_cases(best, start, evaluator, settings, 8, 60)
    assert cases[0].gain()[0] > 0.0
    assert verdict(list(guard(cases)), 0.01) == "not resolved"


def test_an_optimum_of_data_in_front_is_not_resolved_in_data_all_around(traffic: Traffic) -> None:
    """Low down, front data want the sensor in the bumper, where the car hides what is behind."""
    is_front = traffic.centre_m[:, 0] > 2.0
    front = replace(traffic, cls=np.where(is_front, traffic.cls, NO_CLASS).astype(np.uint8))
    rules = MountLimits(height_m=(0.3, 0.9), spacing_m=0.25)
    added = Additions(("generic-16",), mirrored=False, rules=rules, spots_m=0.35, tilts_deg=(0.0,))
    turn = LinearAngles(from_=-180.0, to=180.0, count=180)
    roof = OWN.replace(azimuths_deg=turn, elevations_deg=LinearAngles(from_=-15.0, to=5.0, count=6))
    bare = Rig(name="bare")
    problem = Problem(
        bare, front, added, frames=12, held_out=40, reference=Rig(sensors=(roof,)), checks={"town": traffic}
    )
    found = optimise(problem, 2)
    town = found.best.guard[-1]
    assert (town.case, town.decides) == ("town", True)
    assert found.best.value > found.reference_value
    assert found.best.added[0].places_m[0, 0] > 1.5
    assert not town.is_clear
    assert found.best.verdict == "not resolved"


def test_a_gain_that_stays_is_resolved_and_one_that_halves_is_not() -> None:
    for gain, se, share, said in (
        (0.02, 0.005, 0.8, "resolved"),
        (0.02, 0.011, 0.8, "not resolved"),
        (0.02, 0.005, 0.4, "not resolved"),
        (0.0, 0.0, 0.0, "not resolved"),
        (0.009, 0.001, 0.9, "not resolved"),  # tells no rigs apart
    ):
        assert verdict([GuardResult(HELD_OUT, gain, se, share, True)], 0.01) == said
    assert verdict([], 0.01) == "not checked"


def low_lidar(name: str, x_m: float, y_m: float, yaw_deg: float) -> Lidar:
    """A LiDAR at the car's side that looks at the ground beside it."""
    return Lidar(
        name=name,
        position=(x_m, y_m, 0.9),
        rpy_deg=(0.0, 0.0, yaw_deg),
        elevations_deg=LinearAngles(from_=-60.0, to=0.0, count=32),
        azimuths_deg=LinearAngles(from_=-80.0, to=80.0, count=80),
    )


SIDES = RIG.replace(
    name="sides",
    sensors=(OWN, low_lidar("left", 0.5, 1.05, 90.0), low_lidar("right", 0.5, -1.05, -90.0)),
)


@pytest.mark.parametrize("objective", ["blind_m2", "seen_lidar"])
def test_the_guard_of_ground_and_voxels_compares_the_objective_itself(
    objective: str, traffic: Traffic
) -> None:
    field = random_field(grid_of(60, 60, 8, 0.5), np.random.default_rng(0))
    problem = Problem(RIG, traffic, ADDED, objective, frames=8, held_out=10, voxels=field)
    figure = problem.goal.figure
    evaluator = Evaluator(field, settings=EvaluationSettings(MetricSettings(body=None)))
    whole, own = (evaluator(rig, (figure.needs,)) for rig in (SIDES, RIG))
    assert figure.is_gain(figure.change(whole, own, "car").value)
    sampler = ObjectSampler(traffic, 1, problem.goal)
    more, less = (list(guard(cases_of(problem, *pair, sampler))) for pair in ((SIDES, RIG), (RIG, SIDES)))
    assert verdict(more, figure.resolved) == "resolved"
    assert verdict(less, figure.resolved) == "not resolved"
    assert not any(one.case == HELD_OUT for one in more), "no frames are drawn for it"
    (first, errors), back = more[:2], less[0]
    assert first.gain == -back.gain > 0.0 == first.se
    assert errors.gain > 0.5 * first.gain
    if objective == "blind_m2":
        assert first.gain == pytest.approx(-figure.change(whole, own, "car").value)


def test_the_paired_error_is_that_of_frames(traffic: Traffic) -> None:
    """Against the spread of the gain over random halves of the frames."""
    better = RIG.replace(sensors=(OWN, OWN.replace(name="other", position=(1.0, 0.0, 1.9))))
    evaluator = ObjectSampler(traffic)
    one, other = (evaluator(rig, TargetSettings(), (0, 60)) for rig in (better, RIG))
    gain, se = one.gain_over(other)
    rng, found = np.random.default_rng(0), []
    for _ in range(400):
        frames = rng.integers(0, 60, 60)
        picks = np.concatenate([np.flatnonzero(one.frame == frame) for frame in frames])
        more, cls = (one.values - other.values)[picks], one.cls[picks]
        found.append(np.mean([more[cls == c].mean() for c in range(3)]))
    assert gain == pytest.approx(np.mean(found), abs=2.0 * se)
    assert se == pytest.approx(np.std(found), rel=0.25)
