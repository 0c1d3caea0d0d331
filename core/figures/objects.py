"""Define figures of objects: one number per object, averaged by class, ring of distance and sector."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.figures.figure import ALL, CLASSES_AND_ALL, Estimate, Figure, absence, error_of_runs
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS
from riglens.core.sensors.registry import kind_named

if TYPE_CHECKING:  # loads the compiler, which a window that opens does not need
    from riglens.core.figures.evaluated import Evaluated, Need
    from riglens.core.targets.calibration import Calibration
    from riglens.core.targets.counts import Counted
    from riglens.core.targets.groups import By, Groups, Parts

Doubles = NDArray[np.float64]
Counts = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class ObjectFigure(Figure):
    """A figure of objects that hits of sensors make.

    values: one number per object (k,), NaN for objects that do not count; their mean is the figure, or their median
    where `is_median`. kinds: without an enabled sensor of one of these there is no figure, although a rig that loses
    the last of them loses all of it; least_kinds: number of kinds of enabled sensors that it takes. calibration: that
    the figure rests on, whose kinds are then those of the figure; in_domain: whether the objects in its region count
    alone. of_classes: whether the figure of `ALL` is the mean of those of the classes that are there, not of all
    objects. least: no mean is below. parts: the figure with one kind of sensor alone, by kind.
    """

    values: Callable[[Counted], Doubles]
    is_median: bool = False
    kinds: tuple[str, ...] = ()
    least_kinds: int = 1
    calibration: Callable[[Counted], Calibration | None] | None = None
    in_domain: bool = False
    of_classes: bool = False
    least: float = -math.inf
    parts: Mapping[str, ObjectFigure] = field(default_factory=dict, hash=False)

    @property
    def needs(self) -> Need:
        return "objects"

    def column(self, who: str) -> str:
        return f"{super().column(who)}.value" if self.calibration is not None else super().column(who)

    def of(self, rig: Evaluated, who: str) -> Estimate:
        if rig.objects is None:
            return Estimate.none("no objects were counted")
        return self.estimates(rig.objects, "all", (who,))[who][0]

    def change(self, now: Evaluated, before: Evaluated, who: str) -> Estimate:
        if now.objects is None or before.objects is None:
            return super().change(now, before, who)
        mine, cells = self.of(now, who), self.cells(now.objects, before.objects)
        row = CLASSES_AND_ALL.index(who)
        if not mine.exists or not cells.objects[row, 0]:
            return mine
        change, se, sample_se = (
            float(one[row, 0]) for one in (cells.change, cells.traffic_se, cells.change_se)
        )
        return replace(mine, value=change, se=se, sample_se=sample_se, runs=())

    def calibrated(self, counted: Counted) -> Calibration | None:
        """Return the calibration that the figure rests on, None without any."""
        return None if self.calibration is None else self.calibration(counted)

    def region(self, rig: Evaluated) -> str:
        calibration = None if rig.objects is None else self.calibrated(rig.objects)
        if calibration is None or not self.in_domain:
            return super().region(rig)
        return f"objects {calibration.domain.region}"

    def lacks(self, counted: Counted) -> str:
        """Return why a rig has no such figure; "" where it has one."""
        enabled = {sensor.kind for sensor in counted.rig.sensors if sensor.enabled}
        if len(enabled) < self.least_kinds:
            return (
                "all enabled sensors of the rig are of one kind"
                if enabled
                else "the rig has no enabled sensor"
            )
        calibration = self.calibrated(counted)
        kinds = self.kinds if calibration is None else calibration.kinds
        if not kinds or enabled & set(kinds):
            return ""
        titles = [kind.title for name in kinds if (kind := kind_named(name)) is not None]
        return f"the rig has no enabled {' or '.join(titles)}"

    def estimates(
        self, counted: Counted, by: By, rows: Sequence[str] = CLASSES_AND_ALL, in_detail: bool = True
    ) -> dict[str, list[Estimate]]:
        """Return the figure in each part of some classes, or of `ALL` together; `in_detail`: with its parts by kind
        and with how far runs of frames move it."""
        lack, calibration = self.lacks(counted), self.calibrated(counted)
        outside = "" if calibration is None else counted.outside(calibration)
        errors = np.zeros(len(CLASSES_AND_ALL)) if calibration is None else calibration.errors
        is_whole = counted.frames_used == counted.frames
        values = self.values(counted)
        names = CLASSES_AND_ALL if ALL in rows else CLASSES
        table = [one.tolist() for one in self._means(counted.groups, by, values, ALL in rows)]
        alone = {kind: one.estimates(counted, by, rows) for kind, one in self.parts.items() if in_detail}
        has_runs = in_detail and by == "all" and not self.is_median
        runs = self._runs(counted.groups, values) if has_runs else None
        found = {}
        for who in rows:
            row = CLASSES_AND_ALL.index(who)
            own, cells = float(errors[row]), []
            columns = (one[names.index(who)] for one in table)
            for place, (number, value, se) in enumerate(zip(*columns, strict=True)):
                whole = math.hypot(se, own) if calibration is not None else se
                state: Any = "outside" if outside else "exact" if is_whole and not whole else "sampled"
                parts = {kind: one[who][place].value for kind, one in alone.items()}
                moved = () if runs is None else tuple(runs[:, row].tolist())
                estimate = Estimate(value, whole, state, outside, se, number, parts, moved)
                if not number or lack:
                    reason = lack or absence(who)
                    estimate = replace(estimate, state="none", reason=reason, se=0.0, parts={})
                cells.append(estimate)
            found[who] = cells
        return found

    def means_by(self, counted: Counted, every: Sequence[By]) -> list[tuple[Counts, Doubles]]:
        """Return the number of objects with a value and the figure, cut in several ways into parts, both
        (len(CLASSES_AND_ALL), parts); 0 without objects."""
        values = self.values(counted)
        return [self._means(counted.groups, by, values)[:2] for by in every]

    def _means(
        self, groups: Groups, by: By, values: Doubles, with_all: bool = True
    ) -> tuple[Counts, Doubles, Doubles]:
        """Return the number of objects with a value, their mean or median, and its standard error, each (rows, parts),
        of all classes together, if requested, and of each; 0 without objects."""
        by_class = self._means_of(groups.parts(by), values)
        if not with_all:
            return by_class
        if self.of_classes:
            objects, means, errors = by_class
            classes = np.maximum((objects > 0).sum(axis=0, keepdims=True), 1)
            value = means.sum(axis=0, keepdims=True) / classes
            se = np.linalg.norm(errors, axis=0, keepdims=True) / classes
            whole = objects.sum(axis=0, keepdims=True), value, se
        else:
            whole = self._means_of(groups.parts(by, together=True), values)
        return tuple(np.concatenate(pair) for pair in zip(whole, by_class, strict=True))  # type: ignore[return-value]

    def _runs(self, groups: Groups, values: Doubles) -> Doubles:
        """Return how far each run of frames moves the mean, (runs, len(CLASSES_AND_ALL))."""
        by_class = groups.deviations(values)
        if self.of_classes:
            there = max(np.count_nonzero(np.bincount(groups.cls[~np.isnan(values)])), 1)
            whole = by_class.sum(axis=1, keepdims=True) / there
        else:
            whole = groups.deviations(values, together=True)
        return np.hstack([whole, by_class])

    def _means_of(self, parts: Parts, values: Doubles) -> tuple[Counts, Doubles, Doubles]:
        objects, means, errors = parts.means(values)
        if self.is_median:
            means, errors = parts.medians(values), np.zeros(means.shape)
        return objects, np.where(objects > 0, np.maximum(means, self.least), means), errors

    # ------------------------------------------------------------ changes
    def cells(self, now: Counted, before: Counted, by: By = "all", in_detail: bool = True) -> Cells:
        """Return the figure of a rig by part, with its change from a baseline in the same frames, object by object.
        The first row is all classes together. in_detail: with its parts by kind and the error in other traffic;
        otherwise that error is the sampling error."""
        mine, theirs = self._pairs(now, before)
        calibration = self.calibrated(now)
        objects, value, se = self._means(now.groups, by, mine)
        change, change_se = self._change(now.groups, by, mine, theirs, value)
        traffic_se = change_se
        if in_detail and by == "all" and not self.is_median:
            of_runs = error_of_runs(self._runs(now.groups, mine - theirs))
            traffic_se = np.maximum(change_se, of_runs[:, None])
        value, change = (np.where(objects > 0, one, math.nan) for one in (value, change))
        if calibration is not None:
            se = np.where(objects > 0, np.hypot(se, calibration.errors[:, None]), 0.0)
        parts = {kind: one.cells(now, before, by) for kind, one in self.parts.items() if in_detail}
        return Cells(objects, value, se, change, change_se, traffic_se, parts)

    def changes(self, now: Counted, before: Counted) -> dict[str, tuple[float, float]]:
        """Return the changes of classes from a baseline and their standard errors, 0 without objects: as in `cells`,
        without the rest of it."""
        mine, theirs = self._pairs(now, before)
        change, se = self._change(now.groups, "all", mine, theirs, with_all=False)
        return dict(zip(CLASSES, zip(change[:, 0].tolist(), se[:, 0].tolist(), strict=True), strict=True))

    def _pairs(self, now: Counted, before: Counted) -> tuple[Doubles, Doubles]:
        """Return the values of objects that have one in both of two rigs, NaN of others."""
        mine, theirs = self.values(now), self.values(before)
        return np.where(np.isnan(theirs), math.nan, mine), np.where(np.isnan(mine), math.nan, theirs)

    def _change(
        self,
        groups: Groups,
        by: By,
        mine: Doubles,
        theirs: Doubles,
        value: Doubles | None = None,
        with_all: bool = True,
    ) -> tuple[Doubles, Doubles]:
        """Return the change of the figure between two values of objects, and its standard error, as `_means`; value:
        the figure of `mine`, where it is known."""
        difference = groups, by, mine - theirs, with_all
        if not self.is_median and self.least == -math.inf:
            return self._means(*difference)[1:]
        own = self._means(groups, by, mine, with_all)[1] if value is None else value
        change = own - self._means(groups, by, theirs, with_all)[1]
        if self.is_median:
            return change, np.zeros(change.shape)
        return change, replace(self, least=-math.inf)._means(*difference)[2]


@dataclass(frozen=True)
class Cells:
    """Numbers of groups of objects, (len(CLASSES_AND_ALL), parts): the count of objects, the figure itself (NaN where
    there are none), its standard error, the change against a baseline and its error as that of a sample; traffic_se:
    of the change in other traffic of its kind, at least as large; parts: with one kind of sensor alone, by kind.

    Both rigs meet the same objects, so errors of changes are those of the differences, object by object.
    """

    objects: Counts
    value: Doubles
    se: Doubles
    change: Doubles
    change_se: Doubles
    traffic_se: Doubles
    parts: Mapping[str, Cells] = field(default_factory=dict)

    def anchored(self, exact: Cells) -> Cells:
        """Return exact values of the same baseline plus the changes of this sample, whose errors are those of pairs;
        the error of a calibration stays."""
        se = np.hypot(exact.se, self.change_se)
        parts = {kind: one.anchored(exact.parts[kind]) for kind, one in self.parts.items()}
        return replace(self, value=exact.value - exact.change + self.change, se=se, parts=parts)


@dataclass(frozen=True)
class Part:
    """Objects of a class from `from_m` up to `to_m` away: their number, and the rig's figures for them by key."""

    from_m: float
    to_m: float
    objects: int
    figures: Mapping[str, Estimate]

    def __getitem__(self, key: str) -> Estimate:
        return self.figures[key]

    def __getattr__(self, key: str) -> Estimate:
        """Return the figure of that key, as an attribute."""
        if not key.startswith("_") and key in self.figures:
            return self.figures[key]
        raise AttributeError(f"no figure of objects is called '{key}'")


@dataclass(frozen=True)
class ClassParts:
    """The figures of a class: for all of its objects, and ring by ring."""

    total: Part
    rings: tuple[Part, ...]


def parts_by_class(
    counted: Counted, figures: Sequence[ObjectFigure], with_rings: bool = False, in_detail: bool = True
) -> dict[str, ClassParts]:
    """Return figures of a rig by class, of all objects and, if requested, by ring of distance; `in_detail` as in
    `ObjectFigure.estimates`."""
    edges_m = counted.groups.edges_m.tolist()
    totals = _rows(counted, figures, "all", [(0.0, edges_m[-1])], in_detail)
    rings = _rows(counted, figures, "ring", list(pairwise(edges_m)), in_detail) if with_rings else {}
    return {name: ClassParts(totals[name][0], tuple(rings.get(name, ()))) for name in CLASSES}


def parts_by_sector(counted: Counted, figures: Sequence[ObjectFigure]) -> dict[str, dict[str, Part]]:
    """Return figures of a rig by class and sector, each of all distances."""
    found = _rows(counted, figures, "sector", [(0.0, counted.within_m)] * len(SECTORS), True)
    return {name: dict(zip(SECTORS, found[name], strict=True)) for name in CLASSES}


def _rows(
    counted: Counted,
    figures: Sequence[ObjectFigure],
    by: By,
    places_m: Sequence[tuple[float, float]],
    in_detail: bool,
) -> dict[str, list[Part]]:
    objects = counted.groups.parts(by).objects
    columns = {figure.key: figure.estimates(counted, by, CLASSES, in_detail) for figure in figures}

    def parts(row: int, name: str) -> Iterator[Part]:
        for place, (from_m, to_m) in enumerate(places_m):
            each = {key: column[name][place] for key, column in columns.items()}
            yield Part(from_m, to_m, int(objects[row, place]), each)

    return {name: list(parts(row, name)) for row, name in enumerate(CLASSES)}
