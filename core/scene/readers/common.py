"""Share code between all readers: options, the counts behind a report, the content hash, the limits of a box."""

from __future__ import annotations

import hashlib
import math
import time
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import open_regular
from riglens.core.geometry import Vec3
from riglens.core.reading_time import MAX_BOXES_S, Clock, ReadingTime
from riglens.core.scene.boxes import CLASSES, BoxBatch, DataReport, FrameLabels, Progress
from riglens.core.scene.limits import MAX_FRAMES, one_line, require_few_names
from riglens.core.scene.readers.classes import NO_BOX_CALLED, ClassTable
from riglens.core.scene.statistics import BoxStatistics, BoxTally

MAX_POSITION_M = 1e6
MAX_SIZE_M = 1e3
MAX_YAW_RAD = 1e6
"""Beyond, the digits of a double leave no angle."""
BATCH_BOXES = 4096
"""Approximate number of boxes in a batch where the reader is free to choose."""

ACCEPTED_POSITION = f"a finite number in metres within ±{MAX_POSITION_M:g}"
ACCEPTED_SIZE = f"a number in metres above 0, at most {MAX_SIZE_M:g}"
NUMBERS = ("x", "y", "z", "length", "width", "height", "yaw")
"""The numbers of a box."""
ACCEPTED = {
    **dict.fromkeys(NUMBERS[:3], ACCEPTED_POSITION),
    **dict.fromkeys(NUMBERS[3:6], ACCEPTED_SIZE),
    "yaw": f"a finite number in radians within ±{MAX_YAW_RAD:g}",
}
_HASH_CHUNK = 1 << 20
_SHOWN = 40


@dataclass(frozen=True)
class BoxOptions:
    """Details of a data set that the user may state.

    origin_m: place of the source's origin in the vehicle frame, metres, added to every box; frames: how many
    frames the set holds when empty ones leave no trace in it; is_part: whether it belongs to a larger set, so
    that it may hold no frame; notes: further remarks for the report; is_origin_known: whether the format fixes the
    origin's place; name: in reports, that of the path by default. Raise InputError for numbers out of range.
    """

    origin_m: Vec3
    classes: ClassTable
    frames: int | None = None
    is_part: bool = False
    notes: tuple[str, ...] = ()
    is_origin_known: bool = False
    name: str = ""

    def __post_init__(self) -> None:
        if not all(math.isfinite(value) and abs(value) <= MAX_POSITION_M for value in self.origin_m):
            raise InputError(f"must be three finite numbers in metres (got {self.origin_m})", "origin_m")
        require_frames(self.frames)


@dataclass
class ReadingTally:
    """Counts of one pass; readers add frames, unmapped names and notes, the source counts the boxes.

    sequences: runs of frames that belong together, such as the drives of a data set.
    """

    frames: int = 0
    sequences: int = 1
    boxes: NDArray[np.int64] = field(default_factory=lambda: np.zeros(len(CLASSES), dtype=np.int64))
    unmapped: Counter[str] = field(default_factory=Counter)
    notes: list[str] = field(default_factory=list)
    named: list[FrameLabels] = field(default_factory=list)
    statistics: BoxTally = field(default_factory=BoxTally)

    def name_frames(self, sequence: str, frames: NDArray[np.int64]) -> None:
        """Name the next frames: their sequence, and their numbers within it, (n,)."""
        self.named.append(FrameLabels((sequence,), np.zeros(len(frames), np.int64), frames))

    def miss(self, names: Iterable[str] | Mapping[str, int], where: object) -> None:
        """Count names that belong to no class; raise InputError when there are too many different ones."""
        self.unmapped.update(names)
        require_few_names(self.unmapped, where)


class FileBoxSource(ABC):
    """A BoxSource over files: subclasses stream boxes in the source's frame, this adds origin and counts."""

    def __init__(self, path: Path, options: BoxOptions) -> None:
        self.path = path
        self.options = options
        self.name = options.name or str(path)
        self._report: DataReport | None = None

    @abstractmethod
    def _files(self) -> list[Path]:
        """Return all files that determine the boxes, in a fixed order."""

    @abstractmethod
    def _read(self, tally: ReadingTally, progress: Progress) -> Iterator[BoxBatch]:
        """Stream the boxes in the source's own frame, axes as in the vehicle frame, and fill the tally."""

    @property
    def origin_m(self) -> Vec3:
        """Place of the source's origin in the vehicle frame, metres; the default one unless given."""
        return self.options.origin_m

    @property
    def sort(self) -> str:
        """The sort of source, part of the content hash."""
        return type(self).__name__

    def parts(self) -> Sequence[FileBoxSource]:
        """Return sources over parts of the files, which together hold the same frames; just itself if one."""
        return (self,)

    def merged(self, reports: Sequence[DataReport]) -> DataReport:
        """Return the report of the whole from those of its parts."""
        report = added_up(self.name, self.content_hash, reports)
        return report if self.options.is_part else with_all_frames(report, self.options.frames)

    @cached_property
    def content_hash(self) -> str:
        """SHA-256 (hex) over bytes and relative names of the files, origin, frames and class table."""
        digest = hashlib.sha256(self.sort.encode())
        options = self.options
        origin = [float(value).hex() for value in options.origin_m]
        digest.update(repr((origin, options.frames, list(options.classes.effective().items()))).encode())
        if options.classes.idle():  # they change no box, but a note may be about them
            digest.update(repr(options.classes.idle()).encode())
        with readable(self.path):
            for file in self._files():
                name = b"" if file == self.path else bytes(file.relative_to(self.path))
                digest.update(b"\0" + name + b"\0" + file_digest(file))
        return digest.hexdigest()

    def batches(self, progress: Progress | None = None, clock: Clock = time.monotonic) -> Iterator[BoxBatch]:
        """Stream the boxes once, in the vehicle frame; raise InputError on bad input, or beyond MAX_BOXES_S."""
        tally, taken = (
            ReadingTally(notes=list(self.options.notes)),
            ReadingTime(str(self.path), MAX_BOXES_S, clock),
        )

        def told(share: float) -> None:
            taken.check()
            (progress or _ignore_progress)(share)

        with readable(self.path):
            for batch in self._read(tally, told):
                tally.boxes += np.bincount(batch.cls, minlength=len(CLASSES))
                moved = replace(batch, centre_m=batch.centre_m + np.asarray(self.options.origin_m))
                tally.statistics.add(*_columns(moved))
                taken.pause()
                yield moved
                taken.go_on()
        self._report = self._finish(tally)

    def report(self) -> DataReport:
        """Return the counts of the last complete pass of `batches`; raise RuntimeError before the first one."""
        if self._report is None:
            raise RuntimeError("no complete pass over the boxes yet")
        return self._report

    def _finish(self, tally: ReadingTally) -> DataReport:
        boxes = {name: int(count) for name, count in zip(CLASSES, tally.boxes, strict=True)}
        report = DataReport(
            self.name,
            tally.frames,
            boxes,
            tally.unmapped,
            self.content_hash,
            (*tally.notes, *self.options.classes.never_met()),
            tally.sequences,
            reduce(FrameLabels.joined, tally.named) if tally.named else None,
            tally.statistics.statistics(self.options.origin_m, self.options.is_origin_known),
        )
        return report if self.options.is_part else with_all_frames(report, self.options.frames)


@dataclass(frozen=True)
class BoxFormat:
    """A format of box data.

    name: of the format; title: in the list of formats that are read. recognises: asked with a path that exists; it
    looks at names and first bytes alone. opens: the source at a path, or at each of the `members` of a folder.
    classes: from names in the data, in lower case, to car, bicycle and pedestrian. origin_m: place of the source's
    origin in the vehicle frame, metres, if that is known, and origin_is: what is there ("the rear axle").
    """

    name: str
    title: str
    recognises: Callable[[Path], bool]
    opens: Callable[[Path, BoxOptions], FileBoxSource]
    classes: Mapping[str, str]
    origin_m: Vec3 | None = None
    origin_is: str = ""
    members: Callable[[Path], Sequence[Path]] | None = None


def require_frames(frames: int | None) -> None:
    """Raise InputError for a number of frames, where one is given, that no data set has."""
    if frames is not None and not 1 <= frames <= MAX_FRAMES:
        found = frames if abs(frames) < 1 << 64 else "a very large number"
        raise InputError(f"must be an integer from 1 to {MAX_FRAMES} (got {found})", "frames")


def added_up(name: str, sha256: str, reports: Sequence[DataReport]) -> DataReport:
    """Return one report for several sets of frames; a note that several share appears once.

    A name of the class map that one of them does not know is no news, as long as another does.
    """
    unmapped = Counter[str]()
    for report in reports:
        unmapped.update(report.unmapped)
        require_few_names(unmapped, name)
    return DataReport(
        name,
        sum(report.frames for report in reports),
        {cls: sum(report.boxes[cls] for report in reports) for cls in CLASSES},
        unmapped,
        sha256,
        tuple(dict.fromkeys(note for report in reports for note in report.notes if _holds(note, reports))),
        sum(report.sequences for report in reports),
        _joined_labels(reports),
        BoxStatistics.joined(report.statistics for report in reports),
    )


def _joined_labels(reports: Sequence[DataReport]) -> FrameLabels | None:
    """Return the frame labels of several sets together; None unless all of them have labels."""
    labels = [report.labels for report in reports if report.labels is not None]
    return reduce(FrameLabels.joined, labels) if labels and len(labels) == len(reports) else None


def _holds(note: str, reports: Sequence[DataReport]) -> bool:
    return not note.startswith(NO_BOX_CALLED) or all(note in report.notes for report in reports)


def with_all_frames(report: DataReport, frames: int | None) -> DataReport:
    """Return the report of a whole data set with the number of frames given by the user, if any.

    Raise InputError when there are no frames, or more than that.
    """
    if report.frames == 0:
        raise InputError(f"{report.source}: must hold at least one frame with a box")
    if report.frames > MAX_FRAMES:
        raise InputError(f"{report.source}: must hold at most {MAX_FRAMES} frames (got {report.frames})")
    if frames is not None and frames < report.frames:
        raise InputError(
            f"must be at least {report.frames}, the frames that {report.source} holds (got {frames})",
            "frames",
        )
    return replace(report, frames=frames or report.frames)


@contextmanager
def readable(path: Path) -> Iterator[None]:
    """Turn errors of the operating system into an InputError that names the file."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or one_line(str(error))
        raise InputError(f"{error.filename or path}: cannot be read ({reason})") from error


def shown(text: str) -> str:
    """Return a found value for an error message: quoted, control characters escaped, truncated when long."""
    return repr(text if len(text) <= _SHOWN else text[:_SHOWN] + "…")


def first_bad_number(numbers: NDArray[np.float64]) -> tuple[int, int] | None:
    """Return row and column of the first number that no real box has; numbers (n, k): the first k of NUMBERS."""
    good = np.empty(numbers.shape, bool)
    good[:, :3] = np.abs(numbers[:, :3]) <= MAX_POSITION_M
    good[:, 3:6] = (numbers[:, 3:6] > 0.0) & (numbers[:, 3:6] <= MAX_SIZE_M)
    good[:, 6:] = np.abs(numbers[:, 6:]) <= MAX_YAW_RAD
    if good.all():
        return None
    row, column = np.argwhere(~good)[0].tolist()
    return row, column


def require_boxes(
    centre_m: NDArray[np.float64], size_m: NDArray[np.float64], place: Callable[[int, int], str]
) -> None:
    """Raise InputError for the first number that no real box has; centre and size are (n, 3), metres.

    `place` describes a row and a column, an index into NUMBERS, in messages.
    """
    numbers = np.concatenate([centre_m, size_m], axis=1)
    bad = first_bad_number(numbers)
    if bad is not None:
        raise InputError(f"{place(*bad)}: must be {ACCEPTED[NUMBERS[bad[1]]]} (got {numbers[bad]:g})")


def select(batch: BoxBatch, rows: slice | NDArray[np.intp] | NDArray[np.bool_]) -> BoxBatch:
    """Return the chosen rows of a batch."""
    return BoxBatch(*(column[rows] for column in _columns(batch)))


def join(batches: Sequence[BoxBatch]) -> BoxBatch:
    """Join several batches, at least one."""
    if len(batches) == 1:
        return batches[0]
    return BoxBatch(*(np.concatenate(parts) for parts in zip(*map(_columns, batches), strict=True)))


def whole_frames(frames: NDArray[np.integer[Any]]) -> Iterator[slice]:
    """Yield runs of at least BATCH_BOXES rows, each of whole frames, until none is left; frames (n,) are sorted."""
    start = 0
    while start < frames.size:
        last = min(start + BATCH_BOXES, frames.size) - 1
        end = int(np.searchsorted(frames, frames[last], side="right"))
        yield slice(start, end)
        start = end


def _columns(batch: BoxBatch) -> tuple[NDArray[Any], ...]:
    return batch.frame, batch.cls, batch.centre_m, batch.size_m, batch.rotation


def _ignore_progress(fraction: float) -> None:
    """Ignore progress."""


def file_digest(path: Path) -> bytes:
    """Return the SHA-256 of a file's bytes, read in pieces."""
    digest = hashlib.sha256()
    with open_regular(path, "a file") as file:
        while piece := file.read(_HASH_CHUNK):
            digest.update(piece)
    return digest.digest()
