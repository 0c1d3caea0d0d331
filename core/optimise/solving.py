"""Solve a search: the best set found, its bound, the front of two goals, and what a person would mount."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TypeVar

import numpy as np

from riglens.core.optimise.bounds import Bound, Now, bounded
from riglens.core.optimise.search import Limits, front, search, swap
from riglens.core.optimise.space import Space
from riglens.core.rig.model import Rig

FRONT = 8
"""Points of a front, at most."""
TRIES = 12
"""Further sets that are tried where the best one does not meet requirements."""
_HAND_X = (0.5, 0.92, 0.08, 0.75)
_HAND_Y, _HAND_Z = (0.7, 0.9, 0.9, 0.95), (1.0, 0.5, 0.6, 0.6)
"""Usual places of a pair: roof sides, front corners, rear corners, wings; shares of length, half width and height."""
T = TypeVar("T")


@dataclass(frozen=True)
class Solution:
    """Sets of candidates: the best one, then those of the front; a bound on any other in integers, and the requirements
    that the best one does not meet, None without requirements."""

    sets: tuple[list[int], ...]
    bound: Bound | None
    unmet: tuple[str, ...] | None


def solved(space: Space) -> Generator[Now, None, Solution]:
    """Search for the best set and bound it; where it does not meet requirements, search on for one that does."""
    limits, problem = space.choices.limits, space.problem
    chosen = yield from _steps("searching", None, _searched(space, limits))
    chosen, bound = yield from bounded(
        space.figure, space.goal, limits, chosen, space.caps, space.is_submodular
    )
    unmet = None
    if problem.unmet is not None:
        chosen, unmet = yield from _meeting(space, problem.unmet, chosen, bound)
    if bound is not None and bound.kind == "proven" and space.figure.value(chosen) < bound.value:
        bound = Bound(bound.value, "cuts")
    sets = [chosen]
    if space.ground is not None:
        more = front(space.goal, space.ground.table, limits, chosen, FRONT - 1, space.choices.stays)
        sets += yield from _steps("front", chosen, more)
    return Solution(tuple(sets), bound, unmet)


def _steps(stage: str, chosen: list[int] | None, steps: Generator[None, None, T]) -> Generator[Now, None, T]:
    """Run the steps of a stage."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            found: T = end.value
            return found
        yield stage, chosen, None


def _searched(space: Space, limits: Limits) -> Generator[None, None, list[int]]:
    """Return the best set found; with a failure by exchanges of members of a set that is best without any."""
    chosen = yield from search(space.plain, limits, space.choices.stays)
    return chosen if space.plain is space.goal else sorted((yield from swap(space.goal, limits, chosen)))


def _meeting(
    space: Space, unmet_by: Callable[[Rig], tuple[str, ...]], chosen: list[int], bound: Bound | None
) -> Generator[Now, None, tuple[list[int], tuple[str, ...]]]:
    """Return the first set that meets all requirements, and what it does not meet: the best one where none of a few
    does. Each next one leaves out what the last set would miss least."""
    limits, tried, stage = space.choices.limits, list(chosen), "meeting requirements"
    room, unmet = limits.room, unmet_by(space.rig_with(chosen))
    first = unmet
    for _ in range(TRIES):
        free = [one for one in tried if not space.candidates[one].is_as_now]
        if not unmet or not free:
            break
        worth = {one: space.figure.value([other for other in tried if other != one]) for one in free}
        slot = limits.slot.copy()
        slot[max(free, key=lambda one: worth[one])] = len(room)  # a slot without room
        limits = replace(limits, slot=slot, room=np.append(room, 0))
        tried = yield from _steps(stage, chosen, _searched(space, limits))
        yield stage, tried, None if bound is None else int(bound.value)
        unmet = unmet_by(space.rig_with(tried))
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
        return space.rig_with(chosen, "typical mounts")
    sets = [
        [*stays, *some]
        for count in range(1, additions.count + 1)
        for some in combinations(usual, count)
        if limits.allow([*stays, *some])
    ]
    return space.rig_with(max(sets, key=space.figure.value, default=stays), "typical mounts")


def _usual_mounts(space: Space) -> list[int]:
    """Return the added candidates of each slot that are nearest to the usual places, level, in order."""
    car, additions, listed = space.problem.rig.vehicle, space.problem.additions, space.candidates
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
