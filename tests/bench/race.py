"""Ours against a yardstick, one after the other, again and again: the median of each, and their ratio."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

from tests.bench.bars import Bar, Better

Case = TypeVar("Case")


@dataclass(frozen=True)
class Goal:
    """What is measured, on what work, and which ratio is wanted."""

    bar: str
    work: str
    ratio: float
    better: Better = "higher"


@dataclass
class Race:
    """Measures one bar; `bars` is the list that all races of a run add to.

    pytest-benchmark times ours; the yardstick runs and is timed in the set-up of each of its rounds, so the
    two alternate. "higher": ratio = yardstick / ours (how often faster); "lower": ours / yardstick.
    """

    benchmark: Any
    bars: list[Bar]
    rounds: int

    def run(
        self,
        goal: Goal,
        cases: Iterator[Case],
        ours: Callable[[Case], object],
        yardstick: Callable[[Case], object],
        scale: float = 1.0,
        rounds: int | None = None,
    ) -> Bar:
        """Time both on each case; making the case is not timed. `scale` multiplies the yardstick."""
        yardstick_s: list[float] = []

        def time_yardstick() -> tuple[tuple[Case], dict[str, Any]]:
            case = next(cases)
            started = time.perf_counter()
            yardstick(case)
            yardstick_s.append((time.perf_counter() - started) * scale)
            return (case,), {}

        count = min(rounds or self.rounds, self.rounds)
        self.benchmark.pedantic(ours, setup=time_yardstick, rounds=count, warmup_rounds=1)
        ours_ms = statistics.median(self.benchmark.stats.stats.data) * 1e3
        yardstick_ms = statistics.median(yardstick_s[1:]) * 1e3
        ratio = yardstick_ms / ours_ms if goal.better == "higher" else ours_ms / yardstick_ms
        bar = Bar(goal.bar, goal.work, ours_ms, yardstick_ms, ratio, goal.ratio, goal.better)
        self.bars.append(bar)
        return bar

    def within(
        self, goal: Goal, cases: Iterator[Case], ours: Callable[[Case], object], budget_ms: float
    ) -> Bar:
        """Time ours on each case against a fixed time, for what is to be quick on the machine of the bars."""
        self.benchmark.pedantic(ours, setup=lambda: ((next(cases),), {}), rounds=self.rounds, warmup_rounds=1)
        ours_ms = statistics.median(self.benchmark.stats.stats.data) * 1e3
        bar = Bar(goal.bar, goal.work, ours_ms, budget_ms, ours_ms / budget_ms, goal.ratio, goal.better)
        self.bars.append(bar)
        return bar
