"""Store what each candidate covers: gains of any set without casting again, exact in integers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass, replace
from itertools import pairwise, takewhile
from threading import Event
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from riglens.core.blind.zones import BlindEngine
from riglens.core.errors import Cancelled, IsStale, never_stale
from riglens.core.kernels.objects.counts import CELLS
from riglens.core.kernels.objects.unique_cells import CELL_M
from riglens.core.kernels.optimise import gains as kernel
from riglens.core.optimise.weights import Weights
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.targets.contribution import Contribution, TargetCaster
from riglens.core.targets.settings import CELLS_SCALE, TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.solid import Solid

Ids = NDArray[np.int64]
Cells = NDArray[np.int32]
Doubles = NDArray[np.float64]
UNIT = 1 << 44
"""Integers for a value of 1: rounding stays far below the printed digits."""
MOST_CELLS = 256
"""More cells of one object add less than half an integer."""
_FEW = 32
"""Gains that one thread finds sooner than several."""
_MOST_PAIR_WORDS = 1e10
"""Words of cells compared for all pairs of candidates, at most: some seconds."""
_HALF_CELLS = 1 << 20
"""Index at which `kernels.objects.unique_cells` packs cell 0."""


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

    def gains(self, chosen: Sequence[int], ids: Ids) -> Ids:
        """Return what each of some candidates adds to a set."""

    def value(self, chosen: Sequence[int]) -> int:
        """Return the value of a set."""


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
        row: NDArray[np.uint8],
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

    def concave(self) -> CoverTable:
        """Return the least function above this one whose worth rises by ever less; itself where that is so."""
        worth = self.cover.worth
        if not (np.diff(worth, n=2, axis=1) > 0).any():
            return self
        return self.valued(np.array([_hull(row) for row in worth]))

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
        gains = kernel.gains_serial if len(ids) <= _FEW else kernel.gains  # to wake others takes longer
        gains(self.cover, ids, state.covered, state.known, self.workers, found)
        return found

    def losses(self) -> Ids | None:
        """Return the overlap of each pair, (n, n): both gains added minus their joint gain; None if all pairs would
        take longer than the few that a search needs."""
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
        found = np.zeros((self.size, self.size), np.int64)
        kernel.losses(cover, self.known, by_object, begins, owner, starts, bits, self.workers, found)
        return np.asarray(found + found.T)

    def given(self, cells: Cells, known: Cells) -> State:
        """Return the state where sensors cover cells, by their maker's numbers (rising), and `known` of each object."""
        assert self._numbers is not None
        covered = np.isin(self._numbers, cells, assume_unique=True).astype(np.uint8)
        return State(covered, known, self._worth_of(known))


def _hull(worth: Ids) -> Ids:
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


class TableMaker(ABC):
    """Maker of tables from what sensors cover, numbered below `size`: row (objects,) and worth as there."""

    def __init__(self, size: int, row: NDArray[np.uint8], worth: Ids, workers: int) -> None:
        self.size, self._row, self._worth, self._workers = size, row, worth, workers

    @abstractmethod
    def cells_of(self, sensors: Sequence[Sensor], is_stale: IsStale = never_stale) -> Cells:
        """Return the numbers that sensors cover, each once, rising; raise Cancelled as soon as `is_stale`."""

    def each(self, sets: Sequence[Sequence[Sensor]], is_stale: IsStale = never_stale) -> Iterator[Cells]:
        """Yield the numbers that each of some sets of sensors covers, in order."""
        return (self.cells_of(sensors, is_stale) for sensors in sets)

    def owners_of(self, numbers: Cells | Ids) -> Cells:
        """Return the objects of rising numbers: these themselves, where each object has one cell."""
        return np.asarray(numbers, np.int32)

    def known(self, base: Cells) -> Cells:
        """Return how many of some numbers each object has, (objects,)."""
        return np.bincount(self.owners_of(base), minlength=len(self._row)).astype(np.int32)

    def value(self, cells: Cells) -> int:
        """Return the value of sensors that cover these numbers."""
        most = self._worth.shape[1] - 1
        return int(self._worth[self._row, np.minimum(self.known(cells), most)].sum())

    def table(self, base: Cells, cells: Sequence[Cells]) -> CoverTable:
        """Return the table of candidates, without what sensors of the rig cover."""
        used = np.zeros(self.size, np.bool_)
        for one in cells:
            used[one] = True
        used[base] = False
        place = np.cumsum(used, dtype=np.int32) - 1
        numbers = np.flatnonzero(used).astype(np.int32)
        kept = [place[one[used[one]]] for one in cells]
        owner = self.owners_of(numbers)
        return CoverTable(kept, owner, self.known(base), self._row, self._worth, self._workers, numbers)


class CellSpace:
    """Numbers for the cells of the objects that count in the first `frames` frames: a block of cells around each."""

    def __init__(self, traffic: Traffic, frames: int) -> None:
        self.box = np.flatnonzero(traffic.counts[: traffic.starts[frames]])
        reach = np.floor(traffic.size_m[self.box] / 2.0 / CELL_M).astype(np.int64) + 2
        self._low, self._span = _HALF_CELLS - reach, 2 * reach
        self.base = np.concatenate([[0], np.cumsum(self._span.prod(axis=1))])

    @property
    def size(self) -> int:
        """Numbers in all."""
        return int(self.base[-1])

    def numbers(self, one: Contribution) -> Cells:
        """Return the numbers of the cells that a sensor hits, each once."""
        count = len(self.box)
        found = np.empty(int(one.found[CELLS].sum()), np.int32)
        inside = kernel.number_cells(
            one.cell_starts[:count], one.found[CELLS], one.cells, self.base, self._low, self._span, found
        )
        if not inside:
            raise ValueError("a cell lies outside of its object's block")
        return found


Worth = tuple[NDArray[np.uint8], Ids]
"""Rows of objects (k,), and the worth by number of cells, (rows, most + 1)."""


def worth_of(shares: Doubles, cls: NDArray[np.uint8], ring: Doubles, weights: Weights) -> Worth:
    """Return the worth of objects of classes (k,), weighed by distance (k,), by their shares (classes, most + 1) of a
    number of cells: the mean over the classes that occur of the weighed mean of their objects.

    Steps are rounded, not sums, so that they never rise where those of the shares do not.
    """
    total = np.bincount(cls, ring, len(CLASSES))
    by_class = weights.by_class
    there = float(by_class[total > 0.0].sum()) or 1.0
    levels, level = np.unique(ring, return_inverse=True)
    steps = np.diff(shares, axis=1) / np.where(total > 0.0, total, 1.0)[:, None] / there * UNIT
    steps = np.concatenate([steps * by_class[:, None] * one for one in levels] or [steps[:0]])
    sums = np.cumsum(np.round(steps).astype(np.int64), axis=1)
    row = (level * len(CLASSES) + cls).astype(np.uint8)
    return row, np.concatenate([np.zeros((len(steps), 1), np.int64), sums], axis=1)


def hit_shares() -> Doubles:
    """Return 1 - exp(-cells / 5) of numbers of cells, the same for all classes, (classes, most + 1)."""
    return np.tile(1.0 - np.exp(-np.arange(MOST_CELLS + 1) / CELLS_SCALE), (len(CLASSES), 1))


class ObjectTableMaker(TableMaker):
    """Table maker that casts LiDARs or cameras into traffic and finds what they cover of the objects in its first
    frames that count.

    shares: worth of an object by class and number of cells, (classes, most + 1); which: the objects that count here, of
    those that count in the traffic.
    """

    def __init__(
        self,
        traffic: Traffic,
        frames: int,
        settings: TargetSettings,
        solid: Solid | None,
        workers: int,
        weights: Weights,
        shares: Doubles,
        which: NDArray[np.bool_] | None = None,
    ) -> None:
        self._traffic, self._frames, self._solid = traffic, frames, solid
        self._settings = replace(settings, min_points=1)
        self._caster, self._serial = TargetCaster(traffic, workers), TargetCaster(traffic)
        box = np.flatnonzero(traffic.counts[: traffic.starts[frames]])
        ring = weights.at(traffic.distance_m[box])
        if which is not None:
            ring = np.where(which, ring, 0.0)
        self._objects = shares, traffic.cls[box], ring
        super().__init__(self._numbers(), *worth_of(*self._objects, weights), workers)

    @abstractmethod
    def _numbers(self) -> int:
        """Return how many numbers there are."""

    @abstractmethod
    def _covered(self, sensor: Sensor, one: Contribution) -> Cells:
        """Return the numbers that a sensor covers by its hits, each once."""

    def worth_of_class(self, name: str) -> Ids:
        """Return the worth where only objects of one class count."""
        return worth_of(*self._objects, Weights({other: float(other == name) for other in CLASSES}))[1]

    def cells_of(self, sensors: Sequence[Sensor], is_stale: IsStale = never_stale) -> Cells:
        """Return the numbers that sensors cover."""
        return self._cast(self._caster, sensors, is_stale)

    def each(self, sets: Sequence[Sequence[Sensor]], is_stale: IsStale = never_stale) -> Iterator[Cells]:
        """Yield the numbers that each of some sets covers, in order.

        Each sensor is cast by one thread, several at a time: threads that share the few rays of one gain little.
        """
        is_over, waiting = Event(), deque[Future[Cells]]()
        with ThreadPoolExecutor(self._workers) as pool:
            try:
                for sensors in sets:
                    waiting.append(pool.submit(self._cast, self._serial, sensors, is_over.is_set))
                    if len(waiting) > self._workers:
                        yield waiting.popleft().result()
                    if is_stale():
                        raise Cancelled
                while waiting:
                    yield waiting.popleft().result()
            finally:
                is_over.set()

    def _cast(self, caster: TargetCaster, sensors: Sequence[Sensor], is_stale: IsStale) -> Cells:
        found = [np.zeros(0, np.int32)]
        for sensor in sensors:
            barrier = None if self._solid is None else barrier_of(sensor, self._solid)
            one = caster.cast(sensor, self._settings, barrier, (0, self._frames), is_stale)
            if one is None:
                raise Cancelled
            found.append(np.sort(self._covered(sensor, one)))
        return found[1] if len(found) == 2 else np.unique(np.concatenate(found))


class HitTableMaker(ObjectTableMaker):
    """Table maker that finds the cells that LiDARs hit on objects."""

    def _numbers(self) -> int:
        self._space = CellSpace(self._traffic, self._frames)
        return self._space.size

    def _covered(self, sensor: Sensor, one: Contribution) -> Cells:
        return self._space.numbers(one)

    def owners_of(self, numbers: Cells | Ids) -> Cells:
        """Return the objects of cells."""
        return np.searchsorted(self._space.base, numbers, side="right").astype(np.int32) - 1


class GroundTableMaker(TableMaker):
    """Table maker that finds the ground next to the car that sensors cover: columns where any sees an object of a
    height. All of it is one object, each column worth 1; as a share, all of them together."""

    def __init__(
        self, rig: Rig, engine: BlindEngine, height_m: float, workers: int = 1, is_share: bool = False
    ) -> None:
        self._rig, self._engine, self._height_m = rig, engine, height_m
        self._counts = engine.ground.counts
        columns = int(self._counts.sum())
        worth = np.arange(columns + 1, dtype=np.int64)[None] * (UNIT // columns if is_share else 1)
        super().__init__(self._counts.size, np.zeros(1, np.uint8), worth, workers)
        self.column_m2 = engine.grid.voxel_m**2

    def blind_m2(self, base: Cells) -> float:
        """Return the area that columns leave unseen."""
        return float((int(self._counts.sum()) - len(base)) * self.column_m2)

    def cells_of(self, sensors: Sequence[Sensor], is_stale: IsStale = never_stale) -> Cells:
        """Return the numbers of the columns that sensors see."""
        if is_stale():
            raise Cancelled
        alone = self._rig.model_copy(update={"sensors": tuple(sensors)})
        seen = self._counts & ~self._engine.evaluate(alone).unseen(self._height_m)
        return np.flatnonzero(seen).astype(np.int32)

    def owners_of(self, numbers: Cells | Ids) -> Cells:
        """Return the one object."""
        return np.zeros(len(numbers), np.int32)
