"""Rows of a sweep as Arrow tables: in pieces, put together, and as a Parquet file."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from riglens.core.files import atomic_write
from riglens.core.scene.boxes import CLASSES
from riglens.core.sweep.rows import Row

if TYPE_CHECKING:
    from pyarrow import Table

HEADER = b"riglens"
"""Key of the metadata of a table."""
GROUP_ROWS = 10_000
"""Rows of a group in a Parquet file."""


def packed(rows: Iterable[Row], key: str) -> bytes:
    """Return rows as an Arrow stream under a key."""
    import pyarrow as pa

    listed = list(rows)
    names = dict.fromkeys(name for row in listed for name in row)  # rigs differ in their kinds of sensor
    found = pa.table({name: [row.get(name) for row in listed] for name in names}, metadata={HEADER: key})
    stream = BytesIO()
    with pa.ipc.new_stream(stream, found.schema) as writer:
        writer.write_table(found)
    return stream.getvalue()


def unpacked(key: str, content: bytes) -> Table:
    """Return the rows of a stream; ValueError when they have another key."""
    import pyarrow as pa

    found = pa.ipc.open_stream(content).read_all()
    if (found.schema.metadata or {}).get(HEADER) != key.encode():
        raise ValueError("rows of another sweep")
    return found


def joined(parts: Sequence[Table], header: Mapping[str, Any]) -> Table:
    """Return all rows in one table, the same however they were split; `header` becomes its metadata."""
    import pyarrow as pa

    whole = pa.concat_tables(parts, promote_options="permissive").combine_chunks()
    return whole.replace_schema_metadata({HEADER: json.dumps(header)})


def header_of(table: Table) -> dict[str, Any]:
    """Return the header of a table of a sweep."""
    found: dict[str, Any] = json.loads(table.schema.metadata[HEADER])
    return found


def document_of(table: Table) -> dict[str, Any]:
    """Return header and rows as plain data."""
    return {**header_of(table), "rows": table.to_pylist()}


def main_figures(table: Table) -> list[str]:
    """Return the columns to look at first: by class, hit coverage or else coverage; and the blind area."""
    wanted = [f"{name}.lidar.on_target" for name in CLASSES]
    wanted = wanted if wanted[0] in table.column_names else [f"{name}.any.seen" for name in CLASSES]
    return [name for name in (*wanted, "blind_m2") if name in table.column_names]


def write(table: Table, path: Path) -> None:
    """Write a table as a Parquet file."""
    from pyarrow import parquet

    with atomic_write(path) as stream:
        parquet.write_table(table, stream, row_group_size=GROUP_ROWS)
