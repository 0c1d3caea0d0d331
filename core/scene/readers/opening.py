"""Find out what a path holds, by its content and layout, and open the reader for it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from core.errors import InputError
from core.geometry import Vec3
from core.scene.boxes import BoxSource
from core.scene.readers.carla import FOLDERS, CarlaSource
from core.scene.readers.classes import ANY_TABLE, CARLA, KITTI, ClassTable
from core.scene.readers.common import BoxOptions, readable
from core.scene.readers.kitti import OBJECT, TRACKING, VELODYNE_M, KittiSource, Layout

ACCEPTED = "a CSV, CSV.gz or Parquet table, a KITTI tracking or object folder, or a CARLA folder"
_NO_SHIFT: Vec3 = (0.0, 0.0, 0.0)


def open_boxes(
    path: Path | str,
    origin_m: Vec3 | None = None,
    frames: int | None = None,
    class_map: Mapping[str, str] | None = None,
) -> BoxSource:
    """Open a box data set; what it is follows from the path's content (file) or layout (folder).

    origin_m: place of the source's origin in the vehicle frame, metres, added to every box; None takes the
    source's own default: the Velodyne's place for KITTI folders, zero for everything else. frames: number of
    frames T, for data in which empty frames leave no trace. class_map: {source name: car, bicycle, pedestrian
    or ignore}, on top of the source's table. Raises InputError when nothing readable is there.
    """
    place, overrides = Path(path), dict(class_map or {})

    def options(names: Mapping[str, str], default_origin_m: Vec3 = _NO_SHIFT) -> BoxOptions:
        origin = default_origin_m if origin_m is None else origin_m
        return BoxOptions(origin, ClassTable(names, overrides), frames)

    with readable(place):
        if place.is_file():
            # here, and not above: loads pyarrow, for which the window's first picture need not wait
            from core.scene.readers.table import CsvSource, ParquetSource, is_parquet

            source = ParquetSource if is_parquet(place) else CsvSource
            return source(place, options(ANY_TABLE))
        if not place.is_dir():
            found = "neither a file nor a folder" if place.exists() else "does not exist"
            raise InputError(f"{place}: {found}, accepted is {ACCEPTED}")
        if kitti := _kitti_layouts(place):
            if len(kitti) > 1:
                raise InputError(f"{place}: both label_02 and label_2, accepted is a folder with one of them")
            return KittiSource(place, kitti[0], options(KITTI, VELODYNE_M))
        if any((place / name).is_dir() for name in FOLDERS):
            return CarlaSource(place, options(CARLA))
    raise InputError(f"{place}: found no box data in this folder, accepted is {ACCEPTED}")


def _kitti_layouts(path: Path) -> list[Layout]:
    return [layout for layout in (TRACKING, OBJECT) if (path / layout.folder).is_dir()]
