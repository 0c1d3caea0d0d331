"""The space of a search: candidates with their limits, and what sets of them are worth, in integers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from riglens.core.errors import IsStale, never_stale
from riglens.core.optimise.bounds import Cap
from riglens.core.optimise.candidates import Choices
from riglens.core.optimise.guard import ObjectSampler
from riglens.core.optimise.makers import Ground, Maker, MeasuredSets, TableMaker, maker_of
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.results import CASTING, Progress
from riglens.core.optimise.search import AtLeast, Limits, greedy, unwatched
from riglens.core.optimise.skin import SkinGains
from riglens.core.optimise.tables import Cells, CoverTable, SetFunction, WorstFailure
from riglens.core.rig.model import Rig, Sensor

FIRST = 60
"""Sensors after which a first proposal is made of those that have been cast, in an order drawn by the seed."""
_NOTHING = np.zeros(0, np.int32)


@dataclass(frozen=True)
class Space:
    """Candidates of a problem and what sets of them are worth, in integers.

    figure: the objective; goal: the same after every moved sensor has a place; plain: that without failures; caps:
    tables with limits of sets whose best is worth no less than that of the objective; sampler: of objectives of
    objects; maker: makes the tables, or measures each set; skin: gains of single candidates, where there are tables.
    """

    problem: Problem
    choices: Choices
    figure: SetFunction
    goal: SetFunction
    plain: SetFunction
    caps: Sequence[Cap]
    sampler: ObjectSampler
    maker: Maker[Any] | MeasuredSets
    skin: SkinGains | None
    ground: Ground | None

    def value_of(self, rig: Rig, is_stale: IsStale = never_stale) -> float:
        """Measure the figure of a rig in the frames of choice, or exactly."""
        problem = self.problem
        if problem.goal.of_objects:
            return self.sampler(rig, problem.settings, (0, problem.frames)).value
        assert isinstance(self.maker, Maker)
        covered = self.maker.cells_of(problem.goal.sensors_of(rig), is_stale)
        return self.maker.shown(self.maker.table(covered, []).value([]))

    def adds(self, chosen: Sequence[int]) -> tuple[float, ...]:
        """Return by how much each candidate of a set but those that stay makes the figure better, in its unit."""
        whole, gain = self.figure.value(chosen), self.maker.shown_gains
        rests = [
            self.figure.value([other for other in chosen if other != one])
            for one in chosen
            if not self.choices.candidates[one].is_as_now
        ]
        return tuple(gain(np.array([whole - rest for rest in rests], np.int64)).tolist())


def cast(
    problem: Problem,
    choices: Choices,
    workers: int,
    report: Callable[[Progress], None] = unwatched,
    is_stale: IsStale = never_stale,
) -> Space:
    """Cast the coverage of the rig and of each candidate, in an order drawn by the seed; build the tables."""
    listed, limits, goal = choices.candidates, choices.limits, problem.goal
    sampler = ObjectSampler(problem.traffic, workers, goal, problem.weights, is_stale)
    maker = maker_of(problem, listed, sampler, workers)
    ground = None if problem.blind_m is None else Ground(problem.rig, choices.rest, problem.blind_m, workers)
    own, best = goal.sensors_of(choices.rest), None
    base: Any = maker.cells_of(own, is_stale) if isinstance(maker, Maker) else _NOTHING
    order = np.random.default_rng(problem.seed).permutation(len(listed)).tolist()
    first = min(FIRST // (2 if problem.additions.mirrored else 1), len(listed))
    cells = dict[int, Any]()
    each = maker.each([listed[one].sensors for one in order], is_stale)
    for number, (one, covers) in enumerate(zip(order, each, strict=True), 1):
        cells[one] = covers
        if ground is not None:
            ground.look(one, listed[one].sensors)
        if number == first and isinstance(maker, Maker):
            some = sorted(cells)
            table = maker.table(base, [cells[one] for one in some])
            best = choices.rig_with([some[place] for place in greedy(table, limits.among(some))])
        report(Progress(CASTING, number / len(order), best))
    if isinstance(maker, MeasuredSets):
        worth = filled(maker, choices)
        return Space(problem, choices, maker, worth, worth, (), sampler, maker, None, ground)
    found = [cells[one] for one in range(len(listed))]
    table = maker.table(base, found)
    above, skin = table.above(), SkinGains(goal, maker, listed, found)
    figure: SetFunction = table
    caps = [] if above is None else [(above, limits)]
    worth = plain = filled(table, choices)
    if goal.one_fails:
        assert isinstance(maker, TableMaker)
        figure, caps = _with_failures(maker, choices, found, own, is_stale)
        worth = filled(figure, choices)
    return Space(problem, choices, figure, worth, plain, caps, sampler, maker, skin, ground)


def filled(f: SetFunction, choices: Choices) -> SetFunction:
    """Return a function of sets that gives each slot the least that it needs before anything else: every moved sensor
    a place, and each listed model its least number of sensors."""
    least, limits = choices.least, choices.limits
    if not least.any():
        return f
    order = np.argsort(limits.slot, kind="stable")  # cells of objects rise
    starts = np.cumsum([0, *limits.sizes[order]])
    cells = [np.zeros(0, np.int32)] * len(order)
    for place, one in enumerate(order.tolist()):
        cells[one] = np.arange(starts[place], starts[place + 1], dtype=np.int32)
    owner = np.repeat(limits.slot[order], limits.sizes[order]).astype(np.int32)
    worth = np.minimum(np.arange(int(least.max()) + 1), least[:, None])
    none, rows = np.zeros(len(least), np.int32), np.arange(len(least), dtype=np.uint8)
    return AtLeast(f, CoverTable(cells, owner, none, rows, worth, 1), int(least.sum()))


def _with_failures(
    maker: TableMaker, choices: Choices, cells: list[Cells], sensors: Sequence[Sensor], is_stale: IsStale
) -> tuple[WorstFailure, list[Cap]]:
    """Return the objective with one sensor failed, and tables with limits of sets that bound it: no set is worth more
    after a failure than without any one of its members, or of the rig's own sensors.

    cells: of candidates; sensors: the rig's own.
    """
    limits = choices.limits
    singles = [[maker.cells_of([one], is_stale) for one in some.sensors] for some in choices.candidates]
    own = [maker.cells_of([one], is_stale) for one in sensors]
    alone, places = list[Cells](), list[list[int]]()
    for some in singles:
        places.append([len(cells) + len(alone) + place for place in range(len(some))])
        alone += some
    table = maker.table(_NOTHING, [*cells, *alone, *own])
    figure = WorstFailure(table, places, range(table.size - len(own), table.size))
    count, size = len(cells), len(cells) + len(alone)
    room = np.array([max(0, limits.count - 1), int(any(len(some) > 1 for some in places))], np.int64)
    slot = np.repeat([0, 1], [count, len(alone)])
    free = Limits(int(room.sum()), np.zeros(size), np.inf, np.eye(size, dtype=np.bool_), slot, room)
    caps = [(maker.table(maker.joined(own), [*cells, *alone]), free)]
    rests = [[one for one in own if one is not lost] for lost in own]
    bases = [maker.joined(rest) for rest in rests]
    if bases:
        least = min(bases, key=lambda base: maker.table(base, []).value([]))
        caps.append((maker.table(least, cells), limits))
    return figure, caps
