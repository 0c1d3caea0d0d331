"""Tabulate a rig's figures for objects: one number per class and ring of distance, or per ring and sector."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS, sector_of
from riglens.core.targets.calibration import Calibration, Domain
from riglens.core.targets.quantities import (
    CLASSES_AND_ALL,
    EVERYBODY,
    FOUND,
    PREDICTED,
    Cells,
    PredictedCells,
    Quantity,
    Rose,
    Table,
)
from riglens.core.targets.scores import TargetScores, ring_edges_m, standard_error
from riglens.core.targets.traffic import Traffic

Doubles = NDArray[np.float64]
Counts = NDArray[np.int64]


def table_of(
    traffic: Traffic,
    now: TargetScores,
    before: TargetScores,
    quantity: Quantity,
    region: Domain | None = None,
) -> Table:
    """Tabulate a quantity by class and ring, with changes against a baseline in the same frames; of the objects in the
    region of a domain alone if one is given."""
    figures, cls = _Figures.of(traffic, now, before, quantity, region), traffic.cls[now.objects.box]
    edges_m = ring_edges_m(traffic.within_m)
    totals = figures.by_class(cls, np.zeros(len(cls), np.int64), 1)
    rings = figures.by_class(cls, _ring(traffic, now), len(edges_m) - 1)
    cells = _joined(np.stack, [_joined(np.concatenate, row) for row in zip(totals, rings, strict=True)])
    return Table(quantity, edges_m, _widened(cells, _errors(now, quantity)[:, None]))


def totals_of(traffic: Traffic, now: TargetScores, before: TargetScores, quantity: Quantity) -> Cells:
    """Return a quantity over all distances, in cells (len(CLASSES_AND_ALL),), with changes as in `table_of`."""
    figures, cls = _Figures.of(traffic, now, before, quantity), traffic.cls[now.objects.box]
    return _joined(np.concatenate, figures.by_class(cls, np.zeros(len(cls), np.int64), 1))


def predicted_of(traffic: Traffic, now: TargetScores, before: TargetScores) -> PredictedCells:
    """Return predicted detection over all distances of its domain, with changes as in `table_of`."""

    def of(one: Calibration, quantity: Quantity, outside: str) -> PredictedCells:
        region = one.domain.region
        about = f"{one.predicts} of this detector: {one.detector}. Objects {region}; LiDARs alone."
        return PredictedCells(totals_of(traffic, now, before, quantity), one.errors, region, about, outside)

    recall = now.settings.recall
    found = None if recall is None else of(recall, FOUND, now.found_outside)
    return replace(of(now.calibration, PREDICTED, now.predicted_outside), found=found)


def rose_of(
    traffic: Traffic,
    now: TargetScores,
    before: TargetScores,
    quantity: Quantity,
    who: str,
    region: Domain | None = None,
) -> Rose:
    """Tabulate a quantity of one of `CLASSES_AND_ALL` by ring and sector, in a region as `table_of` does."""
    edges_m, box = ring_edges_m(traffic.within_m), now.objects.box
    chosen = np.ones(len(box), np.bool_) if who == EVERYBODY else traffic.cls[box] == CLASSES.index(who)
    rings, sectors = len(edges_m) - 1, len(SECTORS)
    group = _ring(traffic, now) * sectors + sector_of(*traffic.centre_m[box, :2].T)
    flat = _Figures.of(traffic, now, before, quantity, region).cells(chosen, group, rings * sectors)
    cells = Cells(*(part.reshape(rings, sectors) for part in _parts(flat)))
    return Rose(quantity, who, edges_m, _widened(cells, _errors(now, quantity)[CLASSES_AND_ALL.index(who)]))


def _errors(now: TargetScores, quantity: Quantity) -> Doubles:
    """Return the errors of the calibration of a quantity, (len(CLASSES_AND_ALL),): 0 where it has none."""
    calibration = {PREDICTED.key: now.calibration, FOUND.key: now.settings.recall}.get(quantity.key)
    return np.zeros(len(CLASSES_AND_ALL)) if calibration is None else calibration.errors


def _widened(cells: Cells, error: ArrayLike) -> Cells:
    """Return cells whose standard errors hold that of a calibration too."""
    return (
        replace(cells, se=np.where(cells.objects > 0, np.hypot(cells.se, error), 0.0))
        if np.any(error)
        else cells
    )


def _ring(traffic: Traffic, scores: TargetScores) -> Counts:
    edges_m = ring_edges_m(traffic.within_m)
    inner = np.searchsorted(edges_m, traffic.distance_m[scores.objects.box], side="right") - 1
    return np.minimum(inner, len(edges_m) - 2)  # the end of the last ring belongs to it


@dataclass(frozen=True)
class _Figures:
    """One number per object (k,), of the rig and of the baseline, each computed once for all cells of a table."""

    quantity: Quantity
    mine: Doubles
    theirs: Doubles
    frame: Counts
    used: int
    frames: int

    @classmethod
    def of(
        cls,
        traffic: Traffic,
        now: TargetScores,
        before: TargetScores,
        quantity: Quantity,
        region: Domain | None = None,
    ) -> _Figures:
        mine = quantity.of(now.objects, now.settings)
        if region is not None:
            mine = np.where(region.holds(traffic.centre_m[now.objects.box]), mine, math.nan)
        return cls(
            quantity,
            mine,
            quantity.of(before.objects, before.settings),
            traffic.frame_of_box[now.objects.box],
            now.frames_used,
            now.frames,
        )

    @cached_property
    def _known(self) -> NDArray[np.bool_]:
        """Return which objects have the quantity and lie in the region, (k,)."""
        return ~(np.isnan(self.mine) | np.isnan(self.theirs))

    def by_class(self, cls: NDArray[np.uint8], group: Counts, groups: int) -> list[Cells]:
        """Return the numbers by group (k,) for each of CLASSES_AND_ALL."""
        every = (np.ones(len(cls), np.bool_), *(cls == number for number in range(len(CLASSES))))
        return [self.cells(chosen, group, groups) for chosen in every]

    def cells(self, chosen: NDArray[np.bool_], group: Counts, groups: int) -> Cells:
        """Return the numbers of the chosen objects by group (k,), (groups,); without those that lack it."""
        chosen = chosen & self._known
        group, mine, theirs = group[chosen], self.mine[chosen], self.theirs[chosen]
        objects = np.bincount(group, minlength=groups)
        if self.quantity.is_median:
            value, none = _medians(mine, group, groups), np.zeros(groups)
            return Cells(objects, value, none, value - _medians(theirs, group, groups), none)
        sampled = _Sample(group, groups, self.frame[chosen], self.used, self.frames)
        return Cells(objects, *sampled.means(mine), *sampled.means(mine - theirs))


@dataclass(frozen=True)
class _Sample:
    """Objects by group (k,) and sampled frame (k,): `used` of all `frames`."""

    group: Counts
    groups: int
    frame: Counts
    used: int
    frames: int

    def means(self, values: Doubles) -> tuple[Doubles, Doubles]:
        """Return means of values (k,) by group, and their standard errors."""
        count = np.bincount(self.group, minlength=self.groups).astype(np.float64)
        count[count == 0.0] = math.nan
        mean = np.bincount(self.group, values, self.groups) / count
        if self.used == self.frames:
            return mean, np.zeros(self.groups)
        place = self.frame * self.groups + self.group
        misses = np.bincount(place, values - mean[self.group], self.used * self.groups)
        se = standard_error(misses.reshape(self.used, self.groups), count, self.frames)
        return mean, np.nan_to_num(se, nan=0.0)


def _medians(values: Doubles, group: Counts, groups: int) -> Doubles:
    """Return the medians of values (k,) by group, NaN where there are none."""
    ordered = values[np.lexsort((values, group))]
    ends = np.cumsum(np.bincount(group, minlength=groups))
    starts = ends - np.bincount(group, minlength=groups)
    found = np.full(groups, math.nan)
    some = ends > starts
    low, high = (starts + ends - 1)[some] // 2, (starts + ends)[some] // 2
    found[some] = (ordered[low] + ordered[high]) / 2.0
    return found


def _parts(cells: Cells) -> tuple[NDArray[Any], ...]:
    return cells.objects, cells.value, cells.se, cells.change, cells.change_se


def _joined(join: Callable[..., NDArray[Any]], cells: Sequence[Cells]) -> Cells:
    return Cells(*(join(parts) for parts in zip(*map(_parts, cells), strict=True)))
