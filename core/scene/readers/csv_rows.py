"""Parse blocks of a CSV table: compiled code for whole blocks, a search for the faulty line on failure."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import pyarrow as pa
import pyarrow.csv as arrow_csv

from riglens.core.errors import InputError
from riglens.core.scene.limits import one_line
from riglens.core.scene.readers.common import ACCEPTED, NUMBERS, shown
from riglens.core.scene.readers.text_blocks import TextBlock

ACCEPTED_IN = {"frame": "an integer ≥ 0", **ACCEPTED}
"""Accepted values by column."""


@dataclass(frozen=True)
class Columns:
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


BOX_COLUMNS = Columns(("seq", "frame", "cls", *NUMBERS), ("seq", "cls"))


class CsvParser:
    """Parses blocks of one table with a known header."""

    def __init__(self, path: Path, header: Sequence[str], columns: Columns) -> None:
        self._path, self._columns = path, columns
        self._header = [
            name if name in columns.needed else f"unused {index}" for index, name in enumerate(header)
        ]

    def parse(self, block: TextBlock) -> pa.Table:
        """Return the needed columns of all rows; an InputError names the line, the column and what was found."""
        try:
            return self._table(block.data)
        except pa.ArrowInvalid as error:
            number, line = self._first_bad_line(block.lines())
            raise InputError(f"{self._path}:{number}: {self._explain(line, error)}") from error

    def _table(self, data: bytes) -> pa.Table:
        table = arrow_csv.read_csv(
            pa.BufferReader(data),
            read_options=arrow_csv.ReadOptions(
                column_names=self._header, use_threads=False, block_size=len(data) + 1
            ),
            convert_options=arrow_csv.ConvertOptions(
                column_types=self._columns.types,
                include_columns=list(self._columns.needed),
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
        if len(fields) != len(self._header):
            return f"must be {len(self._header)} values, as in the header (got {len(fields)})"
        for name, value in zip(self._header, fields, strict=True):
            if name in ACCEPTED_IN and not _is_number(value, whole=name == "frame"):
                return f"column {name!r}: must be {ACCEPTED_IN[name]} (got {shown(value)})"
        return f"must be one row of a CSV table: {one_line(str(error), 80)} (got {shown(line.decode())})"


def _is_number(text: str, whole: bool) -> bool:
    """Return whether a CSV value reads as a number (no digit grouping, no hexadecimal)."""
    try:
        value = int(text) if whole else float(text)
    except ValueError:
        return False
    return "_" not in text and (0 <= value < 1 << 63 if whole else math.isfinite(value))
