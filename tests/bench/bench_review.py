"""Blind zones and redundancy while a sensor is dragged: what comes on top of casting it, against a budget of time."""

from __future__ import annotations

import time
from collections.abc import Callable
from statistics import median

from riglens.core.engine.engine import Engine
from riglens.core.metric.scores import MetricSettings
from riglens.core.review.blind import BlindEngine, BlindSettings
from riglens.core.review.redundancy import VoxelRedundancy
from tests.bench.bars import Bar
from tests.bench.scenes import Scenes, wide_trapezoid

THREADS = 2
BUDGET_MS, GOAL = 5.0, 1.0


def test_redundancy_of_one_step(bars: list[Bar], scenes: Scenes, rounds: int) -> None:
    field = scenes.at(0.1).field
    rig, engine = wide_trapezoid(), Engine(field, THREADS)
    engine.evaluate(rig, MetricSettings(), False)
    counted = VoxelRedundancy(field, THREADS)
    ms = _median_ms(lambda: counted.coverage(engine, rig), rounds)
    bars.append(_bar("redundancy", "W+T: all singles and pairs, by class and sector", ms))


def test_blind_zones_of_one_step(bars: list[Bar], rounds: int) -> None:
    rig = wide_trapezoid()
    for within_m in (10.0, 20.0):
        engine = BlindEngine(rig.vehicle, BlindSettings(within_m=within_m), threads=THREADS)
        engine.evaluate(rig)
        ms = _median_ms(lambda found=engine: found.lowest(rig), rounds)  # type: ignore[misc]
        bars.append(_bar("blind zones", f"W+T: L_1 and L_2 within {within_m:g} m of the car", ms))


def _median_ms(work: Callable[[], object], rounds: int) -> float:
    times = []
    for _ in range(rounds):
        started = time.perf_counter()
        work()
        times.append((time.perf_counter() - started) * 1e3)
    return median(times)


def _bar(name: str, work: str, ms: float) -> Bar:
    return Bar(name, f"{work}, {THREADS} threads", ms, BUDGET_MS, ms / BUDGET_MS, GOAL, "lower")
