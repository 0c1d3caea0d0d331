"""The space of a search: candidates with their limits, and what sets of them are worth, in integers."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from riglens.core.errors import IsStale
from riglens.core.optimise.bounds import Cap
from riglens.core.optimise.candidates import Choices, choices_of, mounted
from riglens.core.optimise.guard import ObjectSampler
from riglens.core.optimise.makers import GroundTableMaker, Maker, TableMaker
from riglens.core.optimise.object_makers import maker_of
from riglens.core.optimise.placing import Candidate
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.results import Progress
from riglens.core.optimise.search import AtLeast, Limits, greedy
from riglens.core.optimise.skin import SkinGains
from riglens.core.optimise.tables import UNIT, Cells, CoverTable, Doubles, Ids, SetFunction, WorstFailure
from riglens.core.rig.model import Rig, Sensor

CASTING = "casting"
FIRST = 60
"""Sensors after which a first proposal is made of those that have been cast, in an order drawn by the seed."""
_NOTHING = np.zeros(0, np.int32)


class MeasuredSets:
    """An objective without tables, measured for each set anew; hits of the candidates' sensors are kept."""

    def __init__(self, problem: Problem, listed: Sequence[Candidate], sampler: ObjectSampler) -> None:
        self._problem, self._listed, self.size, self._sampler = problem, listed, len(listed), sampler
        self._held, self._values = list[object](), dict[tuple[int, ...], int]()

    def each(self, sets: Sequence[Sequence[Sensor]], is_stale: IsStale) -> Iterator[Cells]:
        """Cast the sensors of candidates one by one; they have no cells."""
        for sensors in sets:
            alone = self._problem.rig.model_copy(update={"sensors": tuple(sensors)})
            self._held.append(self._sampler.cast(alone, self._problem.settings, self._problem.frames))
            yield _NOTHING

    def shown(self, value: float) -> float:
        """Return the figure, in its own unit, for a value in integers."""
        return self._problem.goal.sign * value / UNIT

    def shown_gains(self, gains: Ids) -> Doubles:
        """Return by how much the figure is better for gains in integers, in its own unit."""
        return np.asarray(gains / UNIT)

    def value(self, chosen: Sequence[int]) -> int:
        """Return the figure of a set, negative where less is better."""
        key, problem = tuple(sorted(chosen)), self._problem
        if key not in self._values:
            rig = mounted(problem.rig, [self._listed[one] for one in key])
            measured = self._sampler(rig, problem.settings, (0, problem.frames)).value
            self._values[key] = round(problem.goal.sign * measured * UNIT)
        return self._values[key]

    def gains(self, chosen: Sequence[int], ids: Ids) -> Ids:
        """Return what each of some candidates adds to a set."""
        before = self.value(chosen)
        return np.array([self.value([*chosen, one]) - before for one in ids.tolist()], np.int64)


class Ground:
    """The second goal: blind ground of a rig with sets of candidates, whose columns are given."""

    def __init__(self, maker: GroundTableMaker, rig: Rig, rest: Rig, columns: Sequence[Cells]) -> None:
        seen, own = (maker.cells_of([s for s in one.sensors if s.enabled]) for one in (rig, rest))
        self.table, self._column_m2 = maker.table(own, columns), maker.column_m2
        self.before_m2, self._rest_m2 = maker.shown(len(seen)), maker.shown(len(own))

    def unseen_m2(self, chosen: Sequence[int]) -> float:
        """Return the area that a set leaves unseen."""
        return self._rest_m2 - (self.table.value(chosen) - self.table.value([])) * self._column_m2


@dataclass(frozen=True)
class Space:
    """Candidates of a problem and what sets of them are worth, in integers.

    figure: the objective; goal: the same after every moved sensor has a place; plain: that without failures; caps:
    tables with limits of sets whose best is worth no less than that of the objective; is_submodular: whether the
    objective's gains never grow with the set; sampler: of objectives of
    objects; maker: makes the tables, or measures each set; skin: gains of single candidates, where there are tables.
    """

    problem: Problem
    choices: Choices
    figure: SetFunction
    goal: SetFunction
    plain: SetFunction
    caps: Sequence[Cap]
    is_submodular: bool
    sampler: ObjectSampler
    maker: Maker[Any] | MeasuredSets
    skin: SkinGains | None
    ground: Ground | None
    is_stale: IsStale

    @property
    def candidates(self) -> tuple[Candidate, ...]:
        """The candidates."""
        return self.choices.candidates

    def shown(self, value: float) -> float:
        """Return the figure, in its own unit, for a value in integers."""
        return self.maker.shown(value)

    def value_of(self, rig: Rig) -> float:
        """Measure the figure of a rig in the frames of choice, or exactly."""
        problem = self.problem
        if problem.goal.of_objects:
            return self.sampler(rig, problem.settings, (0, problem.frames)).value
        assert isinstance(self.maker, Maker)
        own = problem.goal.sensors_of(rig)
        return self.maker.shown(self.maker.value(self.maker.cells_of(own, self.is_stale)))

    def adds(self, chosen: Sequence[int]) -> tuple[float, ...]:
        """Return by how much each candidate of a set but those that stay makes the figure better, in its unit."""
        whole, gain = self.figure.value(chosen), self.maker.shown_gains
        kept = [one for one in chosen if not self.candidates[one].is_as_now]
        rests = [self.figure.value([other for other in chosen if other != one]) for one in kept]
        return tuple(gain(np.array([whole - rest for rest in rests], np.int64)).tolist())

    def rig_with(self, chosen: Sequence[int], name: str = "proposal") -> Rig:
        """Return the rig with some candidates added, and those of its own sensors in their place."""
        return _rig_with(self.problem.rig, self.choices, chosen, name)

    def step(
        self, stage: str, share: float = 0.0, chosen: Sequence[int] | None = None, bound: float | None = None
    ) -> Progress:
        """Return the progress, with a set as the best so far."""
        if chosen is None:
            return Progress(stage, share, skin=self.skin)
        value = self.figure.value(chosen)
        above = None if bound is None else self.shown(max(bound, value))
        return Progress(stage, share, self.rig_with(chosen), self.shown(value), above, self.skin)


def _rig_with(rig: Rig, choices: Choices, chosen: Sequence[int], name: str = "proposal") -> Rig:
    found = mounted(rig, [choices.candidates[one] for one in chosen])
    return found.replace(name=f"{found.name[:150]}, {name}")


def choices_for(problem: Problem, is_stale: IsStale) -> Choices:
    """Return the candidates of a problem, with the limits of sets of them."""
    return choices_of(problem.rig, problem.additions, problem.seed, is_stale, problem.moves)


def cast(
    problem: Problem, choices: Choices, workers: int, is_stale: IsStale
) -> Generator[Progress, None, Space]:
    """Cast the coverage of the rig and of each candidate, in an order drawn by the seed; build the tables."""
    listed, limits, goal = choices.candidates, choices.limits, problem.goal
    sampler = ObjectSampler(problem.traffic, workers, goal, problem.weights, is_stale)
    ground = None if problem.blind_m is None else GroundTableMaker(problem.rig, problem.blind_m, workers)
    order = np.random.default_rng(problem.seed).permutation(len(listed)).tolist()
    maker = maker_of(problem, workers) or MeasuredSets(problem, listed, sampler)
    own, best = goal.sensors_of(choices.rest), None
    base: Any = maker.cells_of(own, is_stale) if isinstance(maker, Maker) else _NOTHING
    first = min(FIRST // (2 if problem.additions.mirrored else 1), len(listed))
    cells, columns = dict[int, Any](), dict[int, Cells]()
    each = maker.each([listed[one].sensors for one in order], is_stale)
    for number, (one, covers) in enumerate(zip(order, each, strict=True), 1):
        cells[one] = covers
        columns[one] = _NOTHING if ground is None else ground.cells_of(listed[one].sensors)
        if number == first and isinstance(maker, Maker):
            some = sorted(cells)
            table = maker.table(base, [cells[one] for one in some])
            picked = [some[place] for place in greedy(table, limits.among(some))]
            best = _rig_with(problem.rig, choices, picked)
        yield Progress(CASTING, number / len(order), best)
    second = None
    if ground is not None:
        second = Ground(ground, problem.rig, choices.rest, [columns[one] for one in range(len(listed))])
    if isinstance(maker, MeasuredSets):
        worth = filled(maker, choices)
        return Space(problem, choices, maker, worth, worth, (), False, sampler, maker, None, second, is_stale)
    found = [cells[one] for one in range(len(listed))]
    table = maker.table(base, found)
    figure: SetFunction = table
    above, plain = table.above(), filled(table, choices)
    caps, worth = [] if above is None else [(above, limits)], plain
    if goal.one_fails:
        assert isinstance(maker, TableMaker)
        figure, caps = _with_failures(maker, choices, found, own, is_stale)
        worth = filled(figure, choices)
    skin = SkinGains(goal, maker, listed, found)
    is_submodular = table.is_submodular and not goal.one_fails
    return Space(
        problem, choices, figure, worth, plain, caps, is_submodular, sampler, maker, skin, second, is_stale
    )


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
        caps.append((maker.table(min(bases, key=maker.value), cells), limits))
    return figure, caps
