"""Road users of all frames of a data set as arrays, in the order in which frames are sampled."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.scene.boxes import BoxSource, DataReport, Progress
from riglens.core.targets.draws import shuffled

Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]
WITHIN_M = 60.0
MAX_BOXES = 10_000_000
"""About 1.5 GB."""


@dataclass(frozen=True)
class Traffic:
    """Boxes of T frames in the vehicle frame, n of them; frames are shuffled, boxes of a frame keep their order.

    data: what was read. frame (T,): number in the data of each frame held; starts (T + 1,): its first box; row (n,):
    place of each box in the data; cls (n,) uint8 index into CLASSES; centre_m, size_m (n, 3); rotation (n, 3, 3) box
    to vehicle frame. Every box hides what is behind it; those `within_m` of the car, from the vehicle frame's origin
    to the box's centre along the ground, are objects that count.
    """

    data: DataReport
    frame: Ids
    starts: Ids
    row: Ids
    cls: NDArray[np.uint8]
    centre_m: Doubles
    size_m: Doubles
    rotation: NDArray[np.float64]
    within_m: float = WITHIN_M

    @property
    def frames(self) -> int:
        """Number of frames, with and without boxes."""
        return len(self.frame)

    @cached_property
    def distance_m(self) -> Doubles:
        """Distance (n,) from the vehicle frame's origin to each box's centre along the ground."""
        return np.hypot(self.centre_m[:, 0], self.centre_m[:, 1])

    @cached_property
    def counts(self) -> NDArray[np.bool_]:
        """Which boxes are objects that count, (n,)."""
        return np.asarray(self.distance_m <= self.within_m)

    @cached_property
    def frame_of_box(self) -> Ids:
        """Place among `frame` of each box's frame, (n,)."""
        return np.repeat(np.arange(self.frames), np.diff(self.starts))

    def within(self, within_m: float) -> Traffic:
        """The same boxes, of which those within another distance count; raise InputError unless it is above 0."""
        if not 0.0 < within_m <= 1e6:
            raise InputError(
                f"--within: found {within_m:g}, accepted is a distance in metres above 0, at most 1e6"
            )
        return self if within_m == self.within_m else replace(self, within_m=within_m)


def read_traffic(
    source: BoxSource, within_m: float = WITHIN_M, progress: Progress | None = None, most: int = MAX_BOXES
) -> Traffic:
    """Read all boxes of a data set; raise InputError on bad input or more than `most` boxes."""
    columns: list[list[NDArray[Any]]] = [[], [], [], [], []]
    held = 0
    for batch in source.batches(progress):
        held += len(batch.frame)
        if held > most:
            raise InputError(
                f"{source.name}: more than {most:,} boxes, accepted are fewer where single road users are counted"
            )
        parts: tuple[NDArray[Any], ...] = (
            batch.frame,
            batch.cls,
            batch.centre_m,
            batch.size_m,
            batch.rotation,
        )
        for column, part in zip(columns, parts, strict=True):
            column.append(part)
    shapes = ((0,), (0,), (0, 3), (0, 3), (0, 3, 3))
    frame, cls, centre_m, size_m, rotation = (
        np.concatenate([np.zeros(shape), *column]) for shape, column in zip(shapes, columns, strict=True)
    )
    report = source.report()
    return traffic_of(
        report, frame.astype(np.int64), cls.astype(np.uint8), centre_m, size_m, rotation
    ).within(within_m)


def traffic_of(
    data: DataReport,
    frame: Ids,
    cls: NDArray[np.uint8],
    centre_m: Doubles,
    size_m: Doubles,
    rotation: Doubles,
) -> Traffic:
    """Traffic of boxes in the order of the data; frame (n,) non-decreasing, below data.frames."""
    order = shuffled(data.frames)
    number = np.bincount(frame, minlength=data.frames)
    begins = np.concatenate([[0], np.cumsum(number)])
    starts = np.concatenate([[0], np.cumsum(number[order])]).astype(np.int64)
    row = np.repeat(begins[:-1][order] - starts[:-1], number[order]) + np.arange(len(frame))
    return Traffic(data, order, starts, row, cls[row], centre_m[row], size_m[row], rotation[row])
