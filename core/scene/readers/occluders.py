"""Read the tables of occluders in maps, and of the vehicle's pose in each frame."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.geometry import Vec3
from riglens.core.scene.occluders import FrameName, Map, MapPose, Occluders
from riglens.core.scene.readers.common import NUMBERS, file_digest, readable, shown
from riglens.core.scene.readers.frames import RowError
from riglens.core.scene.readers.rows import Rows, TableColumns, check_numbers, open_rows

MAX_OCCLUDERS = 1_000_000
MAX_POSES = 5_000_000
"""Tables are held in memory: about 80 bytes for an occluder, 500 for a pose."""

OCCLUDER_COLUMNS = TableColumns(("map", "cls", *NUMBERS), ("map", "cls"))
POSE_COLUMNS = TableColumns(("seq", "frame", "map", "x", "y", "z", "yaw"), ("seq", "map"))


def open_occluders(occluders: Path, poses: Path, origin_m: Vec3 = (0.0, 0.0, 0.0)) -> Occluders:
    """Read both tables, CSV, gzip-compressed CSV or Parquet; raise InputError on bad input.

    origin_m: place of the origin of the boxes' frame in the vehicle frame, metres, as for the boxes.
    """
    with readable(occluders):
        cls, maps = _read_occluders(occluders)
    with readable(poses):
        placed = read_poses(poses)
        digest = hashlib.sha256(file_digest(occluders) + file_digest(poses)).hexdigest()
    return Occluders(str(poses), cls, maps, placed, origin_m, digest)


def _read_occluders(path: Path) -> tuple[list[str], dict[str, Map]]:
    """Return names of all occluders in the order of the table, and the occluders of each map."""
    number_of: dict[str, int] = {}
    cls: list[str] = []
    codes, numbers = [np.zeros(0, np.int64)], [np.zeros((0, 7))]
    for rows in _rows(path, OCCLUDER_COLUMNS):
        try:
            place, name, values = rows.names("map"), rows.names("cls"), rows.numbers
            check_numbers(values, np.arange(len(values)))
        except RowError as error:
            raise InputError(f"{rows.place(error.row)}: {error}") from error
        mapped = [number_of.setdefault(one, len(number_of)) for one in place.distinct]
        codes.append(np.array(mapped, np.int64)[place.codes])
        cls += [name.distinct[code] for code in name.codes]
        numbers.append(values)
        if len(cls) > MAX_OCCLUDERS:
            raise InputError(f"{path}: too many occluders (at most {MAX_OCCLUDERS})")
    return cls, _maps(list(number_of), np.concatenate(codes), np.concatenate(numbers))


def _maps(names: list[str], codes: NDArray[np.int64], numbers: NDArray[np.float64]) -> dict[str, Map]:
    """Return the rows of each map; codes (n,): the number of each row's map."""
    order = np.argsort(codes, kind="stable")
    ends = np.cumsum(np.bincount(codes, minlength=len(names)))
    parts = np.split(order, ends[:-1]) if names else []
    return {
        name: Map.of(rows, numbers[rows, 0:3], numbers[rows, 3:6], numbers[rows, 6])
        for name, rows in zip(names, parts, strict=True)
    }


def read_poses(path: Path) -> dict[FrameName, MapPose]:
    """Return the pose of each frame in a table; InputError for a frame with two."""
    found: dict[FrameName, MapPose] = {}
    for rows in _rows(path, POSE_COLUMNS):
        try:
            _take_poses(rows, found)
        except RowError as error:
            raise InputError(f"{rows.place(error.row)}: {error}") from error
        if len(found) > MAX_POSES:
            raise InputError(f"{path}: too many poses (at most {MAX_POSES})")
    return found


def _take_poses(rows: Rows, found: dict[FrameName, MapPose]) -> None:
    """Add the poses of some rows; raise RowError for an impossible one or a frame that has one already."""
    seq, frame, place, numbers = rows.names("seq"), rows.frames(), rows.names("map"), rows.numbers
    sized = np.column_stack([numbers[:, :3], np.ones((len(numbers), 3)), numbers[:, 3]])
    check_numbers(sized, np.arange(len(numbers)))
    for row, (x_m, y_m, z_m, yaw_rad) in enumerate(numbers.tolist()):
        name = (seq.distinct[seq.codes[row]], int(frame[row]))
        if name in found:
            raise RowError(
                row, f"frame {name[1]} of sequence {shown(name[0])} must have one pose (got a second)"
            )
        found[name] = MapPose(place.distinct[place.codes[row]], (x_m, y_m, z_m), yaw_rad)


def _rows(path: Path, columns: TableColumns) -> Iterator[Rows]:
    yield from open_rows(path, columns).pieces(lambda _: None)
