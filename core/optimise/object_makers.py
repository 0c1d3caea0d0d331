"""Make tables of what sensors cover of objects in traffic: cells, heights, and the chance that they are found."""

from __future__ import annotations

from abc import abstractmethod
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from threading import Event
from typing import NamedTuple, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import Cancelled, IsStale, never_stale
from riglens.core.kernels.objects.counts import CELLS, RAYS
from riglens.core.kernels.objects.unique_cells import CELL_M
from riglens.core.kernels.optimise import gains as kernel
from riglens.core.optimise.chances import Chances
from riglens.core.optimise.fused import FusedTable, Hits
from riglens.core.optimise.makers import GroundTableMaker, Maker, SeenTableMaker, TableMaker
from riglens.core.optimise.problem import Problem
from riglens.core.optimise.tables import UNIT, Cells, Doubles, Ids
from riglens.core.optimise.weights import Weights
from riglens.core.rig.model import Camera, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sensors.registry import kind_of
from riglens.core.targets.contribution import Contribution, TargetCaster
from riglens.core.targets.joining import heights_px
from riglens.core.targets.settings import CELLS_SCALE, HEIGHT_PX, TargetSettings
from riglens.core.targets.traffic import Traffic
from riglens.core.vehicle.solid import Solid, solid_of

C = TypeVar("C")
MOST_CELLS = 256
"""More cells of one object add less than half an integer."""
_HALF_CELLS = 1 << 20
"""Index at which `kernels.objects.unique_cells` packs cell 0."""


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


class ObjectTableMaker(ObjectMaker[Cells], TableMaker):
    """Maker of tables of numbers.

    shares: worth of an object by class and number of cells, (classes, most + 1).
    """

    def __init__(self, objects: Objects, shares: Doubles) -> None:
        ObjectMaker.__init__(self, objects)
        worth = worth_of(shares, self._cls, self._ring, objects.weights)
        TableMaker.__init__(self, self._numbers(), *worth, objects.workers)

    @abstractmethod
    def _numbers(self) -> int:
        """Return how many numbers there are."""


class HitTableMaker(ObjectTableMaker):
    """Table maker that finds the cells that LiDARs hit on objects."""

    def _numbers(self) -> int:
        self._space = CellSpace(self._traffic, self._frames)
        return self._space.size

    def _covered(self, sensor: Sensor, one: Contribution) -> Cells:
        return np.sort(self._space.numbers(one))

    def owners_of(self, numbers: Cells | Ids) -> Cells:
        """Return the objects of cells."""
        return self._space.owners_of(numbers)


class CameraTableMaker(ObjectTableMaker):
    """Table maker that finds the objects that are 25 px tall or more in a camera's picture, each worth its share."""

    def _numbers(self) -> int:
        return len(self._box)

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

    def value(self, cells: Hits) -> int:
        """Return the value of sensors with these hits."""
        return self.table(cells, []).value([])

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


def maker_of(problem: Problem, workers: int) -> Maker[Cells] | Maker[Hits] | None:
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
    objects = Objects(problem.traffic, problem.frames, problem.settings, solid, workers, problem.weights)
    if tables == "heights":
        return CameraTableMaker(objects, np.tile([0.0, 1.0], (len(CLASSES), 1)))
    if tables == "chances":
        return FusedMaker(objects, Chances.of(problem.goal.figure, problem.settings))
    return HitTableMaker(objects, hit_shares())
