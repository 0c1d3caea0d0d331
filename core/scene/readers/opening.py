"""Detect the format of a path, by its content and layout, and open its reader."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from riglens.core.errors import InputError
from riglens.core.geometry import Vec3
from riglens.core.scene.limits import require_few_files
from riglens.core.scene.readers import argoverse_files, nuscenes
from riglens.core.scene.readers.argoverse_files import find_logs, is_feather
from riglens.core.scene.readers.carla import FOLDERS, CarlaSource
from riglens.core.scene.readers.classes import ANY_TABLE, ARGOVERSE, CARLA, KITTI, NUSCENES, ClassTable
from riglens.core.scene.readers.collection import BoxCollection
from riglens.core.scene.readers.common import BoxOptions, FileBoxSource, readable
from riglens.core.scene.readers.kitti import OBJECT, TRACKING, VELODYNE_M, KittiSource, LabelLayout
from riglens.core.scene.readers.nuscenes import NuscenesSource
from riglens.core.scene.readers.nuscenes_tables import tables_folder

ACCEPTED = (
    "a CSV, CSV.gz or Parquet table or a folder of them, a nuScenes folder, annotations.feather or log folders of "
    "Argoverse 2, a KITTI tracking or object folder, or a CARLA folder"
)
PICKLE_ENDINGS = (".pkl", ".pkl.gz", ".pickle")
TABLE_ENDINGS = (".csv", ".csv.gz", ".parquet", ".pq")
Source = FileBoxSource | BoxCollection
Options = Callable[[str, bool], BoxOptions]
"""From a layout, and whether the data are a part of a larger set, to the options of reading them."""
_LAYOUTS: dict[str, tuple[Mapping[str, str], Vec3 | None, str]] = {
    "nuscenes": (NUSCENES, nuscenes.REAR_AXLE_M, "the rear axle is"),
    "argoverse": (ARGOVERSE, argoverse_files.REAR_AXLE_M, "the rear axle is"),
    "kitti": (KITTI, VELODYNE_M, "the Velodyne is"),
    "carla": (CARLA, None, ""),
    "table": (ANY_TABLE, None, ""),
}
"""Classes of a layout's names; the place of its origin in the vehicle frame, metres, where that is known; and what is
there."""
_NO_SHIFT: Vec3 = (0.0, 0.0, 0.0)


def open_boxes(
    path: Path | str | Sequence[Path],
    origin_m: Vec3 | None = None,
    frames: int | None = None,
    class_map: Mapping[str, str] | None = None,
    lift_m: float = 0.0,
    notes: tuple[str, ...] = (),
) -> Source:
    """Open a box data set, or several as one; the format follows from the path's content or layout.

    origin_m: place of the source's origin in the vehicle frame, metres, added to every box; None takes the
    source's own default: the Velodyne's place for KITTI, the rear axle's for nuScenes and Argoverse 2, zero for
    everything else. lift_m: added to the origin's z, whichever it is. frames: number of frames T, for data in
    which empty frames leave no trace. class_map: {source name: car, bicycle, pedestrian or ignore}, on top of
    the source's table. notes: further sentences for the report. Raise InputError when nothing readable is there.
    """

    def options(layout: str, is_part: bool) -> BoxOptions:
        names, known_m, what = _LAYOUTS[layout]
        x, y, z = origin_m or known_m or _NO_SHIFT
        told = f"origin: {what} at {x:g} {y:g} {z:g} m in the vehicle frame"
        more = (told,) if origin_m is None and known_m is not None else ()
        classes = ClassTable(names, dict(class_map or {}))
        return BoxOptions((x, y, z + lift_m), classes, None if is_part else frames, is_part, (*notes, *more))

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
        return _LAYOUTS[_layout(path)][1] or _NO_SHIFT


def has_known_origin(path: Path) -> bool:
    """Return whether the source fixes the origin's place on its car; only names and first bytes are read."""
    with readable(path):
        return _LAYOUTS[_layout(path)][1] is not None


def _open(place: Path, options: Options, is_part: bool) -> Source:
    with readable(place):
        layout = _layout(place)
        chosen = options(layout, is_part)
        if place.is_file():
            return _open_file(place, layout, chosen)
        if layout == "nuscenes":
            tables = tables_folder(place)
            assert tables is not None
            return NuscenesSource(place, tables, chosen)
        if layout == "kitti":
            kitti = _kitti_layouts(place)
            if len(kitti) > 1:
                raise InputError(f"{place}: must hold label_02 or label_2 (got both)")
            return KittiSource(place, kitti[0], chosen)
        if layout == "carla":
            return CarlaSource(place, chosen)
        files = find_logs(place) if layout == "argoverse" else _box_tables(place)
        require_few_files(len(files), place)
        members = [_open_file(file, layout, options(layout, True)) for file in files]
        return BoxCollection(str(place), members, chosen.frames, is_part)


def _layout(place: Path) -> str:
    """Return the format of a path, by layout (folder) or content (file); raise InputError for an unknown one."""
    _refuse_pickles(place)
    if place.is_file():
        return "argoverse" if is_feather(place) else "table"
    if not place.is_dir():
        found = "neither a file nor a folder" if place.exists() else "no such file or folder"
        raise InputError(f"{place}: {found} (must be {ACCEPTED})")
    if tables_folder(place):
        return "nuscenes"
    if _kitti_layouts(place):
        return "kitti"
    if any((place / name).is_dir() for name in FOLDERS):
        return "carla"
    if find_logs(place):
        return "argoverse"
    if _box_tables(place):
        return "table"
    raise InputError(f"{place}: no box data in this folder (must be {ACCEPTED})")


def _refuse_pickles(place: Path) -> None:
    """Raise InputError for cuboids of PandaSet: a pickle can run any program when it is read."""
    is_pickle = place.is_file() and place.name.lower().endswith(PICKLE_ENDINGS)
    folders = [place, place / "cuboids", place / "annotations" / "cuboids"] if place.is_dir() else []
    if is_pickle or any(any(folder.glob(f"*{ending}")) for folder in folders for ending in PICKLE_ENDINGS):
        raise InputError(
            f"{place}: pickle files, as PandaSet's cuboids are; reading one can run any program, so they are never "
            "read here: the page on box data (formats-boxes.md, PandaSet) has the lines that make a table of them"
        )


def _open_file(place: Path, layout: str, options: BoxOptions) -> FileBoxSource:
    # imported late: these load pyarrow, which the window's first picture must not wait for
    from riglens.core.scene.readers.argoverse import ArgoverseSource
    from riglens.core.scene.readers.table import TableSource

    return ArgoverseSource(place, options) if layout == "argoverse" else TableSource(place, options)


def _kitti_layouts(path: Path) -> list[LabelLayout]:
    return [layout for layout in (TRACKING, OBJECT) if (path / layout.folder).is_dir()]


def _box_tables(path: Path) -> list[Path]:
    """Return the tables in a folder, sorted by name."""
    files = (file for file in path.iterdir() if file.name.lower().endswith(TABLE_ENDINGS))
    return sorted(file for file in files if file.is_file() and not file.name.startswith("."))
