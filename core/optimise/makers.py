"""Make tables of what sensors cover: voxels, and ground around the car."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from riglens.core.blind.zones import BlindEngine, BlindSettings
from riglens.core.engine.caster import Caster
from riglens.core.errors import Cancelled, IsStale, never_stale
from riglens.core.metric.entropy import EntropyField
from riglens.core.optimise.tables import UNIT, Cells, CoverTable, Doubles, Ids, Table
from riglens.core.optimise.weights import Weights
from riglens.core.rig.model import Rig, Sensor
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.columns import empty_words
from riglens.core.sensing.body_ends import barrier_of
from riglens.core.vehicle.solid import Solid

C = TypeVar("C")
USUAL_GROUND = BlindSettings()


class Maker(ABC, Generic[C]):
    """Maker of tables from what sensors cover."""

    @abstractmethod
    def cells_of(self, sensors: Sequence[Sensor], is_stale: IsStale = never_stale) -> C:
        """Return what sensors cover together; raise Cancelled as soon as `is_stale`."""

    @abstractmethod
    def joined(self, parts: Sequence[C]) -> C:
        """Return what is covered by several."""

    @abstractmethod
    def value(self, cells: C) -> int:
        """Return the value of sensors that cover this."""

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
