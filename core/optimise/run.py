"""One run: candidates cast one by one, a proposal, its bound, its guard, and the front of two goals, step by step."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TypeVar

import numpy as np

from riglens.core.blind.zones import BlindEngine, BlindSettings
from riglens.core.errors import Cancelled, InputError, IsStale, never_stale
from riglens.core.kernels.runtime import jit
from riglens.core.optimise.bounds import Bound, branch_and_bound, fractional_bound
from riglens.core.optimise.guard import (
    FEW,
    Evaluator,
    GuardResult,
    OtherTraffic,
    Sampler,
    guard,
    with_worst_failure,
)
from riglens.core.optimise.mounts import Candidate, candidates, conflicts, locked, mounted, rules_for
from riglens.core.optimise.objectives import WORST, Problem, WorstFailure, sensors_for
from riglens.core.optimise.results import Cheapest, CostStep, OptimiseResult, Proposal
from riglens.core.optimise.search import ROUNDING, AtLeast, Limits, front, greedy, search, swap
from riglens.core.optimise.skin import SkinGains
from riglens.core.optimise.tables import (
    UNIT,
    Cells,
    CoverTable,
    GroundTableMaker,
    ObjectTableMaker,
    SetFunction,
)
from riglens.core.rig.model import Rig, Sensor
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.solid import solid_of

CASTING = "casting"
FIRST = 60
"""Sensors after which a first proposal is made of those that have been cast, in an order drawn by the seed."""
FRONT = 8
"""Points of a front, at most."""
TRIES = 12
"""Further sets that are tried where the best one does not meet requirements."""
STAIRS = 6
"""Steps of a staircase, at least."""
_NOTHING = np.zeros(0, np.int32)
_HAND_X = (0.5, 0.92, 0.08, 0.75)
_HAND_Y, _HAND_Z = (0.7, 0.9, 0.9, 0.95), (1.0, 0.5, 0.6, 0.6)
"""Usual places of a pair: roof sides, front corners, rear corners, wings; shares of length, half width and height."""
T = TypeVar("T")


@dataclass(frozen=True)
class Progress:
    """Progress of a search: the current step, the share of it that is done, and the best rig so far.

    value, bound: of the best rig and of any other, once candidates have been cast; skin: their gains for any rig;
    result: what is known, once all but the guard is done.
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
    run = _Run(problem, jit.use_threads(threads), is_stale)
    yield from run.cast()
    cheapest = None if problem.at_least is None else (yield from run.cheapest(problem.at_least))
    chosen, bound = yield from run.solve()
    chosen, unmet = yield from run.meeting(chosen, bound)
    if bound.kind == "proven" and run.figure.value(chosen) < bound.value:
        bound = Bound(bound.value, "cuts")
    sets = [chosen, *(yield from run.front(chosen))]
    stairs = yield from run.stairs()
    reference = problem.reference or run.by_hand()
    proposals = [run.proposal(one, number) for number, one in enumerate(sets, 1)]
    sampler = run.sampler(problem.traffic)
    values = list[float]()
    for rig, some in (
        (problem.rig, None),
        (reference, None),
        *zip((p.rig for p in proposals), sets, strict=True),
    ):
        yield run.told("evaluating", len(values) / (len(proposals) + 2), chosen, bound.value)
        values.append(run.value_of(rig, some, sampler))
    proposals = [replace(one, value=value) for one, value in zip(proposals, values[2:], strict=True)]
    found = OptimiseResult(
        problem,
        len(run.candidates),
        values[0],
        run.blind_before_m2,
        reference,
        values[1],
        bound,
        tuple(proposals),
        tuple(range(len(proposals))) if run.ground is not None else (),
        stairs,
        run.floors(chosen),
        unmet,
        cheapest,
    )
    checks = guard(
        proposals[0].rig, reference, sampler, problem.settings, problem.frames, problem.last, run.others()
    )
    kept = list[GuardResult]()
    for one in checks:
        kept.append(one)
        best = replace(found.best, guard=tuple(kept))
        found = replace(found, proposals=(best, *found.proposals[1:]))
        share = len(kept) / (6 + len(problem.checks))
        yield replace(run.told(f"checking: {one.case}", share, chosen, bound.value), result=found)
    return found


def skin_gains(
    problem: Problem, threads: int | None = None, is_stale: IsStale = never_stale
) -> Generator[Progress, None, SkinGains]:
    """Cast the candidates of a problem step by step, as `optimise` does, and return their gains for any rig."""
    run = _Run(problem, jit.use_threads(threads), is_stale)
    yield from run.cast()
    return run.skin


def filled(f: SetFunction, listed: Sequence[Candidate], moves: int) -> SetFunction:
    """Return a function of sets that puts every moved sensor somewhere before anything else."""
    if not moves:
        return f
    cells = [np.arange(one.slot - 1, one.slot, dtype=np.int32)[: one.slot] for one in listed]
    worth, owner = np.arange(moves + 1, dtype=np.int64)[None], np.zeros(moves, np.int32)
    places = CoverTable(cells, owner, np.zeros(1, np.int32), np.zeros(1, np.uint8), worth, 1)
    return AtLeast(f, places, moves)


class _Run:
    """Candidates of a problem and their tables."""

    def __init__(self, problem: Problem, workers: int, is_stale: IsStale) -> None:
        self.problem, self._workers, self._is_stale, rig = problem, workers, is_stale, problem.rig
        solid = solid_of(rig.vehicle) if rig.self_occlusion else None
        self.candidates = candidates(rig, problem.additions, problem.seed, is_stale, problem.moves)
        self._rest = locked(rig, problem.moves)
        self._maker = problem.goal.maker(problem, solid, workers)
        self.ground_maker = None
        if problem.blind_m is not None:
            engine = BlindEngine(rig.vehicle, BlindSettings(), workers)
            self.ground_maker = GroundTableMaker(rig, engine, problem.blind_m, workers)
        self._rules = rules_for(rig, problem.additions.rules)
        self._stays = [number for number, one in enumerate(self.candidates) if one.is_as_now]
        self._cells: list[Cells]
        self.skin: SkinGains
        self.table: CoverTable
        self.figure: SetFunction
        self._goal: SetFunction
        self._failed: list[tuple[CoverTable, Limits]] = []
        self._all: Limits
        self.ground: CoverTable | None = None
        self.blind_before_m2: float | None = None
        self._blind_rest_m2 = 0.0

    def _own(self) -> tuple[Sensor, ...]:
        """Return the sensors of the rig that make the figure and stay."""
        return sensors_for(self.problem.goal, self._rest)

    def cast(self) -> Generator[Progress, None, None]:
        """Cast the coverage of the rig and of each candidate, in an order drawn by the seed; build the tables."""
        base = self._maker.cells_of(self._own(), self._is_stale)
        order = np.random.default_rng(self.problem.seed).permutation(len(self.candidates)).tolist()
        found: dict[int, tuple[Cells, Cells]] = {}
        best, first = None, FIRST // (2 if self.problem.additions.mirrored else 1)
        sets = [self.candidates[one].sensors for one in order]
        covered = self._maker.each(sets, self._is_stale)
        for number, (one, sensors, cells) in enumerate(zip(order, sets, covered, strict=True), 1):
            columns = _NOTHING if self.ground_maker is None else self.ground_maker.cells_of(sensors)
            found[one] = cells, columns
            if number == min(first, len(order)):
                some = sorted(found)
                table = self._maker.table(base, [found[one][0] for one in some])
                picked = [some[place] for place in greedy(table, self._limits(some))]
                best = self.rig_with(picked)
            yield Progress(CASTING, number / len(order), best)
        self._cells = [found[one][0] for one in range(len(order))]
        self.table, self._all = self._maker.table(base, self._cells), self._limits(range(len(order)))
        self.skin = SkinGains(self.problem.goal, self._maker, self.candidates, self._cells)
        self.figure = self.table
        self._goal = self._filled(self._floored())
        if self.ground_maker is not None:
            maker = self.ground_maker
            seen, rest = (maker.cells_of(_enabled(rig)) for rig in (self.problem.rig, self._rest))
            self.blind_before_m2, self._blind_rest_m2 = maker.blind_m2(seen), maker.blind_m2(rest)
            self.ground = maker.table(rest, [found[one][1] for one in range(len(order))])

    def _by_class(self, name: str) -> CoverTable:
        assert isinstance(self._maker, ObjectTableMaker)
        return self.table.valued(self._maker.worth_of_class(name))

    def _floored(self) -> SetFunction:
        """Return a function that reaches floors by class before anything else, to a thousandth."""
        found: SetFunction = self.table
        for name, floor in self.problem.floors.items():
            found = AtLeast(found, self._by_class(name), round(floor * UNIT), 1 << 10)
        return found

    def floors(self, chosen: list[int]) -> dict[str, float]:
        """Return the value of a set for each class that has a floor."""
        return {name: self._by_class(name).value(chosen) / UNIT for name in self.problem.floors}

    def sampler(self, traffic: Traffic) -> Sampler:
        """Return what samples the figure that the guard compares."""
        goal = self.problem.goal
        found: Sampler = Evaluator(traffic, self._workers, goal, self.problem.weights, self._is_stale)
        return with_worst_failure(found) if goal.name == WORST else found

    def others(self) -> list[OtherTraffic]:
        """Return other traffic: the held-out frames in another state, or the first of other data."""
        problem, found = self.problem, list[OtherTraffic]()
        for name, traffic in problem.checks.items():
            own = problem.traffic.data.sha256
            is_other = not own or traffic.data.sha256 != own or traffic.frames != problem.traffic.frames
            where = (0, traffic.frames) if is_other else (problem.frames, problem.last)
            last = min(where[1], where[0] + FEW)
            found.append(OtherTraffic(name, self.sampler(traffic), (where[0], last), is_other))
        return found

    def value_of(self, rig: Rig, chosen: list[int] | None, sampler: Sampler) -> float:
        """Return the value of a rig in the frames of choice."""
        if self.problem.goal.is_guarded:
            return sampler(rig, self.problem.settings, (0, self.problem.frames)).value
        own = sensors_for(self.problem.goal, rig)
        return self._maker.value(self._maker.cells_of(own, self._is_stale)) / UNIT

    def _limits(self, some: Sequence[int]) -> Limits:
        problem, listed = self.problem, [self.candidates[one] for one in some]
        costs = np.array([one.cost for one in listed])
        apart = conflicts(listed, self._rest, self._rules)
        slots = np.array([one.slot for one in listed], np.int64)
        room = np.array([problem.count, *(1 for _ in problem.moves)], np.int64)
        return Limits(int(room.sum()), costs, problem.additions.budget, apart, slots, room)

    def _filled(self, f: SetFunction) -> SetFunction:
        return filled(f, self.candidates, len(self.problem.moves))

    def solve(self) -> Generator[Progress, None, tuple[list[int], Bound]]:
        """Search for the best set, then try to prove it, and bound it by cuts where that takes too many steps, or where
        the figure is not submodular."""
        if self.problem.goal.name == WORST:
            self._prepare_failures()
        chosen = yield from self._steps("searching", self._searched(self._all))
        if self.figure is self.table.concave():
            proof = branch_and_bound(self._goal, self._all, chosen)
            chosen, proven = yield from self._steps("proving", proof, chosen)
            if proven and self._keeps_floors(chosen):
                return chosen, Bound(self.table.value(chosen), "proven")
        return chosen, (yield from self._bounded(chosen))

    def cheapest(self, at_least: float) -> Generator[Progress, None, Cheapest]:
        """Return the least cost at which a set is found that reaches a value, and search at no more than that from now
        on; raise InputError where none reaches it."""
        wanted, costs = math.ceil(at_least * UNIT - 0.5), {0.0}
        if self.problem.goal.name == WORST:
            self._prepare_failures()
        for _ in range(self._all.count):
            sums = {round(a + b, 9) for a in costs for b in np.unique(self._all.costs).tolist()}
            costs |= {one for one in sums if one <= self._all.budget * (1.0 + ROUNDING)}
        levels = sorted(costs)
        low, high, most = 0, len(levels), 0
        while low < high:
            middle = (low + high) // 2
            some = yield from self._steps("costs", self._searched(replace(self._all, budget=levels[middle])))
            value = self.figure.value(some)
            low, high, most = (low, middle, most) if value >= wanted else (middle + 1, high, max(most, value))
        if low == len(levels):
            raise InputError(
                f"must be at most {math.floor(most / UNIT * 1e4) / 1e4:g}, the best found within count and "
                f"budget (got {at_least:g})",
                "at_least",
            )
        self._all, is_proven = replace(self._all, budget=levels[low]), low == 0
        if low:
            below = replace(self._all, budget=levels[low - 1])
            is_proven = (yield from self._bounded([], below)).value < wanted
        return Cheapest(at_least, levels[low], is_proven)

    def _keeps_floors(self, chosen: list[int]) -> bool:
        found = self.floors(chosen)
        return all(found[name] >= floor - 1e-9 for name, floor in self.problem.floors.items())

    def _searched(self, limits: Limits) -> Generator[None, None, list[int]]:
        """Return the best set found; of a figure that is not submodular by exchanges of members of a set that is best
        without failures."""
        if self.problem.goal.name != WORST:
            return (yield from search(self._goal, limits, self._stays))
        chosen = yield from search(self._filled(self.table), limits, self._stays)
        return sorted((yield from swap(self._goal, limits, chosen)))

    def _prepare_failures(self) -> None:
        """Find what single sensors cover."""
        own = [self._maker.cells_of([sensor], self._is_stale) for sensor in self._own()]
        alone, places = list[Cells](), list[list[int]]()
        for one in self.candidates:
            places.append([len(self.candidates) + len(alone) + place for place in range(len(one.sensors))])
            alone += [self._maker.cells_of([sensor], self._is_stale) for sensor in one.sensors]
        every = self._maker.table(_NOTHING, [*self._cells, *alone, *own])
        self.figure = WorstFailure(every, places, range(every.size - len(own), every.size))
        self._goal = self._filled(self.figure)
        base = np.unique(np.concatenate([_NOTHING, *own]))
        count, size = len(self.candidates), len(self.candidates) + len(alone)
        # no set is worth more after a failure than without any one of its members, or of the rig's own sensors
        room = np.array([max(0, self._all.count - 1), int(any(len(some) > 1 for some in places))], np.int64)
        slot = np.repeat([0, 1], [count, len(alone)])
        free = Limits(int(room.sum()), np.zeros(size), np.inf, np.eye(size, dtype=np.bool_), slot, room)
        self._failed = [(self._maker.table(base, [*self._cells, *alone]), free)]
        rests = [[cells for cells in own if cells is not lost] for lost in own]
        bases = [np.unique(np.concatenate([_NOTHING, *rest])) for rest in rests]
        if bases:
            worst = min(bases, key=self._maker.value)
            self._failed.append((self._maker.table(worst, self._cells), self._all))

    def _bounded(self, chosen: list[int], limits: Limits | None = None) -> Generator[Progress, None, Bound]:
        """Bound the figure by cuts of the least concave functions above it."""
        tables = [(self.table.concave(), limits or self._all)]
        if self.problem.goal.name == WORST:
            tables = self._failed
        bounds = []
        for table, limits in tables:
            cuts = fractional_bound(table, limits, chosen)
            bounds.append((yield from self._steps("bounding", cuts, chosen)))
        return Bound(min(bounds), "cuts")

    def told(self, stage: str, share: float, chosen: list[int], bound: int | None = None) -> Progress:
        """Return the progress with a set as the best so far."""
        value = self.figure.value(chosen)
        above = None if bound is None else max(bound, value) / UNIT
        return Progress(stage, share, self.rig_with(chosen), value / UNIT, above, self.skin)

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
            if self._is_stale():
                raise Cancelled
            if bound is not None and chosen is not None and self._keeps_floors(chosen):
                # what comes before the figure itself is all there
                first = self._goal.value(chosen) - self.figure.value(chosen) if stage == "proving" else 0
                least = bound - first if least is None else min(least, bound - first)
            yield (
                Progress(stage, 0.0, skin=self.skin)
                if chosen is None
                else self.told(stage, 0.0, chosen, least)
            )

    def meeting(
        self, chosen: list[int], bound: Bound
    ) -> Generator[Progress, None, tuple[list[int], tuple[str, ...] | None]]:
        """Return the first set that meets all requirements, and what it does not meet: the best one where none of a few
        does. Each next one leaves out what the last set would miss least."""
        if self.problem.unmet is None:
            return chosen, None
        limits, tried, first = self._all, list(chosen), self.problem.unmet(self.rig_with(chosen))
        unmet = first
        for _ in range(TRIES):
            free = [one for one in tried if not self.candidates[one].is_as_now]
            if not unmet or not free:
                break
            worth = {one: self.figure.value([other for other in tried if other != one]) for one in free}
            slot = limits.slot.copy()
            slot[max(free, key=lambda one: worth[one])] = len(self._all.room)  # a slot without room
            limits = replace(limits, slot=slot, room=np.append(self._all.room, 0))
            tried = yield from self._steps("meeting requirements", self._searched(limits), chosen)
            yield self.told("meeting requirements", 0.0, tried, bound.value)
            unmet = self.problem.unmet(self.rig_with(tried))
        return (chosen, first) if unmet else (tried, ())

    def front(self, chosen: list[int]) -> Generator[Progress, None, list[list[int]]]:
        """Return the sets of the front besides the best one."""
        if self.ground is None:
            return []
        steps = front(self._goal, self.ground, self._all, chosen, FRONT - 1, self._stays)
        return (yield from self._steps("front", steps, chosen))

    def stairs(self) -> Generator[Progress, None, tuple[CostStep, ...]]:
        """Return the best sets found by number of additions."""
        found = []
        for count in range(max(self.problem.count, STAIRS) + 1 if self.problem.count else 1):
            room = np.array([count, *self._all.room[1:]], np.int64)
            limits = replace(
                self._all, count=int(room.sum()), room=room, budget=self.problem.additions.budget
            )
            some = yield from self._steps("stairs", self._searched(limits))
            found.append(
                CostStep(count, self.figure.value(some) / UNIT, self.rig_with(some, f"{count} added"))
            )
        return tuple(found)

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
            if self._all.allow([*self._stays, *some])
        ]
        best = max(sets, key=self.figure.value, default=self._stays)
        return self.rig_with(best, "mounted by hand")

    def rig_with(self, chosen: Sequence[int], name: str = "proposal") -> Rig:
        """Return the rig with some candidates added, and those of its own sensors in their place."""
        found = mounted(self.problem.rig, [self.candidates[one] for one in chosen])
        return found.replace(name=f"{found.name[:150]}, {name}")

    def proposal(self, chosen: Sequence[int], number: int) -> Proposal:
        """Return a set as a proposal; its value is still to be evaluated."""
        blind_m2 = None
        if self.ground is not None and self.ground_maker is not None:
            seen = self.ground.value(chosen) - self.ground.value([])
            blind_m2 = self._blind_rest_m2 - seen * self.ground_maker.column_m2
        return Proposal(
            self.rig_with(chosen, f"proposal {number}"),
            tuple(self.candidates[one] for one in chosen if not self.candidates[one].is_as_now),
            0.0,
            blind_m2,
        )


def _enabled(rig: Rig) -> list[Sensor]:
    return [sensor for sensor in rig.sensors if sensor.enabled]


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
