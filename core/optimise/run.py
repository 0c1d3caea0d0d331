"""One run: candidates cast one by one, a proposal, its bound, and its guard, step by step."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import replace

from riglens.core.errors import Cancelled, InputError, IsStale, never_stale
from riglens.core.kernels.runtime import jit
from riglens.core.optimise.bounds import Bound, Now
from riglens.core.optimise.guard import GuardResult, cases_of, guard
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.results import OptimiseResult, Progress, Proposal
from riglens.core.optimise.skin import SkinGains
from riglens.core.optimise.solving import Solution, by_hand, solved
from riglens.core.optimise.space import CASTING, Space, cast, choices_for

Steps = Generator[Progress, None, OptimiseResult]


def optimise(problem: Problem, threads: int | None = None, is_stale: IsStale = never_stale) -> Steps:
    """Propose rigs step by step; each step takes some ten milliseconds, those of the guard up to seconds.

    Raise InputError where nothing can be added, and Cancelled, also within a step, as soon as `is_stale` returns True.
    The result does not depend on the number of threads.
    """
    workers = jit.use_threads(threads)
    space = yield from cast(problem, choices_for(problem, is_stale), workers, is_stale)
    solution = yield from _shown(space, solved(space))
    bound, ground, sets = solution.bound, space.ground, solution.sets
    above = None if bound is None else bound.value
    reference = problem.reference or by_hand(space)
    rigs = [space.rig_with(one, f"proposal {number}") for number, one in enumerate(sets, 1)]
    measured, values = [problem.rig, reference, *rigs], list[float]()
    for rig in measured:
        yield space.step("evaluating", len(values) / len(measured), sets[0], above)
        values.append(space.value_of(rig))
    found = OptimiseResult(
        problem,
        len(space.candidates),
        values[0],
        None if ground is None else ground.before_m2,
        reference,
        values[1],
        None if bound is None else Bound(space.shown(bound.value), bound.kind),
        tuple(
            Proposal(
                rig,
                tuple(space.candidates[one] for one in some if not space.candidates[one].is_as_now),
                value,
                None if ground is None else ground.unseen_m2(some),
                space.adds(some),
            )
            for rig, some, value in zip(rigs, sets, values[2:], strict=True)
        ),
        tuple(range(len(rigs))) if ground is not None else (),
        solution.unmet,
    )
    cases, kept = cases_of(problem, rigs[0], reference, space.sampler, is_stale), list[GuardResult]()
    for one in guard(cases):
        kept.append(one)
        found = found.checked(tuple(kept))
        step = space.step(f"checking: {one.case}", len(kept) / len(cases), sets[0], above)
        yield replace(step, result=found)
    return found


def _shown(space: Space, steps: Generator[Now, None, Solution]) -> Generator[Progress, None, Solution]:
    """Run steps and emit their progress; raise Cancelled between two of them."""
    while True:
        try:
            stage, chosen, bound = next(steps)
        except StopIteration as end:
            found: Solution = end.value
            return found
        if space.is_stale():
            raise Cancelled
        yield space.step(stage, 0.0, chosen, bound)


def skin_gains(
    problem: Problem, threads: int | None = None, is_stale: IsStale = never_stale
) -> Generator[Progress, None, SkinGains]:
    """Cast the candidates of a problem step by step, as `optimise` does, and return their gains for any rig.

    Raise InputError for an objective without tables.
    """
    workers = jit.use_threads(threads)
    space = yield from cast(problem, choices_for(problem, is_stale), workers, is_stale)
    if space.skin is None:
        raise InputError(
            f"{problem.objective} has no gains to show on the car: choose another one", "objective"
        )
    return space.skin


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
