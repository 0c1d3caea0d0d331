"""Sets of candidates by greedy choice and exchange, within limits. Ties go to the lower number."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from riglens.core.optimise.tables import UNIT, SetFunction

Ids = NDArray[np.int64]
Flags = NDArray[np.bool_]
ROUNDING = 1e-9
"""Of sums of costs, relative to the budget."""
_FREE = 1e-6
"""Cost, in gains per cost, of what costs nothing."""


@dataclass(frozen=True)
class Limits:
    """Constraints on a set: at most `count` candidates, costs (n,) within a budget, no two in conflict (n, n); of each
    slot (n,) at most its room (slots,), where there are several, in which candidates take their size (n,), 1 by
    default."""

    count: int
    costs: NDArray[np.float64]
    budget: float
    conflicts: Flags
    slot: Ids = field(default_factory=lambda: np.zeros(0, np.int64))
    room: Ids = field(default_factory=lambda: np.zeros(0, np.int64))
    size: Ids = field(default_factory=lambda: np.zeros(0, np.int64))

    def among(self, some: Sequence[int]) -> Limits:
        """Return the limits of some candidates, numbered anew."""
        apart = self.conflicts[np.ix_(some, some)]
        own = self.slot[some], self.room, self.sizes[some]
        return Limits(self.count, self.costs[some], self.budget, apart, *own)

    @property
    def sizes(self) -> Ids:
        """Return the size of each candidate, (n,)."""
        return self.size if len(self.size) else np.ones(len(self.costs), np.int64)

    def left(self, chosen: Sequence[int]) -> Ids:
        """Return the room that a set leaves in each slot, (slots,)."""
        some = list(chosen)
        taken = np.zeros(len(self.room), np.int64)
        np.add.at(taken, self.slot[some], self.sizes[some])
        return self.room - taken

    def open_to(self, chosen: Sequence[int]) -> Flags:
        """Return which candidates may join a set, (n,)."""
        if len(chosen) >= self.count:
            return np.zeros(len(self.costs), np.bool_)
        fits = self.costs <= self.budget * (1.0 + ROUNDING) - float(self.costs[list(chosen)].sum())
        if len(self.room) > 1:
            fits &= self.sizes <= self.left(chosen)[self.slot]
        return np.asarray(fits & ~self.conflicts[list(chosen)].any(axis=0))

    def of_slots(self, chosen: Sequence[int], ids: Ids, most: int) -> list[tuple[Ids | slice, int]]:
        """Return by slot the places of candidates among `ids`, and how many of them may join a set, at most `most`."""
        if len(self.room) < 2:
            return [(slice(None), most)]
        left, slots = self.left(chosen), self.slot[ids]
        return [
            (np.flatnonzero(slots == one), min(room, most)) for one, room in enumerate(left.tolist()) if room
        ]

    def allow(self, chosen: Sequence[int]) -> bool:
        """Return whether a set is allowed."""
        return all(self.open_to(chosen[:place])[one] for place, one in enumerate(chosen))


def greedy(f: SetFunction, limits: Limits, start: Sequence[int] = (), per_cost: bool = False) -> list[int]:
    """Add the candidate with the largest gain, or gain per cost, to a set until none fits or adds anything."""
    chosen = list(start)
    while (ids := np.flatnonzero(limits.open_to(chosen))).size:
        gains = f.gains(chosen, ids)
        best = int(np.argmax(gains / np.maximum(limits.costs[ids], _FREE) if per_cost else gains))
        if gains[best] <= 0:
            break
        chosen.append(int(ids[best]))
    return chosen


def unwatched(*_: object) -> None:
    """Report no progress."""


def swap(
    f: SetFunction, limits: Limits, chosen: list[int], step: Callable[[], None] = unwatched
) -> list[int]:
    """Exchange one candidate for another, the best exchange first, until none helps; call `step` after each sweep."""
    while True:
        value, best = f.value(chosen), (0, chosen)
        for place in range(len(chosen)):
            others = chosen[:place] + chosen[place + 1 :]
            ids = np.flatnonzero(limits.open_to(others))
            gains = f.gains(others, ids)
            at = int(np.argmax(gains))
            more = f.value(others) + int(gains[at]) - value
            if more > best[0]:
                best = more, [*others, int(ids[at])]
            step()
        if best[0] <= 0:
            return chosen
        chosen = greedy(f, limits, best[1])  # a cheaper one may leave room in a budget


def search(
    f: SetFunction, limits: Limits, stays: Sequence[int] = (), step: Callable[[], None] = unwatched
) -> list[int]:
    """Return the best of the greedy sets after exchanges, sorted; `stays`: what one of them starts with."""
    starts = [greedy(f, limits)]
    if np.isfinite(limits.budget) and len(np.unique(limits.costs)) > 1:
        starts.append(greedy(f, limits, per_cost=True))
    if stays:
        starts.append(greedy(f, limits, stays))
    best: list[int] = []
    for start in starts:
        found = swap(f, limits, start, step)
        if not best or f.value(found) > f.value(best):
            best = found
    return sorted(best)


class AtLeast:
    """A function that counts after a second one, in whole units such as columns, has reached a level."""

    def __init__(self, first: SetFunction, second: SetFunction, level: int) -> None:
        self._first, self._second, self._level, self.size = first, second, level, first.size
        self.is_submodular = first.is_submodular and second.is_submodular

    def value(self, chosen: Sequence[int]) -> int:
        """Return the value of a set."""
        return self._first.value(chosen) + UNIT * min(self._second.value(chosen), self._level)

    def gains(self, chosen: Sequence[int], ids: Ids) -> Ids:
        """Return what each of some candidates adds to a set."""
        before = self._second.value(chosen)
        after = np.minimum(before + self._second.gains(chosen, ids), self._level)
        return np.asarray(self._first.gains(chosen, ids) + UNIT * (after - min(before, self._level)))


def front(
    first: SetFunction,
    second: SetFunction,
    limits: Limits,
    chosen: list[int],
    points: int,
    stays: Sequence[int] = (),
    step: Callable[[], None] = unwatched,
) -> list[list[int]]:
    """Return sets of which none is better than another in both goals, besides one chosen by the first goal alone.

    Epsilon constraint: the first goal at levels of the second one, up to the most that is found of that alone.
    """
    most = search(second, limits, stays, step)
    base, low, high = (second.value(one) for one in ([], chosen, most))
    found = []
    for more in np.unique(np.linspace(low + 1 - base, high - base, points).round().astype(np.int64)).tolist():
        level = base + more
        found.append(search(AtLeast(first, second, level), limits, stays, step))
    found.sort(key=lambda one: (-first.value(one), -second.value(one)))
    kept, best = list[list[int]](), low
    for one in found:
        if second.value(one) > best:
            kept.append(one)
            best = second.value(one)
    return kept
