"""Tolerances: nothing comes of nothing, small errors add up as their derivatives say, a car moves with its sensors."""

import math
from typing import Any

import numpy as np
import pytest

from riglens.core.engine.engine import Engine
from riglens.core.errors import Cancelled, InputError
from riglens.core.figures.evaluated import EvaluationSettings, Evaluator
from riglens.core.figures.figure import SE_FACTOR, Estimate
from riglens.core.figures.registry import tolerated_figures
from riglens.core.geometry import Pose
from riglens.core.metric.scores import MetricSettings
from riglens.core.review.documents import tolerance_document
from riglens.core.review.measures import FEW_CHANGED, Measures, measured_name
from riglens.core.review.redundancy import coverage_of
from riglens.core.review.tolerance import (
    PROFILES,
    Spread,
    ToleranceProfile,
    ToleranceRun,
    disturbed,
    errors_count,
    profile_called,
    rig_of_draw,
    standing,
    tolerance,
    unit_draws,
    worst_rig,
)
from riglens.core.rig.model import Rig, Sensor, Vehicle
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.grid import VoxelGrid
from riglens.core.targets.contribution import TargetCaster
from riglens.core.targets.engine import TargetEngine
from riglens.core.targets.settings import TargetSettings
from riglens.core.vehicle.solid import solid_of
from tests.core.builders import random_field
from tests.core.review.scenes import BOX, random_rig
from tests.core.review.test_redundancy import some_traffic
from tests.core.targets.cases import parts

SMALL = VoxelGrid(0.5, (20.0, 16.0, 4.0))


def ring_m(rig: Rig, stance: Pose) -> dict[str, Estimate]:
    """Where the optical axes of the sensors, which look down, meet the ground: smooth in every error."""
    total = 0.0
    for sensor in standing(rig, stance).sensors:
        ahead = sensor.pose.rotation()[:, 0]
        total += sensor.position[0] - sensor.position[2] * ahead[0] / ahead[2]
    return {"ring": Estimate(total)}


def looking_down() -> Rig:
    rig = random_rig(np.random.default_rng(3), 4)
    sensors = [
        s.replace(rpy_deg=(0.0, 30.0, 5.0 * n), position=(0.3 * n, 0.1, 1.8))
        for n, s in enumerate(rig.sensors)
    ]
    return rig.replace(sensors=tuple(sensors))


def test_without_tolerance_there_is_no_spread_and_the_rig_is_the_very_same() -> None:
    rig = looking_down()
    nothing = ToleranceProfile(name="none", source="a test")
    for errors in unit_draws(4, errors_count(rig), 1):
        assert disturbed(rig, nothing, errors) == (rig, Pose())
    field = random_field(SMALL, np.random.default_rng(0))
    found = tolerance(rig, nothing, Measures(Evaluator(field)), 8)
    for spread in found.spreads.values():
        assert {spread.nominal, spread.median, spread.p05, spread.p95, spread.worst} == {spread.nominal}
    assert found.sensitivities == ()


def test_small_errors_spread_as_first_order_says() -> None:
    rig = looking_down()
    for profile in (
        profile_called("assembly"),
        ToleranceProfile(name="r", source="t", car_pitch_deg=0.2, car_heave_mm=5.0),
    ):
        found = tolerance(rig, profile, ring_m, 512, seed=2)
        spread = float(np.std(found.spreads["ring"].values))
        # errors drawn evenly within plus or minus 1 have a variance of a third
        predicted = math.sqrt(sum(one.effect["ring"] ** 2 for one in found.sensitivities) / 3.0)
        assert spread == pytest.approx(predicted, rel=0.1) and spread > 0.0
    pitch = next(one for one in found.sensitivities if one.axis == "pitch")
    step = math.radians(0.2)
    per_rad = sum(s.position[2] / math.sin(math.radians(30.0)) ** 2 for s in rig.sensors)
    assert abs(pitch.effect["ring"]) == pytest.approx(per_rad * step, rel=0.35)
    heave = next(one for one in found.sensitivities if one.axis == "z")
    assert heave.effect["ring"] == pytest.approx(
        sum(0.005 * math.cos(math.radians(5.0 * n)) / math.tan(math.radians(30.0)) for n in range(4)),
        rel=1e-6,
    )


def test_a_spread_is_told_from_below_with_its_least() -> None:
    spread = Spread.of(7.0, [float((37 * n) % 101) for n in range(101)])
    assert (spread.nominal, spread.p05, spread.median, spread.p95) == pytest.approx((7.0, 5.0, 50.0, 95.0))
    assert (spread.worst, spread.worst_draw) == (0.0, 0)


def test_sensitivities_belong_to_their_sensor_and_the_floor_to_a_millimetre() -> None:
    rig, profile = looking_down(), profile_called("service")
    off = rig.sensors[-1].replace(name="off", enabled=False)
    found = tolerance(rig.replace(sensors=(*rig.sensors, off)), profile, ring_m, 64, seed=1)
    effect = {(one.sensor, one.axis): one.effect["ring"] for one in found.sensitivities}
    step = profile.position_mm / 1e3
    assert "off" not in {sensor for sensor, _ in effect}
    for n, sensor in enumerate(rig.sensors):
        assert effect[sensor.name, "x"] == pytest.approx(step)
        ahead = math.cos(math.radians(5.0 * n)) / math.tan(math.radians(30.0))
        assert effect[sensor.name, "z"] == pytest.approx(step * ahead)
    assert np.std(found.floor["ring"].values) < 0.3 * np.std(found.spreads["ring"].values)


def test_draws_are_balanced_the_same_for_a_seed_and_within_their_limits() -> None:
    one, again, other = unit_draws(64, 12, 5), unit_draws(64, 12, 5), unit_draws(64, 12, 6)
    assert np.array_equal(one, again) and not np.array_equal(one, other)
    assert one.min() >= -1.0 and one.max() < 1.0
    counts = np.stack([np.histogram(column, 8, (-1.0, 1.0))[0] for column in one.T])
    assert np.all(counts == 8)
    rig, profile = looking_down(), profile_called("service")
    for errors in unit_draws(16, errors_count(rig), 0):
        moved, stance = disturbed(rig, profile, errors)
        assert stance == Pose()
        for sensor, was in zip(moved.sensors, rig.sensors, strict=True):
            assert np.abs(np.subtract(sensor.position, was.position)).max() <= 0.005 + 1e-12
            turn = sensor.pose.rotation() @ was.pose.rotation().T
            assert (
                math.degrees(math.acos(min(1.0, (np.trace(turn) - 1.0) / 2.0))) <= 0.3 * math.sqrt(3.0) + 1e-6
            )
    for wrong in (0, 5000):
        with pytest.raises(InputError, match=r"^draws must be"):
            unit_draws(wrong, 3, 0)
    with pytest.raises(InputError, match="must be one of assembly"):
        profile_called("nothing")


def test_sensors_of_a_bracket_move_together() -> None:
    rig = looking_down()
    names = ("bar", "bar", None, "post")
    sensors = [
        s.replace(fails_with=(n, "ecu") if n else None) for s, n in zip(rig.sensors, names, strict=True)
    ]
    rig = rig.replace(sensors=tuple(sensors))
    profile = ToleranceProfile(name="b", source="t", bracket_position_mm=20.0, bracket_angle_deg=2.0)
    errors = unit_draws(3, errors_count(rig), 0)[2]
    moved, _ = disturbed(rig, profile, errors)
    before, after = (np.array([s.position for s in r.sensors]) for r in (rig, moved))
    assert np.linalg.norm(after[1] - after[0]) == pytest.approx(
        np.linalg.norm(before[1] - before[0]), abs=1e-12
    )
    turns = [a.pose.rotation() @ b.pose.rotation().T for a, b in zip(moved.sensors, rig.sensors, strict=True)]
    np.testing.assert_allclose(turns[0], turns[1], atol=1e-12)
    np.testing.assert_allclose(turns[0] @ (before[1] - before[0]), after[1] - after[0], atol=1e-12)
    assert moved.sensors[2] == rig.sensors[2] and not np.allclose(turns[3], turns[0])


def test_a_bracket_turns_about_the_middle_of_what_it_carries() -> None:
    rig = looking_down()
    sensors = (*(s.replace(fails_with=("bar",)) for s in rig.sensors[:3]), rig.sensors[3])
    rig = rig.replace(sensors=sensors)
    profile = ToleranceProfile(name="b", source="t", bracket_angle_deg=2.0)
    moved, _ = disturbed(rig, profile, np.ones(errors_count(rig)))
    before, after = (np.array([s.position for s in r.sensors[:3]]) for r in (rig, moved))
    np.testing.assert_allclose(after.mean(axis=0), before.mean(axis=0), atol=1e-12)
    assert (np.linalg.norm(after - before, axis=1)[[0, 2]] > 1e-3).all()


def test_a_pitching_car_takes_body_and_sensors_along_and_leaves_the_traffic() -> None:
    rng = np.random.default_rng(8)
    field, traffic = random_field(SMALL, rng), some_traffic(rng)
    rig = random_rig(rng, 4).replace(vehicle=Vehicle(length=3.0, width=1.6, height=1.2))
    stance = Pose((0.0, 0.0, 0.1), (2.0, 3.0, 0.0))
    moved = standing(rig, stance)
    for sensor, was in zip(moved.sensors, rig.sensors, strict=True):
        np.testing.assert_allclose(sensor.position, stance.transform(was.position), atol=1e-12)
    solid, turned = (solid_of(BOX, how) for how in (Pose(), stance))
    np.testing.assert_allclose(turned.triangles_m, stance.transform(solid.triangles_m), atol=1e-9)
    assert turned.fingerprint != solid.fingerprint
    blocked = MetricSettings(body="blocks")
    with_body, free = (
        Measures(Evaluator(field, traffic, EvaluationSettings(one, TargetSettings(body=one.body))))(
            rig, stance
        )
        for one in (blocked, MetricSettings())
    )
    lost = [
        (free[name].value - with_body[name].value) * (1.0 if figure.better == "more" else -1.0)
        for figure in tolerated_figures()
        for name in (measured_name(figure, cls) for cls in CLASSES)
    ]
    assert min(lost) >= 0.0 and max(lost) > 0.0
    engine = Engine(field)
    there = engine.evaluate(moved, blocked, False, stance=stance).scores.classes["car"].any_seen
    assert there == with_body["seen car"].value
    assert engine.evaluate(moved, blocked, False).scores.classes["car"].any_seen != there


def test_the_worst_draw_can_be_drawn_again() -> None:
    rig = looking_down()
    profile = profile_called("assembly")
    found = tolerance(rig, profile, ring_m, 100, seed=3, with_sensitivities=False)
    spread = found.spreads["ring"]
    errors = unit_draws(100, errors_count(rig), 3)[spread.worst_draw]
    assert ring_m(*disturbed(rig, profile, errors))["ring"].value == spread.worst == min(spread.values)
    assert found.sensitivities == () and len(spread.values) == 100
    assert all(profile.source for profile in PROFILES)


def test_draws_taken_one_by_one_with_pauses_are_those_of_one_go() -> None:
    rig, profile = looking_down(), profile_called("assembly")
    told = list[float]()
    whole = tolerance(rig, profile, ring_m, 16, 3, with_sensitivities=False, progress=told.append)
    assert told == [done / 21 for done in range(1, 22)]
    run, known = ToleranceRun(rig, profile, 16, 3), []
    assert run.result() is None and run.steps == 1 + 16 + 4
    while run.done < run.steps:
        assert run.wanted() == run.wanted()
        run.take(ring_m(*run.wanted()))
        known.append(run.result())
    assert known[0] is None and known[1] is None and known[-1] == whole
    half = known[9]
    assert half is not None and half.draws == 16
    drawn = half.spreads["ring"].values
    assert 2 < len(drawn) < 10 and drawn == whole.spreads["ring"].values[: len(drawn)]
    assert len(half.floor["ring"].values) >= len(drawn) // 4


@pytest.mark.parametrize("draws", [1, 3, 4, 5, 10, 66])
def test_the_noise_floor_has_a_quarter_of_the_draws_rounded_down_and_at_least_one(draws: int) -> None:
    run = ToleranceRun(looking_down(), profile_called("assembly"), draws)
    assert run.steps == 1 + draws + max(1, draws // 4)


def test_a_measurement_that_is_given_up_gives_nothing_and_the_next_is_whole() -> None:
    rng = np.random.default_rng(5)
    field, traffic, rig = random_field(SMALL, rng), some_traffic(rng), random_rig(rng, 3)
    measures, never = (Measures(Evaluator(field, traffic)) for _ in range(2))
    with pytest.raises(Cancelled):
        measures(rig, Pose(), cancel=lambda: True)
    assert measures(rig, Pose(), cancel=lambda: False) == never(rig, Pose())


def test_the_rig_as_designed_has_its_figure_of_all_frames_and_errors_change_it_as_the_sample_shows() -> None:
    rng = np.random.default_rng(5)
    field, traffic, rig = random_field(SMALL, rng), some_traffic(rng), random_rig(rng, 3)
    used, settings = 7, TargetSettings(body=MetricSettings().body)
    evaluate = Evaluator(field, traffic, EvaluationSettings(targets=settings))
    measures = Measures(evaluate, used, rig)
    whole = TargetEngine(traffic).evaluate(rig, settings)
    assert measures.frames == (used, 12)
    profile = profile_called("service")
    found = tolerance(rig, profile, measures, 8, with_sensitivities=False, frames=measures.frames)
    moved, stance = rig_of_draw(found, found.spreads["on_target car"].worst_draw)
    before, after = (TargetEngine(traffic).evaluate(one, settings, used).objects for one in (rig, moved))
    gain, frame = after.on_target - before.on_target, traffic.frame_of_box[before.box]
    document = tolerance_document(found, "ignored")["sample"]
    assert document["frames"] == used and {f"on_target {c}" for c in CLASSES} <= set(document["worst_se"])
    for number, cls in enumerate(CLASSES):
        total = parts(whole)[cls].total.on_target.value
        assert (
            found.spreads[f"on_target {cls}"].nominal
            == total
            == measures(rig, Pose())[f"on_target {cls}"].value
        )
        mine = traffic.cls[before.box] == number
        change, sums = gain[mine].mean(), np.zeros(used)
        np.add.at(sums, frame[mine], gain[mine] - change)
        few = np.count_nonzero(gain[mine]) < FEW_CHANGED
        se = math.sqrt((1 - used / 12) * max((sums**2).sum() / (used - 1) * used, 1.0 * few)) / mine.sum()
        estimate = measures(moved, stance)[f"on_target {cls}"]
        assert estimate.value == pytest.approx(total + change) and estimate.se == pytest.approx(se)
    worst, again = found.spreads["on_target car"].worst, measures(moved, stance)["on_target car"]
    assert worst == again.value < parts(whole)["car"].total.on_target.value
    assert document["worst_se"]["on_target car"] == again.se > 0.0
    free = Measures(Evaluator(field, traffic), used)(rig, Pose())
    assert free["on_target car"].value != measures(rig, Pose())["on_target car"].value


def test_a_draw_of_some_frames_is_within_its_error_of_the_same_draw_in_all() -> None:
    rng = np.random.default_rng(5)
    field, traffic, rig = random_field(SMALL, rng), some_traffic(rng), random_rig(rng, 3)
    few, every = (Measures(Evaluator(field, traffic), used, rig) for used in (9, None))
    profile, away = profile_called("service"), list[float]()
    for errors in unit_draws(4, errors_count(rig), 1):
        moved = disturbed(rig, profile, errors)
        sampled, whole = few(*moved), every(*moved)
        assert sampled.keys() == whole.keys()
        for name, one in sampled.items():
            assert whole[name].se == 0.0
            away += [abs(one.value - whole[name].value) / one.se] if one.se else []
            assert one.se or name.startswith("seen ")
    assert len(away) > 20 and np.mean(np.array(away) <= SE_FACTOR) > 0.8 and max(away) < 4.0


def test_only_what_an_error_moves_is_cast_again(monkeypatch: pytest.MonkeyPatch) -> None:
    rng, cast = np.random.default_rng(5), list[tuple[float, float, float]]()
    field, traffic, rig = random_field(SMALL, rng), some_traffic(rng), random_rig(rng, 3)
    real = TargetCaster.cast

    def counted(self: TargetCaster, sensor: Sensor, *how: Any) -> Any:
        cast.append(sensor.position)
        return real(self, sensor, *how)

    monkeypatch.setattr(TargetCaster, "cast", counted)
    evaluate = Evaluator(field, traffic)
    coverage_of(evaluate, rig, "objects")
    measures = Measures(evaluate, 7, rig)
    measures(rig, Pose())
    assert sorted(cast) == sorted(sensor.position for sensor in rig.sensors)
    for number in range(len(rig.sensors)):
        for way in (1.0, -1.0):
            cast.clear()
            errors = np.zeros(errors_count(rig))
            errors[6 * number] = way
            moved, stance = disturbed(rig, profile_called("service"), errors)
            measures(moved, stance)
            assert cast == [moved.sensors[number].position]


def test_a_rig_has_the_same_figures_whichever_was_measured_before() -> None:
    """Of one rig all sensors have moved, of the next one alone, of another none."""
    rng = np.random.default_rng(6)
    field, traffic, rig = random_field(SMALL, rng), some_traffic(rng), random_rig(rng, 3)
    one, every = np.zeros(errors_count(rig)), rng.uniform(-1.0, 1.0, errors_count(rig))
    one[0] = 1.0
    rigs = [disturbed(rig, profile_called("service"), errors) for errors in (every, one, 0.0 * one, -every)]
    measures = Measures(Evaluator(field, traffic), 5)
    for number in rng.integers(0, len(rigs), 12):
        assert measures(*rigs[number]) == Measures(Evaluator(field, traffic), 5)(*rigs[number])


def test_the_worst_rig_is_magnified_to_be_seen() -> None:
    rig, profile = looking_down(), profile_called("assembly")
    found = tolerance(rig, profile, ring_m, 8, with_sensitivities=False)
    name = rig.sensors[0].name
    here, near, far = (np.array(made.sensor(name).position) for made in (
        rig, worst_rig(found, "ring"), worst_rig(found, "ring", 50.0)
    ))  # fmt: skip
    assert 0.0 < np.abs(near - here).max() <= 0.003
    np.testing.assert_allclose(far - here, 50.0 * (near - here), atol=1e-9)
