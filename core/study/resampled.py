"""A box data set with its frames drawn again, with replacement: the bootstrap of the stability study."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from riglens.core.scene.boxes import CLASSES, BoxBatch, BoxSource, DataReport, Progress


@dataclass(frozen=True)
class StoredBoxes:
    """All boxes of a data set in memory, so that it is read once for many resamples."""

    boxes: tuple[BoxBatch, ...]
    data: DataReport

    @classmethod
    def read(cls, source: BoxSource, progress: Progress | None = None) -> StoredBoxes:
        """Read a data set once; InputError on bad input."""
        boxes = tuple(source.batches(progress))
        return cls(boxes, source.report())


class ResampledFrames:
    """As many frames as the data set has, drawn with replacement; frames without boxes are drawn too."""

    def __init__(self, stored: StoredBoxes, seed: int) -> None:
        self._stored, self._seed = stored, seed
        frames = stored.data.frames
        drawn = np.random.default_rng(seed).integers(0, max(frames, 1), frames)
        self.times = np.bincount(drawn, minlength=frames)
        """How often each frame was drawn, (frames,)."""
        self._first = np.concatenate([[0], np.cumsum(self.times)])

    @property
    def name(self) -> str:
        """Name of the data set that was drawn from."""
        return self._stored.data.source

    @property
    def content_hash(self) -> str:
        """Hash of the data set's own and of the draw."""
        return hashlib.sha256(f"{self._stored.data.sha256} {self._seed}".encode()).hexdigest()

    def batches(self, progress: Progress | None = None) -> Iterator[BoxBatch]:
        """The boxes of the frames drawn, each copy of a frame as a frame of its own."""
        for done, batch in enumerate(self._stored.boxes, 1):
            rows, frame = self._copies(batch.frame)
            yield BoxBatch(
                frame, batch.cls[rows], batch.centre_m[rows], batch.size_m[rows], batch.rotation[rows]
            )
            if progress is not None:
                progress(done / len(self._stored.boxes))

    def _copies(self, frame: NDArray[np.int64]) -> tuple[NDArray[np.intp], NDArray[np.int64]]:
        """Which rows to take, as often as their frames were drawn, and the new numbers of their frames."""
        times = self.times[frame]
        rows = np.repeat(np.arange(frame.size), times)
        copy = np.arange(rows.size) - np.repeat(np.cumsum(times) - times, times)
        numbers = self._first[frame[rows]] + copy
        order = np.argsort(numbers, kind="stable")
        return rows[order], numbers[order]

    def report(self) -> DataReport:
        """The data set's report with the boxes of the draw."""
        totals = np.zeros(len(CLASSES), np.int64)
        for batch in self._stored.boxes:
            totals += np.bincount(batch.cls, weights=self.times[batch.frame], minlength=len(CLASSES)).astype(
                int
            )
        boxes = dict(zip(CLASSES, totals.tolist(), strict=True))
        return replace(self._stored.data, boxes=boxes, sha256=self.content_hash)
