"""Points on road users: all frames of the town, one moved sensor, and a sample, against a budget of time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from statistics import median

import pytest

from riglens.core.rig.model import Rig
from riglens.core.scene.readers.bundled import bundled_source
from riglens.core.targets.engine import TargetEngine, warm_up
from riglens.core.targets.traffic import Traffic, read_traffic
from tests.bench.bars import Bar
from tests.bench.scenes import moved, names_of, wide_trapezoid

THREADS = 2
SAMPLE_FRAMES = 100
SCRATCH_MS, EDIT_MS, SAMPLE_MS = 1000.0, 60.0, 16.0
GOAL = 1.0


@pytest.fixture(scope="module")
def traffic() -> Traffic:
    """The bundled town, with the kernels loaded."""
    warm_up(THREADS)
    return read_traffic(bundled_source())


def test_all_frames_from_scratch(bars: list[Bar], traffic: Traffic, rounds: int) -> None:
    ms = _median_ms(
        lambda _: TargetEngine(traffic, THREADS).evaluate(wide_trapezoid()), range(min(rounds, 5))
    )
    bars.append(_bar("targets", f"W+T, all {traffic.frames:,} frames from scratch", ms, SCRATCH_MS))


@pytest.mark.parametrize("kind", ["lidar", "camera"])
def test_one_moved_sensor(bars: list[Bar], traffic: Traffic, rounds: int, kind: str) -> None:
    engine, rigs = TargetEngine(traffic, THREADS), list(_moves(kind, rounds))
    engine.evaluate(wide_trapezoid())
    ms = _median_ms(lambda number: engine.evaluate(rigs[number]), range(rounds))
    bars.append(_bar("targets edit", f"one {kind} of W+T moved, all {traffic.frames:,} frames", ms, EDIT_MS))
    ms = _median_ms(lambda number: engine.evaluate(rigs[-1 - number], frames=SAMPLE_FRAMES), range(rounds))
    bars.append(_bar("targets sample", f"one {kind} of W+T moved, {SAMPLE_FRAMES} frames", ms, SAMPLE_MS))


def _moves(kind: str, count: int) -> Iterator[Rig]:
    rig = wide_trapezoid()
    (name, *_) = names_of(rig, kind)
    for number in range(1, count + 1):
        yield rig.with_sensor(name, moved(rig.sensor(name), number))


def _median_ms(work: Callable[[int], object], numbers: range) -> float:
    times = []
    for number in numbers:
        started = time.perf_counter()
        work(number)
        times.append((time.perf_counter() - started) * 1e3)
    return median(times)


def _bar(name: str, work: str, ours_ms: float, budget_ms: float) -> Bar:
    return Bar(name, f"{work}, {THREADS} threads", ours_ms, budget_ms, ours_ms / budget_ms, GOAL, "lower")
