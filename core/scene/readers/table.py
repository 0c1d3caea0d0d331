"""Box tables: CSV, gzip-compressed CSV and Parquet with the columns of BOX_COLUMNS, streamed frame by frame."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from riglens.core.errors import InputError
from riglens.core.scene.boxes import BoxBatch, Progress, rotations_from_yaw
from riglens.core.scene.readers.classes import UNMAPPED
from riglens.core.scene.readers.common import BoxOptions, FileBoxSource, ReadingTally
from riglens.core.scene.readers.frames import FrameCounter, RowError, WholeFrames
from riglens.core.scene.readers.rows import BOX_COLUMNS, ParquetFile, Rows, check_numbers, open_rows


class TableSource(FileBoxSource):
    """A table of boxes: from checked columns to whole frames."""

    def __init__(self, path: Path, options: BoxOptions) -> None:
        super().__init__(path, options)
        self._file = open_rows(path, BOX_COLUMNS)

    @property
    def sort(self) -> str:
        """The sort of source, part of the content hash."""
        return "ParquetSource" if isinstance(self._file, ParquetFile) else "CsvSource"

    @property
    def unused(self) -> list[str]:
        """Columns that are not used."""
        return self._file.unused

    def _files(self) -> list[Path]:
        return [self.path]

    def _read(self, tally: ReadingTally, progress: Progress) -> Iterator[BoxBatch]:
        if self.unused:
            tally.notes.append(f"columns not used: {', '.join(self.unused)}")
        counter, whole, largest_yaw = FrameCounter(), WholeFrames(self.path), 0.0
        for rows in self._file.pieces(progress):
            try:
                batch, yaw_rad = self._boxes(rows, counter, tally)
            except RowError as error:
                raise InputError(f"{rows.place(error.row)}: {error}") from error
            largest_yaw = max(largest_yaw, yaw_rad)
            tally.frames, tally.sequences = counter.count, counter.sequences
            yield from whole.push(batch, counter.count - 1)
        tally.named = [counter.labels()]
        yield from whole.flush()
        tally.statistics.yaw_rad = largest_yaw
        progress(1.0)

    def _boxes(self, rows: Rows, counter: FrameCounter, tally: ReadingTally) -> tuple[BoxBatch, float]:
        """Return mapped rows as boxes, and the largest yaw of all; raise RowError for a frame out of order or an
        impossible number."""
        every, number, seq, name = rows.numbers, rows.frames(), rows.names("seq"), rows.names("cls")
        frame = counter.number(seq.distinct, seq.codes, number)
        cls = np.asarray(self.options.classes.codes(name.distinct), dtype=np.int64)[name.codes]
        mapped = np.flatnonzero(cls != UNMAPPED)
        missed = np.bincount(name.codes[cls == UNMAPPED], minlength=len(name.distinct))
        tally.miss({text: int(n) for text, n in zip(name.distinct, missed, strict=True) if n}, self.path)
        numbers = every[mapped]
        check_numbers(numbers, mapped)
        batch = BoxBatch(
            frame[mapped],
            cls[mapped].astype(np.uint8),
            numbers[:, 0:3],
            numbers[:, 3:6],
            rotations_from_yaw(numbers[:, 6]),
        )
        return batch, float(np.max(np.abs(every[:, 6]), initial=0.0))
