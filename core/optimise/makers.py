"""Make tables of what sensors cover: voxels, ground around the car, and objects in traffic."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from functools import cached_property
from threading import Event
from typing import Any, Generic, NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from riglens.core.blind.zones import BlindEngine, BlindSettings
from riglens.core.engine.caster import Caster
from riglens.core.errors import Cancelled, IsStale, never_stale
from riglens.core.kernels.objects.counts import CELLS, RAYS
from riglens.core.kernels.objects.unique_cells import CELL_M
from riglens.core.kernels.optimise import gains as kernel
from riglens.core.metric.entropy import EntropyField
from riglens.core.optimise.candidates import mounted
from riglens.core.optimise.chances import Chances
from riglens.core.optimise.fused import FusedTable, Hits
from riglens.core.optimise.guard import ObjectSampler
from riglens.core.optimise.placing import Candidate
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.tables import UNIT, Cells, CoverTable, Doubles, Ids, Table
from riglens.core.optimise.weights import Weights
from riglens.core.rig.model import Camera, Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.columns import empty_words
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sensors.registry import kind_of
from riglens.core.targets.contribution import Contribution, TargetCaster
from riglens.core.targets.joining import heights_px
from riglens.core.targets.settings import CELLS_SCALE, HEIGHT_PX, TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.solid import Solid, solid_of

C = TypeVar("C")
USUAL_GROUND = BlindSettings()
MOST_CELLS = 256
"""More cells of one object add less than half an integer."""
_HALF_CELLS = 1 << 20
"""Index at which `kernels.objects.unique_cells` packs cell 0."""


class Maker(ABC, Generic[C]):
    """Maker of tables from what sensors cover."""

    @abstractmethod
    def cells_of(self, sensors: Sequence[Sensor], is_stale: IsStale = never_stale) -> C:
        """Return what sensors cover together; raise Cancelled as soon as `is_stale`."""

    @abstractmethod
    def joined(self, parts: Sequence[C]) -> C:
        """Return what is covered by several."""

    @abstractmethod
    def table(self, base: C, cells: Sequence[C]) -> Table:
        """Return the table of candidates next to what sensors of the rig cover."""

    @abstractmethod
    def gains_next_to(self, table: Any, base: C) -> Ids:
        """Return what each candidate of a table without a base adds next to one."""

    def each(self, sets: Sequence[Sequence[Sensor]], is_stale: IsStale = never_stale) -> Iterator[C]:
        """Yield what each of some sets of sensors covers, in order."""
        return (self.cells_of(sensors, is_stale) for sensors in sets)

    def shown(self, value: float) -> float:
        """Return the figure, in its own unit, for a value in integers."""
        return value / UNIT

    def shown_gains(self, gains: Ids) -> Doubles:
        """Return by how much the figure is better for gains in integers, in its own unit."""
        return np.asarray(gains / UNIT)


class TableMaker(Maker[Cells]):
    """Maker of tables from numbers below `size` that sensors cover, each once, rising: row (objects,) and worth as
    there."""

    def __init__(self, size: int, row: NDArray[np.uint8], worth: Ids, workers: int) -> None:
        self.size, self._row, self._worth, self._workers = size, row, worth, workers

    def joined(self, parts: Sequence[Cells]) -> Cells:
        """Return the numbers that are covered by any."""
        return parts[0] if len(parts) == 1 else np.unique(np.concatenate([np.zeros(0, np.int32), *parts]))

    def gains_next_to(self, table: CoverTable, base: Cells) -> Ids:
        """Return what each candidate of a table adds to numbers that are covered."""
        return table.gains_in(table.given(base, self.known(base)), np.arange(table.size))

    def owners_of(self, numbers: Cells | Ids) -> Cells:
        """Return the objects of rising numbers: these themselves, where each object has one cell."""
        return np.asarray(numbers, np.int32)

    def known(self, base: Cells) -> Cells:
        """Return how many of some numbers each object has, (objects,)."""
        return np.bincount(self.owners_of(base), minlength=len(self._row)).astype(np.int32)

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


class Ground:
    """The second goal: blind ground of a rig with sets of candidates next to the rest of its sensors."""

    def __init__(self, rig: Rig, rest: Rig, height_m: float, workers: int) -> None:
        self._maker = maker = GroundTableMaker(rig, height_m, workers)
        seen, self._own = (maker.cells_of([s for s in one.sensors if s.enabled]) for one in (rig, rest))
        self._columns = dict[int, Cells]()
        self.before_m2, self._rest_m2 = maker.shown(len(seen)), maker.shown(len(self._own))

    def look(self, number: int, sensors: Sequence[Sensor]) -> None:
        """Find the columns that the sensors of a candidate see."""
        self._columns[number] = self._maker.cells_of(sensors)

    @cached_property
    def table(self) -> CoverTable:
        """The table of the candidates, once all of them have looked."""
        return self._maker.table(self._own, [self._columns[one] for one in range(len(self._columns))])

    def unseen_m2(self, chosen: Sequence[int]) -> float:
        """Return the area that a set leaves unseen."""
        seen = self.table.value(chosen) - self.table.value([])
        return self._rest_m2 - seen * self._maker.column_m2


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

    def owners_of(self, numbers: Cells | Ids) -> Cells:
        """Return the objects of cells."""
        return np.searchsorted(self.base, numbers, side="right").astype(np.int32) - 1


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


class Objects(NamedTuple):
    """Objects in the first frames of traffic, how they are counted, the car's body, and their weights."""

    traffic: Traffic
    frames: int
    settings: TargetSettings
    solid: Solid | None
    workers: int
    weights: Weights


class ObjectMaker(Maker[C]):
    """Maker that casts sensors into traffic and finds what they cover of the objects that count."""

    def __init__(self, objects: Objects) -> None:
        traffic, frames, settings, self._solid, workers, weights = objects
        self._traffic, self._frames, self._workers = traffic, frames, workers
        self._settings = replace(settings, min_points=1, calibration=None)
        self._caster = TargetCaster(traffic, workers)
        self._box = np.flatnonzero(traffic.counts[: traffic.starts[frames]])
        self._cls, self._ring = traffic.cls[self._box], weights.at(traffic.distance_m[self._box])

    @abstractmethod
    def _covered(self, sensor: Sensor, one: Contribution) -> C:
        """Return what a sensor covers by its hits."""

    def cells_of(self, sensors: Sequence[Sensor], is_stale: IsStale = never_stale) -> C:
        """Return what sensors cover."""
        return self._cast(self._caster, sensors, is_stale)

    def each(self, sets: Sequence[Sequence[Sensor]], is_stale: IsStale = never_stale) -> Iterator[C]:
        """Yield what each of some sets covers, in order.

        Each sensor is cast by one thread, several at a time: threads that share the few rays of one gain little.
        """
        is_over, waiting, caster = Event(), deque[Future[C]](), self._caster.with_workers(1)
        with ThreadPoolExecutor(self._workers) as pool:
            try:
                for sensors in sets:
                    waiting.append(pool.submit(self._cast, caster, sensors, is_over.is_set))
                    if len(waiting) > self._workers:
                        yield waiting.popleft().result()
                    if is_stale():
                        raise Cancelled
                while waiting:
                    yield waiting.popleft().result()
            finally:
                is_over.set()

    def _cast(self, caster: TargetCaster, sensors: Sequence[Sensor], is_stale: IsStale) -> C:
        found = list[C]()
        for sensor in sensors:
            barrier = None if self._solid is None else barrier_of(sensor, self._solid)
            all_rays = sensor.finest() if kind_of(sensor).hits.measure == "returns" else sensor
            one = caster.cast(all_rays, self._settings, barrier, (0, self._frames), is_stale)
            if one is None:
                raise Cancelled
            found.append(self._covered(sensor, one))
        return self.joined(found)


class HitTableMaker(ObjectMaker[Cells], TableMaker):
    """Table maker that finds the cells that LiDARs hit on objects."""

    def __init__(self, objects: Objects) -> None:
        ObjectMaker.__init__(self, objects)
        self._space = CellSpace(self._traffic, self._frames)
        worth = worth_of(hit_shares(), self._cls, self._ring, objects.weights)
        TableMaker.__init__(self, self._space.size, *worth, objects.workers)

    def _covered(self, sensor: Sensor, one: Contribution) -> Cells:
        return np.sort(self._space.numbers(one))

    def owners_of(self, numbers: Cells | Ids) -> Cells:
        """Return the objects of cells."""
        return self._space.owners_of(numbers)


class CameraTableMaker(ObjectMaker[Cells], TableMaker):
    """Table maker that finds the objects that are 25 px tall or more in a camera's picture, each worth its share."""

    def __init__(self, objects: Objects) -> None:
        ObjectMaker.__init__(self, objects)
        shares = np.tile([0.0, 1.0], (len(CLASSES), 1))
        worth = worth_of(shares, self._cls, self._ring, objects.weights)
        TableMaker.__init__(self, len(self._box), *worth, objects.workers)

    def _covered(self, sensor: Sensor, one: Contribution) -> Cells:
        return np.flatnonzero(heights_px(cast(Camera, sensor), one.found) >= HEIGHT_PX).astype(np.int32)


class FusedMaker(ObjectMaker[Hits]):
    """Table maker of the chance that objects are found: by points or cells of all LiDARs, and by each other sensor."""

    def __init__(self, objects: Objects, chances: Chances) -> None:
        super().__init__(objects)
        self._chances, self._space = chances, CellSpace(self._traffic, self._frames)
        ring = np.where(chances.counts(self._traffic, self._box), self._ring, 0.0)
        total, by_class = np.bincount(self._cls, ring, len(CLASSES)), objects.weights.by_class
        there = float(by_class[total > 0.0].sum()) or 1.0
        share = by_class / np.where(total > 0.0, total, 1.0) / there
        self._weight = UNIT * ring * (share * np.nan_to_num(chances.scale))[self._cls]
        self._empty = Hits(
            np.zeros(0, np.int32), np.zeros(len(self._box), np.int32), np.zeros(len(self._box))
        )

    def _covered(self, sensor: Sensor, one: Contribution) -> Hits:
        chances, count = self._chances, len(self._box)
        if kind_of(sensor) is not LIDAR:
            distance_m = self._traffic.distance_m[self._box]
            return replace(self._empty, chance=chances.of_others(sensor, one, distance_m))
        if chances.unit == "cells":
            return replace(self._empty, cells=np.sort(self._space.numbers(one)))
        return replace(self._empty, points=one.found[RAYS, :count].astype(np.int32))

    def joined(self, parts: Sequence[Hits]) -> Hits:
        """Return the hits of several."""
        if len(parts) == 1:
            return parts[0]
        every = [self._empty, *parts]
        return Hits(
            np.unique(np.concatenate([one.cells for one in every])),
            np.sum([one.points for one in every], axis=0, dtype=np.int32),
            np.max([one.chance for one in every], axis=0),
        )

    def table(self, base: Hits, cells: Sequence[Hits]) -> FusedTable:
        """Return the table of candidates next to the hits of the rig's sensors."""
        curve = self._chances.curve
        return FusedTable(base, cells, self._space.owners_of, curve, self._cls, self._weight, self._workers)

    def gains_next_to(self, table: FusedTable, base: Hits) -> Ids:
        """Return what each candidate of a table adds to the hits of others."""
        return table.gains_in(table.given(base), np.arange(table.size))

    def shown(self, value: float) -> float:
        """Return the figure, in its own unit, for a value in integers."""
        return self._chances.shown(value / UNIT)


class MeasuredSets:
    """An objective without tables, measured for each set anew; hits of the candidates' sensors are kept."""

    is_submodular = False

    def __init__(self, problem: Problem, listed: Sequence[Candidate], sampler: ObjectSampler) -> None:
        self._problem, self._listed, self.size, self._sampler = problem, listed, len(listed), sampler
        self._held, self._values = list[object](), dict[tuple[int, ...], int]()

    def each(self, sets: Sequence[Sequence[Sensor]], is_stale: IsStale) -> Iterator[Cells]:
        """Cast the sensors of candidates one by one; they have no cells."""
        for sensors in sets:
            alone = self._problem.rig.model_copy(update={"sensors": tuple(sensors)})
            self._held.append(self._sampler.cast(alone, self._problem.settings, self._problem.frames))
            yield np.zeros(0, np.int32)

    def shown(self, value: float) -> float:
        """Return the figure, in its own unit, for a value in integers."""
        return self._problem.goal.sign * value / UNIT

    def shown_gains(self, gains: Ids) -> Doubles:
        """Return by how much the figure is better for gains in integers, in its own unit."""
        return np.asarray(gains / UNIT)

    def value(self, chosen: Sequence[int]) -> int:
        """Return the figure of a set, negative where less is better."""
        key, problem = tuple(sorted(chosen)), self._problem
        if key not in self._values:
            rig = mounted(problem.rig, [self._listed[one] for one in key])
            measured = self._sampler(rig, problem.settings, (0, problem.frames)).value
            self._values[key] = round(problem.goal.sign * measured * UNIT)
        return self._values[key]

    def gains(self, chosen: Sequence[int], ids: Ids) -> Ids:
        """Return what each of some candidates adds to a set."""
        before = self.value(chosen)
        return np.array([self.value([*chosen, one]) - before for one in ids.tolist()], np.int64)


def maker_of(
    problem: Problem, listed: Sequence[Candidate], sampler: ObjectSampler, workers: int
) -> Maker[Cells] | Maker[Hits] | MeasuredSets:
    """Return the maker of tables for the objective of a problem, or sets of candidates that are measured."""
    tables, rig = problem.goal.tables, problem.rig
    if tables == "none":
        return MeasuredSets(problem, listed, sampler)
    if tables == "ground":
        return GroundTableMaker(rig, problem.ground_m, workers, is_objective=True)
    solid = solid_of(rig.vehicle) if rig.self_occlusion else None
    if tables in ("voxels", "entropies"):
        assert problem.voxels is not None
        return SeenTableMaker(problem.voxels, solid, workers, problem.weights, tables == "entropies")
    objects = Objects(problem.traffic, problem.frames, problem.settings, solid, workers, problem.weights)
    if tables == "heights":
        return CameraTableMaker(objects)
    if tables == "chances":
        return FusedMaker(objects, Chances.of(problem.goal.figure, problem.settings))
    return HitTableMaker(objects)
