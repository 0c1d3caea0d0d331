"""Store what each candidate covers: gains of any set without casting again, exact in integers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import Cancelled
from riglens.core.kernels.objects.counts import CELLS
from riglens.core.kernels.objects.unique_cells import CELL_M
from riglens.core.kernels.optimise import gains as kernel
from riglens.core.review.blind import BlindEngine
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensing.body_ends import housing_radius_m
from riglens.core.targets.contribution import Contribution, TargetCaster
from riglens.core.targets.settings import CELLS_SCALE, TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.solid import Solid

Ids = NDArray[np.int64]
Cells = NDArray[np.int32]
IsStale = Callable[[], bool]
UNIT = 1 << 44
"""Integers for a value of 1: rounding stays far below the printed digits."""
_MOST_CELLS = 256
"""More cells of one object add less than half an integer."""
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
    ever less. Such a function is monotone and submodular.
    """

    def __init__(
        self,
        cells: Sequence[Cells],
        owner: Cells,
        known: Cells,
        row: NDArray[np.uint8],
        worth: Ids,
        workers: int,
    ) -> None:
        self.workers, self.known, self.owner = workers, known, owner
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

    def _worth_of(self, known: Cells) -> int:
        worth = self.cover.worth
        return int(worth[self.cover.row, np.minimum(known, worth.shape[1] - 1)].sum())

    def value(self, chosen: Sequence[int]) -> int:
        """Return the value of a set."""
        return self.state(chosen).value

    def gains(self, chosen: Sequence[int], ids: Ids) -> Ids:
        """Return what each of some candidates adds to a set, the same for any number of workers."""
        state, found = self.state(chosen), np.empty(len(ids), np.int64)
        kernel.gains(self.cover, ids, state.covered, state.known, self.workers, found)
        return found


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


def hit_worth(cls: NDArray[np.uint8]) -> Ids:
    """Return the worth (classes, most + 1) of numbers of cells: the mean over classes of 1 - exp(-cells / 5).

    Steps are rounded, not sums, so that they never rise.
    """
    objects = np.bincount(cls, minlength=len(CLASSES))
    there = max(1, int((objects > 0).sum()))
    share = 1.0 - np.exp(-np.arange(_MOST_CELLS + 1) / CELLS_SCALE)
    steps = np.diff(share)[None] / np.maximum(objects, 1)[:, None] / there * UNIT
    sums = np.cumsum(np.round(steps).astype(np.int64), axis=1)
    return np.concatenate([np.zeros((len(CLASSES), 1), np.int64), sums], axis=1)


class HitTableMaker:
    """Casts candidates one after another and makes the table of cells that they hit on objects (on target)."""

    def __init__(
        self, traffic: Traffic, frames: int, settings: TargetSettings, solid: Solid | None, workers: int = 1
    ) -> None:
        self._traffic, self._frames, self._settings, self._solid = traffic, frames, settings, solid
        self._workers, self._space = workers, CellSpace(traffic, frames)
        self._caster = TargetCaster(traffic, workers)

    def cells_of(self, sensors: Sequence[Sensor], is_stale: IsStale) -> Cells:
        """Return numbers of the cells that LiDARs hit, each once, rising; raise Cancelled as soon as `is_stale`."""
        found = [np.zeros(0, np.int32)]
        for sensor in sensors:
            barrier = None
            if self._solid is not None:
                barrier = self._solid.barrier(sensor.kind, housing_radius_m(sensor))
            settings = replace(self._settings, min_points=1)
            one = self._caster.cast(sensor, settings, barrier, (0, self._frames), is_stale)
            if one is None:
                raise Cancelled
            found.append(self._space.numbers(one))
        return np.unique(np.concatenate(found))

    def table(self, base: Cells, cells: Sequence[Cells]) -> CoverTable:
        """Return the table of candidates, without the cells that the rig's own LiDARs hit."""
        used = np.zeros(self._space.size, np.bool_)
        for one in cells:
            used[one] = True
        used[base] = False
        place = np.cumsum(used, dtype=np.int32) - 1
        owner = np.searchsorted(self._space.base, np.flatnonzero(used), side="right").astype(np.int32) - 1
        of_base = np.searchsorted(self._space.base, base, side="right") - 1
        known = np.bincount(of_base, minlength=len(self._space.box)).astype(np.int32)
        cls = self._traffic.cls[self._space.box]
        kept = [place[one[used[one]]] for one in cells]
        return CoverTable(kept, owner.astype(np.int32), known, cls, hit_worth(cls), self._workers)


class GroundTableMaker:
    """Find the ground next to the car that candidates cover: columns where any sensor sees an object of a height."""

    def __init__(self, rig: Rig, engine: BlindEngine, height_m: float, workers: int = 1) -> None:
        self._rig, self._engine, self._height_m, self._workers = rig, engine, height_m, workers
        self._blind = engine.evaluate(rig).unseen(height_m)
        self.column_m2 = engine.grid.voxel_m**2

    @property
    def blind_m2(self) -> float:
        """Area that the rig itself leaves unseen."""
        return float(self._blind.sum() * self.column_m2)

    def cells_of(self, sensors: Sequence[Sensor]) -> Cells:
        """Return the columns that the rig leaves unseen and these sensors see, by their number among those."""
        alone = self._rig.model_copy(update={"sensors": tuple(sensors)})
        seen = ~self._engine.evaluate(alone).unseen(self._height_m)
        return np.flatnonzero(seen[self._blind]).astype(np.int32)

    def table(self, cells: Sequence[Cells]) -> CoverTable:
        """Return the table of columns: one object, each column worth 1."""
        count = int(self._blind.sum())
        worth = np.arange(count + 1, dtype=np.int64)[None]
        return CoverTable(
            cells,
            np.zeros(count, np.int32),
            np.zeros(1, np.int32),
            np.zeros(1, np.uint8),
            worth,
            self._workers,
        )
