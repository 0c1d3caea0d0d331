"""Blind zones and redundancy while a sensor is dragged, against a budget of time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from statistics import median

import pytest

from riglens.core.engine.engine import Engine
from riglens.core.engine.inspect import covered_at_least
from riglens.core.metric.scores import MetricSettings
from riglens.core.review.blind import BlindEngine, BlindSettings
from riglens.core.review.redundancy import VoxelRedundancy
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


@pytest.mark.parametrize("name", DRAGGED)
def test_redundancy_of_one_step(bars: list[Bar], scenes: Scenes, rounds: int, name: str) -> None:
    field = scenes.at(0.1).field
    rigs, engine, counted = drag(name), Engine(field, THREADS), VoxelRedundancy(field, THREADS)

    def step() -> Callable[[], object]:
        rig = next(rigs)
        engine.evaluate(rig, MetricSettings(), False)
        return lambda: counted.coverage(engine, rig)

    for _ in range(2):  # from the second move of the same sensor on only changes are counted
        step()()
    work = f"W+T: all singles and pairs, by class and sector, {DRAGGED[name]} moved, its casting not counted"
    bars.append(_bar("redundancy", work, _median_ms(step, rounds)))


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


def _median_ms(step: Callable[[], Callable[[], object]], rounds: int) -> float:
    """Median time of what a step, which is not measured, hands out."""
    times = []
    for _ in range(rounds):
        work = step()
        started = time.perf_counter()
        work()
        times.append((time.perf_counter() - started) * 1e3)
    return median(times)


def _bar(name: str, work: str, ms: float) -> Bar:
    return Bar(name, f"{work}, {THREADS} threads", ms, BUDGET_MS, ms / BUDGET_MS, GOAL, "lower")
