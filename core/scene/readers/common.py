"""What all readers share: options, the counts behind a report, the content hash, the limits of a box."""

from __future__ import annotations

import hashlib
import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.errors import InputError
from core.geometry import Vec3
from core.scene.boxes import CLASSES, BoxBatch, DataReport, Progress
from core.scene.readers.classes import ClassTable

MAX_POSITION_M = 1e6
MAX_SIZE_M = 1e3
ACCEPTED_POSITION = f"a finite number in metres within ±{MAX_POSITION_M:g}"
ACCEPTED_SIZE = f"a number in metres above 0, at most {MAX_SIZE_M:g}"
ACCEPTED_ANGLE = "a finite number in radians"
_HASH_CHUNK = 1 << 20
_SHOWN = 40


@dataclass(frozen=True)
class BoxOptions:
    """What the user may say about a data set.

    origin_m: place of the source's origin in the vehicle frame, metres, added to every box; frames: how many
    frames the set holds when empty ones leave no trace in it. Raises InputError for numbers out of range.
    """

    origin_m: Vec3
    classes: ClassTable
    frames: int | None = None

    def __post_init__(self) -> None:
        if not all(math.isfinite(value) and abs(value) <= MAX_POSITION_M for value in self.origin_m):
            raise InputError(f"origin: found {self.origin_m}, accepted are three finite numbers in metres")
        if self.frames is not None and self.frames < 1:
            raise InputError(f"frames: found {self.frames}, accepted is a whole number of at least 1")


@dataclass
class Tally:
    """Counts of one pass; readers add frames, unmapped names and notes, the source counts the boxes."""

    frames: int = 0
    boxes: NDArray[np.int64] = field(default_factory=lambda: np.zeros(len(CLASSES), dtype=np.int64))
    unmapped: Counter[str] = field(default_factory=Counter)
    notes: list[str] = field(default_factory=list)


class FileBoxSource(ABC):
    """A BoxSource over files: subclasses stream boxes in the source's frame, this adds origin and counts."""

    def __init__(self, path: Path, options: BoxOptions) -> None:
        self.path = path
        self.options = options
        self._report: DataReport | None = None

    @abstractmethod
    def _files(self) -> list[Path]:
        """All files that decide about the boxes, in a fixed order."""

    @abstractmethod
    def _read(self, tally: Tally, progress: Progress) -> Iterator[BoxBatch]:
        """Stream the boxes in the source's own frame, axes as in the vehicle frame, and fill the tally."""

    @cached_property
    def content_hash(self) -> str:
        """SHA-256 (hex) over bytes and relative names of the files, origin, frames and class table."""
        digest = hashlib.sha256(type(self).__name__.encode())
        options = self.options
        origin = [float(value).hex() for value in options.origin_m]
        digest.update(repr((origin, options.frames, list(options.classes.effective().items()))).encode())
        with readable(self.path):
            for file in self._files():
                name = b"" if file == self.path else bytes(file.relative_to(self.path))
                digest.update(b"\0" + name + b"\0" + _file_digest(file))
        return digest.hexdigest()

    def batches(self, progress: Progress | None = None) -> Iterator[BoxBatch]:
        """Stream the boxes once, in the vehicle frame; InputError on bad input."""
        tally = Tally()
        with readable(self.path):
            for batch in self._read(tally, progress or _ignore_progress):
                tally.boxes += np.bincount(batch.cls, minlength=len(CLASSES))
                yield replace(batch, centre_m=batch.centre_m + np.asarray(self.options.origin_m))
        self._report = self._finish(tally)

    def report(self) -> DataReport:
        """Counts of the last complete pass of `batches`; RuntimeError before the first one."""
        if self._report is None:
            raise RuntimeError("no complete pass over the boxes yet")
        return self._report

    def _finish(self, tally: Tally) -> DataReport:
        if tally.frames == 0:
            raise InputError(f"{self.path}: found no boxes, accepted is a data set with at least one frame")
        wanted = self.options.frames
        if wanted is not None and wanted < tally.frames:
            raise InputError(
                f"{self.path}: frames: found {wanted}, but the data hold {tally.frames} frames already"
            )
        boxes = {name: int(count) for name, count in zip(CLASSES, tally.boxes, strict=True)}
        frames = wanted or tally.frames
        return DataReport(
            str(self.path), frames, boxes, tally.unmapped, self.content_hash, tuple(tally.notes)
        )


@contextmanager
def readable(path: Path) -> Iterator[None]:
    """Turn what the operating system refuses into an InputError that names the file."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or one_line(str(error))
        raise InputError(f"{error.filename or path}: cannot be read ({reason})") from error


def one_line(text: str, limit: int = 200) -> str:
    """Foreign text as one line of at most `limit` characters."""
    return " ".join(text.split())[:limit]


def shown(text: str) -> str:
    """A found value for an error message: quoted, control characters escaped, cut when long."""
    return repr(text if len(text) <= _SHOWN else text[:_SHOWN] + "…")


@dataclass(frozen=True)
class BadBox:
    """The first unsound number of an array of boxes; column counts in x, y, z, length, width, height."""

    row: int
    column: int
    value: float


def first_bad_box(centre_m: NDArray[np.float64], size_m: NDArray[np.float64]) -> BadBox | None:
    """The first number that no real box has; centre and size are (n, 3), metres."""
    good_centre = np.abs(centre_m) <= MAX_POSITION_M
    good_size = (size_m > 0.0) & (size_m <= MAX_SIZE_M)
    bad = ~np.concatenate([good_centre, good_size], axis=1)
    if not bad.any():
        return None
    row, column = (int(index) for index in np.argwhere(bad)[0])
    value = np.concatenate([centre_m[row], size_m[row]])[column]
    return BadBox(row, column, float(value))


def accepted_number(column: int) -> str:
    """What is accepted in a column of `first_bad_box`."""
    return ACCEPTED_POSITION if column < 3 else ACCEPTED_SIZE


def select(batch: BoxBatch, rows: slice | NDArray[np.intp] | NDArray[np.bool_]) -> BoxBatch:
    """The chosen rows of a batch."""
    return BoxBatch(*(column[rows] for column in _columns(batch)))


def join(batches: Sequence[BoxBatch]) -> BoxBatch:
    """Several batches, at least one, as one."""
    if len(batches) == 1:
        return batches[0]
    return BoxBatch(*(np.concatenate(parts) for parts in zip(*map(_columns, batches), strict=True)))


def _columns(batch: BoxBatch) -> tuple[NDArray[Any], ...]:
    return batch.frame, batch.cls, batch.centre_m, batch.size_m, batch.rotation


def _ignore_progress(fraction: float) -> None:
    """Progress of nobody's interest."""


def _file_digest(path: Path) -> bytes:
    """SHA-256 of a file's bytes, read in pieces."""
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while piece := file.read(_HASH_CHUNK):
            digest.update(piece)
    return digest.digest()
