"""Boxes of traffic around the car: the streamed batches every reader yields, and the report of what was read."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from riglens.core.scene.statistics import BoxStatistics
from riglens.core.shown_text import visible

CLASSES = ("car", "bicycle", "pedestrian")
Progress = Callable[[float], None]
"""Called with the fraction done, 0 to 1; it may raise to cancel the work."""


@dataclass(frozen=True)
class BoxBatch:
    """A run of boxes in the vehicle frame; a frame never continues in the next batch.

    frame (n,) int64, non-decreasing, numbered over the whole data set; cls (n,) uint8 index into CLASSES;
    centre_m (n, 3); size_m (n, 3) length, width, height; rotation (n, 3, 3) box to vehicle frame.
    """

    frame: NDArray[np.int64]
    cls: NDArray[np.uint8]
    centre_m: NDArray[np.float64]
    size_m: NDArray[np.float64]
    rotation: NDArray[np.float64]


@dataclass(frozen=True)
class FrameLabels:
    """Frame labels of a table: `names` of the sequences, and for each frame (T,) its sequence, an index into `names`,
    and its number within the sequence."""

    names: tuple[str, ...]
    sequence: NDArray[np.int64]
    frame: NDArray[np.int64]

    def of(self, frame: int) -> tuple[str, int]:
        """Return sequence and number of a frame, by its number in the whole data set."""
        return self.names[self.sequence[frame]], int(self.frame[frame])

    def joined(self, more: FrameLabels) -> FrameLabels:
        """Return these frames followed by those of another data set."""
        return FrameLabels(
            self.names + more.names,
            np.concatenate([self.sequence, len(self.names) + more.sequence]),
            np.concatenate([self.frame, more.frame]),
        )


@dataclass(frozen=True)
class DataReport:
    """Contents of a data set: frames T (with and without boxes), boxes per class, and names that were not mapped.

    `notes` are sentences for the user about how the data were read, such as columns that were not used;
    `sequences` counts the runs of frames that belong together (drives, scenes, logs);
    `labels`: what tables call their frames; `statistics`: of the boxes, None where nothing was tallied.
    """

    source: str
    frames: int
    boxes: dict[str, int]
    unmapped: Counter[str] = field(default_factory=Counter)
    sha256: str = ""
    notes: tuple[str, ...] = ()
    sequences: int = 1
    labels: FrameLabels | None = field(default=None, compare=False, repr=False)
    statistics: BoxStatistics | None = field(default=None, compare=False, repr=False)

    @property
    def short_source(self) -> str:
        """The data set's short name to show: that of its file or folder, without the path."""
        return visible(os.path.basename(self.source.rstrip("/")) or self.source)


class BoxSource(Protocol):
    """A box data set that can be streamed any number of times with flat memory."""

    @property
    def name(self) -> str:
        """The data set's name in reports: usually its path."""

    @property
    def content_hash(self) -> str:
        """SHA-256 (hex) over the bytes of the files and the options that change the boxes."""

    def batches(self, progress: Progress | None = None) -> Iterator[BoxBatch]:
        """Stream the boxes once; InputError on bad input."""

    def report(self) -> DataReport:
        """Return the counts of the last complete pass of `batches`."""


def rotations_from_yaw(yaw_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rotation matrices (n, 3, 3) about z from yaw angles (n,) in radians."""
    cos, sin = np.cos(yaw_rad), np.sin(yaw_rad)
    rotation = np.zeros((yaw_rad.size, 3, 3))
    rotation[:, 0, 0], rotation[:, 0, 1] = cos, -sin
    rotation[:, 1, 0], rotation[:, 1, 1] = sin, cos
    rotation[:, 2, 2] = 1.0
    return rotation


def rotations_from_quaternions(wxyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return rotation matrices (n, 3, 3) from quaternions (n, 4) in the order w, x, y, z, of any length."""
    w, x, y, z = (wxyz / np.linalg.norm(wxyz, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows, dtype=np.float64), 2, 0)
