"""The bundled boxes in memory, repeated until there are as many frames as wanted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from riglens.core.scene.boxes import CLASSES, BoxBatch, DataReport, Progress
from riglens.core.scene.readers.bundled import bundled_source


class CycledBoxes:
    """Yields the frames of the bundled scenario again and again; nothing grows with `frames`."""

    def __init__(self, frames: int) -> None:
        source = bundled_source()
        self._batches = list(source.batches())
        self._cycle = source.report().frames
        self._frames = frames
        self._report = DataReport("repeated town", 0, dict.fromkeys(CLASSES, 0))
        self.name = self._report.source
        self.content_hash = f"{source.content_hash} x {frames}"

    def batches(self, progress: Progress | None = None) -> Iterator[BoxBatch]:
        """Stream the boxes once."""
        boxes = np.zeros(len(CLASSES), np.int64)
        for start in range(0, self._frames, self._cycle):
            for batch in self._batches:
                kept = _until(replace(batch, frame=batch.frame + start), self._frames)
                boxes += np.bincount(kept.cls, minlength=len(CLASSES))
                yield kept
        counts = {name: int(count) for name, count in zip(CLASSES, boxes, strict=True)}
        self._report = replace(self._report, frames=self._frames, boxes=counts)

    def report(self) -> DataReport:
        """Counts of the last complete pass."""
        return self._report


class PickedFrames:
    """Every `step`-th frame of the bundled scenario, for a yardstick that takes a sample."""

    def __init__(self, step: int) -> None:
        source = bundled_source()
        self.batches_ = [_every(batch, step) for batch in source.batches()]
        self.frames = -(-source.report().frames // step)
        self.name = "some frames of the town"
        self.content_hash = f"{source.content_hash} / {step}"

    def batches(self, progress: Progress | None = None) -> Iterator[BoxBatch]:
        """Stream the boxes once."""
        yield from self.batches_

    def report(self) -> DataReport:
        """Frames, without counts of boxes."""
        return DataReport(self.name, self.frames, dict.fromkeys(CLASSES, 0))


def _until(batch: BoxBatch, frames: int) -> BoxBatch:
    """The boxes of frames below `frames`."""
    count = int(np.searchsorted(batch.frame, frames))
    return _rows(batch, np.arange(len(batch.frame)) < count)


def _every(batch: BoxBatch, step: int) -> BoxBatch:
    return _rows(batch, batch.frame % step == 0)


def _rows(batch: BoxBatch, keep: np.ndarray) -> BoxBatch:
    return BoxBatch(*(column[keep] for column in vars(batch).values()))
