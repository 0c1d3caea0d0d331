"""Turn rows of (sequence, frame) into whole frames: number them, never split one over two batches."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.scene.boxes import BoxBatch, FrameLabels
from riglens.core.scene.limits import MAX_SEQUENCES
from riglens.core.scene.readers.common import join, select, shown

MAX_BOXES_PER_FRAME = 1_000_000
"""More than this in one frame is not traffic but a broken table; this bounds the memory."""


_TOO_MANY = f"too many sequences (at most {MAX_SEQUENCES})"


class RowError(Exception):
    """A problem with one row of the current piece of a table; the reader knows which line that is."""

    def __init__(self, row: int, message: str) -> None:
        super().__init__(message)
        self.row = row


class FrameCounter:
    """Counter that numbers the distinct (sequence, frame) pairs of a table grouped by sequence and sorted by frame."""

    def __init__(self) -> None:
        self.count = 0
        self._sequences: dict[str, int] = {}
        self._labels = array("q"), array("q")
        self._last = (-1, -1)

    @property
    def sequences(self) -> int:
        """Number of sequences so far."""
        return len(self._sequences)

    def labels(self) -> FrameLabels:
        """Return the table's labels of the frames so far."""
        sequence, frame = (np.array(held, np.int64) for held in self._labels)
        return FrameLabels(tuple(self._sequences), sequence, frame)

    def number(
        self, names: Sequence[str], codes: NDArray[np.intp], frame: NDArray[np.int64]
    ) -> NDArray[np.int64]:
        """Return the number over the whole data set, (n,), of each row; raise RowError where the order breaks.

        names: sequence names of this piece; codes (n,): index into names; frame (n,): frame in its sequence.
        """
        if frame.size == 0:
            return frame
        sequence = self._sequence_numbers(names, codes)
        before_sequence = np.concatenate([[self._last[0]], sequence[:-1]])
        before_frame = np.concatenate([[self._last[1]], frame[:-1]])
        same = sequence == before_sequence
        wrong = (sequence < before_sequence) | (same & (frame < before_frame))
        if wrong.any():
            row = int(np.argmax(wrong))
            raise RowError(
                row, _disorder(names[codes[row]], int(frame[row]), bool(same[row]), int(before_frame[row]))
            )
        begins = ~same | (frame != before_frame)
        numbers = self.count - 1 + np.cumsum(begins)
        for held, more in zip(self._labels, (sequence, frame), strict=True):
            held.frombytes(more[begins].astype(np.int64).tobytes())
        self.count = int(numbers[-1]) + 1
        self._last = (int(sequence[-1]), int(frame[-1]))
        return numbers.astype(np.int64)

    def _sequence_numbers(self, names: Sequence[str], codes: NDArray[np.intp]) -> NDArray[np.int64]:
        """Return the numbers by first appearance in the table: they fall only where a sequence comes back."""
        used, first = np.unique(codes, return_index=True)
        numbers = np.zeros(len(names), dtype=np.int64)
        for code in used[np.argsort(first)]:
            numbers[code] = self._sequences.setdefault(names[code], len(self._sequences))
            if len(self._sequences) > MAX_SEQUENCES:
                raise RowError(int(first[used == code][0]), _TOO_MANY)
        return numbers[codes]


class WholeFrames:
    """Filter that holds back the last frame of each piece until the next one shows that it is complete."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._pending: list[BoxBatch] = []

    def push(self, batch: BoxBatch, last_frame: int) -> Iterator[BoxBatch]:
        """Take boxes of frames up to `last_frame`, which may continue; yield those of all earlier frames."""
        self._pending.append(batch)
        held = join(self._pending)
        cut = int(np.searchsorted(held.frame, last_frame))
        if held.frame.size - cut > MAX_BOXES_PER_FRAME:
            raise InputError(f"{self._path}: too many boxes in one frame (at most {MAX_BOXES_PER_FRAME})")
        self._pending = [select(held, slice(cut, None))]
        if cut:
            yield select(held, slice(0, cut))

    def flush(self) -> Iterator[BoxBatch]:
        """Yield the rest: nothing follows."""
        held, self._pending = self._pending, []
        if held and held[0].frame.size:
            yield join(held)


def _disorder(sequence: str, frame: int, same: bool, before: int) -> str:
    name = shown(sequence)
    found = f"frame {frame} after frame {before} of sequence {name}" if same else f"sequence {name} again"
    return f"must be a table grouped by seq and sorted by frame (got {found})"
