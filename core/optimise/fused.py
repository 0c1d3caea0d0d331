"""Store what each candidate hits, for figures that points or cells of all LiDARs and other sensors make together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from riglens.core.in_threads import in_threads
from riglens.core.kernels.optimise import gains as kernel
from riglens.core.optimise.tables import FEW, Cells, CoverTable, Doubles, Ids, hull

_MOST_CELLS = 20_000_000
"""Cells, and numbers of a worth, of a function above, at most: some hundred MB."""
_FLAT = 1e-4
"""Share of a curve that is counted to its last step in a function above."""
_SCALE = 1 << 40


@dataclass(frozen=True, eq=False)
class Hits:
    """Hits of sensors: the numbers of the cells of all objects, rising, and of each object (k,) the points and the
    chance that the best of the sensors other than LiDARs finds it."""

    cells: Cells
    points: Cells
    chance: Doubles


@dataclass
class _State:
    """A set of candidates: cells that are covered, and of each object the number that is known, the chance and the
    worth."""

    covered: NDArray[np.uint8]
    known: Cells
    chance: Doubles
    worth: Ids


class FusedTable:
    """Value of chances, in integers: of each object its weight times 1 - (1 - L)(1 - C), rounded, summed over objects.

    owners_of: returns the objects of cells; curve (rows, most + 1): L by number, row (objects,); weight (objects,).
    Where the curves rise by ever less the function is submodular: what a LiDAR adds to L shrinks as others join, and
    so does 1 - C, which it is multiplied by, and the other way round. Rounding moves each object by half an integer.
    """

    def __init__(
        self,
        base: Hits,
        candidates: Sequence[Hits],
        owners_of: Callable[[Cells], Cells],
        curve: Doubles,
        row: NDArray[np.uint8],
        weight: Doubles,
        workers: int,
    ) -> None:
        self._base, self._owners_of, self._workers = base, owners_of, workers
        self._numbers = np.unique(np.concatenate([np.zeros(0, np.int32), *(one.cells for one in candidates)]))
        self._owner = owners_of(self._numbers)
        mine = [np.searchsorted(self._numbers, one.cells) for one in candidates]
        each = [np.bincount(self._owner[cells], minlength=len(row)) for cells in mine]
        met = [
            np.flatnonzero((one.points > 0) | (one.chance > 0.0) | (cells > 0))
            for one, cells in zip(candidates, each, strict=True)
        ]
        nothing = np.zeros(0, np.int32)
        counts = [cells[some] for cells, some in zip(each, met, strict=True)]
        self.fused = kernel.Fused(
            np.cumsum([0, *(len(some) for some in met)]),
            np.concatenate([nothing, *met]).astype(np.int32),
            np.concatenate([[0], np.cumsum(np.concatenate([nothing, *counts]))]).astype(np.int64),
            np.concatenate([nothing, *mine]).astype(np.int32),
            np.concatenate([nothing, *(one.points[some] for one, some in zip(candidates, met, strict=True))]),
            np.concatenate(
                [[0.0][:0], *(one.chance[some] for one, some in zip(candidates, met, strict=True))]
            ),
            curve,
            row,
            weight,
        )
        self._kept = tuple[int, ...](), self.given(base)

    @property
    def size(self) -> int:
        """Number of candidates."""
        return len(self.fused.starts) - 1

    @property
    def is_submodular(self) -> bool:
        """Return whether the curves of LiDARs rise by ever less."""
        return not (np.diff(self.fused.curve, n=2, axis=1) > 1e-12).any()

    def given(self, base: Hits) -> _State:
        """Return the state where sensors of the rig have these hits."""
        covered = np.isin(self._numbers, base.cells, assume_unique=True).astype(np.uint8)
        known = base.points + np.bincount(self._owners_of(base.cells), minlength=len(base.points))
        return self._worked_out(covered, known.astype(np.int32), base.chance.copy())

    def _worked_out(self, covered: NDArray[np.uint8], known: Cells, chance: Doubles) -> _State:
        return _State(covered, known, chance, self._worth(known, chance))

    def _worth(self, known: Cells, chance: Doubles) -> Ids:
        fused = self.fused
        by_lidars = fused.curve[fused.row, np.minimum(known, fused.curve.shape[1] - 1)]
        found: Ids = np.rint(fused.weight * (1.0 - (1.0 - by_lidars) * (1.0 - chance))).astype(np.int64)
        return found

    def _with(self, state: _State, one: int) -> _State:
        """Return the state with one more candidate."""
        fused, runs = self.fused, slice(*self.fused.starts[one : one + 2])
        of, cells = fused.of[runs], fused.cells[fused.ends[runs.start] : fused.ends[runs.stop]]
        covered, known, chance = state.covered.copy(), state.known.copy(), state.chance.copy()
        new = cells[covered[cells] == 0]
        known += np.bincount(self._owner[new], minlength=len(known)).astype(np.int32)
        covered[new] = 1
        known[of] += fused.points[runs]
        chance[of] = np.maximum(chance[of], fused.chance[runs])
        return self._worked_out(covered, known, chance)

    def _state(self, chosen: Sequence[int]) -> _State:
        wanted = tuple(chosen)
        if self._kept[0] != wanted:
            same = self._kept[0] == wanted[: len(self._kept[0])]
            before, state = self._kept if same else ((), self.given(self._base))
            for one in wanted[len(before) :]:
                state = self._with(state, one)
            self._kept = wanted, state
        return self._kept[1]

    def value(self, chosen: Sequence[int]) -> int:
        """Return the value of a set."""
        return int(self._state(chosen).worth.sum())

    def gains(self, chosen: Sequence[int], ids: Ids) -> Ids:
        """Return what each of some candidates adds to a set, the same for any number of workers."""
        return self.gains_in(self._state(chosen), ids)

    def gains_in(self, state: _State, ids: Ids) -> Ids:
        """Return what each of some candidates adds in a state."""
        found = np.empty(len(ids), np.int64)
        how = self.fused, ids, state.covered, state.known, state.chance, state.worth
        shares = 1 if len(ids) <= FEW else self._workers
        in_threads(shares, lambda share: kernel.fused_gains(*how, share, shares, found))
        return found

    def above(self) -> CoverTable | None:
        """Return a function above this one, which adds up what LiDARs and what others add to the rig's own sensors.

        With misses a and b of the two in the rig, less by x and y: ab - (a - x)(b - y) <= bx + ay. The part of LiDARs
        is the least curve above theirs, from what is known on, that rises by ever less; that of others has a cell for
        each chance of an object, worth what it is more than the one below.
        """
        state, fused, objects = self.given(self._base), self.fused, len(self.fused.row)
        lidars, owner = self._cells_of_lidars(state)
        by_lidars = fused.curve[fused.row, np.minimum(state.known, fused.curve.shape[1] - 1)]
        steps = self._steps(state.known) if len(owner) else np.zeros((objects, 1))
        above = state.chance[fused.of] < fused.chance
        pairs = np.stack([fused.of, np.where(above, fused.chance, 0.0)])
        (of, level), place = np.unique(pairs[:, above], axis=1, return_inverse=True)
        of = of.astype(np.int64)
        first = np.searchsorted(of, np.arange(objects))
        is_first = np.diff(of, prepend=-1) > 0
        more = level - np.where(is_first, state.chance[of], np.roll(level, 1))
        counts = np.zeros(len(fused.of), np.int64)
        counts[above] = place.reshape(-1) - first[fused.of[above]] + 1
        if counts.sum() > _MOST_CELLS or (objects + len(of)) * steps.shape[1] > _MOST_CELLS:
            return None
        others = np.repeat(first[fused.of], counts) + _places(counts)
        ends = np.concatenate([[0], np.cumsum(counts)])[fused.starts]
        worth = np.zeros((objects + len(of), 1 + steps.shape[1]), np.int64)
        worth[:objects, 0] = state.worth + np.ceil(1.0 + fused.weight / _SCALE)  # rounding
        worth[:objects, 1:] = np.ceil(steps * (fused.weight * (1.0 - state.chance))[:, None])
        worth[objects:, 1] = np.ceil(more * (fused.weight * (1.0 - by_lidars))[of])
        cells = [
            np.concatenate([mine, len(owner) + others[low:high]]).astype(np.int32)
            for mine, (low, high) in zip(lidars, pairwise(ends.tolist()), strict=True)
        ]
        owners = np.concatenate([owner, objects + np.arange(len(of))]).astype(np.int32)
        known, rows = np.zeros(len(worth), np.int32), np.arange(len(worth), dtype=np.int32)
        return CoverTable(cells, owners, known, rows, np.cumsum(worth, axis=1), self._workers)

    def _cells_of_lidars(self, state: _State) -> tuple[list[Ids], Ids]:
        """Return the cells that candidates hit beyond those of the rig, and their objects, rising; points are cells
        that no other candidate hits."""
        fused = self.fused
        if len(fused.cells):
            is_new = state.covered == 0
            number = np.cumsum(is_new) - 1
            ends = fused.ends[fused.starts].tolist()
            hit = (fused.cells[low:high] for low, high in pairwise(ends))
            return [number[one[is_new[one]]] for one in hit], self._owner[is_new].astype(np.int64)
        counts = np.minimum(fused.points, self._reach).astype(np.int64)
        order = np.argsort(fused.of, kind="stable")
        begins = np.empty(len(counts), np.int64)
        begins[order] = np.cumsum(counts[order]) - counts[order]
        cells = np.repeat(begins, counts) + _places(counts)
        ends = np.concatenate([[0], np.cumsum(counts)])[fused.starts]
        parts = [cells[low:high] for low, high in pairwise(ends.tolist())]
        return parts, np.repeat(fused.of[order], counts[order]).astype(np.int64)

    @property
    def _reach(self) -> int:
        """Number of points or cells from which on the curves are all but flat."""
        curve = self.fused.curve
        return int((curve < (1.0 - _FLAT) * curve[:, -1:]).sum(axis=1).max()) + 1

    def _steps(self, known: Cells) -> Doubles:
        """Return by how much the least curves above those of objects rise, by the number beyond what is known,
        (objects, reach)."""
        curve, reach = self.fused.curve, self._reach
        pairs = np.stack([self.fused.row, np.minimum(known, reach)])
        (row, start), place = np.unique(pairs, axis=1, return_inverse=True)
        numbers = np.minimum(start[:, None] + np.arange(reach + 1), curve.shape[1] - 1)
        rises = curve[row[:, None], numbers]
        rises[:, -1] = curve[row, -1]
        hulls = np.array([hull(np.ceil(one * _SCALE).astype(np.int64)) for one in rises]) / _SCALE
        return np.diff(hulls, axis=1)[place.reshape(-1)]


def _places(counts: Ids) -> Ids:
    """Return 0 to count - 1 for each of some counts, one after the other."""
    return np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
