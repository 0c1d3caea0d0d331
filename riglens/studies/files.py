"""Write the output of studies: a folder, texts, tables as CSV."""

from __future__ import annotations

import csv
import io
import itertools
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import IO

from riglens.core.errors import InputError
from riglens.core.files import require_writable
from riglens.core.shown_text import spreadsheet_cell


def require_folder(folder: Path, names: Sequence[str]) -> None:
    """Make the folder if there is none; InputError when files of these names cannot be written there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: folder cannot be created: {error.strerror}", "out") from error
    for name in names:
        require_writable(folder / name)


def csv_text(lines: Sequence[Mapping[str, object]], columns: Sequence[str] = ()) -> str:
    """Return the lines of a table as CSV; the columns are those of all lines unless they are given, and cells that a
    line does not have are empty."""
    text, names = io.StringIO(), columns or list(dict.fromkeys(name for line in lines for name in line))
    write_csv(text, names, ([line.get(name, "") for name in names] for line in lines))
    return text.getvalue()


def write_csv(stream: IO[str], columns: Iterable[str], rows: Iterable[Iterable[object]]) -> None:
    """Write a table as CSV, row by row."""
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerows(map(spreadsheet_cell, row) for row in itertools.chain([columns], rows))
