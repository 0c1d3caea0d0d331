"""One run: candidates cast one by one, a proposal, its bound, its guard, and the front of two goals, step by step."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import TypeVar

import numpy as np

from riglens.core.errors import Cancelled, InputError, IsStale, never_stale
from riglens.core.kernels.runtime import jit
from riglens.core.optimise.bounds import Bound, branch_and_bound, fractional_bound
from riglens.core.optimise.guard import GuardResult, ObjectSampler, cases_of, guard
from riglens.core.optimise.makers import GroundTableMaker, TableMaker, maker_of
from riglens.core.optimise.mounts import Candidate, candidates, conflicts, locked, mounted, rules_for
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.results import OptimiseResult, Proposal
from riglens.core.optimise.search import AtLeast, Limits, front, greedy, search, swap
from riglens.core.optimise.skin import SkinGains
from riglens.core.optimise.tables import UNIT, Cells, CoverTable, Ids, SetFunction, WorstFailure
from riglens.core.rig.model import Rig, Sensor

CASTING = "casting"
FIRST = 60
"""Sensors after which a first proposal is made of those that have been cast, in an order drawn by the seed."""
FRONT = 8
"""Points of a front, at most."""
TRIES = 12
"""Further sets that are tried where the best one does not meet requirements."""
_NOTHING = np.zeros(0, np.int32)
_HAND_X = (0.5, 0.92, 0.08, 0.75)
_HAND_Y, _HAND_Z = (0.7, 0.9, 0.9, 0.95), (1.0, 0.5, 0.6, 0.6)
"""Usual places of a pair: roof sides, front corners, rear corners, wings; shares of length, half width and height."""
T = TypeVar("T")


@dataclass(frozen=True)
class Progress:
    """Progress of a search: the current step, the share of it that is done, and the best rig so far.

    value, bound: the figure of the best rig and of any other, once candidates have been cast; skin: their gains for any
    rig; result: what is known, once all but the guard is done.
    """

    stage: str
    share: float
    best: Rig | None = None
    value: float | None = None
    bound: float | None = None
    skin: SkinGains | None = None
    result: OptimiseResult | None = None


Steps = Generator[Progress, None, OptimiseResult]


def optimise(problem: Problem, threads: int | None = None, is_stale: IsStale = never_stale) -> Steps:
    """Propose rigs step by step; each step takes some ten milliseconds, those of the guard up to seconds.

    Raise InputError where nothing can be added, and Cancelled, also within a step, as soon as `is_stale` returns True.
    The result does not depend on the number of threads.
    """
    workers = jit.use_threads(threads)
    run = yield from _cast(problem, workers, is_stale)
    chosen, bound = yield from run.solve()
    chosen, unmet = yield from run.meeting(chosen, bound)
    if bound is not None and bound.kind == "proven" and run.figure.value(chosen) < bound.value:
        bound = Bound(bound.value, "cuts")
    sets = [chosen, *(yield from run.front(chosen))]
    reference = problem.reference or run.by_hand()
    rigs = [run.rig_with(one, f"proposal {number}") for number, one in enumerate(sets, 1)]
    values, sampler = (
        list[float](),
        ObjectSampler(problem.traffic, workers, problem.goal, problem.weights, is_stale),
    )
    for rig in (problem.rig, reference, *rigs):
        yield run.step(
            "evaluating", len(values) / (len(rigs) + 2), chosen, None if bound is None else bound.value
        )
        if problem.goal.of_objects:
            values.append(sampler(rig, problem.settings, (0, problem.frames)).value)
        else:
            values.append(run.value_of(rig))
    found = OptimiseResult(
        problem,
        len(run.candidates),
        values[0],
        None if run.ground is None else run.ground.before_m2,
        reference,
        values[1],
        None if bound is None else Bound(run.shown(bound.value), bound.kind),
        tuple(
            Proposal(
                rig,
                tuple(run.candidates[one] for one in some if not run.candidates[one].is_as_now),
                value,
                None if run.ground is None else run.ground.unseen_m2(some),
            )
            for rig, some, value in zip(rigs, sets, values[2:], strict=True)
        ),
        tuple(range(len(rigs))) if run.ground is not None else (),
        unmet,
    )
    cases, kept = cases_of(problem, rigs[0], reference, workers, is_stale), list[GuardResult]()
    for one in guard(cases):
        kept.append(one)
        found = found.checked(tuple(kept))
        step = run.step(
            f"checking: {one.case}", len(kept) / len(cases), chosen, None if bound is None else bound.value
        )
        yield replace(step, result=found)
    return found


def skin_gains(
    problem: Problem, threads: int | None = None, is_stale: IsStale = never_stale
) -> Generator[Progress, None, SkinGains]:
    """Cast the candidates of a problem step by step, as `optimise` does, and return their gains for any rig.

    Raise InputError for an objective without tables.
    """
    run = yield from _cast(problem, jit.use_threads(threads), is_stale)
    if run.skin is None:
        raise InputError(
            f"{problem.objective} has no gains to show on the car: choose another one", "objective"
        )
    return run.skin


def filled(f: SetFunction, listed: Sequence[Candidate], moves: int) -> SetFunction:
    """Return a function of sets that puts every moved sensor somewhere before anything else."""
    if not moves:
        return f
    cells = [np.arange(one.slot - 1, one.slot, dtype=np.int32)[: one.slot] for one in listed]
    worth, owner = np.arange(moves + 1, dtype=np.int64)[None], np.zeros(moves, np.int32)
    places = CoverTable(cells, owner, np.zeros(1, np.int32), np.zeros(1, np.uint8), worth, 1)
    return AtLeast(f, places, moves)


def _rig_with(problem: Problem, picked: Sequence[Candidate], name: str = "proposal") -> Rig:
    """Return the rig with some candidates added, and those of its own sensors in their place."""
    found = mounted(problem.rig, picked)
    return found.replace(name=f"{found.name[:150]}, {name}")


class _Ground:
    """The second goal: blind ground of sets of candidates, whose columns are given."""

    def __init__(self, problem: Problem, maker: GroundTableMaker, columns: Sequence[Cells]) -> None:
        seen, rest = (
            maker.cells_of([sensor for sensor in rig.sensors if sensor.enabled])
            for rig in (problem.rig, locked(problem.rig, problem.moves))
        )
        self.table, self._column_m2 = maker.table(rest, columns), maker.column_m2
        self.before_m2, self._rest_m2 = maker.shown(len(seen)), maker.shown(len(rest))

    def unseen_m2(self, chosen: Sequence[int]) -> float:
        """Return the area that a set leaves unseen."""
        return self._rest_m2 - (self.table.value(chosen) - self.table.value([])) * self._column_m2


def _limits(problem: Problem, listed: Sequence[Candidate]) -> Limits:
    costs = np.array([one.cost for one in listed])
    apart = conflicts(
        listed, locked(problem.rig, problem.moves), rules_for(problem.rig, problem.additions.rules)
    )
    slots = np.array([one.slot for one in listed], np.int64)
    room = np.array([problem.count, *(1 for _ in problem.moves)], np.int64)
    return Limits(int(room.sum()), costs, problem.additions.budget, apart, slots, room)


class _MeasuredSets:
    """An objective without tables, measured for each set anew; hits of the candidates' sensors are kept."""

    def __init__(
        self, problem: Problem, listed: Sequence[Candidate], workers: int, is_stale: IsStale
    ) -> None:
        self._problem, self._listed, self.size = problem, listed, len(listed)
        self._sampler = ObjectSampler(problem.traffic, workers, problem.goal, problem.weights, is_stale)
        self._held, self._values = list[object](), dict[tuple[int, ...], int]()

    def cast(self, sensors: tuple[Sensor, ...]) -> None:
        """Cast a candidate's sensors."""
        alone = self._problem.rig.model_copy(update={"sensors": sensors})
        self._held.append(self._sampler.cast(alone, self._problem.settings, self._problem.frames))

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


def _cast(problem: Problem, workers: int, is_stale: IsStale) -> Generator[Progress, None, _Run]:
    """Cast the coverage of the rig and of each candidate, in an order drawn by the seed; build the tables."""
    listed = candidates(problem.rig, problem.additions, problem.seed, is_stale, problem.moves)
    limits, count = _limits(problem, listed), len(listed)
    order = np.random.default_rng(problem.seed).permutation(count).tolist()
    ground = None if problem.blind_m is None else GroundTableMaker(problem.rig, problem.blind_m, workers)
    maker, columns = maker_of(problem, workers), dict[int, Cells]()

    def second_goal() -> _Ground | None:
        return None if ground is None else _Ground(problem, ground, [columns[one] for one in range(count)])

    if maker is None:
        sets = _MeasuredSets(problem, listed, workers, is_stale)
        for number, one in enumerate(order, 1):
            sets.cast(listed[one].sensors)
            columns[one] = _NOTHING if ground is None else ground.cells_of(listed[one].sensors)
            yield Progress(CASTING, number / count)
        return _Run(problem, is_stale, listed, limits, sets, sets, [], None, None, second_goal())
    own, cells = problem.goal.sensors_of(locked(problem.rig, problem.moves)), dict[int, Cells]()
    base = maker.cells_of(own, is_stale)
    best, first = None, min(FIRST // (2 if problem.additions.mirrored else 1), count)
    covered = maker.each([listed[one].sensors for one in order], is_stale)
    for number, (one, covers) in enumerate(zip(order, covered, strict=True), 1):
        cells[one] = covers
        columns[one] = _NOTHING if ground is None else ground.cells_of(listed[one].sensors)
        if number == first:
            some = sorted(cells)
            table = maker.table(base, [cells[one] for one in some])
            picked = greedy(table, _limits(problem, [listed[one] for one in some]))
            best = _rig_with(problem, [listed[some[place]] for place in picked])
        yield Progress(CASTING, number / count, best)
    every = [cells[one] for one in range(count)]
    table = maker.table(base, every)
    skin = SkinGains(problem.goal, maker, listed, every)
    figure: SetFunction = table
    caps = [(table.concave(), limits)]
    if problem.goal.one_fails:
        singles = [[maker.cells_of([sensor], is_stale) for sensor in one.sensors] for one in listed]
        figure, caps = _with_failures(
            maker, limits, every, singles, [maker.cells_of([sensor], is_stale) for sensor in own]
        )
    return _Run(problem, is_stale, listed, limits, figure, table, caps, maker, skin, second_goal())


def _with_failures(
    maker: TableMaker,
    limits: Limits,
    cells: list[Cells],
    singles: Sequence[Sequence[Cells]],
    own: Sequence[Cells],
) -> tuple[WorstFailure, list[tuple[CoverTable, Limits]]]:
    """Return the objective with one sensor failed, and tables with limits of sets that bound it: no set is worth more
    after a failure than without any one of its members, or of the rig's own sensors.

    cells: of candidates; singles: of their sensors; own: of the rig's sensors.
    """
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
    caps = [(maker.table(np.unique(np.concatenate([_NOTHING, *own])), [*cells, *alone]), free)]
    rests = [[one for one in own if one is not lost] for lost in own]
    bases = [np.unique(np.concatenate([_NOTHING, *rest])) for rest in rests]
    if bases:
        caps.append((maker.table(min(bases, key=maker.value), cells), limits))
    return figure, caps


@dataclass(frozen=True)
class _Run:
    """Candidates of a problem and what sets of them are worth, in integers.

    figure: the objective; plain: the same without failures; caps: tables with limits of sets whose best is worth no
    less than that of the objective, its own table where that can be proven; maker: None where each set is measured.
    """

    problem: Problem
    is_stale: IsStale
    candidates: tuple[Candidate, ...]
    limits: Limits
    figure: SetFunction
    plain: SetFunction
    caps: Sequence[tuple[CoverTable, Limits]]
    maker: TableMaker | None
    skin: SkinGains | None
    ground: _Ground | None

    @cached_property
    def goal(self) -> SetFunction:
        """The objective, after every moved sensor has a place."""
        return filled(self.figure, self.candidates, len(self.problem.moves))

    @property
    def _stays(self) -> list[int]:
        return [number for number, one in enumerate(self.candidates) if one.is_as_now]

    def shown(self, value: float) -> float:
        """Return the figure, in its own unit, for a value in integers."""
        return self.problem.goal.sign * value / UNIT if self.maker is None else self.maker.shown(value)

    def value_of(self, rig: Rig) -> float:
        """Return the figure of a rig by what its sensors cover."""
        assert self.maker is not None
        own = self.problem.goal.sensors_of(rig)
        return self.maker.shown(self.maker.value(self.maker.cells_of(own, self.is_stale)))

    def solve(self) -> Generator[Progress, None, tuple[list[int], Bound | None]]:
        """Search for the best set, then try to prove it; bound it by cuts of the least concave functions above it where
        that takes too many steps, or where the figure is not submodular."""
        chosen = yield from self._steps("searching", self._searched(self.limits))
        if any(table is self.figure for table, _ in self.caps):
            proof = branch_and_bound(self.goal, self.limits, chosen)
            chosen, proven = yield from self._steps("proving", proof, chosen)
            if proven:
                return chosen, Bound(self.figure.value(chosen), "proven")
        bounds = list[int]()
        for table, limits in self.caps:
            cuts = fractional_bound(table, limits, chosen)
            bounds.append((yield from self._steps("bounding", cuts, chosen)))
        return chosen, Bound(min(bounds), "cuts") if bounds else None

    def _searched(self, limits: Limits) -> Generator[None, None, list[int]]:
        """Return the best set found; with a failure by exchanges of members of a set that is best without any."""
        plain = self.goal
        if self.plain is not self.figure:
            plain = filled(self.plain, self.candidates, len(self.problem.moves))
        chosen = yield from search(plain, limits, self._stays)
        return chosen if plain is self.goal else sorted((yield from swap(self.goal, limits, chosen)))

    def step(self, stage: str, share: float, chosen: list[int], bound: float | None = None) -> Progress:
        """Return the progress with a set as the best so far."""
        value = self.figure.value(chosen)
        above = None if bound is None else self.shown(max(bound, value))
        return Progress(stage, share, self.rig_with(chosen), self.shown(value), above, self.skin)

    def _steps(
        self, stage: str, steps: Generator[int | None, None, T], chosen: list[int] | None = None
    ) -> Generator[Progress, None, T]:
        """Run steps and emit their progress; raise Cancelled between two of them."""
        least: int | None = None
        while True:
            try:
                bound = next(steps)
            except StopIteration as end:
                found: T = end.value
                return found
            if self.is_stale():
                raise Cancelled
            if bound is not None and chosen is not None:
                # what comes before the figure itself is all there
                first = self.goal.value(chosen) - self.figure.value(chosen) if stage == "proving" else 0
                least = bound - first if least is None else min(least, bound - first)
            yield (
                Progress(stage, 0.0, skin=self.skin)
                if chosen is None
                else self.step(stage, 0.0, chosen, least)
            )

    def meeting(
        self, chosen: list[int], bound: Bound | None
    ) -> Generator[Progress, None, tuple[list[int], tuple[str, ...] | None]]:
        """Return the first set that meets all requirements, and what it does not meet: the best one where none of a few
        does. Each next one leaves out what the last set would miss least."""
        if self.problem.unmet is None:
            return chosen, None
        limits, tried, first = self.limits, list(chosen), self.problem.unmet(self.rig_with(chosen))
        unmet = first
        for _ in range(TRIES):
            free = [one for one in tried if not self.candidates[one].is_as_now]
            if not unmet or not free:
                break
            worth = {one: self.figure.value([other for other in tried if other != one]) for one in free}
            slot = limits.slot.copy()
            slot[max(free, key=lambda one: worth[one])] = len(self.limits.room)  # a slot without room
            limits = replace(limits, slot=slot, room=np.append(self.limits.room, 0))
            tried = yield from self._steps("meeting requirements", self._searched(limits), chosen)
            yield self.step("meeting requirements", 0.0, tried, None if bound is None else bound.value)
            unmet = self.problem.unmet(self.rig_with(tried))
        return (chosen, first) if unmet else (tried, ())

    def front(self, chosen: list[int]) -> Generator[Progress, None, list[list[int]]]:
        """Return the sets of the front besides the best one."""
        if self.ground is None:
            return []
        steps = front(self.goal, self.ground.table, self.limits, chosen, FRONT - 1, self._stays)
        return (yield from self._steps("front", steps, chosen))

    def by_hand(self) -> Rig:
        """Return the best of the sets that a person would mount level at roof sides, corners and wings; the rig itself
        where nothing is added."""
        if not self.problem.count:
            return self.problem.rig
        car, additions = self.problem.rig.vehicle, self.problem.additions
        middles = np.array([one.places_m[0] for one in self.candidates])
        least = min(additions.tilts_deg)
        level = np.array([one.tilt_deg == least and not one.slot for one in self.candidates])
        usual = []
        for side in (1.0,) if additions.mirrored else (1.0, -1.0):
            for x, y, z in zip(_HAND_X, _HAND_Y, _HAND_Z, strict=True):
                place = [(x - 0.5) * car.length, side * y * car.width / 2.0, z * car.height]
                away = np.where(level, np.linalg.norm(middles - place, axis=1), np.inf)
                usual.append(int(np.argmin(away)))
        usual = sorted(set(usual))
        sets = [
            [*self._stays, *some]
            for count in range(1, additions.count + 1)
            for some in combinations(usual, count)
            if self.limits.allow([*self._stays, *some])
        ]
        best = max(sets, key=self.figure.value, default=self._stays)
        return self.rig_with(best, "mounted by hand")

    def rig_with(self, chosen: Sequence[int], name: str = "proposal") -> Rig:
        """Return the rig with some candidates added, and those of its own sensors in their place."""
        return _rig_with(self.problem, [self.candidates[one] for one in chosen], name)


def finished(
    problem: Problem, threads: int | None = None, progress: Callable[[float], None] | None = None
) -> OptimiseResult:
    """Run a problem to its end; `progress` gets the share that is done, most of it casting."""
    steps = optimise(problem, threads)
    while True:
        try:
            step = next(steps)
        except StopIteration as end:
            found: OptimiseResult = end.value
            return found
        if progress is not None:
            progress(0.7 * step.share if step.stage == CASTING else 0.7)
