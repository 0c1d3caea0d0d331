"""Recall of a study's detector by the number of LiDAR points on an object: by class and ring of distance, and by rig
and by sequence for a fit with its error on those left out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.precision import Detections, Truth, found_objects
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.detection.pieces import Pieces
from riglens.core.targets.calibration import MATCH_M, MIN_SCORE
from riglens.core.targets.settings import RING_M

POINTS = (0, 1, 2, 3, 5, 10, 20, 50)
"""Least number of points of each row; the last row has no end."""
MOST_POINTS, WITHIN_M = 50, 30.0
"""Limits of tallies: more points are counted as MOST_POINTS; objects beyond WITHIN_M, the reach of the region ahead,
are left out."""
Group = Literal["rig", "sequence"]


@dataclass(frozen=True)
class Recall:
    """Objects of a class with `least` to `most` points (None: no end), in a ring of distance from the vehicle's origin
    (None: in all), and how many of them were found."""

    cls: str
    least: int
    most: int | None
    ring_m: tuple[float, float] | None
    objects: int
    found: int


def recall(judged: Iterable[tuple[Truth, Detections]]) -> Iterator[Recall]:
    """Yield recall over all pairs of objects and detections, class by class, all distances first; rings and rows
    without objects are left out.

    An object is found as `riglens calibrate` counts it: the same least score, the same distance of a match.
    """
    counted: NDArray[np.int64] = np.zeros((2, len(CLASSES), len(POINTS), 1), np.int64)
    for truth, found in judged:
        ring = (np.hypot(*truth.centre_m.T) // RING_M).astype(np.int64)
        row = np.searchsorted(POINTS, truth.points, side="right") - 1
        more = max(0, int(ring.max(initial=0)) + 1 - counted.shape[3])
        counted = np.pad(counted, ((0, 0), (0, 0), (0, 0), (0, more)))
        hit = _hit(truth, found)
        np.add.at(counted[0], (truth.cls, row, ring), 1)
        np.add.at(counted[1], (truth.cls, row, ring), hit)
    for number, name in enumerate(CLASSES):
        yield from _rows(name, None, counted[:, number].sum(axis=2))
        for ring in range(counted.shape[3]):
            yield from _rows(name, (ring * RING_M, (ring + 1) * RING_M), counted[:, number, :, ring])


def _hit(truth: Truth, found: Detections) -> NDArray[np.bool_]:
    """Return which objects are found, (n,)."""
    kept = found.where(found.score >= MIN_SCORE)
    return np.asarray(
        np.any([found_objects(truth, kept, number, MATCH_M) for number in range(len(CLASSES))], axis=0)
    )


@dataclass(frozen=True)
class Tally:
    """Objects of a class within WITHIN_M with `points` LiDAR points (MOST_POINTS: or more) of a rig, or of all rigs in
    a sequence, and how many were found."""

    group: Group
    name: str
    cls: str
    points: int
    objects: int
    found: int


def tallies(
    judged: Iterable[tuple[str, Truth, Detections]], sequences: Sequence[str], sequence: NDArray[np.int64]
) -> Iterator[Tally]:
    """Yield the tallies of rigs by name, then of sequences; sequence (frames,): an index into `sequences` each."""
    shape = 2, len(CLASSES), MOST_POINTS + 1
    rigs: dict[str, NDArray[np.int64]] = {}
    drives = {name: np.zeros(shape, np.int64) for name in sequences}
    for name, truth, found in judged:
        hit, near = _hit(truth, found), np.hypot(*truth.centre_m.T) <= WITHIN_M
        place = truth.cls, np.minimum(truth.points, MOST_POINTS)
        drive = sequence[truth.frame]
        mine = [(rigs.setdefault(name, np.zeros(shape, np.int64)), near)]
        mine += [(held, near & (drive == number)) for number, held in enumerate(drives.values())]
        for held, chosen in mine:
            np.add.at(held[0], tuple(part[chosen] for part in place), 1)
            np.add.at(held[1], tuple(part[chosen] for part in place), hit[chosen])
    groups: dict[Group, dict[str, NDArray[np.int64]]] = {"rig": rigs, "sequence": drives}
    for group, members in groups.items():
        for name, (objects, hits) in members.items():
            for number, points in np.argwhere(objects).tolist():
                of = int(objects[number, points]), int(hits[number, points])
                yield Tally(group, name, CLASSES[number], points, *of)


def _rows(name: str, ring_m: tuple[float, float] | None, counted: NDArray[np.int64]) -> Iterator[Recall]:
    for (least, end), objects, found in zip(pairwise((*POINTS, None)), *counted.tolist(), strict=True):
        if objects:
            yield Recall(name, least or 0, None if end is None else end - 1, ring_m, objects, found)


def recall_of(pieces: Pieces, seeds: int) -> Iterator[Recall]:
    """Yield recall over all rigs of a study and the nets of its first seeds, which must be complete."""
    return recall((truth, found) for _, truth, found in _judged(pieces, seeds))


def tallies_of(pieces: Pieces, seeds: int) -> Iterator[Tally]:
    """Yield the tallies of a study's rigs and sequences by the nets of its first seeds, which must be complete."""
    return tallies(_judged(pieces, seeds), pieces.study.split.sequences, pieces.study.split.sequence)


def _judged(pieces: Pieces, seeds: int) -> Iterator[tuple[str, Truth, Detections]]:
    nets = [net for net in pieces.study.nets if net.seed < seeds]
    return ((one.name, *pieces.judged(net, one)) for net in nets for one in net.judges)
