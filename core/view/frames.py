"""The boxes of single frames of a streamed data set, kept in a bounded store once they have been read."""

from __future__ import annotations

import tempfile
from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import Cancelled
from riglens.core.scene.boxes import BoxBatch, BoxSource

REACH_M = 250.0
"""Boxes farther away than this are not kept: no sensor shows them."""
MEMORY_BYTES = 4 << 20
"""Memory limit beyond which frames go to a temporary file."""
MAX_BOXES = 10_000_000
_RECORD = np.dtype([("cls", "u1"), ("centre", "f4", 3), ("size", "f4", 3), ("rotation", "f4", (3, 3))])


@dataclass(frozen=True)
class FrameBoxes:
    """Boxes of one frame in the vehicle frame, n of them.

    cls (n,) uint8 index into CLASSES; centre_m (n, 3); size_m (n, 3) length, width, height; rotation (n, 3, 3)
    box to vehicle frame.
    """

    cls: NDArray[np.uint8]
    centre_m: NDArray[np.float64]
    size_m: NDArray[np.float64]
    rotation: NDArray[np.float64]

    @classmethod
    def none(cls) -> FrameBoxes:
        """Return a frame without boxes."""
        return cls(np.zeros(0, np.uint8), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3, 3)))

    def only(self, number: int) -> FrameBoxes:
        """Return a single box."""
        one = slice(number, number + 1)
        return FrameBoxes(self.cls[one], self.centre_m[one], self.size_m[one], self.rotation[one])


class FrameStore:
    """Frames of a source by number. The source is streamed up to the requested frame, and only once.

    Called by one thread; `close` gives the file handles back.
    """

    def __init__(self, source: BoxSource, max_boxes: int = MAX_BOXES) -> None:
        self._batches: Iterator[BoxBatch] | None = source.batches()
        self._max_boxes = max_boxes
        self._starts = array("q", [0])
        self._file = tempfile.SpooledTemporaryFile(max_size=MEMORY_BYTES)  # noqa: SIM115

    @property
    def frames_read(self) -> int:
        """Return the number of frames, from the first on, whose boxes are kept."""
        return len(self._starts) - 1

    @property
    def is_full(self) -> bool:
        """Return whether the store holds as many boxes as it may, so that later frames cannot be shown."""
        return self._starts[-1] >= self._max_boxes

    def boxes(self, frame: int, cancel: Callable[[], bool] = lambda: False) -> FrameBoxes:
        """Return the boxes of a frame; raise Cancelled as soon as `cancel` returns True.

        A frame that the data do not mention has no boxes, nor has one beyond a full store (see `is_full`). Raises
        InputError when the data are unsound.
        """
        while self.frames_read <= frame and self._batches is not None and not self.is_full:
            if cancel():
                raise Cancelled
            self._read_on(self._batches)
        return self._stored(frame) if frame < self.frames_read else FrameBoxes.none()

    def close(self) -> None:
        """Stop reading and forget all frames."""
        self._batches = None
        self._file.close()

    def _read_on(self, batches: Iterator[BoxBatch]) -> None:
        batch = next(batches, None)
        if batch is None:
            self._batches = None
        elif len(batch.frame):
            self._keep(batch)

    def _keep(self, batch: BoxBatch) -> None:
        near = np.linalg.norm(batch.centre_m, axis=1) <= REACH_M
        records = np.empty(np.count_nonzero(near), _RECORD)
        records["cls"], records["centre"] = batch.cls[near], batch.centre_m[near]
        records["size"], records["rotation"] = batch.size_m[near], batch.rotation[near]
        new_frames = int(batch.frame[-1]) + 1 - self.frames_read
        counts = np.bincount(batch.frame[near] - self.frames_read, minlength=new_frames)
        self._file.seek(0, 2)
        self._file.write(records.tobytes())
        self._starts.extend((self._starts[-1] + np.cumsum(counts)).tolist())

    def _stored(self, frame: int) -> FrameBoxes:
        start, end = self._starts[frame], self._starts[frame + 1]
        self._file.seek(start * _RECORD.itemsize)
        records = np.frombuffer(self._file.read((end - start) * _RECORD.itemsize), _RECORD)
        return FrameBoxes(
            records["cls"].copy(),
            records["centre"].astype(np.float64),
            records["size"].astype(np.float64),
            records["rotation"].astype(np.float64),
        )
