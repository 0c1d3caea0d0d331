"""Argoverse 2 logs: the cuboids of one `annotations.feather`, which are in the ego frame of their sweep already.

Columns as in the guide of the av2 package (Sensor Dataset, Annotations). The car itself, EGO_VEHICLE where a file
has it, maps to no class.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.scene.boxes import BoxBatch, Progress, rotations_from_quaternions
from riglens.core.scene.limits import MAX_NAME_CHARS, require_few_names
from riglens.core.scene.readers.classes import UNMAPPED
from riglens.core.scene.readers.common import (
    FileBoxSource,
    ReadingTally,
    readable,
    require_boxes,
    select,
    whole_frames,
)
from riglens.core.scene.readers.feather import FeatherLimits, read_feather
from riglens.core.scene.readers.rows import TypeName, require_type

NUMBERS = ("tx_m", "ty_m", "tz_m", "length_m", "width_m", "height_m", "qw", "qx", "qy", "qz")
LOG = FeatherLimits("the annotations of one log", file_bytes=1 << 26, memory_bytes=1 << 28, rows=500_000)
"""A log of 15 seconds has some twenty thousand rows; they may come in any order, so all are held in memory."""
_QUATERNION_TOLERANCE = 0.01


class ArgoverseSource(FileBoxSource):
    """One log. A frame is a sweep with annotations; sweeps without any leave no trace in the file."""

    def _files(self) -> list[Path]:
        return [self.path]

    def _read(self, tally: ReadingTally, progress: Progress) -> Iterator[BoxBatch]:
        table = _table(self.path)
        time = table["timestamp_ns"].cast(pa.int64()).to_numpy()
        sweep_ns, frame = np.unique(time, return_inverse=True)
        tally.frames = len(sweep_ns)
        tally.name_frames(self.path.resolve().parent.name, sweep_ns)
        names, code = category_names(self.path, table["category"])
        cls = np.asarray(self.options.classes.codes(names), dtype=np.int64)[code]
        missed = np.bincount(code[cls == UNMAPPED], minlength=len(names))
        tally.miss({name: int(n) for name, n in zip(names, missed, strict=True) if n}, self.path)
        rows = np.flatnonzero(cls != UNMAPPED)
        boxes = _boxes(self.path, table, frame, cls, rows[np.argsort(frame[rows], kind="stable")])
        for run in whole_frames(boxes.frame):
            yield select(boxes, run)
            progress(run.stop / rows.size)


def _table(path: Path) -> pa.Table:
    """Return the columns that are needed, complete and of a type that fits; raise InputError otherwise."""
    kinds: dict[str, TypeName] = {
        "timestamp_ns": "integers",
        "category": "text",
        **dict.fromkeys(NUMBERS, "numbers"),
    }
    with readable(path):
        table = read_feather(path, list(kinds), LOG)
    for name, kind in kinds.items():
        require_type(path, table.schema.field(name), kind)
        if table[name].null_count:
            raise InputError(f"{path}: column {name!r} must have a value in every row")
    return table


def category_names(path: Path, column: pa.ChunkedArray) -> tuple[list[str], NDArray[np.intp]]:
    """Return the distinct names in a column, and the index of its name for every row."""
    category = column.combine_chunks().dictionary_encode()
    used, code = np.unique(category.indices.to_numpy(), return_inverse=True)
    require_few_names(used, path)
    names = [str(name) for name in category.dictionary.take(pa.array(used)).to_pylist()]
    if any(len(name) > MAX_NAME_CHARS for name in names):
        raise InputError(f"{path}: column 'category': names must be at most {MAX_NAME_CHARS} characters long")
    return names, code.astype(np.intp)


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
    require_boxes(
        numbers[:, 0:3],
        numbers[:, 3:6],
        lambda row, column: f"{path}: row {rows[row] + 1}: column {NUMBERS[column]!r}",
    )
    with np.errstate(over="ignore"):
        length = np.linalg.norm(numbers[:, 6:10], axis=1)
    wrong = ~(np.abs(length - 1.0) <= _QUATERNION_TOLERANCE)
    if wrong.any():
        row = int(np.argmax(wrong))
        raise InputError(
            f"{path}: row {rows[row] + 1}: qw qx qy qz: must be a quaternion of length 1 "
            f"(got length {length[row]:g})"
        )
    rotation = rotations_from_quaternions(numbers[:, 6:10])
    return BoxBatch(
        frame[rows].astype(np.int64), cls[rows].astype(np.uint8), numbers[:, 0:3], numbers[:, 3:6], rotation
    )
