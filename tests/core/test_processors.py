"""Threads of an edit: as many as other programs leave processors, and all of them where it takes long."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from riglens.core.engine import engine as module
from riglens.core.engine.engine import Engine
from riglens.core.engine.processors import LONG_MS, PERIOD_S, Processors, Work, work_until_now
from tests.core.builders import grid_of, random_field, rig_of, spinning


@dataclass
class Computer:
    """A clock, and what programs have worked by it."""

    now_s: float = 0.0
    others_s: float = 0.0
    own_s: float = 0.0

    def run(self, seconds: float, others: float, own: float) -> None:
        """Let time pass, in which so many processors work for others, and so many for us."""
        self.now_s += seconds
        self.others_s += others * seconds
        self.own_s += own * seconds

    def processors(self, count: int = 4) -> Processors:
        """What is known of its processors."""
        return Processors(count, lambda: self.now_s, lambda: Work(self.others_s + self.own_s, self.own_s))


@pytest.mark.parametrize(
    ("others", "threads"), [(0.0, 4), (0.4, 4), (0.6, 3), (2.0, 2), (2.9, 1), (4.0, 1), (5.0, 1)]
)
@pytest.mark.parametrize("own", [0.0, 1.0])
def test_a_short_edit_gets_the_processors_that_others_leave(others: float, own: float, threads: int) -> None:
    computer = Computer()
    processors = computer.processors()
    assert processors.threads(4, 5.0) == 4
    computer.run(1.0, others, own)
    assert processors.threads(4, 5.0) == threads
    assert processors.threads(2, 5.0) == min(2, threads)


def test_a_long_edit_gets_all_threads_and_one_thread_is_one() -> None:
    computer = Computer()
    processors = computer.processors()
    computer.run(1.0, 4.0, 0.0)
    assert processors.threads(4, LONG_MS) == 4
    assert processors.threads(1, 5.0) == 1


def test_it_is_looked_up_a_few_times_a_second() -> None:
    computer = Computer()
    processors = computer.processors()
    computer.run(PERIOD_S, 4.0, 0.0)
    assert processors.threads(4, 5.0) == 1
    computer.run(0.9 * PERIOD_S, 0.0, 0.0)
    assert processors.threads(4, 5.0) == 1
    computer.run(0.1 * PERIOD_S, 0.0, 0.0)
    assert processors.threads(4, 5.0) == 4


def test_the_system_tells_of_its_work_and_of_ours() -> None:
    before = work_until_now()
    sum(i * i for i in range(200_000))
    after = work_until_now()
    assert after.own >= before.own > 0.0
    assert after.everyone >= before.everyone > 0.0


def test_the_number_of_threads_changes_from_edit_to_edit_and_no_score_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rng = np.random.default_rng(3)
    field = random_field(grid_of(10, 9, 70, 0.5), rng)
    few = iter([1, 4, 2, 1, 3, 4])
    monkeypatch.setattr(module.Processors, "threads", lambda *_: next(few))
    varying, alone = Engine(field, 4), Engine(field, 1)
    monkeypatch.setattr(alone._processors, "threads", lambda *_: 1)
    for step in range(6):
        place = (0.3 * step, 0.2, 1.0)
        rig = rig_of(spinning(place, (3.0, 2.0, 1.0), beams=9, count=100), spinning((0.0, 0.0, 2.0)))
        one, other = varying.evaluate(rig), alone.evaluate(rig)
        assert one.scores == other.scores
        assert np.array_equal(one.seen["lidar"], other.seen["lidar"])
