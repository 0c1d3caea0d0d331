"""One run: candidates cast one by one, a proposal, its bound, its guard, and the front of two goals, step by step."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TypeVar

import numpy as np

from riglens.core.errors import Cancelled
from riglens.core.kernels.runtime import jit
from riglens.core.optimise.bounds import Bound, branch_and_bound, fractional_bound
from riglens.core.optimise.guard import Evaluator, Kept, guard
from riglens.core.optimise.mounts import candidates, conflicts, rules_for
from riglens.core.optimise.results import OptimiseResult, Problem, Proposal
from riglens.core.optimise.search import Limits, front, greedy, search
from riglens.core.optimise.tables import Cells, CoverTable, GroundTableMaker, HitTableMaker
from riglens.core.review.blind import BlindEngine, BlindSettings
from riglens.core.rig.model import Rig
from riglens.core.targets.engine import never_stale
from riglens.core.vehicle.solid import solid_of

CASTING = "casting"
FIRST = 100
"""Sensors after which a first proposal is made of those that have been cast, in an order drawn by the seed."""
FRONT = 8
"""Points of a front, at most."""
_NOTHING = np.zeros(0, np.int32)
_HAND_X = (0.5, 0.92, 0.08, 0.75)
_HAND_Y, _HAND_Z = (0.7, 0.9, 0.9, 0.95), (1.0, 0.5, 0.6, 0.6)
"""Usual places of a pair: roof sides, front corners, rear corners, wings; shares of length, half width and height."""
IsStale = Callable[[], bool]
T = TypeVar("T")


@dataclass(frozen=True)
class Progress:
    """Progress of a search: the current step, the share done, and the best rig so far."""

    stage: str
    share: float
    best: Rig | None = None


Steps = Generator[Progress, None, OptimiseResult]


def optimise(problem: Problem, threads: int | None = None, is_stale: IsStale = never_stale) -> Steps:
    """Propose rigs step by step; each step takes some ten milliseconds, those of the guard up to seconds.

    Raise InputError where nothing can be added, and Cancelled, also within a step, as soon as `is_stale` returns True.
    The result does not depend on the number of threads.
    """
    run = _Run(problem, jit.use_threads(threads), is_stale)
    yield from run.cast()
    chosen, bound = yield from run.solve()
    sets = [chosen, *(yield from run.front(chosen))]
    reference = problem.reference or run.by_hand()
    proposals = [run.proposal(one, number) for number, one in enumerate(sets, 1)]
    evaluator = Evaluator(problem.traffic, threads)
    frames = 0, problem.frames
    values = list[float]()
    for rig in (problem.rig, reference, *(one.rig for one in proposals)):
        yield Progress("evaluating", len(values) / (len(proposals) + 2), proposals[0].rig)
        values.append(evaluator.sample(rig, problem.settings, frames, is_stale).value)
    proposals = [replace(one, value=value) for one, value in zip(proposals, values[2:], strict=True)]
    checks = guard(
        proposals[0].rig, reference, problem.traffic, problem.settings, problem.frames, problem.held_out,
        threads, is_stale,
    )  # fmt: skip
    kept = list[Kept]()
    for one in checks:
        kept.append(one)
        yield Progress(f"checking: {one.case}", len(kept) / 6, proposals[0].rig)
    proposals[0] = replace(proposals[0], guard=tuple(kept))
    before_m2 = None if run.ground_maker is None else run.ground_maker.blind_m2
    points = tuple(range(len(proposals))) if run.ground is not None else ()
    return OptimiseResult(
        problem,
        len(run.candidates),
        values[0],
        before_m2,
        reference,
        values[1],
        bound,
        tuple(proposals),
        points,
    )


class _Run:
    """Candidates of a problem and their tables."""

    def __init__(self, problem: Problem, workers: int, is_stale: IsStale) -> None:
        self.problem, self._is_stale, rig = problem, is_stale, problem.rig
        solid = solid_of(rig.vehicle) if rig.self_occlusion else None
        self.candidates = candidates(rig, problem.additions, problem.seed, is_stale)
        self._maker = HitTableMaker(problem.traffic, problem.frames, problem.settings, solid, workers)
        self.ground_maker = None
        if problem.blind_m is not None:
            engine = BlindEngine(rig.vehicle, BlindSettings(), workers)
            self.ground_maker = GroundTableMaker(rig, engine, problem.blind_m, workers)
        self._rules = rules_for(rig, problem.additions.rules)
        self.table: CoverTable
        self._all: Limits
        self.ground: CoverTable | None = None

    def cast(self) -> Generator[Progress, None, None]:
        """Cast the coverage of the rig and of each candidate, in an order drawn by the seed; build the tables."""
        base = self._maker.cells_of(self.problem.rig.enabled_lidars(), self._is_stale)
        order = np.random.default_rng(self.problem.seed).permutation(len(self.candidates)).tolist()
        found: dict[int, tuple[Cells, Cells]] = {}
        best, first = None, FIRST // (2 if self.problem.additions.mirrored else 1)
        for number, one in enumerate(order, 1):
            sensors = self.candidates[one].sensors
            columns = _NOTHING if self.ground_maker is None else self.ground_maker.cells_of(sensors)
            found[one] = self._maker.cells_of(sensors, self._is_stale), columns
            if number == min(first, len(order)):
                some = sorted(found)
                table = self._maker.table(base, [found[one][0] for one in some])
                picked = [some[place] for place in greedy(table, self._limits(some))]
                best = self.rig_with(picked)
            yield Progress(CASTING, number / len(order), best)
        self.table = self._maker.table(base, [found[one][0] for one in range(len(order))])
        self._all = self._limits(range(len(order)))
        if self.ground_maker is not None:
            self.ground = self.ground_maker.table([found[one][1] for one in range(len(order))])

    def _limits(self, some: Sequence[int]) -> Limits:
        additions, listed = self.problem.additions, [self.candidates[one] for one in some]
        costs = np.array([one.cost for one in listed])
        apart = conflicts(listed, self.problem.rig, self._rules)
        return Limits(additions.count, costs, additions.budget, apart)

    def solve(self) -> Generator[Progress, None, tuple[list[int], Bound]]:
        """Search for the best set, then try to prove it, and bound it by cuts where that takes too many steps."""
        chosen = yield from self._told("searching", search(self.table, self._all))
        chosen, proven = yield from self._told(
            "proving", branch_and_bound(self.table, self._all, chosen), self.rig_with(chosen)
        )
        if proven:
            return chosen, Bound(self.table.value(chosen), "proven")
        cuts = fractional_bound(self.table, self._all, chosen)
        value = yield from self._told("bounding", cuts, self.rig_with(chosen))
        return chosen, Bound(value, "cuts")

    def _told(
        self, stage: str, steps: Generator[None, None, T], best: Rig | None = None
    ) -> Generator[Progress, None, T]:
        """Run steps and emit their progress; raise Cancelled between two of them."""
        while True:
            try:
                next(steps)
            except StopIteration as end:
                found: T = end.value
                return found
            if self._is_stale():
                raise Cancelled
            yield Progress(stage, 0.0, best)

    def front(self, chosen: list[int]) -> Generator[Progress, None, list[list[int]]]:
        """Return the sets of the front besides the best one."""
        if self.ground is None:
            return []
        steps = front(self.table, self.ground, self._all, chosen, FRONT - 1)
        return (yield from self._told("front", steps, self.rig_with(chosen)))

    def by_hand(self) -> Rig:
        """Return the best of the sets that a person would mount level at roof sides, corners and wings."""
        car, additions = self.problem.rig.vehicle, self.problem.additions
        middles = np.array([one.places_m[0] for one in self.candidates])
        level = np.array([one.tilt_deg == min(additions.tilts_deg) for one in self.candidates])
        usual = []
        for side in (1.0,) if additions.mirrored else (1.0, -1.0):
            for x, y, z in zip(_HAND_X, _HAND_Y, _HAND_Z, strict=True):
                place = [(x - 0.5) * car.length, side * y * car.width / 2.0, z * car.height]
                away = np.where(level, np.linalg.norm(middles - place, axis=1), np.inf)
                usual.append(int(np.argmin(away)))
        usual = sorted(set(usual))
        sets = [
            list(some)
            for count in range(1, additions.count + 1)
            for some in combinations(usual, count)
            if self._all.allow(some)
        ]
        best = max(sets, key=self.table.value, default=[])
        return self.rig_with(best, "mounted by hand")

    def rig_with(self, chosen: Sequence[int], name: str = "proposal") -> Rig:
        """Return the rig with some candidates added."""
        rig = self.problem.rig
        added = [sensor for one in chosen for sensor in self.candidates[one].sensors]
        return rig.replace(name=f"{rig.name[:150]}, {name}", sensors=(*rig.sensors, *added))

    def proposal(self, chosen: Sequence[int], number: int) -> Proposal:
        """Return a set as a proposal; its value is still to be evaluated."""
        blind_m2 = None
        if self.ground is not None and self.ground_maker is not None:
            seen = self.ground.value(chosen)
            blind_m2 = self.ground_maker.blind_m2 - seen * self.ground_maker.column_m2
        return Proposal(
            self.rig_with(chosen, f"proposal {number}"),
            tuple(self.candidates[one] for one in chosen),
            0.0,
            blind_m2,
        )


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
