"""Make tables of what sensors cover: cells and heights of objects, voxels, and ground around the car."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from threading import Event
from typing import cast

import numpy as np
from numpy.typing import NDArray

from riglens.core.blind.zones import BlindEngine, BlindSettings
from riglens.core.engine.caster import Caster
from riglens.core.errors import Cancelled, IsStale, never_stale
from riglens.core.kernels.objects.counts import CELLS
from riglens.core.kernels.objects.unique_cells import CELL_M
from riglens.core.kernels.optimise import gains as kernel
from riglens.core.metric.entropy import EntropyField
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.tables import UNIT, Cells, CoverTable, Doubles, Ids
from riglens.core.optimise.weights import Weights
from riglens.core.rig.model import Camera, Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.columns import empty_words
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.targets.contribution import Contribution, TargetCaster
from riglens.core.targets.joining import heights_px
from riglens.core.targets.settings import CELLS_SCALE, HEIGHT_PX, TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.solid import Solid, solid_of

MOST_CELLS = 256
"""More cells of one object add less than half an integer."""
USUAL_GROUND = BlindSettings()
_HALF_CELLS = 1 << 20
"""Index at which `kernels.objects.unique_cells` packs cell 0."""


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

    def shown(self, value: float) -> float:
        """Return the figure, in its own unit, for a value in integers."""
        return value / UNIT

    def shown_gains(self, gains: Ids) -> Doubles:
        """Return by how much the figure is better for gains in integers, in its own unit."""
        return np.asarray(gains / UNIT)

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

    shares: worth of an object by class and number of cells, (classes, most + 1).
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
    ) -> None:
        self._traffic, self._frames, self._solid = traffic, frames, solid
        self._settings = replace(settings, min_points=1)
        self._caster, self._serial = TargetCaster(traffic, workers), TargetCaster(traffic)
        box = np.flatnonzero(traffic.counts[: traffic.starts[frames]])
        ring = weights.at(traffic.distance_m[box])
        self._objects = shares, traffic.cls[box], ring
        super().__init__(self._numbers(), *worth_of(*self._objects, weights), workers)

    @abstractmethod
    def _numbers(self) -> int:
        """Return how many numbers there are."""

    @abstractmethod
    def _covered(self, sensor: Sensor, one: Contribution) -> Cells:
        """Return the numbers that a sensor covers by its hits, each once."""

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


class CameraTableMaker(ObjectTableMaker):
    """Table maker that finds the objects that are 25 px tall or more in a camera's picture, each worth its share."""

    def _numbers(self) -> int:
        return len(self._objects[1])

    def _covered(self, sensor: Sensor, one: Contribution) -> Cells:
        return np.flatnonzero(heights_px(cast(Camera, sensor), one.found) >= HEIGHT_PX).astype(np.int32)


class SeenTableMaker(TableMaker):
    """Table maker that finds the voxels that sensors cover, each worth its share of the entropy of its classes.

    Shares are averaged over classes, by their weights; for S-MS, entropies of all classes are added up.
    """

    def __init__(
        self,
        field: EntropyField,
        solid: Solid | None,
        workers: int,
        weights: Weights,
        are_added: bool = False,
    ) -> None:
        self._solid, self._caster = solid, Caster(field, workers)
        self._keep = np.flatnonzero(_bits(field.index.words))
        total = np.array(field.totals_q, np.float64)
        by_class = np.where(total > 0.0, total if are_added else weights.by_class, 0.0)
        each = by_class / np.where(total > 0.0, total, 1.0) / (by_class.sum() or 1.0)
        value = np.round(field.entropies_q[:, : len(CLASSES)] @ each * UNIT).astype(np.int64)
        super().__init__(len(self._keep), field.codes(), np.stack([0 * value, value], axis=1), workers)

    def cells_of(self, sensors: Sequence[Sensor], is_stale: IsStale = never_stale) -> Cells:
        """Return the numbers of informative voxels."""
        marks = empty_words(self._caster.field.grid)
        for sensor in sensors:
            barrier = None if self._solid is None else barrier_of(sensor, self._solid)
            if not self._caster.mark(sensor, "exact", self._caster.window(sensor), marks, is_stale, barrier):
                raise Cancelled
        return np.flatnonzero(_bits(marks)[self._keep]).astype(np.int32)


def _bits(words: NDArray[np.uint64]) -> NDArray[np.bool_]:
    return np.unpackbits(words.view(np.uint8), bitorder="little").astype(np.bool_)


class GroundTableMaker(TableMaker):
    """Table maker that finds the ground next to the car that sensors cover: columns where any sees an object of a
    height. All of it is one object, each column worth 1; as an objective, all of them together."""

    def __init__(
        self,
        rig: Rig,
        height_m: float,
        workers: int = 1,
        settings: BlindSettings = USUAL_GROUND,
        is_objective: bool = False,
    ) -> None:
        self._rig, self._height_m = rig, height_m
        self._engine = BlindEngine(rig.vehicle, settings, workers)
        self._counts = self._engine.ground.counts
        columns = int(self._counts.sum())
        self._unit = UNIT // columns if is_objective else 1
        worth = np.arange(columns + 1, dtype=np.int64)[None] * self._unit
        super().__init__(self._counts.size, np.zeros(1, np.uint8), worth, workers)
        self.column_m2 = self._engine.grid.voxel_m**2

    def shown(self, value: float) -> float:
        """Return the area that is left unseen, in m²."""
        columns = int(self._counts.sum())
        return max(0.0, float((columns - value / self._unit) * self.column_m2))

    def shown_gains(self, gains: Ids) -> Doubles:
        """Return the area that is seen in addition, in m²."""
        return np.asarray(gains / self._unit * self.column_m2)

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


def maker_of(problem: Problem, workers: int) -> TableMaker | None:
    """Return the maker of tables for the objective of a problem; None for one that has none."""
    tables, rig = problem.goal.tables, problem.rig
    if tables == "none":
        return None
    if tables == "ground":
        return GroundTableMaker(rig, problem.ground_m, workers, is_objective=True)
    solid = solid_of(rig.vehicle) if rig.self_occlusion else None
    if tables in ("voxels", "entropies"):
        assert problem.voxels is not None
        return SeenTableMaker(problem.voxels, solid, workers, problem.weights, tables == "entropies")
    of_objects = (problem.traffic, problem.frames, problem.settings, solid, workers, problem.weights)
    if tables == "heights":
        return CameraTableMaker(*of_objects, np.tile([0.0, 1.0], (len(CLASSES), 1)))
    return HitTableMaker(*of_objects, hit_shares())
