"""Read the rays of a scan pattern from a CSV or Parquet file."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import open_regular, read_csv
from riglens.core.rig.yaml.nodes import shortened
from riglens.core.sensors.lattice import MAX_LISTED_RAYS
from riglens.core.sensors.scan import RayRows, Reader, within_half_a_turn

if TYPE_CHECKING:
    import pyarrow as pa
    from pyarrow import parquet

MAX_BYTES = 1 << 28
_BATCH_ROWS = 1 << 16
_AZIMUTH = ("azimuth_deg", "azimuth/deg")
_ELEVATION = ("elevation_deg",)
_ZENITH = ("zenith/deg", "zenith_deg")
_TIME = ("time_s", "time/s")
"""Names of columns in any case; the second ones are those of the tables of Livox's simulation."""
_LIMITS = {"azimuth": 360.0, "elevation": 90.0, "time": 1e6}


def reader_in(folder: Path) -> Reader:
    """Return a reader of files that a rig in that folder names."""
    return lambda file: read_ray_rows(folder / file, file)


def read_ray_rows(path: Path, name: str) -> RayRows:
    """Return the rays of a table; raise InputError, whose line begins with `file`, when it is missing or wrong."""
    where = f"file {name!r:.60}"
    try:
        with open_regular(path, "a table of rays") as stream:
            content = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(f"{where} cannot be read ({error.strerror or error})") from error
    except ValueError as error:  # a null byte in the name, a device
        raise InputError(f"{where}: {error}") from error
    if len(content) > MAX_BYTES:
        raise InputError(f"{where} must have at most {MAX_BYTES / 1e6:g} MB")
    columns = _columns(content, where)
    names = {column.strip().lower(): column for column in columns}
    azimuth = _numbers(columns, names, _AZIMUTH, "azimuth", where)
    if any(column in names for column in _ELEVATION):
        elevation = _numbers(columns, names, _ELEVATION, "elevation", where)
    else:
        elevation = 90.0 - _numbers(columns, names, (*_ZENITH, *_ELEVATION), "elevation", where)
    has_times = any(column in names for column in _TIME)
    time_s = _numbers(columns, names, _TIME, "time", where) if has_times else np.zeros(azimuth.size)
    for what, values in (("azimuth", azimuth), ("elevation", elevation), ("time", time_s)):
        low, high = (0.0 if what == "time" else -_LIMITS[what]), _LIMITS[what]
        bad = np.flatnonzero(~((values >= low) & (values <= high)))
        if bad.size:
            row, value = int(bad[0]), values[bad[0]]
            raise InputError(f"{where}: row {row + 1}: {what} must be {low:g} to {high:g} (got {value:g})")
    return RayRows(within_half_a_turn(azimuth), elevation, time_s, hashlib.sha256(content).hexdigest())


def _columns(content: bytes, where: str) -> Mapping[str, pa.ChunkedArray]:
    """Return the columns of a CSV or Parquet table by name."""
    import pyarrow as pa  # only rigs with tables wait for it
    from pyarrow import csv, parquet

    try:
        if content[:4] == b"PAR1":
            table = _numbers_of(parquet.ParquetFile(pa.BufferReader(content)), where)
        else:
            table = read_csv(pa.BufferReader(content), read_options=csv.ReadOptions(use_threads=False))
    except (pa.ArrowException, OSError, MemoryError, UnicodeDecodeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = " ".join(str(error).split())
        raise InputError(f"{where} is not a table ({reason:.100})") from error
    _require_rows(table.num_rows, where)
    return dict(zip(table.column_names, table.columns, strict=True))


def _numbers_of(file: parquet.ParquetFile, where: str) -> pa.Table:
    """Read the known columns of a Parquet table, which must be numbers: short texts may stand for gigabytes."""
    import pyarrow as pa

    _require_rows(file.metadata.num_rows, where)
    known = {*_AZIMUTH, *_ELEVATION, *_ZENITH, *_TIME}
    wanted = [column for column in file.schema_arrow if column.name.strip().lower() in known]
    for column in wanted:
        kind = column.type
        if not (pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_decimal(kind)):
            name = column.name.strip().lower()
            raise InputError(f"{where}: column {name} must hold numbers (got type {shortened(str(kind))})")
    batches, rows = list[pa.RecordBatch](), 0
    names = [column.name for column in wanted]
    for batch in file.iter_batches(_BATCH_ROWS, columns=names, use_threads=False):
        batches.append(batch)
        rows += batch.num_rows
        _require_rows(rows, where)  # what the file announces may be wrong
    return pa.Table.from_batches(batches, pa.schema(wanted))


def _require_rows(rows: int, where: str) -> None:
    if not 0 < rows <= MAX_LISTED_RAYS:
        raise InputError(f"{where} must hold 1 to {MAX_LISTED_RAYS} rays (got {rows})")


def _numbers(
    columns: Mapping[str, pa.ChunkedArray],
    names: Mapping[str, str],
    known: Sequence[str],
    what: str,
    where: str,
) -> NDArray[np.float64]:
    import pyarrow as pa

    found = [name for name in known if name in names]
    if not found:
        raise InputError(f"{where}: column {known[-1] if what == 'elevation' else known[0]} is missing")
    column = columns[names[found[0]]]
    try:
        numbers = column.cast(pa.float64()).to_numpy()
    except pa.ArrowException as error:
        raise InputError(f"{where}: column {found[0]} must hold numbers") from error
    return np.asarray(numbers, np.float64)
