"""Rows of a table file with known columns: CSV, gzip-compressed CSV and Parquet, streamed and complete."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO, Literal

import numpy as np
import pyarrow as pa
import pyarrow.parquet as parquet
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import open_regular
from riglens.core.scene.boxes import Progress
from riglens.core.scene.limits import MAX_NAME_CHARS, one_line
from riglens.core.scene.readers.common import NUMBERS, first_bad_number, readable
from riglens.core.scene.readers.csv_rows import ACCEPTED_IN, Columns, CsvParser
from riglens.core.scene.readers.frames import RowError
from riglens.core.scene.readers.text_blocks import TextBlock, text_blocks

PARQUET_MAGIC = b"PAR1"
MAX_ROWS = 1_000_000_000
MAX_FOOTER_BYTES = 1 << 25
_PARQUET_ROWS = 1 << 14
_PARQUET_BUFFER_BYTES = 1 << 20
TypeName = Literal["text", "text or integers", "integers", "numbers"]


@dataclass(frozen=True)
class Names:
    """Column of names: the distinct ones, and for each row the index of its name."""

    distinct: list[str]
    codes: NDArray[np.intp]


@dataclass(frozen=True)
class Rows:
    """Some rows of a table: names by column, `frame` (n,) where the table has one, numbers (n, k) in the order of the
    columns; `place` describes where in the file a row is."""

    texts: Mapping[str, Names]
    frame: NDArray[np.int64]
    numbers: NDArray[np.float64]
    place: Callable[[int], str]

    @classmethod
    def of(cls, table: pa.Table, columns: Columns, place: Callable[[int], str]) -> Rows:
        """Take Arrow columns, checked to be complete; raise ArrowInvalid for what does not fit into the arrays."""
        numbers = np.column_stack([table[name].cast(pa.float64()).to_numpy() for name in columns.numbers])
        frame = table["frame"].cast(pa.int64()).to_numpy() if "frame" in columns.needed else _NO_FRAMES
        return cls({name: _names(table[name]) for name in columns.texts}, frame, numbers, place)

    def names(self, column: str) -> Names:
        """Return a column of names; raise RowError when one is too long."""
        names = self.texts[column]
        for code, name in enumerate(names.distinct):
            if len(name) > MAX_NAME_CHARS:
                row = int(np.argmax(names.codes == code))
                raise RowError(
                    row,
                    f"column {column!r}: names must be at most {MAX_NAME_CHARS} characters (got {len(name)})",
                )
        return names

    def frames(self) -> NDArray[np.int64]:
        """Return the column `frame`, (n,); raise RowError when one is below 0."""
        if self.frame.size and self.frame.min() < 0:
            row = int(np.argmax(self.frame < 0))
            raise RowError(row, f"column 'frame': must be {ACCEPTED_IN['frame']} (got {self.frame[row]})")
        return self.frame


_NO_FRAMES = np.zeros(0, np.int64)


def _names(column: pa.ChunkedArray) -> Names:
    if not pa.types.is_dictionary(column.type):
        column = column.cast(pa.string()).dictionary_encode()
    array = column.unify_dictionaries().combine_chunks()
    distinct = [str(name) for name in array.dictionary.to_pylist()]
    return Names(distinct, array.indices.to_numpy().astype(np.intp))


class RowFile(ABC):
    """A table file; its columns are checked when it is opened. unused: columns that nothing needs."""

    unused: list[str]

    def __init__(self, path: Path, columns: Columns) -> None:
        self.path, self.columns = path, columns

    @abstractmethod
    def pieces(self, progress: Progress) -> Iterator[Rows]:
        """Stream the rows in the order of the file; raise InputError on bad input."""


class CsvFile(RowFile):
    """A CSV file, plain or gzip-compressed, with a header line."""

    def __init__(self, path: Path, columns: Columns) -> None:
        super().__init__(path, columns)
        with readable(path):
            first = next(text_blocks(path, lambda _: None), None)
        if first is None:
            raise InputError(f"{path}: the file is empty (a table needs {columns.listed})")
        self._header = columns.header(path, first.data.split(b"\n", 1)[0].rstrip(b"\r"))
        self.unused = columns.unused(path, self._header)

    def pieces(self, progress: Progress) -> Iterator[Rows]:
        """Stream the rows block by block."""
        parser = CsvParser(self.path, self._header, self.columns)
        for block in text_blocks(self.path, progress):
            rows = _without_header(block)
            if rows.has_lines:
                yield Rows.of(parser.parse(rows), self.columns, self._place_in(rows))

    def _place_in(self, block: TextBlock) -> Callable[[int], str]:
        return lambda row: f"{self.path}:{block.lines()[row][0]}"


class ParquetFile(RowFile):
    """A Parquet file; column types are checked when it is opened."""

    def __init__(self, path: Path, columns: Columns) -> None:
        super().__init__(path, columns)
        with readable(path), _parquet_file(path) as file:
            schema = file.schema_arrow
        self.unused = columns.unused(path, list(schema.names))
        for name in columns.needed:
            kind: TypeName = "integers" if name == "frame" else "numbers"
            kind = "text or integers" if name in columns.texts else kind
            require_type(path, schema.field(name), kind)
        self._dictionaries = self._text_dictionaries()

    def pieces(self, progress: Progress) -> Iterator[Rows]:
        """Stream the rows batch by batch."""
        with _parquet_file(self.path, self._dictionaries) as file:
            total, start = max(1, file.metadata.num_rows), 0
            for batch in file.iter_batches(
                batch_size=_PARQUET_ROWS, columns=list(self.columns.needed), use_threads=False
            ):
                place = _row_place(self.path, start)
                self._check_no_nulls(batch, place)
                if batch.num_rows:
                    yield Rows.of(pa.Table.from_batches([batch]), self.columns, place)
                start += batch.num_rows
                if start > MAX_ROWS:
                    raise InputError(f"{self.path}: a table must have at most {MAX_ROWS} rows")
                progress(start / total)

    def _text_dictionaries(self) -> tuple[str, ...]:
        """Return the columns to read as dictionaries, so that texts are not repeated for each row.

        Arrow cannot do so for some encodings, and says it only while reading; its accessors of a column's metadata end
        the process for damaged files.
        """
        texts = self.columns.texts
        try:
            with _parquet_file(self.path, texts) as file:
                next(file.iter_batches(batch_size=1, columns=list(texts), use_threads=False), None)
        except InputError:
            return ()
        return tuple(texts)

    def _check_no_nulls(self, batch: pa.RecordBatch, place: Callable[[int], str]) -> None:
        for name in self.columns.needed:
            column = batch.column(name)
            if column.null_count:
                row = int(np.argmax(column.is_null().to_numpy(zero_copy_only=False)))
                raise InputError(
                    f"{place(row)}: column {name!r}: must be {ACCEPTED_IN.get(name, 'a name')} (got nothing)"
                )


def require_type(path: Path, column: pa.Field, accepted: TypeName) -> None:
    """Raise InputError unless a column has one of these types; integers are numbers, too."""
    kind = column.type
    value = kind.value_type if pa.types.is_dictionary(kind) else kind
    good = pa.types.is_integer(kind) and accepted != "text"
    if accepted.startswith("text"):
        good |= pa.types.is_string(value) or pa.types.is_large_string(value)
    elif accepted == "numbers":
        good |= pa.types.is_floating(kind) or pa.types.is_decimal(kind)
    if not good:
        raise InputError(
            f"{path}: column {column.name!r}: must be {accepted} (got type {one_line(str(kind), 60)})"
        )


def open_rows(path: Path, columns: Columns) -> RowFile:
    """Open a table file, of whichever kind; raise InputError when it lacks one of these columns."""
    with readable(path):
        return ParquetFile(path, columns) if is_parquet(path) else CsvFile(path, columns)


def is_parquet(path: Path) -> bool:
    """Return whether a file is a Parquet file, by its first bytes or its name."""
    if path.suffix.lower() in (".parquet", ".pq"):
        return True
    with open_regular(path, "a table") as file:
        return file.read(len(PARQUET_MAGIC)) == PARQUET_MAGIC


@contextmanager
def _parquet_file(path: Path, dictionaries: Sequence[str] = ()) -> Iterator[parquet.ParquetFile]:
    """Yield an open Parquet file; any damage, even if found later, becomes an InputError."""
    try:
        with open_regular(path, "a Parquet table") as raw:
            _require_footer(path, raw)
        with parquet.ParquetFile(
            path, read_dictionary=list(dictionaries), buffer_size=_PARQUET_BUFFER_BYTES, pre_buffer=False
        ) as file:
            yield file
    except (pa.ArrowException, MemoryError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: damaged Parquet file ({one_line(str(error), 120)})") from error
    except OSError as error:
        if error.errno is not None:
            raise
        raise InputError(f"{path}: damaged Parquet file ({one_line(str(error), 120)})") from error


def _require_footer(path: Path, file: BinaryIO) -> None:
    """Raise InputError when the description at the end of the file is larger than that of any table."""
    size = file.seek(0, os.SEEK_END)
    file.seek(max(0, size - 8))
    length = int.from_bytes(file.read(8)[:4], "little")
    if length > MAX_FOOTER_BYTES:
        raise InputError(f"{path}: the footer must have at most {MAX_FOOTER_BYTES} bytes (got {length})")


def _without_header(block: TextBlock) -> TextBlock:
    """Return the lines of a block that are rows of the table."""
    if block.first_line > 1:
        return block
    return TextBlock(2, block.data.partition(b"\n")[2])


def _row_place(path: Path, start: int) -> Callable[[int], str]:
    return lambda row: f"{path}: row {start + row + 1}"


def check_numbers(numbers: NDArray[np.float64], rows: NDArray[np.intp]) -> None:
    """Raise RowError for the first mapped row with an impossible number; `rows`: their places in the piece."""
    bad = first_bad_number(numbers)
    if bad is not None:
        name = NUMBERS[bad[1]]
        raise RowError(
            int(rows[bad[0]]), f"column {name!r}: must be {ACCEPTED_IN[name]} (got {numbers[bad]:g})"
        )
