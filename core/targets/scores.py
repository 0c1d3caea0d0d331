"""Turn counts per sensor into counts per object, and into tables per class and ring of distance or sector."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS, sector_of
from riglens.core.sensors.camera import CAMERA
from riglens.core.sensors.lidar import LIDAR
from riglens.core.sensors.registry import kind_named
from riglens.core.targets.calibration import Calibration, Domain, shipped
from riglens.core.targets.quantities import of_100
from riglens.core.targets.settings import CELLS_SCALE, HEIGHT_PX, RING_M, RINGS_TO_M, TargetSettings
from riglens.core.targets.traffic import Traffic

Doubles = NDArray[np.float64]
Counts = NDArray[np.int64]


@dataclass(frozen=True)
class Returns:
    """Rays of the sensors of one kind, by name, that reach k objects first, or rows of pixels that show them: counts
    (k, sensors); is_image: the sensor with most counts, not the sum of all."""

    names: tuple[str, ...]
    counts: Counts
    is_image: bool = False

    def without(self, failed: Collection[str]) -> Counts:
        """Return the counts of all sensors together but those that failed, or of the best of them for images, (k,)."""
        left = self.counts[:, np.array([name not in failed for name in self.names], np.bool_)]
        return np.asarray(left.max(axis=1, initial=0) if self.is_image else left.sum(axis=1))


@dataclass(frozen=True)
class ObjectCounts:
    """Counts of the k objects that count, in the order of the sampled frames.

    box (k,): their places in the traffic; points (k, lidars) rays that reach them first, pixels (k, cameras) native
    pixels that show them, of the enabled sensors by name; points_alone and pixels_alone (k,): of all of them together
    without occlusion; cells (k,): distinct cells of 0.2 m that LiDARs hit; heights_px (k, cameras): rows of
    native pixels from the first to the last that shows it; returns: of the kinds of sensor beside these two, by name;
    predicted (k,): how well a detector finds each, 0 to 1, found (k,): the chance that it does, both NaN where the
    calibration says nothing.
    """

    box: Counts
    lidars: tuple[str, ...]
    cameras: tuple[str, ...]
    points: Counts
    pixels: Doubles
    points_alone: Counts
    pixels_alone: Doubles
    cells: Counts
    heights_px: Doubles
    returns: Mapping[str, Returns] = field(default_factory=dict)
    predicted: Doubles = field(default_factory=lambda: np.zeros(0))
    found: Doubles = field(default_factory=lambda: np.zeros(0))

    def detected(self, min_points: int, failed: Collection[str] = ()) -> dict[str, NDArray[np.bool_]]:
        """Return by kind of sensor which objects are detected (k,) without some sensors: LiDARs by `min_points` points
        of all, cameras by 25 px of height in one, others by the number of returns set by their kind."""
        points = Returns(self.lidars, self.points).without(failed)
        cameras = np.array([name not in failed for name in self.cameras], np.bool_)
        tallest = self.heights_px[:, cameras].max(axis=1, initial=0.0)
        return {
            LIDAR.name: points >= min_points,
            CAMERA.name: tallest >= HEIGHT_PX,
            **{kind: found.without(failed) >= _enough(kind) for kind, found in self.returns.items()},
        }

    def sensors_detecting(self, min_points: int) -> Counts:
        """Return the number of sensors that detect each object on their own, (k,)."""
        flags = [self.points >= min_points, self.heights_px >= HEIGHT_PX]
        flags += [found.counts >= _enough(kind) for kind, found in self.returns.items()]
        return np.asarray(np.concatenate(flags, axis=1).sum(axis=1))

    def without_first(self, count: int) -> ObjectCounts:
        """Return the counts without the first `count` objects."""
        columns = {
            one.name: getattr(self, one.name)[count:]
            for one in fields(self)
            if one.name not in ("lidars", "cameras", "returns")
        }
        returns = {kind: replace(found, counts=found.counts[count:]) for kind, found in self.returns.items()}
        return replace(self, **columns, returns=returns)

    @cached_property
    def height_px(self) -> Doubles:
        """Height in the camera that shows it tallest, (k,)."""
        return np.asarray(self.heights_px.max(axis=1, initial=0.0))

    @cached_property
    def all_points(self) -> Counts:
        """Points of all LiDARs, (k,)."""
        return np.asarray(self.points.sum(axis=1))

    @cached_property
    def all_returns(self) -> Counts:
        """Returns of all sensors of further kinds, (k,)."""
        parts = [found.without(()) for found in self.returns.values()]
        return np.asarray(np.sum([np.zeros(len(self.box), np.int64), *parts], axis=0))

    @cached_property
    def visible(self) -> Doubles:
        """Pixels seen over pixels without anything before it, of all cameras, (k,); 0 where no camera could see it."""
        alone = np.where(self.pixels_alone > 0.0, self.pixels_alone, 1.0)
        return np.asarray(self.pixels.sum(axis=1) / alone)

    @cached_property
    def on_target(self) -> Doubles:
        """1 - exp(-cells / 5), (k,)."""
        return np.asarray(1.0 - np.exp(-self.cells / CELLS_SCALE))


def _enough(kind_name: str) -> float:
    kind = kind_named(kind_name)
    assert kind is not None
    return kind.hits.threshold


@dataclass(frozen=True)
class Estimate:
    """A mean over objects, and its standard error as an estimate of that over all frames: 0 where all were used."""

    value: float = 0.0
    se: float = 0.0


@dataclass(frozen=True)
class Predicted(Estimate):
    """Predicted detection, a mean over `objects` objects: `sample_se` of the sampled frames alone, `se` with the error
    of the calibration on rigs or sequences that it was not fitted on."""

    objects: int = 0
    sample_se: float = 0.0


@dataclass(frozen=True)
class Row:
    """Objects of one class, in one ring, in one sector or in all: their number, and the rig's figures for them.

    LiDARs: on_target, shares with at least 1, 5 and `min_points` points, median points. Cameras: mean visible share,
    share at least 25 pixels tall, median height. by_kind: of further kinds, the share with enough returns. By both: by
    sensors of two kinds; by neither: by none. predicted: detection, found: recall; None if no calibration says it.
    """

    from_m: float
    to_m: float
    objects: int
    on_target: Estimate
    share_1: Estimate
    share_5: Estimate
    share_n: Estimate
    median_points: float
    visible: Estimate
    share_25px: Estimate
    median_height_px: float
    both: Estimate
    neither: Estimate
    by_kind: Mapping[str, Estimate] = field(default_factory=dict)
    predicted: Predicted | None = None
    found: Predicted | None = None


@dataclass(frozen=True)
class ClassTargets:
    """The table of a class: all of its objects, and ring by ring."""

    total: Row
    rings: tuple[Row, ...]


@dataclass(frozen=True)
class TargetScores:
    """Figures of a rig for the objects of the frames `span` of the sampling order, of `frames` frames."""

    rig: Rig
    settings: TargetSettings
    frames: int
    span: range
    within_m: float
    objects: ObjectCounts
    classes: Mapping[str, ClassTargets]
    elapsed_ms: float = 0.0

    @property
    def frames_used(self) -> int:
        """Number of frames in which objects were counted."""
        return len(self.span)

    @property
    def calibration(self) -> Calibration:
        """The calibration of predicted detection."""
        return self.settings.calibration or shipped()

    @property
    def predicted_outside(self) -> str:
        """Return why predicted detection is outside its domain; "" inside."""
        return self.calibration.outside(self.rig, self.settings.shape, self.settings.range_law)

    @property
    def found_outside(self) -> str:
        """Return the same of the objects found; "" also where no calibration says which are."""
        recall = self.settings.recall
        return (
            "" if recall is None else recall.outside(self.rig, self.settings.shape, self.settings.range_law)
        )

    def of_100(self, errors: float) -> str:
        """Say how many of 100 objects of each class are found, ± that many standard errors; empty where no calibration
        says so."""
        known = {name: one.total.found for name, one in self.classes.items()}
        shares = {name: (one.value, errors * one.se) for name, one in known.items() if one is not None}
        recall = self.settings.recall
        return "" if recall is None else of_100(shares, recall.domain.region)

    @property
    def predicted_mean(self) -> Predicted | None:
        """Mean of predicted detection over classes; None if there is none of a class."""
        found = [one.total.predicted for one in self.classes.values()]
        known = [one for one in found if one is not None]
        if len(known) < len(found):
            return None
        sample_se = float(np.linalg.norm([one.sample_se for one in known])) / len(known)
        return Predicted(
            sum(one.value for one in known) / len(known),
            math.hypot(sample_se, self.calibration.mean_error),
            sum(one.objects for one in known),
            sample_se,
        )


class Groups:
    """The objects that count in some frames, k of them, by class and ring of distance or sector.

    `frames`: the first N of the sampling order, or a range of it. box (k,): their places in the traffic; before:
    how many count in frames before these; edges_m: of the rings. Made once for a range of frames.
    """

    def __init__(self, traffic: Traffic, frames: int | range, by: Literal["ring", "sector"] = "ring") -> None:
        self.span = range(frames) if isinstance(frames, int) else frames
        self.frames, self.of_frames = len(self.span), traffic.frames
        every = np.flatnonzero(traffic.counts[: traffic.starts[self.span.stop]])
        self.before = int(np.searchsorted(every, traffic.starts[self.span.start]))
        self.every, self.box = every, every[self.before :]
        self.cls, self._centre_m = traffic.cls[self.box], traffic.centre_m[self.box, :2]
        self._inside: dict[Domain, NDArray[np.bool_]] = {}
        self.edges_m = np.array(ring_edges_m(traffic.within_m))
        if by == "ring":
            # the last ring ends with what counts: its end belongs to it
            place = np.searchsorted(self.edges_m[1:-1], traffic.distance_m[self.box], side="right")
            self._places = len(self.edges_m) - 1
        else:
            place = sector_of(*self._centre_m.T).astype(np.int64)
            self._places = len(SECTORS)
        group = self.cls * self._places + place
        self._order = np.argsort(group, kind="stable")
        self._frame = traffic.frame_of_box[self.box][self._order] - self.span.start
        self._bounds = np.searchsorted(group[self._order], np.arange(len(CLASSES) * self._places + 1))

    def slices(self, number: int) -> list[slice]:
        """Return the places of a class among `sorted` values: all of them, then group by group."""
        first = number * self._places
        bounds = self._bounds[first : first + self._places + 1].tolist()
        return [slice(bounds[0], bounds[-1]), *(slice(*pair) for pair in pairwise(bounds))]

    def sorted(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return values of objects (k,), class by class and group by group."""
        return values[self._order]

    def inside(self, domain: Domain) -> NDArray[np.bool_]:
        """Return which objects (k,) lie in the region of a calibration; kept."""
        if domain not in self._inside:
            self._inside[domain] = domain.holds(self._centre_m)
        return self._inside[domain]

    def mean(self, values: Doubles, part: slice | Counts) -> Estimate:
        """Return the mean of a part of sorted values, and its standard error."""
        mine = values[part]
        if not mine.size:
            return Estimate()
        mean = float(mine.sum() / mine.size)
        if self.frames == self.of_frames:
            return Estimate(mean)
        misses = np.bincount(self._frame[part], mine - mean, self.frames)
        return Estimate(mean, float(standard_error(misses, mine.size, self.of_frames)))

    def means_by_class(self, values: Doubles) -> dict[str, Estimate]:
        """Return the means of values of objects (k,) by class."""
        ordered = self.sorted(values)
        return {name: self.mean(ordered, self.slices(number)[0]) for number, name in enumerate(CLASSES)}


def standard_error(misses: NDArray[Any], objects: ArrayLike, of_frames: int) -> Doubles:
    """Return the standard errors of means over objects (...) of sampled frames: 0 where all frames were used.

    misses (sampled frames, ...): sums of the deviations of a frame's objects from the mean. Objects of a frame
    are not independent, so frames are what was drawn: a ratio of two totals over frames, linearised (Cochran,
    Sampling Techniques, 1977, chapter 6), with the correction for a finite number of frames.
    """
    used = len(misses)
    if used == of_frames or used < 2:
        return np.zeros(misses.shape[1:])
    spread = (misses**2).sum(axis=0) / (used - 1)
    return np.asarray(np.sqrt(spread * (1.0 - used / of_frames) * used) / objects)


def scores_of(
    groups: Groups, rig: Rig, settings: TargetSettings, objects: ObjectCounts, with_rings: bool = True
) -> TargetScores:
    """Tabulate the figures of a rig's enabled sensors for the objects of `groups`, and predicted detection.

    The rings of distance, which take most of the time, can be left out."""
    predicted = _of_objects(groups, settings.calibration or shipped(), objects)
    objects = replace(objects, predicted=predicted, found=_of_objects(groups, settings.recall, objects))
    tables = _Sorted.of(groups, objects, settings)
    classes = {
        name: _class_targets(groups, tables, number, settings, with_rings)
        for number, name in enumerate(CLASSES)
    }
    within_m = float(groups.edges_m[-1])
    return TargetScores(rig, settings, groups.of_frames, groups.span, within_m, objects, classes)


def _of_objects(groups: Groups, calibration: Calibration | None, objects: ObjectCounts) -> Doubles:
    """Return the curve of a calibration at each object, (k,): NaN where it says nothing."""
    if calibration is None or not objects.lidars:
        return np.full(len(objects.box), math.nan)
    n = objects.cells if calibration.unit == "cells" else objects.all_points
    return calibration.of_objects(groups.cls, groups.inside(calibration.domain), n)


def sectors_of(traffic: Traffic, scores: TargetScores) -> dict[str, dict[str, Row]]:
    """Tabulate the figures of a rig by class and sector, each of all distances."""
    groups = Groups(traffic, scores.span, "sector")
    tables = _Sorted.of(groups, scores.objects, scores.settings)
    return {
        name: {
            sector: _row(groups, tables, part, (0.0, scores.within_m), _errors(scores.settings, name))
            for sector, part in zip(SECTORS, groups.slices(number)[1:], strict=True)
        }
        for number, name in enumerate(CLASSES)
    }


def ring_edges_m(within_m: float) -> tuple[float, ...]:
    """Return where rings of distance begin, and where the last one ends, metres."""
    return (*np.arange(0.0, min(within_m, RINGS_TO_M + 1e-9), RING_M).tolist(), within_m)


@dataclass(frozen=True)
class _Sorted:
    """Inputs of the tables, sorted by class and ring or sector."""

    points: Doubles
    height_px: Doubles
    on_target: Doubles
    share_1: Doubles
    share_5: Doubles
    share_n: Doubles
    visible: Doubles
    share_25px: Doubles
    both: Doubles
    neither: Doubles
    predicted: Doubles
    found: Doubles
    by_kind: Mapping[str, Doubles] = field(kw_only=True)

    @classmethod
    def of(cls, groups: Groups, objects: ObjectCounts, settings: TargetSettings) -> Self:
        points, height_px, on_target, visible = (
            groups.sorted(column)
            for column in (objects.all_points, objects.height_px, objects.on_target, objects.visible)
        )
        found = {kind: groups.sorted(flags) for kind, flags in objects.detected(settings.min_points).items()}
        by_lidar, by_camera = found[LIDAR.name], found[CAMERA.name]
        kinds = np.sum(list(found.values()), axis=0)
        columns = (
            points, height_px, on_target, points >= 1, points >= 5, by_lidar, visible, by_camera,
            kinds >= 2, kinds == 0, groups.sorted(objects.predicted), groups.sorted(objects.found),
        )  # fmt: skip
        others = {kind: found[kind].astype(np.float64) for kind in objects.returns}
        return cls(*(column.astype(np.float64) for column in columns), by_kind=others)


def _class_targets(
    groups: Groups, tables: _Sorted, number: int, settings: TargetSettings, with_rings: bool
) -> ClassTargets:
    whole, *rings = groups.slices(number)
    edges = groups.edges_m.tolist()
    errors = _errors(settings, CLASSES[number])
    return ClassTargets(
        _row(groups, tables, whole, (0.0, edges[-1]), errors),
        tuple(
            _row(groups, tables, part, ring, errors)
            for part, ring in zip(rings, pairwise(edges), strict=True)
            if with_rings
        ),
    )


def _errors(settings: TargetSettings, name: str) -> tuple[float, float]:
    """Return the errors of a class in the calibrations of predicted detection and of recall; 0 without a curve."""
    predicted, found = (
        None if one is None else one.classes.of(name)
        for one in (settings.calibration or shipped(), settings.recall)
    )
    return 0.0 if predicted is None else predicted.error, 0.0 if found is None else found.error


def _row(
    groups: Groups, tables: _Sorted, part: slice, ring_m: tuple[float, float], errors: tuple[float, float]
) -> Row:
    def mean(values: Doubles) -> Estimate:
        return groups.mean(values, part)

    return Row(
        *ring_m,
        part.stop - part.start,
        mean(tables.on_target),
        mean(tables.share_1),
        mean(tables.share_5),
        mean(tables.share_n),
        _median(tables.points[part]),
        mean(tables.visible),
        mean(tables.share_25px),
        _median(tables.height_px[part]),
        mean(tables.both),
        mean(tables.neither),
        {kind: mean(values) for kind, values in tables.by_kind.items()},
        _predicted(groups, tables.predicted, part, errors[0]),
        _predicted(groups, tables.found, part, errors[1]),
    )


def _predicted(groups: Groups, values: Doubles, part: slice, error: float) -> Predicted | None:
    """Return the mean over the objects of which the calibration says something; None without any."""
    known = part.start + np.flatnonzero(~np.isnan(values[part]))
    if not known.size:
        return None
    found = groups.mean(values, known)
    return Predicted(found.value, math.hypot(found.se, error), len(known), found.se)


def _median(values: Doubles) -> float:
    if not values.size:
        return 0.0
    low, high = (values.size - 1) // 2, values.size // 2
    ordered = np.partition(values, (low, high))
    return float((ordered[low] + ordered[high]) / 2.0)
