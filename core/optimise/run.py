"""One run: candidates cast one by one, the best set, its bound, the front of two goals, and the guard's cases."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np

from riglens.core.errors import Cancelled, InputError, IsStale, never_stale
from riglens.core.kernels.runtime import jit
from riglens.core.optimise.bounds import Bound, Step, bounded
from riglens.core.optimise.candidates import choices_of
from riglens.core.optimise.guard import GuardResult, cases_of, guard
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.results import OptimiseResult, Progress, Proposal
from riglens.core.optimise.search import Limits, front, search, swap, unwatched
from riglens.core.optimise.skin import SkinGains
from riglens.core.optimise.space import Space, cast
from riglens.core.rig.model import Rig

FRONT = 8
"""Points of a front, at most."""
TRIES = 12
"""Further sets that are tried where the best one does not meet requirements."""
_HAND_X = (0.5, 0.92, 0.08, 0.75)
_HAND_Y, _HAND_Z = (0.7, 0.9, 0.9, 0.95), (1.0, 0.5, 0.6, 0.6)
"""Usual places of a pair: roof sides, front corners, rear corners, wings; shares of length, half width and height."""


def optimise(
    problem: Problem,
    threads: int | None = None,
    report: Callable[[Progress], None] = unwatched,
    is_stale: IsStale = never_stale,
) -> OptimiseResult:
    """Propose rigs; report each step, which takes some ten milliseconds, those of the guard up to seconds.

    Raise InputError where nothing can be added, and Cancelled, also within a step, as soon as `is_stale` returns True.
    The result does not depend on the number of threads.
    """
    space = _cast(problem, threads, report, is_stale)
    choices, ground, shown = space.choices, space.ground, space.maker.shown

    def progress(stage: str, chosen: list[int], bound: float | None, share: float = 0.0) -> Progress:
        value = space.figure.value(chosen)
        above = None if bound is None else shown(max(bound, value))
        return Progress(stage, share, choices.rig_with(chosen), shown(value), above, space.skin)

    def step(stage: str, chosen: list[int] | None, bound: int | None) -> None:
        if is_stale():
            raise Cancelled
        report(Progress(stage, 0.0, skin=space.skin) if chosen is None else progress(stage, chosen, bound))

    sets, bound, unmet = solved(space, step)
    above = None if bound is None else bound.value
    reference = problem.reference or by_hand(space)
    rigs = [choices.rig_with(one, f"proposal {number}") for number, one in enumerate(sets, 1)]
    measured, values = [problem.rig, reference, *rigs], list[float]()
    for rig in measured:
        report(progress("evaluating", sets[0], above, len(values) / len(measured)))
        values.append(space.value_of(rig, is_stale))
    found = OptimiseResult(
        problem,
        len(choices.candidates),
        values[0],
        None if ground is None else ground.before_m2,
        reference,
        values[1],
        None if bound is None else Bound(shown(bound.value), bound.kind),
        tuple(
            Proposal(
                rig,
                tuple(choices.candidates[one] for one in some if not choices.candidates[one].is_as_now),
                value,
                None if ground is None else ground.unseen_m2(some),
                space.adds(some),
            )
            for rig, some, value in zip(rigs, sets, values[2:], strict=True)
        ),
        tuple(range(len(rigs))) if ground is not None else (),
        unmet,
    )
    cases, kept = cases_of(problem, rigs[0], reference, space.sampler, is_stale), list[GuardResult]()
    for one in guard(cases):
        kept.append(one)
        found = found.checked(tuple(kept))
        now = progress(f"checking: {one.case}", sets[0], above, len(kept) / len(cases))
        report(replace(now, result=found))
    return found


def skin_gains(
    problem: Problem,
    threads: int | None = None,
    report: Callable[[Progress], None] = unwatched,
    is_stale: IsStale = never_stale,
) -> SkinGains:
    """Cast the candidates of a problem, as `optimise` does, and return their gains for any rig.

    Raise InputError for an objective without tables.
    """
    skin = _cast(problem, threads, report, is_stale).skin
    if skin is None:
        raise InputError(
            f"{problem.objective} has no gains to show on the car: choose another one", "objective"
        )
    return skin


def _cast(
    problem: Problem, threads: int | None, report: Callable[[Progress], None], is_stale: IsStale
) -> Space:
    workers = jit.use_threads(threads)
    choices = choices_of(problem.rig, problem.additions, problem.seed, is_stale, problem.moves)
    return cast(problem, choices, workers, report, is_stale)


def solved(
    space: Space, step: Step = unwatched
) -> tuple[list[list[int]], Bound | None, tuple[str, ...] | None]:
    """Search for the best set and bound it; where it does not meet requirements, search on for one that does.

    Return the best set, then those of the front; a bound on any other in integers; and the requirements that the best
    one does not meet, None without requirements.
    """
    limits, stays = space.choices.limits, space.choices.stays
    chosen = _searched(space, limits, partial(step, "searching", None, None))
    chosen, bound = bounded(space.figure, space.goal, limits, chosen, space.caps, step)
    unmet = None
    if space.problem.unmet is not None:
        chosen, unmet = _meeting(space, space.problem.unmet, chosen, bound, step)
    if bound is not None and bound.kind == "proven" and space.figure.value(chosen) < bound.value:
        bound = Bound(bound.value, "cuts")
    sets = [chosen]
    if space.ground is not None:
        watched = partial(step, "front", chosen, None)
        sets += front(space.goal, space.ground.table, limits, chosen, FRONT - 1, stays, watched)
    return sets, bound, unmet


def _searched(space: Space, limits: Limits, step: Callable[[], None]) -> list[int]:
    """Return the best set found; with a failure by exchanges of members of a set that is best without any."""
    chosen = search(space.plain, limits, space.choices.stays, step)
    return chosen if space.plain is space.goal else sorted(swap(space.goal, limits, chosen, step))


def _meeting(
    space: Space,
    unmet_by: Callable[[Rig], tuple[str, ...]],
    chosen: list[int],
    bound: Bound | None,
    step: Step,
) -> tuple[list[int], tuple[str, ...]]:
    """Return the first set that meets all requirements, and what it does not meet: the best one where none of a few
    does. Each next one leaves out what the last set would miss least."""
    choices, tried, stage = space.choices, list(chosen), "meeting requirements"
    limits, first = choices.limits, unmet_by(choices.rig_with(chosen))
    room, unmet = limits.room, first
    for _ in range(TRIES):
        free = [one for one in tried if not choices.candidates[one].is_as_now]
        if not unmet or not free:
            break
        worth = {one: space.figure.value([other for other in tried if other != one]) for one in free}
        slot = limits.slot.copy()
        slot[max(free, key=lambda one: worth[one])] = len(room)  # a slot without room
        limits = replace(limits, slot=slot, room=np.append(room, 0))
        tried = _searched(space, limits, partial(step, stage, chosen, None))
        step(stage, tried, None if bound is None else int(bound.value))
        unmet = unmet_by(choices.rig_with(tried))
    return (chosen, first) if unmet else (tried, ())


def by_hand(space: Space) -> Rig:
    """Return the best of the sets that a person would mount level at roof sides, corners and wings; the rig itself
    where nothing is added."""
    additions, stays, limits = space.problem.additions, space.choices.stays, space.choices.limits
    if not additions.models:
        return space.problem.rig
    usual = _usual_mounts(space)
    if additions.counts:
        chosen = list(stays)
        while (ids := np.array([one for one in usual if limits.open_to(chosen)[one]], np.int64)).size:
            gains = space.goal.gains(chosen, ids)
            if gains.max() <= 0:
                break
            chosen.append(int(ids[np.argmax(gains)]))
        return space.choices.rig_with(chosen, "typical mounts")
    sets = [
        [*stays, *some]
        for count in range(1, additions.count + 1)
        for some in combinations(usual, count)
        if limits.allow([*stays, *some])
    ]
    return space.choices.rig_with(max(sets, key=space.figure.value, default=stays), "typical mounts")


def _usual_mounts(space: Space) -> list[int]:
    """Return the added candidates of each slot that are nearest to the usual places, level, in order."""
    car, additions, listed = space.problem.rig.vehicle, space.problem.additions, space.choices.candidates
    middles, least = np.array([one.places_m[0] for one in listed]), min(additions.tilts_deg)
    moves = len(space.problem.moves)
    slots = ({0} if additions.shared else set[int]()) | {one.slot for one in listed if one.slot > moves}
    usual = set[int]()
    for slot in slots:
        level = np.array([one.tilt_deg == least and one.slot == slot for one in listed])
        for side in (1.0,) if additions.mirrored else (1.0, -1.0):
            for x, y, z in zip(_HAND_X, _HAND_Y, _HAND_Z, strict=True):
                place = [(x - 0.5) * car.length, side * y * car.width / 2.0, z * car.height]
                away = np.where(level, np.linalg.norm(middles - place, axis=1), np.inf)
                usual.add(int(np.argmin(away)))
    return sorted(usual)
