"""Average precision as nuScenes defines it: matched by distance of centres, without torch.

Source: Caesar et al., nuScenes: A multimodal dataset for autonomous driving, CVPR 2020, section 3.1, and the devkit
1.2.0 (nuscenes/eval/detection, configuration detection_cvpr_2019), whose choices in corner cases these are.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]
Flags = NDArray[np.bool_]

MATCH_M = (0.5, 1.0, 2.0, 4.0)
"""A detection is right when the nearest object that no better one took is closer than this, metres on the ground."""
MIN_RECALL = MIN_PRECISION = 0.1
_RECALLS = np.linspace(0.0, 1.0, 101)[round(100 * MIN_RECALL) + 1 :]
_REPLICAS_AT_ONCE = 200


class Truth(NamedTuple):
    """Objects of all frames, n: frame (n,), cls (n,) index into CLASSES, centre_m (n, 2) x and y; points (n,) of LiDARs
    on each."""

    frame: Ids
    cls: NDArray[np.uint8]
    centre_m: Doubles
    points: Ids

    def where(self, chosen: Flags) -> Truth:
        """Return some of the objects."""
        return Truth(self.frame[chosen], self.cls[chosen], self.centre_m[chosen], self.points[chosen])


class Detections(NamedTuple):
    """Detections in all frames, m: frame (m,), cls (m,), centre_m (m, 2) x and y, score (m,)."""

    frame: Ids
    cls: NDArray[np.uint8]
    centre_m: Doubles
    score: Doubles

    def where(self, chosen: Flags) -> Detections:
        """Return some of the detections."""
        return Detections(self.frame[chosen], self.cls[chosen], self.centre_m[chosen], self.score[chosen])

    @classmethod
    def joined(cls, parts: Iterable[tuple[NDArray[Any], ...]]) -> Self:
        """Return detections that were found in parts, of the same columns."""
        empty = (np.zeros(0, np.int64), np.zeros(0, np.uint8), np.zeros((0, 2)), np.zeros(0))
        return cls(*(np.concatenate(column) for column in zip(empty, *parts, strict=True)))


@dataclass(frozen=True)
class Matched:
    """Detections of one class, the best score first, m of them, and whether they are right.

    group (m,): of the frame of each (its sequence); right (len(MATCH_M), m); objects (groups,): how many objects of the
    class each group has.
    """

    group: Ids
    right: Flags
    objects: Ids

    @classmethod
    def of(cls, truth: Truth, found: Detections, number: int, group_of_frame: Ids) -> Self:
        """Match the detections of class `number` frame by frame; group_of_frame (frames,): groups from 0.

        Raise ValueError for a score that is not finite.
        """
        if not np.isfinite(found.score).all():
            raise ValueError("scores of detections must be finite")
        mine, own = np.flatnonzero(found.cls == number), np.flatnonzero(truth.cls == number)
        # equal scores: the later one first, as in the devkit
        order = mine[np.lexsort((np.arange(len(mine)), found.score[mine]))[::-1]]
        groups = int(group_of_frame.max(initial=-1)) + 1
        objects = np.bincount(group_of_frame[truth.frame[own]], minlength=groups)
        near = _near(truth, own, found, order)
        right = np.array([_taken(near, within_m) for within_m in MATCH_M], np.int64) >= 0
        return cls(group_of_frame[found.frame[order]], right.reshape(len(MATCH_M), len(order)), objects)

    def precision(self, weights: Doubles | None = None) -> Doubles:
        """Return average precision, 0 to 1, mean over MATCH_M: (replicas,) for weights (groups, replicas).

        A group of weight 2 counts as if its frames were there twice, a group of weight 0 as if they were not. Without
        weights one value, that of the devkit's `calc_ap` over the four distances. NaN where no object is left (the
        devkit says 0).
        """
        if weights is None:
            weights = np.ones((len(self.objects), 1))
        parts = np.arange(_REPLICAS_AT_ONCE, weights.shape[1], _REPLICAS_AT_ONCE)
        found = [
            np.mean([curve.precision(part) for curve in self._curves], axis=0)
            for part in np.split(weights, parts, axis=1)
        ]
        return np.concatenate(found)

    @cached_property
    def _curves(self) -> list[_Curve]:
        return [_Curve.of(self.group, right, self.objects) for right in self.right]


def found_objects(truth: Truth, found: Detections, number: int, within_m: float) -> Flags:
    """Return which objects of class `number` a detection of the class took, (n,), the best score first; True nowhere
    else."""
    own, mine = np.flatnonzero(truth.cls == number), np.flatnonzero(found.cls == number)
    order = mine[np.argsort(-found.score[mine], kind="stable")]
    taken = np.array(_taken(_near(truth, own, found, order), within_m), np.int64)
    flags = np.zeros(len(truth.cls), np.bool_)
    flags[taken[taken >= 0]] = True
    return flags


def right_detections(truth: Truth, found: Detections, number: int, within_m: float) -> Flags:
    """Return which detections of class `number` are right, (m,), the best score first; False for other classes."""
    own, mine = np.flatnonzero(truth.cls == number), np.flatnonzero(found.cls == number)
    order = mine[np.argsort(-found.score[mine], kind="stable")]
    flags = np.zeros(len(found.cls), np.bool_)
    flags[order] = np.array(_taken(_near(truth, own, found, order), within_m), np.int64) >= 0
    return flags


_Near = list[list[tuple[float, int]]]


def _near(truth: Truth, own: Ids, found: Detections, order: Ids) -> _Near:
    """Return for each detection the objects of its frame that are near enough for the widest match, nearest first."""
    by_frame: dict[int, list[tuple[int, float, float]]] = {}
    places = zip(truth.frame[own].tolist(), own.tolist(), *truth.centre_m[own].T.tolist(), strict=True)
    for frame, place, x, y in places:
        by_frame.setdefault(frame, []).append((place, x, y))
    near: _Near = []
    for frame, x, y in zip(found.frame[order].tolist(), *found.centre_m[order].T.tolist(), strict=True):
        apart = [(math.sqrt((x - a) ** 2 + (y - b) ** 2), place) for place, a, b in by_frame.get(frame, ())]
        near.append(sorted(pair for pair in apart if pair[0] < MATCH_M[-1]))
    return near


def _taken(near: _Near, within_m: float) -> list[int]:
    """Match detections, the best first, to the nearest object left that is close enough; return its number, or -1."""
    taken: set[int] = set()
    places = []
    for candidates in near:
        distance_m, place = next((pair for pair in candidates if pair[1] not in taken), (math.inf, -1))
        if distance_m < within_m:
            taken.add(place)
        places.append(place if distance_m < within_m else -1)
    return places


class _Curve(NamedTuple):
    """Counts behind precision over recall, at the k right detections: right ones (k, groups) up to each of them, and
    wrong ones (k + 1, groups) before each and in all; objects (groups,)."""

    right: Doubles
    wrong: Doubles
    objects: Ids

    @classmethod
    def of(cls, group: Ids, right: Flags, objects: Ids) -> Self:
        places = np.flatnonzero(right)
        hits = np.zeros((len(places), len(objects)))
        hits[np.arange(len(places)), group[places]] = 1.0
        wrong = np.zeros((len(places) + 1, len(objects)))
        np.add.at(wrong, (np.searchsorted(places, np.flatnonzero(~right)), group[~right]), 1.0)
        return cls(hits.cumsum(axis=0), wrong.cumsum(axis=0), objects)

    def precision(self, weights: Doubles) -> Doubles:
        """Average precision (replicas,) for weights (groups, replicas)."""
        right, wrong, objects = self.right @ weights, self.wrong @ weights, self.objects @ weights
        return np.array(
            [_area(*columns) for columns in zip(right.T, wrong.T, objects.tolist(), strict=True)], np.float64
        )


def _area(right: Doubles, wrong: Doubles, objects: float) -> float:
    """Return the mean, over recalls above the least, of precision above the least, 0 to 1; right (k,), wrong (k + 1,).

    Between two right detections recall does not grow: linear interpolation over recall goes from the last detection
    before the next right one to that one, and there is nothing beyond the last recall.
    """
    if objects == 0.0:
        return float("nan")
    if not right.size or right[-1] == 0.0:
        return 0.0
    hits = np.concatenate([[0.0], right])
    recall = hits / objects
    last = np.searchsorted(recall, _RECALLS, side="right") - 1
    following = np.minimum(last + 1, len(right))
    start, end, missed = hits[last], hits[following], wrong[last]
    seen = start + missed
    high = end / (end + missed)
    low = np.where(
        seen > 0.0, start / np.where(seen > 0.0, seen, 1.0), high
    )  # before any detection: as the first
    width = np.where(last == following, 1.0, recall[following] - recall[last])
    precision = low + (high - low) / width * (_RECALLS - recall[last])
    precision = np.where(last < len(right), precision, np.where(recall[-1] == _RECALLS, low, 0.0))
    return float(np.maximum(precision - MIN_PRECISION, 0.0).mean()) / (1.0 - MIN_PRECISION)
