"""Distinct cells of several LiDARs on each road user, from one edit to the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels import distinct
from riglens.core.kernels.targets import CELLS
from riglens.core.targets.contribution import Contribution

Counts = NDArray[np.int64]
Lidars = tuple[Contribution, ...]


@dataclass(frozen=True)
class _Rest:
    """The cells of all LiDARs but one on the first `objects` objects."""

    lidars: Lidars
    objects: int
    lists: distinct.Lists
    marks: distinct.Marks

    def is_of(self, lidars: Lidars, objects: int) -> bool:
        return self.objects == objects and _are(self.lidars, lidars)


class JoinedCells:
    """Counts cells that LiDARs hit, each once; what does not change from one edit to the next is kept."""

    def __init__(self) -> None:
        self._rest: _Rest | None = None
        self._last: tuple[Lidars, int, Counts] | None = None

    def of(self, lidars: Lidars, objects: int) -> Counts:
        """Distinct cells of all LiDARs together on each of the first objects, (objects,)."""
        lidars = tuple({id(one): one for one in lidars}.values())  # twins share theirs
        if not lidars:
            return np.zeros(objects, np.int64)
        if len(lidars) == 1:
            return lidars[0].found[CELLS, :objects].astype(np.int64)
        last = () if self._last is None else self._last[0]
        if self._last is not None and self._last[1] == objects and _are(last, lidars):
            return self._last[2]
        moved = next((one for one in lidars if not any(one is other for other in last)), lidars[-1])
        rest = self._rest_of(tuple(one for one in lidars if one is not moved), objects)
        found, more = np.empty(objects, np.int64), _lists((moved,), objects)
        distinct.join_cells(rest.lists, rest.marks, more, _table(rest.lists, more), found)
        self._last = lidars, objects, found
        return found

    def _rest_of(self, lidars: Lidars, objects: int) -> _Rest:
        if self._rest is None or not self._rest.is_of(lidars, objects):
            lists = _lists(lidars, objects)
            self._rest = _Rest(lidars, objects, lists, _marks(lists, objects))
        return self._rest


def _are(some: Lidars, others: Lidars) -> bool:
    """Whether these are the very same contributions, in any order."""
    return sorted(map(id, some)) == sorted(map(id, others))


def _lists(lidars: Lidars, objects: int) -> distinct.Lists:
    begins = np.cumsum([0, *(one.cells.size for one in lidars)])
    return distinct.Lists(
        np.stack([one.cell_starts[:objects] + begin for one, begin in zip(lidars, begins, strict=False)]),
        np.stack([one.found[CELLS, :objects] for one in lidars]),
        np.concatenate([one.cells for one in lidars]),
    )


def _marks(lists: distinct.Lists, objects: int) -> distinct.Marks:
    blocks, words = np.empty((objects, 6), np.int32), np.zeros(objects + 1, np.int64)
    distinct.find_blocks(lists, blocks, words)
    words = np.cumsum(words)
    marks = distinct.Marks(blocks, words, np.zeros(int(words[-1]), np.int64), np.empty(objects, np.int64))
    distinct.mark_cells(lists, marks, _table(lists))
    return marks


def _table(*lists: distinct.Lists) -> Counts:
    """A hash table for the cells on any object."""
    most = sum(int(one.counts.sum(axis=0).max(initial=0)) for one in lists)
    return np.empty(distinct.table_mask(most) + 1, np.int64)
