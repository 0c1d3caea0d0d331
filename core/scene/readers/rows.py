"""Rows of a table file with known columns: CSV, gzip-compressed CSV and Parquet, streamed and complete."""

from __future__ import annotations

import csv
import math
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import BinaryIO, Literal

import numpy as np
import pyarrow as pa
import pyarrow.csv as arrow_csv
import pyarrow.parquet as parquet
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import open_regular, read_csv
from riglens.core.scene.boxes import Progress
from riglens.core.scene.limits import MAX_NAME_CHARS, one_line
from riglens.core.scene.readers.common import ACCEPTED, NUMBERS, first_bad_number, readable, shown
from riglens.core.scene.readers.frames import RowError
from riglens.core.scene.readers.text_blocks import TextBlock, text_blocks

PARQUET_MAGIC = b"PAR1"
MAX_ROWS = 1_000_000_000
MAX_FOOTER_BYTES = 1 << 25
_PARQUET_ROWS = 1 << 14
_PARQUET_BUFFER_BYTES = 1 << 20
TypeName = Literal["text", "text or integers", "integers", "numbers"]


ACCEPTED_IN = {"frame": "an integer ≥ 0", **ACCEPTED}
"""Accepted values by column."""


@dataclass(frozen=True)
class TableColumns:
    """The columns that a kind of table has, in the order of messages; `frame` holds integers, those of
    `texts` names, all others numbers."""

    needed: tuple[str, ...]
    texts: tuple[str, ...]

    @property
    def listed(self) -> str:
        """The header line."""
        return ",".join(self.needed)

    @property
    def numbers(self) -> tuple[str, ...]:
        """The columns of numbers that need not be whole."""
        return tuple(name for name in self.needed if name in NUMBERS)

    @cached_property
    def types(self) -> Mapping[str, pa.DataType]:
        """Return the type that each column is read as."""
        texts = dict.fromkeys(self.texts, pa.dictionary(pa.int32(), pa.string()))
        return dict.fromkeys(self.needed, pa.float64()) | {"frame": pa.int64()} | texts

    def unused(self, path: Path, names: Sequence[str]) -> list[str]:
        """Return the columns that are not used; raise InputError when a needed one is missing or duplicated."""
        for name in self.needed:
            if names.count(name) > 1:
                raise InputError(f"{path}: column {name!r} must appear once (got {names.count(name)} times)")
        missing = [name for name in self.needed if name not in names]
        if missing:
            which = "columns" if len(missing) > 1 else "column"
            listed = ", ".join(map(repr, missing))
            raise InputError(f"{path}: {which} {listed} missing (a table needs {self.listed})")
        return [name for name in names if name not in self.needed]

    def header(self, path: Path, line: bytes) -> list[str]:
        """Return the column names of a CSV header line; raise InputError when it is not text."""
        try:
            names = next(csv.reader([line.decode("utf-8-sig")], strict=True), [])
        except (UnicodeDecodeError, csv.Error) as error:
            raise InputError(f"{path}:1: must be a CSV header with {self.listed}") from error
        return [name.strip() for name in names]


BOX_COLUMNS = TableColumns(("seq", "frame", "cls", *NUMBERS), ("seq", "cls"))


@dataclass(frozen=True)
class NameColumn:
    """Column of names: the distinct ones, and for each row the index of its name."""

    distinct: list[str]
    codes: NDArray[np.intp]


@dataclass(frozen=True)
class Rows:
    """Some rows of a table: names by column, `frame` (n,) where the table has one, numbers (n, k) in the order of the
    columns; `place` describes where in the file a row is."""

    texts: Mapping[str, NameColumn]
    frame: NDArray[np.int64]
    numbers: NDArray[np.float64]
    place: Callable[[int], str]

    @classmethod
    def of(cls, table: pa.Table, columns: TableColumns, place: Callable[[int], str]) -> Rows:
        """Take Arrow columns, checked to be complete; raise ArrowInvalid for what does not fit into the arrays."""
        numbers = np.column_stack([table[name].cast(pa.float64()).to_numpy() for name in columns.numbers])
        frame = table["frame"].cast(pa.int64()).to_numpy() if "frame" in columns.needed else _NO_FRAMES
        return cls({name: _names(table[name]) for name in columns.texts}, frame, numbers, place)

    def names(self, column: str) -> NameColumn:
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


def _names(column: pa.ChunkedArray) -> NameColumn:
    if not pa.types.is_dictionary(column.type):
        column = column.cast(pa.string()).dictionary_encode()
    array = column.unify_dictionaries().combine_chunks()
    distinct = [str(name) for name in array.dictionary.to_pylist()]
    return NameColumn(distinct, array.indices.to_numpy().astype(np.intp))


class RowFile(ABC):
    """A table file; its columns are checked when it is opened. unused: columns that nothing needs."""

    unused: list[str]

    def __init__(self, path: Path, columns: TableColumns) -> None:
        self.path, self.columns = path, columns

    @abstractmethod
    def pieces(self, progress: Progress) -> Iterator[Rows]:
        """Stream the rows in the order of the file; raise InputError on bad input."""


class CsvFile(RowFile):
    """A CSV file, plain or gzip-compressed, with a header line: compiled code for whole blocks, a search for the faulty
    line on failure."""

    def __init__(self, path: Path, columns: TableColumns) -> None:
        super().__init__(path, columns)
        with readable(path):
            first = next(text_blocks(path, lambda _: None), None)
        if first is None:
            raise InputError(f"{path}: the file is empty (a table needs {columns.listed})")
        header = columns.header(path, first.data.split(b"\n", 1)[0].rstrip(b"\r"))
        self.unused = columns.unused(path, header)
        self._names = [name if name in columns.needed else f"unused {k}" for k, name in enumerate(header)]

    def pieces(self, progress: Progress) -> Iterator[Rows]:
        """Stream the rows block by block."""
        for block in text_blocks(self.path, progress):
            rows = _without_header(block)
            if rows.has_lines:
                yield Rows.of(self._parsed(rows), self.columns, self._place_in(rows))

    def _place_in(self, block: TextBlock) -> Callable[[int], str]:
        return lambda row: f"{self.path}:{block.lines()[row][0]}"

    def _parsed(self, block: TextBlock) -> pa.Table:
        """Return the needed columns of all rows; an InputError names the line, the column and what was found."""
        try:
            return self._table(block.data)
        except pa.ArrowInvalid as error:
            number, line = self._first_bad_line(block.lines())
            raise InputError(f"{self.path}:{number}: {self._explain(line, error)}") from error

    def _table(self, data: bytes) -> pa.Table:
        table = read_csv(
            pa.BufferReader(data),
            read_options=arrow_csv.ReadOptions(
                column_names=self._names, use_threads=False, block_size=len(data) + 1
            ),
            convert_options=arrow_csv.ConvertOptions(
                column_types=self.columns.types,
                include_columns=list(self.columns.needed),
                null_values=[],
            ),
        )
        # A stray quote can swallow the following lines; then the rows are fewer than the lines.
        if table.num_rows != data.count(b"\n") and table.num_rows != len(TextBlock(1, data).lines()):
            raise pa.ArrowInvalid("a line break inside a value")
        return table

    def _first_bad_line(self, lines: list[tuple[int, bytes]]) -> tuple[int, bytes]:
        """Return the line after the longest run of lines, found by halving, that still parses."""
        good, bad = 0, len(lines)
        while bad - good > 1:
            middle = (good + bad) // 2
            if self._parses(lines[:middle]):
                good = middle
            else:
                bad = middle
        return lines[good]

    def _parses(self, lines: list[tuple[int, bytes]]) -> bool:
        try:
            self._table(b"\n".join(line for _, line in lines))
        except pa.ArrowInvalid:
            return False
        return True

    def _explain(self, line: bytes, error: Exception) -> str:
        try:
            fields = next(csv.reader([line.decode()], strict=True), [])
        except UnicodeDecodeError:
            return "must be UTF-8 text"
        except csv.Error:
            return f"must be one row of a CSV table (got {shown(line.decode(errors='replace'))})"
        if len(fields) != len(self._names):
            return f"must be {len(self._names)} values, as in the header (got {len(fields)})"
        for name, value in zip(self._names, fields, strict=True):
            if name in ACCEPTED_IN and not _is_number(value, whole=name == "frame"):
                return f"column {name!r}: must be {ACCEPTED_IN[name]} (got {shown(value)})"
        return f"must be one row of a CSV table: {one_line(str(error), 80)} (got {shown(line.decode())})"


class ParquetFile(RowFile):
    """A Parquet file; column types are checked when it is opened."""

    def __init__(self, path: Path, columns: TableColumns) -> None:
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


def open_rows(path: Path, columns: TableColumns) -> RowFile:
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


def _is_number(text: str, whole: bool) -> bool:
    """Return whether a CSV value reads as a number (no digit grouping, no hexadecimal)."""
    try:
        value = int(text) if whole else float(text)
    except ValueError:
        return False
    return "_" not in text and (0 <= value < 1 << 63 if whole else math.isfinite(value))
