"""Objects of all frames of a data set as arrays, in the order in which frames are sampled."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.scene.boxes import CLASSES, BoxSource, DataReport, Progress
from riglens.core.scene.occluders import Occluders, StandingBoxes
from riglens.core.targets.draws import shuffled

Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]
WITHIN_M, EVERYWHERE_M = 60.0, 1e6
NO_CLASS = len(CLASSES)
"""Class of boxes that are not objects."""
MAX_BOXES = 10_000_000
"""About 1.5 GB."""


@dataclass(frozen=True, eq=False)
class Traffic:
    """Boxes of T frames in the vehicle frame, n of them; frames are shuffled, boxes of a frame keep their order.

    data: what was read. frame (T,): number in the data of each frame held; starts (T + 1,): its first box; row (n,):
    place of each box in the data; cls (n,) uint8 index into CLASSES; centre_m, size_m (n, 3); rotation (n, 3, 3) box
    to vehicle frame. Occluders have the class NO_CLASS and come after the objects of their
    frame; their `row` is their place in the table of occluders. Every box hides what is behind it; objects
    `within_m` of the car, from the vehicle frame's origin to the box's centre along the ground,
    are objects that count. surroundings_sha256: of the tables of occluders, empty without. Equal only to itself.
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
    surroundings_sha256: str = ""

    @property
    def frames(self) -> int:
        """Number of frames, with and without boxes."""
        return len(self.frame)

    @cached_property
    def distance_m(self) -> Doubles:
        """Distance (n,) from the vehicle frame's origin to each box's centre along the ground."""
        return np.hypot(self.centre_m[:, 0], self.centre_m[:, 1])

    @cached_property
    def half_m(self) -> Doubles:
        """Half the size (n, 3) of each box."""
        return self.size_m / 2.0

    @cached_property
    def counts(self) -> NDArray[np.bool_]:
        """Return which boxes are objects that count, (n,)."""
        return np.asarray((self.distance_m <= self.within_m) & (self.cls != NO_CLASS))

    @cached_property
    def frame_of_box(self) -> Ids:
        """Place among `frame` of each box's frame, (n,)."""
        return np.repeat(np.arange(self.frames), np.diff(self.starts))

    def frames_alone(self, places: Ids) -> Traffic:
        """Return some of the frames, by their places, in that order."""
        lengths = np.diff(self.starts)[places]
        starts = np.concatenate([[0], np.cumsum(lengths)])
        boxes = np.arange(starts[-1]) + np.repeat(self.starts[places] - starts[:-1], lengths)
        columns = {
            name: getattr(self, name)[boxes] for name in ("row", "cls", "centre_m", "size_m", "rotation")
        }
        return replace(self, frame=self.frame[places], starts=starts, **columns)

    def frame_alone(self, place: int) -> Traffic:
        """Return a single frame by its index; all its objects count, at any distance."""
        return replace(self.frames_alone(np.array([place])), within_m=EVERYWHERE_M)

    def within(self, within_m: float) -> Traffic:
        """Return the same boxes, of which those within another distance count; raise InputError unless it is above
        0."""
        require_within(within_m)
        return self if within_m == self.within_m else replace(self, within_m=within_m)


def require_within(within_m: float) -> None:
    """Raise InputError unless a distance within which objects count is above 0."""
    if not 0.0 < within_m <= 1e6:
        raise InputError(f"must be above 0 and at most 1e6 m (got {within_m:g})", "within_m")


def read_traffic(
    source: BoxSource,
    within_m: float = WITHIN_M,
    progress: Progress | None = None,
    most: int = MAX_BOXES,
    occluders: Occluders | None = None,
) -> Traffic:
    """Read all boxes of a data set, and its occluders; raise InputError on bad input or more than `most` boxes."""
    columns: list[list[NDArray[Any]]] = [[], [], [], [], []]
    held = 0
    for batch in source.batches(progress):
        held += len(batch.frame)
        if held > most:
            raise InputError(f"{source.name}: too many boxes to count points per object (at most {most:,})")
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
    boxes = _Boxes(frame.astype(np.int64), cls.astype(np.uint8), centre_m, size_m, rotation)
    standing = None if occluders is None else _standing(report, boxes, occluders, most)
    sha256 = "" if occluders is None else occluders.sha256
    return replace(traffic_of(report, *boxes, standing).within(within_m), surroundings_sha256=sha256)


class _Boxes(NamedTuple):
    """Boxes in the order of the data: frame (n,) non-decreasing, cls (n,), centre_m, size_m (n, 3), rotation."""

    frame: Ids
    cls: NDArray[np.uint8]
    centre_m: Doubles
    size_m: Doubles
    rotation: Doubles


class Standing(NamedTuple):
    """Occluders of all frames: frame (n,) non-decreasing; row (n,) in their table; boxes in the vehicle frame."""

    frame: Ids
    row: Ids
    centre_m: Doubles
    size_m: Doubles
    rotation: Doubles


def _standing(report: DataReport, boxes: _Boxes, occluders: Occluders, most: int) -> Standing:
    """Return the occluders as near as the farthest object, in each frame that has one."""
    if report.labels is None:
        raise InputError(f"{report.source}: needs columns seq and frame, by which occluders are assigned")
    farthest_m = (
        np.hypot(boxes.centre_m[:, 0], boxes.centre_m[:, 1]) + np.linalg.norm(boxes.size_m, axis=1) / 2
    )
    reach_m = float(farthest_m.max(initial=0.0))
    held, found = 0, list[tuple[int, StandingBoxes]]()
    for frame in np.unique(boxes.frame).tolist():
        near = occluders.around(report.labels.of(frame), reach_m)
        found.append((frame, near))
        held += len(near.row)
        if held > most:
            raise InputError(f"{occluders.source}: too many occluders in all frames (at most {most:,})")
    frames = [np.full(len(near.row), frame, np.int64) for frame, near in found]
    return Standing(
        np.concatenate([np.zeros(0, np.int64), *frames]),
        np.concatenate([np.zeros(0, np.int64), *(near.row for _, near in found)]),
        np.concatenate([np.zeros((0, 3)), *(near.centre_m for _, near in found)]),
        np.concatenate([np.zeros((0, 3)), *(near.size_m for _, near in found)]),
        np.concatenate([np.zeros((0, 3, 3)), *(near.rotation for _, near in found)]),
    )


def traffic_of(
    data: DataReport,
    frame: Ids,
    cls: NDArray[np.uint8],
    centre_m: Doubles,
    size_m: Doubles,
    rotation: Doubles,
    standing: Standing | None = None,
) -> Traffic:
    """Make traffic of boxes in the order of the data; frame (n,) non-decreasing, below data.frames."""
    row = np.arange(len(frame))
    if standing is not None:
        count = len(standing.frame)
        row = np.concatenate([row, standing.row])
        cls = np.concatenate([cls, np.full(count, NO_CLASS, np.uint8)])
        frame, centre_m, size_m, rotation = (
            np.concatenate(pair)
            for pair in zip((frame, centre_m, size_m, rotation), (standing.frame, *standing[2:]), strict=True)
        )
    order = shuffled(data.frames)
    place_of = np.empty(data.frames, np.int64)
    place_of[order] = np.arange(data.frames)
    sort = np.argsort(place_of[frame], kind="stable")  # objects of a frame stay before its occluders
    starts = np.concatenate([[0], np.cumsum(np.bincount(place_of[frame], minlength=data.frames))])
    return Traffic(
        data,
        order,
        starts.astype(np.int64),
        row[sort],
        cls[sort],
        centre_m[sort],
        size_m[sort],
        rotation[sort],
    )
