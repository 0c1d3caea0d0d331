"""Rows of a sweep as Arrow tables: in pieces, put together, and as a Parquet file."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.figures.figure import ALL, Better
from riglens.core.figures.registry import figures
from riglens.core.files import atomic_write
from riglens.core.scene.boxes import CLASSES
from riglens.core.sweep.rows import Row

if TYPE_CHECKING:
    from pyarrow import Table

Doubles = NDArray[np.float64]
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
    """Return the columns to look at first: the leading figures of each class that have a direction, and those of the
    whole rig."""
    first = [one for one in figures() if one.better != "neither" and (one.leads or not one.per_class)]
    wanted = [one.column(who) for one in first for who in (CLASSES if one.per_class else (ALL,))]
    return [name for name in wanted if name in table.column_names]


def better_of(column: str) -> Better:
    """Return the direction in which the figure of a column improves; a change improves as its figure does."""
    name = column.removesuffix("_change")
    for figure in figures():
        for who in CLASSES if figure.per_class else (ALL,):
            if name in (figure.column(who), f"{who}.{figure.place}"):
                return figure.better
    return "neither"


def near_best(column: str, values: Doubles, noise: Doubles | float = 0.0) -> NDArray[np.bool_]:
    """Return which values (n,) of a column lie within their noise of the best; none without a direction."""
    better = better_of(column)
    if better == "neither" or np.isnan(values).all():
        return np.zeros(len(values), np.bool_)
    graded = values if better == "more" else -values
    return np.asarray(graded >= np.nanmax(graded) - noise)


def doubles(table: Table, column: str) -> Doubles:
    """Return a column as doubles, NaN where there is nothing."""
    values = table[column].to_pylist()
    return np.array([np.nan if one is None or isinstance(one, str) else one for one in values], np.float64)


def write(table: Table, path: Path) -> None:
    """Write a table as a Parquet file."""
    from pyarrow import parquet

    with atomic_write(path) as stream:
        parquet.write_table(table, stream, row_group_size=GROUP_ROWS)
