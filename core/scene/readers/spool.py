"""Boxes that come in any order of frames, held in a temporary file and returned frame by frame."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.scene.boxes import BoxBatch
from riglens.core.scene.readers.common import whole_frames

_ROW = np.dtype([("cls", "u1"), ("centre", "f8", 3), ("size", "f8", 3), ("rotation", "f8", (3, 3))])


class BoxSpool:
    """Store for batches with frames in any order; holds four bytes per box in memory, the rest on disk.

    Raise InputError when the folder of temporary files has no room.
    """

    def __init__(self) -> None:
        with _room():
            self._file = tempfile.TemporaryFile(prefix="riglens-boxes-", buffering=0)  # noqa: SIM115 (see close)
        self._frames: list[NDArray[np.int32]] = []

    def close(self) -> None:
        """Delete the boxes."""
        self._file.close()

    def put(self, batch: BoxBatch) -> None:
        """Take some boxes."""
        rows = np.zeros(batch.frame.size, _ROW)
        rows["cls"], rows["centre"] = batch.cls, batch.centre_m
        rows["size"], rows["rotation"] = batch.size_m, batch.rotation
        with _room():
            self._write(memoryview(rows.tobytes()))
        self._frames.append(batch.frame.astype(np.int32))

    def _write(self, content: memoryview) -> None:
        """Write everything: the unbuffered file takes what fits on the disk and returns the amount."""
        while content:
            content = content[self._file.write(content) :]

    def batches(self) -> Iterator[BoxBatch]:
        """Yield all boxes, sorted by frame; within a frame in the order in which they came."""
        if not self._frames:
            return
        frame = np.concatenate(self._frames)
        order = np.argsort(frame, kind="stable")
        frame = frame[order]
        for run in whole_frames(frame):
            yield self._rows(frame[run], order[run])

    def _rows(self, frame: NDArray[np.int32], rows: NDArray[np.intp]) -> BoxBatch:
        """Return the boxes at these places; the file is mapped again each time, so that its pages do not accumulate."""
        found = np.memmap(self._file, _ROW, "r")[rows]
        return BoxBatch(
            frame.astype(np.int64),
            found["cls"].copy(),
            found["centre"].copy(),
            found["size"].copy(),
            found["rotation"].copy(),
        )


@contextmanager
def _room() -> Iterator[None]:
    """Report a full disk with its folder and a remedy, rather than as an error of the box data."""
    try:
        yield
    except OSError as error:
        folder = f"{tempfile.tempdir}: " if tempfile.tempdir else ""
        raise InputError(
            f"{folder}temporary files cannot be written ({error.strerror}); make room there, or name another folder in "
            "TMPDIR"
        ) from error
