"""Store what each candidate covers: gains of any set without casting again, exact in integers."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from itertools import pairwise, takewhile
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from riglens.core.in_threads import in_threads
from riglens.core.kernels.optimise import gains as kernel

Ids = NDArray[np.int64]
Cells = NDArray[np.int32]
Doubles = NDArray[np.float64]
UNIT = 1 << 44
"""Integers for a value of 1: rounding stays far below the printed digits."""
FEW = 32
"""Gains that one thread finds sooner than several."""
_MOST_PAIR_WORDS = 1e10
"""Words of cells compared for all pairs of candidates, at most: some seconds."""
_GROUPS, _MOST_OVERLAPS = 64, 1 << 23
"""Groups of objects whose overlaps are summed apart, and sums for all pairs, at most: 64 MB."""


@dataclass
class State:
    """A set of candidates: how often each cell is covered, cells known of each object, and its value."""

    covered: NDArray[np.uint8]
    known: Cells
    value: int


class SetFunction(Protocol):
    """A monotone function of sets of candidates, in integers."""

    @property
    def size(self) -> int:
        """Number of candidates."""

    @property
    def is_submodular(self) -> bool:
        """Return whether gains never grow with the set, but for rounding far below the printed digits."""

    def gains(self, chosen: Sequence[int], ids: Ids) -> Ids:
        """Return what each of some candidates adds to a set."""

    def value(self, chosen: Sequence[int]) -> int:
        """Return the value of a set."""


class Table(SetFunction, Protocol):
    """A function that is worked out from what candidates cover."""

    def above(self) -> CoverTable | None:
        """Return a function of covered cells with the least worth above this one that rises by ever less; None where
        that would take too much memory."""


class CoverTable:
    """Value of covered cells: of each object a concave function of its number of cells, summed over objects.

    cells: of each candidate, each cell once, numbers below len(owner); owner (cells,): their objects, rising; known
    (objects,): cells of what is on the car already; row (objects,): row of worth (rows, most + 1), which rises by
    ever less; numbers (cells,): of the cells for their maker. Such a function is monotone and submodular.
    """

    def __init__(
        self,
        cells: Sequence[Cells],
        owner: Cells,
        known: Cells,
        row: NDArray[Any],
        worth: Ids,
        workers: int,
        numbers: Cells | None = None,
    ) -> None:
        self.workers, self.known, self.owner, self._numbers = workers, known, owner, numbers
        runs = [np.flatnonzero(np.diff(owner[one], prepend=-1)) for one in cells]
        starts = np.cumsum([0, *(len(run) for run in runs)])
        begins = np.cumsum([0, *(len(one) for one in cells)])
        ends = [run + begin for run, begin in zip(runs, begins, strict=False)]
        of = [owner[one[run]] for one, run in zip(cells, runs, strict=True)]
        self.cover = kernel.Cover(
            starts,
            np.concatenate([np.zeros(0, np.int32), *of]),
            np.concatenate([*ends, begins[-1:]]).astype(np.int64),
            np.concatenate([np.zeros(0, np.int32), *cells]),
            worth,
            row,
        )
        self._kept = tuple[int, ...](), self.empty()

    @property
    def size(self) -> int:
        """Number of candidates."""
        return len(self.cover.starts) - 1

    def empty(self) -> State:
        """Return the state without added candidates."""
        covered = np.zeros(len(self.owner), np.uint8)
        return State(covered, self.known.copy(), self._worth_of(self.known))

    def state(self, chosen: Sequence[int]) -> State:
        """Return the state of a set; the part shared with the previous set is reused."""
        (before, state), wanted = self._kept, tuple(chosen)
        if before != wanted:
            pairs = zip(before, wanted, strict=False)
            same = len(list(takewhile(lambda pair: pair[0] == pair[1], pairs)))
            for one in before[same:]:
                kernel.change(self.cover, one, -1, state.covered, state.known)
            for one in wanted[same:]:
                kernel.change(self.cover, one, 1, state.covered, state.known)
            state.value = self._worth_of(state.known)
            self._kept = wanted, state
        return state

    def valued(self, worth: Ids) -> CoverTable:
        """Return the same cells with another worth, rows as before."""
        found = copy(self)
        found.cover = self.cover._replace(worth=worth)
        found._kept = (), found.empty()
        return found

    @property
    def is_submodular(self) -> bool:
        """Return whether the worth rises by ever less."""
        return not (np.diff(self.cover.worth, n=2, axis=1) > 0).any()

    def above(self) -> CoverTable:
        """Return the least function above this one whose worth rises by ever less; itself where that is so."""
        if self.is_submodular:
            return self
        return self.valued(np.array([hull(row) for row in self.cover.worth]))

    def _worth_of(self, known: Cells) -> int:
        worth = self.cover.worth
        return int(worth[self.cover.row, np.minimum(known, worth.shape[1] - 1)].sum())

    def value(self, chosen: Sequence[int]) -> int:
        """Return the value of a set."""
        return self.state(chosen).value

    def gains(self, chosen: Sequence[int], ids: Ids) -> Ids:
        """Return what each of some candidates adds to a set, the same for any number of workers."""
        return self.gains_in(self.state(chosen), ids)

    def gains_in(self, state: State, ids: Ids) -> Ids:
        """Return what each of some candidates adds in a state."""
        found = np.empty(len(ids), np.int64)
        shares = 1 if len(ids) <= FEW else self.workers  # to wake others takes longer
        how = self.cover, ids, state.covered, state.known
        in_threads(shares, lambda share: kernel.gains(*how, share, shares, found))
        return found

    def losses(self) -> Ids | None:
        """Return the overlap of each pair on each group of objects, (groups, n, n): both gains added minus their joint
        gain, of a candidate with itself its gain; None if all pairs would take longer than the few that a search needs.
        """
        cover, objects = self.cover, len(self.known)
        words = -(-np.bincount(self.owner, minlength=objects) // 64)
        hits = np.bincount(cover.of, minlength=objects)
        if float((hits.astype(np.float64) ** 2 * (words + 1)).sum()) > _MOST_PAIR_WORDS:
            return None
        starts = np.concatenate([[0], np.cumsum(words[cover.of])])
        bits, first = np.zeros(int(starts[-1]), np.uint64), np.searchsorted(self.owner, np.arange(objects))
        kernel.mark_runs(cover, first, starts, bits)
        begins = np.concatenate([[0], np.cumsum(hits)])
        by_object, owner = (
            np.argsort(cover.of, kind="stable"),
            np.repeat(np.arange(self.size), np.diff(cover.starts)),
        )
        group = self._groups()
        found = np.zeros((int(group.max(initial=0)) + 1, self.size, self.size), np.int64)
        kernel.losses(cover, self.known, group, by_object, begins, owner, starts, bits, self.workers, found)
        for one in found:
            one += np.tril(one, -1).T
        return found

    def _groups(self) -> Ids:
        """Return a group of each object, (objects,): by which of some candidates, evenly drawn, hits most of it."""
        cover, group = self.cover, np.zeros(len(self.known), np.int64)
        most = np.zeros(len(self.known), np.int64)
        count = min(_GROUPS, self.size, max(1, _MOST_OVERLAPS // max(1, self.size) ** 2))
        for number, one in enumerate(np.linspace(0, self.size - 1, count).astype(np.int64).tolist()):
            runs = slice(*cover.starts[one : one + 2])
            hits = np.diff(cover.ends[runs.start : runs.stop + 1])
            is_more = hits > most[cover.of[runs]]
            of = cover.of[runs][is_more]
            group[of], most[of] = number, hits[is_more]
        return group

    def given(self, cells: Cells, known: Cells) -> State:
        """Return the state where sensors cover cells, by their maker's numbers (rising), and `known` of each object."""
        assert self._numbers is not None
        covered = np.isin(self._numbers, cells, assume_unique=True).astype(np.uint8)
        return State(covered, known, self._worth_of(known))


def hull(worth: Ids) -> Ids:
    """Return the least integers above a row of worth that rise by ever less."""
    corners = [0]
    for place in range(1, len(worth)):
        while len(corners) > 1:
            a, b = corners[-2:]
            if (worth[b] - worth[a]) * (place - b) > (worth[place] - worth[b]) * (b - a):
                break
            corners.pop()
        corners.append(place)
    # whole steps, the larger ones first: that only raises sums
    steps = list[int]()
    for a, b in pairwise(corners):
        whole, more = divmod(int(worth[b] - worth[a]), b - a)
        steps += [whole + 1] * more + [whole] * (b - a - more)
    return np.concatenate([worth[:1], worth[0] + np.cumsum(np.sort(np.array(steps, np.int64))[::-1])])


class WorstFailure:
    """Value of a set with the one sensor failed that it misses most. It is not submodular: greedy choice and bounds of
    such functions do not hold for it.

    table: of candidates, then of each of their sensors by itself, then of the rig's own; alone: places of a
    candidate's sensors; own: those of the rig's.
    """

    is_submodular = False

    def __init__(self, table: CoverTable, alone: Sequence[Sequence[int]], own: Sequence[int]) -> None:
        self._table, self._alone, self._own, self.size = table, alone, list(own), len(alone)

    def _left(self, chosen: Sequence[int]) -> list[list[int]]:
        """Return what is left by each failure."""
        every = [*self._own, *chosen]
        left = [[one for one in every if one != own] for own in self._own]
        for one in chosen:
            others = [*self._own, *(other for other in chosen if other != one)]
            left += [[*others, *(s for s in self._alone[one] if s != lost)] for lost in self._alone[one]]
        return left

    def value(self, chosen: Sequence[int]) -> int:
        """Return the value of a set."""
        return min((self._table.value(left) for left in self._left(chosen)), default=0)

    def gains(self, chosen: Sequence[int], ids: Ids) -> Ids:
        """Return what each of some candidates adds to a set."""
        every = [*self._own, *chosen]
        worst = np.full(len(ids), np.iinfo(np.int64).max)
        for left in self._left(chosen):
            worst = np.minimum(worst, self._table.value(left) + self._table.gains(left, ids))
        value = self._table.value(every)
        for place in range(2):  # one of the sensors that join fails
            others = [[s for s in self._alone[one] if s != self._alone[one][-1 - place :][0]] for one in ids]
            has = np.array([bool(some) for some in others], np.bool_)
            found = np.full(len(ids), value, np.int64)
            if has.any():
                joins = np.array([some[0] for some in others if some], np.int64)
                found[has] += self._table.gains(every, joins)
            worst = np.minimum(worst, found)
        return worst - self.value(chosen)
