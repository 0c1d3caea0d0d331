"""Argoverse 2 logs: the cuboids of one `annotations.feather`, which are in the ego frame of their sweep already.

Columns as in the guide of the av2 package (Sensor Dataset, Annotations). The car itself, EGO_VEHICLE where a file
has it, maps to no class.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import open_regular
from riglens.core.scene.boxes import BoxBatch, Progress, rotations_from_quaternions
from riglens.core.scene.limits import MAX_NAME_CHARS, one_line, require_few_names
from riglens.core.scene.readers.classes import UNMAPPED
from riglens.core.scene.readers.common import (
    ACCEPTED_POSITION,
    ACCEPTED_SIZE,
    BATCH_BOXES,
    FileBoxSource,
    Tally,
    end_of_frame,
    first_bad_box,
    readable,
    select,
)
from riglens.core.scene.readers.feather_sizes import MAGIC_BYTES, Sizes, feather_sizes

NUMBERS = ("tx_m", "ty_m", "tz_m", "length_m", "width_m", "height_m", "qw", "qx", "qy", "qz")
MAX_FILE_BYTES = 1 << 26
MAX_ROWS = 500_000
"""A log of 15 seconds has some twenty thousand; this bounds the memory, since rows may come in any order."""
MAX_FULL_BYTES = 1 << 28
MAX_BATCHES = 10_000
_LOG = "the annotations of one log"

_QUATERNION_TOLERANCE = 0.01


class ArgoverseSource(FileBoxSource):
    """One log. A frame is a sweep with annotations; sweeps without any leave no trace in the file."""

    def _files(self) -> list[Path]:
        return [self.path]

    def _read(self, tally: Tally, progress: Progress) -> Iterator[BoxBatch]:
        table = _table(self.path)
        time = table["timestamp_ns"].cast(pa.int64()).to_numpy()
        _, frame = np.unique(time, return_inverse=True)
        tally.frames = int(frame.max(initial=-1)) + 1
        names, code = category_names(self.path, table["category"])
        cls = np.asarray(self.options.classes.codes(names), dtype=np.int64)[code]
        missed = np.bincount(code[cls == UNMAPPED], minlength=len(names))
        tally.miss({name: int(n) for name, n in zip(names, missed, strict=True) if n}, self.path)
        rows = np.flatnonzero(cls != UNMAPPED)
        boxes = _boxes(self.path, table, frame, cls, rows[np.argsort(frame[rows], kind="stable")])
        start = 0
        while start < rows.size:
            end = end_of_frame(boxes.frame, start + BATCH_BOXES)
            yield select(boxes, slice(start, end))
            progress(end / rows.size)
            start = end


def _table(path: Path) -> pa.Table:
    """Return the columns that are needed, complete and of a type that fits; raise InputError otherwise."""
    needed = ["timestamp_ns", "category", *NUMBERS]
    with readable(path), _feather_errors(path):
        content = _content(path)
        pa.ipc.open_file(content)  # complete up to its end
        stream = content.slice(MAGIC_BYTES)
        _require_small(path, feather_sizes(stream))
        schema = pa.ipc.open_stream(stream).schema
        for name in needed:
            _check_type(path, schema, name)
        fields = [schema.get_field_index(name) for name in needed]
        options = pa.ipc.IpcReadOptions(included_fields=fields)
        batches = list(pa.ipc.open_stream(stream, options=options))
        for batch in batches:
            batch.validate(full=True)
        columns = schema.empty_table().select(needed).schema
        table = pa.Table.from_batches([batch.select(needed) for batch in batches], columns)
    for name in needed:
        if table[name].null_count:
            raise InputError(f"{path}: column {name!r}: found no value, accepted is one in every row")
    return table


def _content(path: Path) -> pa.Buffer:
    """Return the bytes of a file, which must not be larger than a log's."""
    with open_regular(path, _LOG) as file:
        data = file.read(MAX_FILE_BYTES + 1)
    if len(data) > MAX_FILE_BYTES:
        raise InputError(f"{path}: larger than {MAX_FILE_BYTES >> 20} MiB, accepted are {_LOG}")
    return pa.py_buffer(data)


def _require_small(path: Path, sizes: Sizes) -> None:
    """Raise InputError when the file would expand to more than any log has."""
    if sizes.rows > MAX_ROWS:
        raise InputError(f"{path}: more than {MAX_ROWS} rows, accepted are {_LOG}")
    if sizes.full_bytes > MAX_FULL_BYTES:
        raise InputError(f"{path}: expands to more than {MAX_FULL_BYTES >> 20} MiB, accepted are {_LOG}")
    if sizes.batches > MAX_BATCHES:
        raise InputError(f"{path}: more than {MAX_BATCHES} batches of rows, accepted are {_LOG}")


def category_names(path: Path, column: pa.ChunkedArray) -> tuple[list[str], NDArray[np.intp]]:
    """Return the distinct names in a column, and the index of its name for every row."""
    category = column.combine_chunks().dictionary_encode()
    used, code = np.unique(category.indices.to_numpy(), return_inverse=True)
    require_few_names(used, path)
    names = [str(name) for name in category.dictionary.take(pa.array(used)).to_pylist()]
    if any(len(name) > MAX_NAME_CHARS for name in names):
        raise InputError(
            f"{path}: column 'category': found a name of more than {MAX_NAME_CHARS} characters, accepted are fewer"
        )
    return names, code.astype(np.intp)


@contextmanager
def _feather_errors(path: Path) -> Iterator[None]:
    """Turn what Arrow says about broken bytes into an InputError."""
    try:
        yield
    except (pa.ArrowException, MemoryError, UnicodeDecodeError, KeyError, IndexError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: damaged Feather file ({one_line(str(error), 120)})") from error
    except OSError as error:
        if error.errno is not None:
            raise
        raise InputError(f"{path}: damaged Feather file ({one_line(str(error), 120)})") from error


def _check_type(path: Path, schema: pa.Schema, name: str) -> None:
    """Raise InputError when a column is missing, duplicated or of another type."""
    places = schema.get_all_field_indices(name)
    if len(places) != 1:
        found = "missing" if not places else f"appears {len(places)} times"
        raise InputError(f"{path}: column {name!r} {found}, accepted are the annotations of Argoverse 2")
    kind = schema.field(places[0]).type
    if name == "category":
        value = kind.value_type if pa.types.is_dictionary(kind) else kind
        good, accepted = pa.types.is_string(value) or pa.types.is_large_string(value), "text"
    elif name == "timestamp_ns":
        good, accepted = pa.types.is_integer(kind), "whole numbers"
    else:
        good, accepted = pa.types.is_floating(kind), "numbers"
    if not good:
        raise InputError(
            f"{path}: column {name!r}: found type {one_line(str(kind), 60)}, accepted are {accepted}"
        )


def _boxes(
    path: Path,
    table: pa.Table,
    frame: NDArray[np.intp],
    cls: NDArray[np.int64],
    rows: NDArray[np.intp],
) -> BoxBatch:
    """Return the chosen rows as boxes; raise InputError for a number that no box has."""
    columns = [table[name].cast(pa.float64()).to_numpy() for name in NUMBERS]
    numbers = np.column_stack(columns)[rows].reshape(-1, len(NUMBERS))
    bad = first_bad_box(numbers[:, 0:3], numbers[:, 3:6])
    if bad is not None:
        accepted = ACCEPTED_POSITION if bad.column < 3 else ACCEPTED_SIZE
        place = f"{path}: row {rows[bad.row] + 1}: column {NUMBERS[bad.column]!r}"
        raise InputError(f"{place}: found {bad.value:g}, accepted is {accepted}")
    with np.errstate(over="ignore"):
        length = np.linalg.norm(numbers[:, 6:10], axis=1)
    wrong = ~(np.abs(length - 1.0) <= _QUATERNION_TOLERANCE)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise InputError(
            f"{path}: row {rows[row] + 1}: qw qx qy qz: found length {length[row]:g}, accepted is a quaternion of "
            "length 1"
        )
    rotation = rotations_from_quaternions(numbers[:, 6:10])
    return BoxBatch(
        frame[rows].astype(np.int64), cls[rows].astype(np.uint8), numbers[:, 0:3], numbers[:, 3:6], rotation
    )
