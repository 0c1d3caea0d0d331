"""Find out what a path holds, by its content and layout, and open the reader for it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from core.errors import InputError
from core.geometry import Vec3
from core.scene.boxes import BoxSource
from core.scene.readers.classes import ANY_TABLE, ClassTable
from core.scene.readers.common import BoxOptions, readable
from core.scene.readers.table import CsvSource, ParquetSource, is_parquet

ACCEPTED = "a CSV, CSV.gz or Parquet table, a KITTI tracking or object folder, or a CARLA folder"


def open_boxes(
    path: Path | str,
    origin_m: Vec3 | None = None,
    frames: int | None = None,
    class_map: Mapping[str, str] | None = None,
) -> BoxSource:
    """Open a box data set; what it is follows from the path's content (file) or layout (folder).

    origin_m: place of the source's origin in the vehicle frame, metres, added to every box; None takes the
    source's own default: the Velodyne's place for KITTI folders, zero for everything else. frames: number of
    frames T, for data in which empty frames leave no trace. class_map: {source name: car, bicycle, pedestrian or
    ignore}, on top of the source's table. Raises InputError when the path holds nothing that can be read.
    """
    place = Path(path)
    overrides = dict(class_map or {})
    with readable(place):
        if not place.exists():
            raise InputError(f"{place}: does not exist, accepted is {ACCEPTED}")
        if not (place.is_file() or place.is_dir()):
            raise InputError(f"{place}: neither a file nor a folder, accepted is {ACCEPTED}")
        if place.is_file():
            options = BoxOptions(origin_m or (0.0, 0.0, 0.0), ClassTable(ANY_TABLE, overrides), frames)
            return ParquetSource(place, options) if is_parquet(place) else CsvSource(place, options)
    raise InputError(f"{place}: found no box data in this folder, accepted is {ACCEPTED}")
