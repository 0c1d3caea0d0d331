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


def _unfailed(names: tuple[str, ...], failed: Collection[str]) -> NDArray[np.bool_]:
    return np.array([name not in failed for name in names], np.bool_)


@dataclass(frozen=True)
class Returns:
    """Rays of the sensors of one kind, by name, that reach k objects first, or rows of pixels that show them: counts
    (k, sensors); is_image: the sensor with most counts, not the sum of all."""

    names: tuple[str, ...]
    counts: Counts
    is_image: bool = False

    def without(self, failed: Collection[str]) -> Counts:
        """Return the counts of all sensors together but those that failed, or of the best of them for images, (k,)."""
        left = self.counts[:, _unfailed(self.names, failed)] if failed else self.counts
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
        points, tallest = self.all_points, self.height_px
        if failed:
            points = self.points[:, _unfailed(self.lidars, failed)].sum(axis=1)
            tallest = self.heights_px[:, _unfailed(self.cameras, failed)].max(axis=1, initial=0.0)
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
        self.bounds = np.searchsorted(group[self._order], np.arange(len(CLASSES) * self._places + 1))
        self.class_bounds = self.bounds[:: self._places]

    def sorted(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return values of objects (k,), class by class and group by group."""
        return values[self._order]

    def inside(self, domain: Domain) -> NDArray[np.bool_]:
        """Return which objects (k,) lie in the region of a calibration; kept."""
        if domain not in self._inside:
            self._inside[domain] = domain.holds(self._centre_m)
        return self._inside[domain]

    def means(
        self, values: Doubles, bounds: Counts, places: Counts | slice = slice(None)
    ) -> list[list[Estimate]]:
        """Return the means of sorted values (columns, k) from each bound to the next, column by column, and their
        standard errors; places (k,): among the sorted objects if not all have a value."""
        sizes, columns = np.diff(bounds), len(values)
        means = np.empty((len(sizes), columns))
        for place, (start, end) in enumerate(pairwise(bounds.tolist())):
            means[place] = values[:, start:end].sum(axis=1) / max(1, end - start)
        errors = np.zeros(means.shape)
        if self.frames < self.of_frames:
            part = np.repeat(np.arange(len(sizes)), sizes)
            bins = self._frame[places] + self.frames * (part + len(sizes) * np.arange(columns)[:, None])
            missed = (values - np.repeat(means.T, sizes, axis=1)).ravel()
            misses = np.bincount(bins.ravel(), missed, self.frames * means.size)
            by_frame = misses.reshape(columns, len(sizes), self.frames).T
            errors = standard_error(by_frame, np.maximum(sizes, 1)[:, None], self.of_frames)
        return [
            [Estimate(*pair) for pair in zip(*rows, strict=True)]
            for rows in zip(means.tolist(), errors.tolist(), strict=True)
        ]

    def means_by_class(self, values: Doubles) -> dict[str, Estimate]:
        """Return the means of values of objects (k,) by class."""
        means = self.means(self.sorted(values)[None], self.class_bounds)
        return {name: mean for name, (mean,) in zip(CLASSES, means, strict=True)}


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
    within_m, rings_m = float(groups.edges_m[-1]), list(pairwise(groups.edges_m.tolist()))
    totals = _rows(groups, tables, settings, groups.class_bounds, [(0.0, within_m)])
    rings = _rows(groups, tables, settings, groups.bounds, rings_m) if with_rings else [[]] * len(totals)
    classes = {
        name: ClassTargets(total, tuple(rows))
        for name, (total,), rows in zip(CLASSES, totals, rings, strict=True)
    }
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
    rows = _rows(groups, tables, scores.settings, groups.bounds, [(0.0, scores.within_m)] * len(SECTORS))
    return {name: dict(zip(SECTORS, found, strict=True)) for name, found in zip(CLASSES, rows, strict=True)}


def ring_edges_m(within_m: float) -> tuple[float, ...]:
    """Return where rings of distance begin, and where the last one ends, metres."""
    return (*np.arange(0.0, min(within_m, RINGS_TO_M + 1e-9), RING_M).tolist(), within_m)


@dataclass(frozen=True)
class _Known:
    """Values of those objects that have one, at places (n,) among the sorted objects."""

    places: Counts
    values: Doubles

    @classmethod
    def of(cls, groups: Groups, values: Doubles) -> Self:
        """Return the values of objects (k,) that are not NaN."""
        ordered = groups.sorted(values)
        places = np.flatnonzero(~np.isnan(ordered))
        return cls(places, ordered[places])

    def means(self, groups: Groups, bounds: Counts) -> list[tuple[Estimate, int]]:
        """Return the means from each bound to the next, and the number of values."""
        bounds = np.searchsorted(self.places, bounds)
        means = groups.means(self.values[None], bounds, self.places)
        return [(mean, objects) for (mean,), objects in zip(means, np.diff(bounds).tolist(), strict=True)]


@dataclass(frozen=True)
class _Sorted:
    """Inputs of the tables, sorted by class and ring or sector: points and height_px (k,); predicted and found, where
    they are known; means (columns, k) of `names`, then of the further kinds, by name."""

    points: Doubles
    height_px: Doubles
    predicted: _Known
    found: _Known
    means: Doubles
    names: tuple[str, ...]
    kinds: tuple[str, ...]

    @classmethod
    def of(cls, groups: Groups, objects: ObjectCounts, settings: TargetSettings) -> Self:
        points, height_px, on_target, visible = (
            groups.sorted(column)
            for column in (objects.all_points, objects.height_px, objects.on_target, objects.visible)
        )
        detected = {
            kind: groups.sorted(flags) for kind, flags in objects.detected(settings.min_points).items()
        }
        by_lidar, by_camera = detected[LIDAR.name], detected[CAMERA.name]
        kinds = np.sum(list(detected.values()), axis=0)
        means = {
            "on_target": on_target,
            "share_1": points >= 1,
            "share_5": points >= 5,
            "share_n": by_lidar,
            "visible": visible,
            "share_25px": by_camera,
            "both": kinds >= 2,
            "neither": kinds == 0,
        }
        others = [detected[kind] for kind in objects.returns]
        columns = np.array([*means.values(), *others], np.float64)
        predicted, found = (_Known.of(groups, values) for values in (objects.predicted, objects.found))
        return cls(points, height_px, predicted, found, columns, tuple(means), tuple(objects.returns))


def _rows(
    groups: Groups,
    tables: _Sorted,
    settings: TargetSettings,
    bounds: Counts,
    places_m: list[tuple[float, float]],
) -> list[list[Row]]:
    """Return the rows of each class: one for each of its distances `places_m`, of the objects between two bounds."""
    known = [values.means(groups, bounds) for values in (tables.predicted, tables.found)]
    parts = zip(pairwise(bounds.tolist()), groups.means(tables.means, bounds), *known, strict=True)
    rows = list[list[Row]]()
    for name in CLASSES:
        errors = _errors(settings, name)
        rows.append(
            [
                Row(
                    *place_m,
                    end - start,
                    median_points=_median(tables.points[start:end]),
                    median_height_px=_median(tables.height_px[start:end]),
                    by_kind=dict(zip(tables.kinds, means[len(tables.names) :], strict=True)),
                    predicted=_predicted(predicted, errors[0]),
                    found=_predicted(found, errors[1]),
                    **dict[str, Any](zip(tables.names, means, strict=False)),
                )
                for place_m, ((start, end), means, predicted, found) in zip(places_m, parts, strict=False)
            ]
        )
    return rows


def _errors(settings: TargetSettings, name: str) -> tuple[float, float]:
    """Return the errors of a class in the calibrations of predicted detection and of recall; 0 without a curve."""
    predicted, found = (
        None if one is None else one.classes.of(name)
        for one in (settings.calibration or shipped(), settings.recall)
    )
    return 0.0 if predicted is None else predicted.error, 0.0 if found is None else found.error


def _predicted(known: tuple[Estimate, int], error: float) -> Predicted | None:
    """Return the mean over the objects of which the calibration says something; None without any."""
    mean, objects = known
    return Predicted(mean.value, math.hypot(mean.se, error), objects, mean.se) if objects else None


def _median(values: Doubles) -> float:
    if not values.size:
        return 0.0
    low, high = (values.size - 1) // 2, values.size // 2
    ordered = np.partition(values, (low, high))
    return float((ordered[low] + ordered[high]) / 2.0)
