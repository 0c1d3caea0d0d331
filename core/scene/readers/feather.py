"""Feather files of Argoverse 2, read by PyArrow batch by batch within stated limits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa

from riglens.core.errors import InputError
from riglens.core.files import open_regular
from riglens.core.scene.limits import one_line


@dataclass(frozen=True)
class FeatherLimits:
    """Largest file of one sort: its bytes on the disk, its bytes in memory, its rows."""

    sort: str
    file_bytes: int
    memory_bytes: int
    rows: int


def read_feather(
    path: Path, columns: Sequence[str], limits: FeatherLimits, with_others: bool = False
) -> pa.Table:
    """Return these columns of a Feather file, and all others too if requested.

    Raise InputError for a file that is damaged, lacks a column or has it twice, or exceeds its limits. They are checked
    after each batch, so that a file takes at most one batch more than them.
    """
    with open_regular(path, limits.sort) as file:
        data = file.read(limits.file_bytes + 1)
    _require(path, len(data), limits.file_bytes, "bytes", limits)
    with _errors(path):
        reader = pa.ipc.open_file(pa.py_buffer(data))
        names = reader.schema.names
        for name in columns:
            if names.count(name) != 1:
                count = "is missing" if name not in names else "is there more than once"
                raise InputError(f"{path}: column {name!r} {count}")
        if with_others:
            columns = list(dict.fromkeys(name for name in names if names.count(name) == 1))
        fields = [names.index(name) for name in columns]
        reader = pa.ipc.open_file(pa.py_buffer(data), options=pa.ipc.IpcReadOptions(included_fields=fields))
        _require(path, reader.num_record_batches, limits.rows, "batches of rows", limits)
        batches, rows, size = [], 0, 0
        for number in range(reader.num_record_batches):
            batch = reader.get_batch(number).select(list(columns))
            rows, size = rows + batch.num_rows, size + batch.nbytes
            _require(path, rows, limits.rows, "rows", limits)
            _require(path, size, limits.memory_bytes, "bytes in memory", limits)
            batch.validate(full=True)
            batches.append(batch)
        kinds = pa.schema([reader.schema.field(name) for name in columns])
        return pa.Table.from_batches(batches, kinds)


def _require(path: Path, count: int, most: int, unit: str, limits: FeatherLimits) -> None:
    if count > most:
        raise InputError(f"{path}: {limits.sort} must have at most {most} {unit}")


@contextmanager
def _errors(path: Path) -> Iterator[None]:
    """Turn Arrow's errors on damaged bytes into an InputError."""
    try:
        yield
    except InputError:
        raise
    except (pa.ArrowException, MemoryError, KeyError, IndexError, ValueError, OSError) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise
        raise InputError(f"{path}: damaged Feather file ({one_line(str(error), 120)})") from error
