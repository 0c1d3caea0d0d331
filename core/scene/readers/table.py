"""Box tables: CSV, gzip-compressed CSV and Parquet with the columns of NEEDED, streamed frame by frame."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import open_regular
from riglens.core.scene.boxes import BoxBatch, Progress, rotations_from_yaw
from riglens.core.scene.limits import MAX_NAME_CHARS, one_line
from riglens.core.scene.readers.classes import UNMAPPED
from riglens.core.scene.readers.common import (
    BadBox,
    BoxOptions,
    FileBoxSource,
    Tally,
    first_bad_box,
    readable,
)
from riglens.core.scene.readers.csv_rows import (
    ACCEPTED,
    NEEDED,
    NUMBERS,
    CsvParser,
    check_columns,
    header_names,
)
from riglens.core.scene.readers.frames import FrameCounter, RowError, WholeFrames
from riglens.core.scene.readers.parquet_pages import MAX_ROWS, dictionary_columns, require_footer
from riglens.core.scene.readers.text_blocks import TextBlock, text_blocks

PARQUET_MAGIC = b"PAR1"
_PARQUET_ROWS = 1 << 14
_PARQUET_BUFFER_BYTES = 1 << 20
_FULL_TURN_RAD = 2 * math.pi + 0.01


@dataclass(frozen=True)
class Names:
    """A column of names: the distinct ones, and for each row the index of its own."""

    distinct: list[str]
    codes: NDArray[np.intp]


@dataclass(frozen=True)
class Piece:
    """Some rows of a table: `numbers` (n, 7) is as in NUMBERS; `place` describes where in the file a row is."""

    seq: Names
    frame: NDArray[np.int64]
    cls: Names
    numbers: NDArray[np.float64]
    place: Callable[[int], str]


class TableSource(FileBoxSource):
    """What CSV and Parquet share: from checked columns to whole frames of boxes."""

    unused: list[str]

    @abstractmethod
    def _pieces(self, progress: Progress) -> Iterator[Piece]:
        """Stream the rows in the order of the file."""

    def _files(self) -> list[Path]:
        return [self.path]

    def _read(self, tally: Tally, progress: Progress) -> Iterator[BoxBatch]:
        if self.unused:
            tally.notes.append(f"columns not used: {', '.join(self.unused)}")
        counter, whole, largest_yaw = FrameCounter(), WholeFrames(self.path), 0.0
        for piece in self._pieces(progress):
            try:
                batch = self._boxes(piece, counter, tally)
            except RowError as error:
                raise InputError(f"{piece.place(error.row)}: {error}") from error
            largest_yaw = max(largest_yaw, float(np.max(np.abs(piece.numbers[:, 6]), initial=0.0)))
            tally.frames, tally.sequences = counter.count, counter.sequences
            yield from whole.push(batch, counter.count - 1)
        tally.labels = counter.labels()
        yield from whole.flush()
        if largest_yaw > _FULL_TURN_RAD:
            tally.notes.append(f"yaw reaches {largest_yaw:g}, more than a full turn: yaw is taken as radians")
        progress(1.0)

    def _boxes(self, piece: Piece, counter: FrameCounter, tally: Tally) -> BoxBatch:
        """Return mapped rows as boxes; raise RowError for a frame out of order or an impossible number."""
        _check_frames(piece.frame)
        _check_lengths("seq", piece.seq)
        _check_lengths("cls", piece.cls)
        frame = counter.number(piece.seq.distinct, piece.seq.codes, piece.frame)
        cls = np.asarray(self.options.classes.codes(piece.cls.distinct), dtype=np.int64)[piece.cls.codes]
        rows = np.flatnonzero(cls != UNMAPPED)
        missed = np.bincount(piece.cls.codes[cls == UNMAPPED], minlength=len(piece.cls.distinct))
        tally.miss({name: int(n) for name, n in zip(piece.cls.distinct, missed, strict=True) if n}, self.path)
        numbers = piece.numbers[rows]
        _check_numbers(numbers, rows)
        rotation = rotations_from_yaw(numbers[:, 6])
        return BoxBatch(frame[rows], cls[rows].astype(np.uint8), numbers[:, 0:3], numbers[:, 3:6], rotation)


class CsvSource(TableSource):
    """A CSV file, plain or gzip-compressed, with a header line."""

    def __init__(self, path: Path, options: BoxOptions) -> None:
        super().__init__(path, options)
        with readable(path):
            first = next(text_blocks(path, lambda _: None), None)
        if first is None:
            raise InputError(f"{path}: the file is empty, accepted is a table with {','.join(NEEDED)}")
        self._header = header_names(path, first.data.split(b"\n", 1)[0].rstrip(b"\r"))
        self.unused = check_columns(path, self._header)

    def _pieces(self, progress: Progress) -> Iterator[Piece]:
        parser = CsvParser(self.path, self._header)
        for block in text_blocks(self.path, progress):
            rows = _without_header(block)
            if rows.has_lines:
                yield _piece(parser.parse(rows), self._place_in(rows))

    def _place_in(self, block: TextBlock) -> Callable[[int], str]:
        return lambda row: f"{self.path}:{block.lines()[row][0]}"


class ParquetSource(TableSource):
    """A Parquet file; column types are checked when it is opened."""

    def __init__(self, path: Path, options: BoxOptions) -> None:
        super().__init__(path, options)
        with readable(path), _parquet_file(path) as file:
            schema = file.schema_arrow
        self.unused = check_columns(path, list(schema.names))
        for name in NEEDED:
            _check_type(path, name, schema.field(name).type)

    def _pieces(self, progress: Progress) -> Iterator[Piece]:
        with _parquet_file(self.path, as_dictionaries=True) as file:
            total, start = max(1, file.metadata.num_rows), 0
            for batch in file.iter_batches(batch_size=_PARQUET_ROWS, columns=list(NEEDED), use_threads=False):
                place = _row_place(self.path, start)
                _check_no_nulls(batch, place)
                if batch.num_rows:
                    yield _piece(pa.Table.from_batches([batch]), place)
                start += batch.num_rows
                if start > MAX_ROWS:
                    raise InputError(f"{self.path}: more than {MAX_ROWS} rows, accepted are fewer")
                progress(start / total)


def is_parquet(path: Path) -> bool:
    """Return whether the file's first bytes or its name say so."""
    if path.suffix.lower() in (".parquet", ".pq"):
        return True
    with path.open("rb") as file:
        return file.read(len(PARQUET_MAGIC)) == PARQUET_MAGIC


@contextmanager
def _parquet_file(path: Path, as_dictionaries: bool = False) -> Iterator[parquet.ParquetFile]:
    """Yield an open Parquet file; whatever is wrong with its bytes, also later on, becomes an InputError.

    as_dictionaries: check what its pages expand to, and read texts without repeating them.
    """
    try:
        with open_regular(path, "a Parquet table") as raw:
            require_footer(path, raw)
            how = {"buffer_size": _PARQUET_BUFFER_BYTES, "pre_buffer": False}
            with parquet.ParquetFile(path, **how) as file:
                if not as_dictionaries:
                    yield file
                    return
                names = dictionary_columns(path, raw, file.metadata, NEEDED)
            with parquet.ParquetFile(path, read_dictionary=names, **how) as file:
                yield file
    except (pa.ArrowException, MemoryError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: damaged Parquet file ({one_line(str(error), 120)})") from error
    except OSError as error:
        if error.errno is not None:
            raise
        raise InputError(f"{path}: damaged Parquet file ({one_line(str(error), 120)})") from error


def _without_header(block: TextBlock) -> TextBlock:
    """Return the lines of a block that are rows of the table."""
    if block.first_line > 1:
        return block
    return TextBlock(2, block.data.partition(b"\n")[2])


def _row_place(path: Path, start: int) -> Callable[[int], str]:
    return lambda row: f"{path}: row {start + row + 1}"


def _piece(table: pa.Table, place: Callable[[int], str]) -> Piece:
    """Return Arrow columns, checked to be complete, as arrays."""
    numbers = np.column_stack([table[name].cast(pa.float64()).to_numpy() for name in NUMBERS])
    frame = table["frame"].cast(pa.int64()).to_numpy()
    return Piece(_names(table["seq"]), frame, _names(table["cls"]), numbers, place)


def _names(column: pa.ChunkedArray) -> Names:
    if not pa.types.is_dictionary(column.type):
        column = column.cast(pa.string()).dictionary_encode()
    array = column.unify_dictionaries().combine_chunks()
    used, codes = np.unique(array.indices.to_numpy(), return_inverse=True)
    distinct = [str(name) for name in array.dictionary.take(pa.array(used)).to_pylist()]
    return Names(distinct, codes.astype(np.intp))


def _check_type(path: Path, name: str, kind: pa.DataType) -> None:
    """Raise InputError when a Parquet column cannot hold what is needed."""
    value = kind.value_type if pa.types.is_dictionary(kind) else kind
    text = pa.types.is_string(value) or pa.types.is_large_string(value)
    whole = pa.types.is_integer(kind)
    if name in ("seq", "cls"):
        good, accepted = text or whole, "text"
    elif name == "frame":
        good, accepted = whole, "whole numbers"
    else:
        good, accepted = whole or pa.types.is_floating(kind) or pa.types.is_decimal(kind), "numbers"
    if not good:
        raise InputError(
            f"{path}: column {name!r}: found type {one_line(str(kind), 60)}, accepted are {accepted}"
        )


def _check_no_nulls(batch: pa.RecordBatch, place: Callable[[int], str]) -> None:
    for name in NEEDED:
        column = batch.column(name)
        if column.null_count:
            row = int(np.argmax(column.is_null().to_numpy(zero_copy_only=False)))
            raise InputError(
                f"{place(row)}: column {name!r}: found no value, accepted is {ACCEPTED.get(name, 'a name')}"
            )


def _check_frames(frame: NDArray[np.int64]) -> None:
    if frame.size and frame.min() < 0:
        row = int(np.argmax(frame < 0))
        raise RowError(row, f"column 'frame': found {frame[row]}, accepted is {ACCEPTED['frame']}")


def _check_lengths(column: str, names: Names) -> None:
    for code, name in enumerate(names.distinct):
        if len(name) > MAX_NAME_CHARS:
            row = int(np.argmax(names.codes == code))
            found = f"column {column!r}: found {len(name)} characters"
            raise RowError(row, f"{found}, accepted is a name of at most {MAX_NAME_CHARS}")


def _check_numbers(numbers: NDArray[np.float64], rows: NDArray[np.intp]) -> None:
    """Raise RowError for the first mapped row with an impossible number; `rows`: their places in the piece."""
    bad = first_bad_box(numbers[:, 0:3], numbers[:, 3:6])
    wild = np.flatnonzero(~np.isfinite(numbers[:, 6]))
    if wild.size and (bad is None or wild[0] < bad.row):
        bad = BadBox(int(wild[0]), NUMBERS.index("yaw"), float(numbers[wild[0], 6]))
    if bad is not None:
        name = NUMBERS[bad.column]
        raise RowError(
            int(rows[bad.row]), f"column {name!r}: found {bad.value:g}, accepted is {ACCEPTED[name]}"
        )
