"""Group objects by class and ring of distance, sector or both, and average numbers over the groups."""

from __future__ import annotations

import copy
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS, sector_of
from riglens.core.targets.calibration import Domain
from riglens.core.targets.settings import RING_M, RINGS_TO_M
from riglens.core.targets.traffic import Traffic

Doubles = NDArray[np.float64]
Counts = NDArray[np.int64]
By = Literal["all", "ring", "sector", "ring and sector"]
RUNS = 8
"""Runs of frames, in the order of the data: what differs between them would differ in other traffic of its kind."""


class Means(NamedTuple):
    """Of each group, in arrays of equal shape: the number of objects that have a value, the mean of their values, 0
    without any, and its standard error as an estimate of that over all frames: 0 where all were used."""

    objects: Counts
    value: Doubles
    se: Doubles


class Parts:
    """Objects sorted into groups: each of `rows`, a class or all classes together, cut into `places` parts."""

    def __init__(
        self, row: Counts, rows: int, place: Counts, places: int, frame: Counts, frames: tuple[int, int]
    ) -> None:
        group = row * places + place
        self._order, self.shape = np.argsort(group, kind="stable"), (rows, places)
        self._frame, (self._used, self._of) = frame[self._order], frames
        self._bounds = np.searchsorted(group[self._order], np.arange(rows * places + 1))
        self.objects = np.diff(self._bounds).reshape(self.shape)

    def whole(self) -> Parts:
        """Return the rows uncut, their objects in the order of the parts: sums depend on it in their last bits."""
        found, (rows, places) = copy.copy(self), self.shape
        found._bounds, found.shape = self._bounds[::places], (rows, 1)
        found.objects = np.diff(found._bounds).reshape(found.shape)
        return found

    def means(self, values: Doubles) -> Means:
        """Return the means of values of objects (k,) in each part; objects without one, NaN, do not count."""
        ordered = values[self._order]
        places = np.flatnonzero(~np.isnan(ordered))
        bounds, frame = self._bounds, self._frame
        if len(places) < len(ordered):
            ordered, frame, bounds = ordered[places], frame[places], np.searchsorted(places, bounds)
        sizes = np.diff(bounds)
        sums = [ordered[start:end].sum() for start, end in pairwise(bounds.tolist())]
        means, errors = np.array(sums, np.float64) / np.maximum(sizes, 1), np.zeros(len(sizes))
        if self._used < self._of:
            bins = frame + self._used * np.repeat(np.arange(len(sizes)), sizes)
            misses = np.bincount(bins, ordered - np.repeat(means, sizes), self._used * len(sizes))
            errors = standard_error(misses.reshape(-1, self._used).T, np.maximum(sizes, 1), self._of)
        return Means(sizes.reshape(self.shape), means.reshape(self.shape), errors.reshape(self.shape))

    def medians(self, values: Doubles) -> Doubles:
        """Return the medians of values of objects (k,) in each part, 0 without any."""
        ordered = values[self._order]
        found = [_median(ordered[start:end]) for start, end in pairwise(self._bounds.tolist())]
        return np.array(found).reshape(self.shape)


class Groups:
    """The objects that count in some frames, k of them.

    span: the first N of the sampling order, or a range of it; every: their places in the traffic from the first frame
    on, box (k,): of those in `span`, before: how many come before these.
    """

    def __init__(self, traffic: Traffic, frames: int | range) -> None:
        self.traffic, self.span = traffic, range(frames) if isinstance(frames, int) else frames
        self.every = np.flatnonzero(traffic.counts[: traffic.starts[self.span.stop]])
        self.before = int(np.searchsorted(self.every, traffic.starts[self.span.start]))
        self.box = self.every[self.before :]
        self.cls, self.centre_m = traffic.cls[self.box], traffic.centre_m[self.box, :2]
        self.frame = traffic.frame_of_box[self.box] - self.span.start
        self.edges_m = np.array(ring_edges_m(traffic.within_m))
        self._inside: dict[Domain, NDArray[np.bool_]] = {}
        self._parts: dict[tuple[By, bool], Parts] = {}

    def parts(self, by: By = "all", together: bool = False) -> Parts:
        """Return the groups of each class, or of all classes `together`; kept."""
        if (by, together) not in self._parts:
            if by == "all":
                return self._parts.setdefault((by, together), self.parts("ring", together).whole())
            place, places = self._places(by)
            row = np.zeros(len(self.box), np.int64) if together else self.cls.astype(np.int64)
            rows, frames = 1 if together else len(CLASSES), (len(self.span), self.traffic.frames)
            self._parts[by, together] = Parts(row, rows, place, places, self.frame, frames)
        return self._parts[by, together]

    def _places(self, by: By) -> tuple[Counts, int]:
        rings, sectors = len(self.edges_m) - 1, len(SECTORS)
        if by == "sector":
            return sector_of(*self.centre_m.T).astype(np.int64), sectors
        # the last ring ends with what counts: its end belongs to it
        ring = np.searchsorted(self.edges_m[1:-1], self.traffic.distance_m[self.box], side="right")
        if by == "ring":
            return ring, rings
        return ring * sectors + sector_of(*self.centre_m.T), rings * sectors

    @cached_property
    def run(self) -> Counts:
        """Return the run of frames that each object (k,) belongs to."""
        number = self.traffic.frame[self.span.start + self.frame]
        return np.minimum(number * RUNS // (int(self.traffic.frame.max()) + 1), RUNS - 1)

    def deviations(self, values: Doubles, together: bool = False) -> Doubles:
        """Return how far each run of frames that occurs moves the mean of values of objects (k,) of each class, or of
        all classes `together`, (runs, rows); objects without a value, NaN, do not count."""
        known = ~np.isnan(values)
        cell = self._run_and_class
        if not known.all():
            cell, values = cell[known], values[known]
        shape = (RUNS, len(CLASSES))
        objects, sums = (
            np.bincount(cell, weights, RUNS * len(CLASSES)).reshape(shape) for weights in (None, values)
        )
        if together:
            objects, sums = (one.sum(axis=1, keepdims=True) for one in (objects, sums))
        whole = np.maximum(objects.sum(axis=0), 1)
        moved = (sums - objects * (sums.sum(axis=0) / whole)) / whole
        return np.asarray(moved[np.bincount(self.run, minlength=RUNS) > 0])

    @cached_property
    def _run_and_class(self) -> Counts:
        return self.run * len(CLASSES) + self.cls

    def inside(self, domain: Domain) -> NDArray[np.bool_]:
        """Return which objects (k,) lie in the region of a calibration; kept."""
        if domain not in self._inside:
            self._inside[domain] = domain.holds(self.centre_m)
        return self._inside[domain]


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


def ring_edges_m(within_m: float) -> tuple[float, ...]:
    """Return where rings of distance begin, and where the last one ends, metres."""
    return (*np.arange(0.0, min(within_m, RINGS_TO_M + 1e-9), RING_M).tolist(), within_m)


def _median(values: Doubles) -> float:
    if not values.size:
        return 0.0
    low, high = (values.size - 1) // 2, values.size // 2
    ordered = np.partition(values, (low, high))
    return float((ordered[low] + ordered[high]) / 2.0)
