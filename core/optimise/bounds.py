"""Bound the gain of any allowed set of candidates: by cutting planes, or by a proof with branch and bound.

Both count steps, never seconds, so that the same problem gives the same bound on any machine.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.optimise import gains as kernel
from riglens.core.optimise.search import ROUNDING, Limits, unwatched
from riglens.core.optimise.tables import CoverTable, SetFunction

Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]
CUTS, MOST_GAINS = 24, 100_000
_AT_ONCE, _STEPS = 16, 256
_LAST = 64
"""Gains of last candidates at once, more than one thread finds alone."""
_SLACK = 1e-9
"""Rounding of sums of doubles, relative; the bound is raised by it."""


@dataclass(frozen=True)
class Bound:
    """No allowed set is better than `value`; "proven": the set that was found is as good."""

    value: float
    kind: Literal["cuts", "proven"]


Step = Callable[[str, list[int] | None, int | None], None]
"""Called with each step of a search: its stage, the best set so far, and the bound so far."""
Cap = tuple[CoverTable, Limits]
"""A table, and limits of sets of its candidates, the best of which is worth no less than any allowed set."""


def bounded(
    figure: SetFunction,
    goal: SetFunction,
    limits: Limits,
    chosen: list[int],
    caps: Sequence[Cap],
    step: Step = unwatched,
) -> tuple[list[int], Bound | None]:
    """Try to prove a set, the best found, where the figure is submodular; bound it by cuts of functions above it where
    that takes too many steps. Return the best set and its bound, or None if nothing bounds it.

    figure: what is bounded; goal: the same after what comes before it, which counts whole units.
    """
    bounds = list[int]()
    if figure.is_submodular:
        first = goal.value(chosen) - figure.value(chosen)  # what comes before the figure is all there

        def proving(bound: int) -> None:
            bounds[:] = [min([bound - first, *bounds])]
            step("proving", chosen, bounds[0])

        chosen, is_proven = branch_and_bound(goal, limits, chosen, report=proving)
        if is_proven:
            return chosen, Bound(figure.value(chosen), "proven")
    for table, its_limits in caps:
        report = partial(step, "bounding", chosen)
        bounds.append(fractional_bound(table, its_limits, chosen, report=report))
    return chosen, Bound(min(bounds), "cuts") if bounds else None


def most_that_fit(limits: Limits) -> int:
    """Return an upper limit of the number of candidates in any allowed set."""
    spent = np.cumsum(np.sort(limits.costs)[: limits.count])
    return int((spent <= limits.budget * (1.0 + ROUNDING)).sum())


def fractional_bound(
    table: CoverTable,
    limits: Limits,
    incumbent: Sequence[int],
    cuts: int = CUTS,
    report: Callable[[int], None] = unwatched,
) -> int:
    """Bound the value of every allowed set from above; report the bound so far after each cut.

    A candidate may be taken in part: a cell is covered by the sum of the shares that hit it, at most 1, and an object's
    worth is taken linearly between whole cells. That function of the shares is concave and equals the table's value
    for whole candidates, so its supergradients are cuts. A linear program maximises the least cut over shares within
    count and budget (Kelley's method, next point half-way). The bound comes from the program's dual values, and any
    values >= 0 give a valid one: no tolerance of a solver enters. Conflicts are left out, which only raises the bound.
    """
    from scipy.optimize import linprog  # slow to load

    fits = limits.costs <= limits.budget * (1.0 + ROUNDING)
    most = most_that_fit(limits)
    point = np.zeros(table.size)
    point[list(incumbent)] = 1.0
    best_point, best_height, bound = point, -np.inf, np.inf
    offsets, slopes = list[float](), list[Doubles]()
    for _ in range(cuts):
        height, slope = _cut(table, point)
        if height > best_height:
            best_point, best_height = point, height
        offsets.append(height - float(slope @ point))
        slopes.append(np.where(fits, slope, 0.0))
        unit = max(best_height, 1.0)
        rows = np.column_stack([-np.array(slopes) / unit, np.ones(len(slopes))])
        rights = np.array(offsets) / unit
        extra = [np.append(np.ones(table.size), 0.0)]
        ends = [float(most)]
        if len(limits.room) > 1:
            extra += [
                np.append(np.where(limits.slot == one, limits.sizes, 0.0), 0.0)
                for one in range(len(limits.room))
            ]
            ends += limits.room.astype(np.float64).tolist()
        if np.isfinite(limits.budget):
            extra.append(np.append(limits.costs / limits.budget, 0.0))
            ends.append(1.0)
        found = linprog(
            np.append(np.zeros(table.size), -1.0),
            np.vstack([rows, *extra]),
            np.concatenate([rights, ends]),
            bounds=[*((0.0, float(fit)) for fit in fits), (None, None)],
            method="highs-ds",
        )
        if found.x is None:
            break
        dual = np.maximum(-found.ineqlin.marginals, 0.0)
        price = float(dual[-1]) * unit / limits.budget if np.isfinite(limits.budget) else 0.0
        bound = min(
            bound, _certified(np.array(offsets), np.array(slopes), dual[: len(slopes)], price, limits, most)
        )
        if bound <= best_height:
            break
        point = (best_point + np.clip(found.x[:-1], 0.0, 1.0)) / 2.0
        report(int(np.ceil(bound)))
    start = _certified(np.array(offsets), np.array(slopes), np.eye(len(slopes))[0], 0.0, limits, most)
    return int(np.floor(min(bound, start) * (1.0 + _SLACK))) + 1


def _cut(table: CoverTable, point: Doubles) -> tuple[float, Doubles]:
    """Return height and supergradient (n,) of the concave function at shares (n,)."""
    cover, most = table.cover, table.cover.worth.shape[1] - 1
    sums = np.zeros(len(table.owner))
    kernel.add_shares(cover, point, sums)
    cells = table.known + np.bincount(table.owner, np.minimum(sums, 1.0), len(table.known))
    whole = np.minimum(np.floor(cells), most).astype(np.int64)
    steps = np.diff(cover.worth, append=cover.worth[:, -1:])[cover.row, whole].astype(np.float64)
    height = float((cover.worth[cover.row, whole] + steps * (cells - whole)).sum())
    slope = np.empty(table.size)
    kernel.slopes(cover, sums, steps, table.workers, slope)
    return height, slope


def _certified(
    offsets: Doubles, slopes: Doubles, dual: Doubles, price: float, limits: Limits, most: int
) -> float:
    """Bound of a mixture of cuts: the largest shares times what each candidate adds beyond its price."""
    if dual.sum() <= 0.0:
        return float("inf")
    mixture = dual / dual.sum()
    gain = mixture @ slopes - price * limits.costs
    every = np.arange(len(gain))
    tops = [
        np.sort(np.maximum(gain[places], 0.0))[-room:]
        for places, room in limits.of_slots([], every, most)
        if room
    ]
    largest = np.sort(np.concatenate([np.zeros(0), *tops]))[-most:] if most else np.zeros(0)
    budget = price * limits.budget * (1.0 + 2.0 * ROUNDING) if price > 0.0 else 0.0
    return float(mixture @ offsets + largest.sum() + budget)


def branch_and_bound(
    f: SetFunction,
    limits: Limits,
    incumbent: list[int],
    most_gains: int = MOST_GAINS,
    report: Callable[[int], None] = unwatched,
) -> tuple[list[int], bool]:
    """Search for a better set until there is none or the budget of gains is spent; return the best set, and whether it
    is proven.

    Gains never grow with the set, so gains of a smaller set bound what candidates can add: a branch whose value with
    its largest gains does not exceed the best is cut. Where a table gives the overlaps of all pairs, these bound them,
    too. Report the bound so far every few hundred gains.
    """
    search = _Branches(f, limits, sorted(incumbent), most_gains, report)
    ids = np.flatnonzero(limits.open_to([]))
    search.explore([], f.value([]), ids, search.gains([], ids), most_that_fit(limits))
    return search.best, search.left >= 0


class _Branches:
    def __init__(
        self, f: SetFunction, limits: Limits, best: list[int], most_gains: int, report: Callable[[int], None]
    ) -> None:
        self._report = report
        self._f, self._limits, self.best, self._value = f, limits, best, f.value(best)
        self.left, self.bound, self._steps = most_gains, 0, 0
        self._losses = f.losses() if isinstance(f, CoverTable) and limits.count > 1 else None
        if self._losses is not None:
            self._pairs, self._alone = self._losses.sum(axis=0), self._losses.diagonal(axis1=1, axis2=2)

    def gains(self, chosen: list[int], ids: Ids) -> Ids:
        """Return gains, and count them unless they are known."""
        if self._losses is not None and len(chosen) < 2:
            alone = self._alone[:, ids].sum(axis=0)
            return np.asarray(alone - self._pairs[chosen][:, ids].sum(axis=0))
        self.left -= len(ids)
        self._steps += len(ids)
        return self._f.gains(chosen, ids)

    def _most_next_to(self, chosen: list[int], ids: Ids) -> Ids:
        """Return limits of the gains next to a set, by overlaps of pairs.

        In each group of objects, what c loses next to a and b is at least its overlap with either, and at least both
        of these less the overlap of a and b.
        """
        assert self._losses is not None
        by = self._losses[:, np.array(chosen)[:, None], ids]
        least = by.max(axis=1)
        for a, b in combinations(range(len(chosen)), 2):
            shared = self._losses[:, chosen[a], chosen[b], None]
            np.maximum(least, by[:, a] + by[:, b] - shared, out=least)
        return np.asarray((self._alone[:, ids] - least).sum(axis=0))

    def _take(self, chosen: list[int], value: int) -> None:
        if value > self._value:
            self.best, self._value = sorted(chosen), value

    def _most(self, chosen: list[int], ids: Ids, gains: Ids, room: int) -> int:
        """Return an upper bound of the gain of sets of up to `room` candidates; gains are in descending order."""
        parts = self._limits.of_slots(chosen, ids, room)
        return sum(int(gains[places][:most].sum()) for places, most in parts)

    def _most_with(self, chosen: list[int], ids: Ids, gains: Ids, room: int) -> Ids:
        """Return limits of what sets with each of some candidates add, (n,)."""
        found = gains + self._most(chosen, ids, gains, room)
        for places, most in self._limits.of_slots(chosen, ids, room):
            best = gains[places]
            found[places] -= best[most - 1] if 0 < most <= len(best) else 0
        return found

    def _after(self, chosen: list[int], ids: Ids, gains: Ids, first: int) -> Ids:
        """Return limits of what candidates from `first` on add to a set with each of the first few of them, by pairs:
        0 up to that one and in conflict with it."""
        ones = ids[first : first + _AT_ONCE]
        found = np.stack([self._most_next_to([*chosen, one], ids[first:]) for one in ones.tolist()])
        np.minimum(found, gains[first:], out=found)
        found[self._limits.conflicts[np.ix_(ones, ids[first:])] | np.tri(*found.shape, dtype=np.bool_)] = 0
        return found

    def explore(self, chosen: list[int], value: int, ids: Ids, stale: Ids, room: int) -> None:
        """Search the sets made of a set and up to `room` of some candidates, whose gains are at most `stale`."""
        order = np.lexsort((ids, -stale))
        ids, stale = ids[order], stale[order]
        if room == 1:
            for place in range(0, len(ids), _LAST):
                some = ids[place : place + _LAST][value + stale[place : place + _LAST] > self._value]
                if self.left < 0 or not len(some):
                    return
                gains = self.gains(chosen, some)
                best = int(np.argmax(gains))
                self._take([*chosen, int(some[best])], value + int(gains[best]))
            return
        # with the largest other gains, at most one of which is its own
        hopeful = value + self._most_with(chosen, ids, stale, room) > self._value
        ids, stale = ids[hopeful], stale[hopeful]
        gains = self.gains(chosen, ids)
        order = np.lexsort((ids, -gains))
        ids, gains = ids[order], gains[order]
        if len(ids):
            self._take([*chosen, int(ids[0])], value + int(gains[0]))
        for place, one in enumerate(ids.tolist()):
            reach = value + self._most(chosen, ids[place:], gains[place:], room)
            if not chosen:
                self.bound = max(reach, self._value)
            if self.left < 0 or reach <= self._value:
                return
            self._steps += 1
            if self._steps >= _STEPS or (not chosen and place == 0):
                self._steps = 0
                self._report(self.bound)
            row = place % _AT_ONCE
            if self._losses is not None:
                if row == 0:
                    after = self._after(chosen, ids, gains, place)
                    most = np.sort(after, axis=1)[:, 1 - room :].sum(axis=1)
                if value + int(gains[place] + most[row]) <= self._value:
                    continue
            larger = [*chosen, one]
            rest = place + 1 + np.flatnonzero(self._limits.open_to(larger)[ids[place + 1 :]])
            if len(rest):
                left = gains[rest] if self._losses is None else after[row, rest - (place - row)]
                self.explore(larger, value + int(gains[place]), ids[rest], left, room - 1)
