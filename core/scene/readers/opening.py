"""Detect the format of a path, by its content and layout, and open its reader."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path

from riglens.core.errors import InputError
from riglens.core.extensions import extended, first_fitting
from riglens.core.geometry import Vec3
from riglens.core.scene.limits import require_few_files
from riglens.core.scene.readers import argoverse_files, nuscenes
from riglens.core.scene.readers.argoverse_files import find_logs, is_feather
from riglens.core.scene.readers.carla import FOLDERS, CarlaSource
from riglens.core.scene.readers.classes import (
    ANY_TABLE,
    ARGOVERSE,
    CARLA,
    FRAME_FILES,
    KITTI,
    NUSCENES,
    ClassTable,
)
from riglens.core.scene.readers.collection import BoxCollection
from riglens.core.scene.readers.common import BoxFormat, BoxOptions, FileBoxSource, readable
from riglens.core.scene.readers.frame_files import DAIR, ONCE, OPV2V, ZOD, FrameFilesSource, Layout
from riglens.core.scene.readers.kitti import OBJECT, TRACKING, VELODYNE_M, KittiSource, LabelLayout
from riglens.core.scene.readers.nuscenes import NuscenesSource
from riglens.core.scene.readers.nuscenes_tables import tables_folder

PICKLE_ENDINGS = (".pkl", ".pkl.gz", ".pickle")
TABLE_ENDINGS = (".csv", ".csv.gz", ".parquet", ".pq")
Source = FileBoxSource | BoxCollection
Options = Callable[[BoxFormat, bool], BoxOptions]
"""From a format, and whether the data are a part of a larger set, to the options of reading them."""
_NO_SHIFT: Vec3 = (0.0, 0.0, 0.0)
_GROUP = "riglens.formats"


def open_boxes(
    path: Path | str | Sequence[Path],
    origin_m: Vec3 | None = None,
    frames: int | None = None,
    class_map: Mapping[str, str] | None = None,
    lift_m: float = 0.0,
    notes: tuple[str, ...] = (),
    name: str = "",
) -> Source:
    """Open a box data set, or several as one; the format follows from the path's content or layout.

    origin_m: place of the source's origin in the vehicle frame, metres, added to every box; None takes the
    source's own default: the Velodyne's place for KITTI, the rear axle's for nuScenes and Argoverse 2, zero for
    everything else. lift_m: added to the origin's z, whichever it is. frames: number of frames T, for data in
    which empty frames leave no trace. class_map: {source name: car, bicycle, pedestrian or ignore}, on top of
    the source's table. notes: further sentences for the report; name: in it, instead of the path. Raise InputError
    when nothing readable is there.
    """

    def options(format_: BoxFormat, is_part: bool) -> BoxOptions:
        x, y, z = origin_m or format_.origin_m or _NO_SHIFT
        told = f"origin: {format_.origin_is} is at {x:g} {y:g} {z:g} m in the vehicle frame"
        is_known = origin_m is None and format_.origin_m is not None
        more = (told,) if is_known else ()
        classes = ClassTable(format_.classes, dict(class_map or {}))
        return BoxOptions(
            (x, y, z + lift_m), classes, None if is_part else frames, is_part, (*notes, *more), is_known, name
        )

    places = [Path(path)] if isinstance(path, str | Path) else list(path)
    if len(places) == 1:
        return _open(places[0], options, is_part=False)
    members = [_open(place, options, is_part=True) for place in places]
    return BoxCollection(together(places), members, frames)


def together(paths: Sequence[Path]) -> str:
    """Return the name of several data sets that are read as one."""
    return str(paths[0]) if len(paths) == 1 else f"{paths[0]} + {len(paths) - 1} more"


def default_origin_m(path: Path) -> Vec3:
    """Return the default origin of the data at a path in the vehicle frame, metres.

    Looks at names and first bytes alone. Raise InputError as open_boxes does.
    """
    with readable(path):
        return _format_of(path).origin_m or _NO_SHIFT


def _open(place: Path, options: Options, is_part: bool) -> Source:
    with readable(place):
        format_ = _format_of(place)
        if format_.members is None or place.is_file():
            return format_.opens(place, options(format_, is_part))
        files = format_.members(place)
        require_few_files(len(files), place)
        members = [format_.opens(file, options(format_, True)) for file in files]
        return BoxCollection(str(place), members, options(format_, is_part).frames, is_part)


def _format_of(place: Path) -> BoxFormat:
    """Return the format of a path, by layout (folder) or content (file); raise InputError for an unknown one."""
    _refuse_pickles(place)
    problem = "no such file or folder"
    if place.is_file() or place.is_dir():
        found = (
            next((format_ for format_ in _FORMATS if format_.recognises(place)), None)
            or first_fitting(_GROUP, _added(), lambda format_: format_.recognises(place))
            or (_TABLE if _TABLE.recognises(place) else None)  # last: any file may be a table
        )
        if found is not None:
            return found
        problem = "no box data in this folder"
    elif place.exists():
        problem = "neither a file nor a folder"
    titles = ", ".join(format_.title for format_ in (*_FORMATS, *_added()))
    raise InputError(f"{place}: {problem} (must be {titles}, or {_TABLE.title})")


@cache
def _added() -> tuple[BoxFormat, ...]:
    """Return the formats of installed packages."""
    built_in = {format_.name: format_ for format_ in (*_FORMATS, _TABLE)}
    found = extended(
        _GROUP, built_in, BoxFormat, beside=(object,)
    )  # the registry of rig formats reports others
    return tuple(format_ for name, format_ in found.items() if name not in built_in)


def _refuse_pickles(place: Path) -> None:
    """Raise InputError for cuboids of PandaSet: a pickle can run any program when it is read."""
    is_pickle = place.is_file() and place.name.lower().endswith(PICKLE_ENDINGS)
    folders = [place, place / "cuboids", place / "annotations" / "cuboids"] if place.is_dir() else []
    if is_pickle or any(any(folder.glob(f"*{ending}")) for folder in folders for ending in PICKLE_ENDINGS):
        raise InputError(
            f"{place}: pickle files, as PandaSet's cuboids are; reading one can run any program, so they are never "
            "read here: the page on box data (formats-boxes.md, PandaSet) has the lines that make a table of them"
        )


def _open_nuscenes(place: Path, options: BoxOptions) -> FileBoxSource:
    tables = tables_folder(place)
    assert tables is not None
    return NuscenesSource(place, tables, options)


def _open_kitti(place: Path, options: BoxOptions) -> FileBoxSource:
    layouts = _kitti_layouts(place)
    if len(layouts) > 1:
        raise InputError(f"{place}: must hold label_02 or label_2 (got both)")
    return KittiSource(place, layouts[0], options)


def _kitti_layouts(path: Path) -> list[LabelLayout]:
    return [layout for layout in (TRACKING, OBJECT) if (path / layout.folder).is_dir()]


def _open_argoverse(place: Path, options: BoxOptions) -> FileBoxSource:
    # imported late, as for tables: this loads pyarrow, which the window's first picture must not wait for
    from riglens.core.scene.readers.argoverse import ArgoverseSource

    return ArgoverseSource(place, options)


def _open_table(place: Path, options: BoxOptions) -> FileBoxSource:
    from riglens.core.scene.readers.table import TableSource

    return TableSource(place, options)


def _box_tables(path: Path) -> list[Path]:
    """Return the tables in a folder, sorted by name."""
    files = (file for file in path.iterdir() if file.name.lower().endswith(TABLE_ENDINGS))
    return sorted(file for file in files if file.is_file() and not file.name.startswith("."))


def _of_files(layout: Layout, title: str, origin_m: Vec3 | None = None, origin_is: str = "") -> BoxFormat:
    """Return the format of a data set with a file for each frame or sequence."""
    return BoxFormat(
        layout.name, title,
        lambda place: bool(layout.finds(place)),
        lambda place, options: FrameFilesSource(place, options, layout),
        FRAME_FILES, origin_m, origin_is,
    )  # fmt: skip


_FORMATS = (
    BoxFormat(
        "nuscenes", "a nuScenes folder",
        lambda place: place.is_dir() and tables_folder(place) is not None,
        _open_nuscenes, NUSCENES, nuscenes.REAR_AXLE_M, "the rear axle",
    ),
    BoxFormat(
        "kitti", "a KITTI tracking or object folder",
        lambda place: bool(_kitti_layouts(place)),
        _open_kitti, KITTI, VELODYNE_M, "the Velodyne",
    ),
    BoxFormat(
        "carla", "a CARLA folder",
        lambda place: any((place / name).is_dir() for name in FOLDERS),
        CarlaSource, CARLA,
    ),
    BoxFormat(
        "argoverse", "annotations.feather or log folders of Argoverse 2",
        lambda place: is_feather(place) if place.is_file() else bool(find_logs(place)),
        _open_argoverse, ARGOVERSE, argoverse_files.REAR_AXLE_M, "the rear axle", find_logs,
    ),
    _of_files(ONCE, "a sequence or folder of ONCE"),
    _of_files(ZOD, "a frame or folder of ZOD"),
    _of_files(DAIR, "a vehicle's side of DAIR-V2X"),
    _of_files(OPV2V, "an agent or scenario of OPV2V", (0.0, 0.0, 0.0), "the vehicle's actor"),
)  # fmt: skip
"""The built-in formats of folders and logs, in the order in which they are tried."""
_TABLE = BoxFormat(
    "table",
    "a CSV, CSV.gz or Parquet table or a folder of them",
    lambda place: place.is_file() or bool(_box_tables(place)),
    _open_table,
    ANY_TABLE,
    members=_box_tables,
)
