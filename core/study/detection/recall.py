"""Recall of a study's detector by the number of LiDAR points on an object, by class and ring of distance."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.precision import Detections, Truth, found_objects
from riglens.core.scene.boxes import CLASSES
from riglens.core.study.detection.pieces import Pieces
from riglens.core.targets.calibration import MATCH_M, MIN_SCORE
from riglens.core.targets.settings import RING_M

POINTS = (0, 1, 2, 3, 5, 10, 20, 50)
"""Least number of points of each row; the last row has no end."""


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
        kept = found.where(found.score >= MIN_SCORE)
        hit = np.zeros(len(ring), np.bool_)
        for number in range(len(CLASSES)):
            hit |= found_objects(truth, kept, number, MATCH_M)
        np.add.at(counted[0], (truth.cls, row, ring), 1)
        np.add.at(counted[1], (truth.cls, row, ring), hit)
    for number, name in enumerate(CLASSES):
        yield from _rows(name, None, counted[:, number].sum(axis=2))
        for ring in range(counted.shape[3]):
            yield from _rows(name, (ring * RING_M, (ring + 1) * RING_M), counted[:, number, :, ring])


def _rows(name: str, ring_m: tuple[float, float] | None, counted: NDArray[np.int64]) -> Iterator[Recall]:
    for (least, end), objects, found in zip(pairwise((*POINTS, None)), *counted.tolist(), strict=True):
        if objects:
            yield Recall(name, least or 0, None if end is None else end - 1, ring_m, objects, found)


def recall_of(pieces: Pieces, seeds: int) -> Iterator[Recall]:
    """Yield recall over all rigs of a study and the nets of its first seeds, which must be complete."""
    nets = [net for net in pieces.study.nets if net.seed < seeds]
    return recall(pieces.judged(net, one) for net in nets for one in net.judges)
