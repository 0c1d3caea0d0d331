"""Blind zones, redundancy, failing sensors, mounts and tolerance while a sensor is dragged: against a budget."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from itertools import cycle, pairwise
from statistics import median

import pytest

from riglens.core.blind.zones import BlindEngine, BlindSettings
from riglens.core.engine.engine import Engine
from riglens.core.engine.inspect import covered_at_least
from riglens.core.figures.evaluated import Evaluator
from riglens.core.metric.scores import MetricSettings
from riglens.core.review.measures import Measures
from riglens.core.review.mounts import USUAL_LIMITS, violations
from riglens.core.review.tolerance import ToleranceRun, profile_called
from riglens.core.rig.model import Rig
from tests.bench.bars import Bar
from tests.bench.scenes import Scenes, moved, wide_trapezoid

THREADS = 2
BUDGET_MS, GOAL = 5.0, 1.0
DRAGGED = {"LIDAR_1": "a LiDAR", "CAM_FRONT": "a camera"}


def drag(name: str) -> Iterator[Rig]:
    """W+T, one of its sensors at another place each time."""
    rig, number = wide_trapezoid(), 0
    while True:
        number += 1
        yield rig.with_sensor(name, moved(rig.sensor(name), number))


def test_voxels_seen_by_1_2_and_3_sensors(bars: list[Bar], scenes: Scenes, rounds: int) -> None:
    engine, rig = scenes.at(0.1).engine(THREADS), wide_trapezoid()
    engine.evaluate(rig, MetricSettings(), False)
    ms = _median_ms(lambda: lambda: covered_at_least(engine, rig, "exact"), rounds)
    bars.append(_bar("redundancy", "W+T: voxels that 1, 2 and 3 sensors see, for heatmap and map", ms))


@pytest.mark.parametrize("name", DRAGGED)
@pytest.mark.parametrize("within_m", [10.0, 20.0])
def test_blind_zones_of_one_step(bars: list[Bar], rounds: int, within_m: float, name: str) -> None:
    rigs = drag(name)
    engine = BlindEngine(wide_trapezoid().vehicle, BlindSettings(within_m=within_m), threads=THREADS)
    engine.evaluate(next(rigs))

    def step() -> Callable[[], object]:
        rig = next(rigs)
        return lambda: engine.evaluate(rig)

    work = f"W+T: L_1 to L_3 within {within_m:g} m of the car, {DRAGGED[name]} moved and cast"
    bars.append(_bar("blind zones", work, _median_ms(step, rounds)))


@pytest.mark.parametrize("name", DRAGGED)
def test_a_sensor_fails_and_works_again(bars: list[Bar], scenes: Scenes, rounds: int, name: str) -> None:
    engine, whole = Engine(scenes.at(0.1).field, THREADS), wide_trapezoid()
    failed = whole.with_sensor(name, whole.sensor(name).model_copy(update={"enabled": False}))
    turns = cycle((failed, whole))
    engine.evaluate(whole, MetricSettings(), False)

    def step() -> Callable[[], object]:
        rig = next(turns)
        return lambda: engine.evaluate(rig, MetricSettings(), False)

    ms = _median_ms(step, rounds)
    bars.append(_bar("fail", f"W+T: all scores once {DRAGGED[name]} fails, and once it works again", ms))


def test_mounts_of_one_step(bars: list[Bar], rounds: int) -> None:
    """By a thread of its own with serial code, as the window finds them."""
    rigs = drag("LIDAR_1")
    violations(next(rigs), USUAL_LIMITS)

    def step() -> Callable[[], object]:
        rig = next(rigs)
        return lambda: violations(rig, USUAL_LIMITS)

    ms = _median_ms(step, rounds)
    bars.append(_bar("mounts", "W+T: all that is wrong with the places of ten sensors, one moved", ms, 1))


def test_what_an_edit_waits_for_tolerances(bars: list[Bar], scenes: Scenes, rounds: int) -> None:
    """While nobody edits, draws are measured one after the other: how long until one says that it gives way."""
    rig, measures = wide_trapezoid(), Measures(Evaluator(scenes.at(0.1).field, threads=THREADS))
    run = ToleranceRun(rig, profile_called("assembly"), 16)
    waits: list[float] = []
    for _ in range(rounds):
        asked = [time.perf_counter()]

        def is_stale(asked: list[float] = asked) -> bool:
            asked.append(time.perf_counter())
            return False

        run.take(measures(*run.wanted(), cancel=is_stale))
        asked.append(time.perf_counter())
        waits.append(max(b - a for a, b in pairwise(asked)) * 1e3)
    bars.append(
        _bar("tolerance", "W+T: longest time until a draw asks whether somebody edits", median(waits))
    )


def _median_ms(step: Callable[[], Callable[[], object]], rounds: int) -> float:
    """Median time of what a step, which is not measured, hands out."""
    times = []
    for _ in range(rounds):
        work = step()
        started = time.perf_counter()
        work()
        times.append((time.perf_counter() - started) * 1e3)
    return median(times)


def _bar(name: str, work: str, ms: float, threads: int = THREADS) -> Bar:
    on = f"{threads} thread{'s' * (threads > 1)}"
    return Bar(name, f"{work}, {on}", ms, BUDGET_MS, ms / BUDGET_MS, GOAL, "lower")
