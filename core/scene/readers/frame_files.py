"""Read boxes of data sets with a file for each frame or sequence: ONCE, ZOD, DAIR-V2X, OPV2V.

Metres; yaw in radians to the left. Centres are the middles of the boxes.
- ONCE: SEQ/SEQ.json, `frames` with `annos`; boxes_3d x y z l w h yaw in the LiDAR's axes: x left, y backwards, z up.
  Source: ONCE documentation, "Coordinate systems"; once_devkit, once.py.
- ZOD: ID/annotations/object_detection.json; places and quaternions in the axes of the LiDAR, which ID/calibration.json
  leads to the car: x forward, y left, z up. Source: zod, anno/object.py, data_classes/box.py and calibration.py.
- DAIR-V2X: label/lidar/ID.json, in the axes of the LiDAR: x forward, y left, z up. Source: DAIR-V2X, data/README.md,
  gen_kitti/label_lidarcoord_to_cameracoord.py.
- OPV2V, V2XSet: AGENT/FRAME.yaml; `vehicles` and `true_ego_pos` in CARLA's left-handed map, degrees, half edges.
  Source: OpenCOOD, utils/box_utils.py and transformation_utils.py.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import open_regular
from riglens.core.geometry import is_rotation, rotation_from_rpy_deg
from riglens.core.rig.pose_text import rotation_from_quaternion
from riglens.core.rig.yaml.nodes import parse_yaml, plain_value, read_text
from riglens.core.scene.boxes import BoxBatch, Progress
from riglens.core.scene.limits import MAX_NAME_CHARS, require_few_files
from riglens.core.scene.readers.classes import UNMAPPED
from riglens.core.scene.readers.common import (
    NUMBERS,
    BoxOptions,
    FileBoxSource,
    ReadingTally,
    join,
    require_boxes,
    shown,
)

MAX_JSON_BYTES, MAX_YAML_BYTES = 1 << 26, 200_000
MAX_OBJECTS = 100_000
"""In a frame."""
_FILES_PER_PART, _FRAMES_PER_BATCH = 200, 256
_LEFT_BACK = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
_MIRROR = np.array([1.0, -1.0, 1.0])
Rows = NDArray[np.float64]


@dataclass
class FrameBoxes:
    """The boxes of one frame, x forward, y left, z up: names, and for each centre, size, rotation (3, 3)."""

    place: str
    names: list[str] = field(default_factory=list)
    centre_m: list[Rows] = field(default_factory=list)
    size_m: list[Rows] = field(default_factory=list)
    rotation: list[Rows] = field(default_factory=list)
    without_box: int = 0

    def add(self, name: object, centre_m: Rows, size_m: Rows, rotation: Rows) -> None:
        """Add a box; raise InputError for a name that is none."""
        if not isinstance(name, str) or len(name) > MAX_NAME_CHARS:
            raise InputError(f"{self.place}: name of an object: must be a text (got {shown(str(name))})")
        self.names.append(name)
        self.centre_m.append(centre_m)
        self.size_m.append(size_m)
        self.rotation.append(rotation)


@dataclass(frozen=True)
class Layout:
    """A data set's layout: `finds` its files in a folder, in a fixed order, and `reads` the frames of one."""

    name: str
    finds: Callable[[Path], list[Path]]
    reads: Callable[[Path], Iterator[FrameBoxes]]
    beside: Callable[[Path], Path | None] = lambda _: None
    """A further file that the boxes of one depend on."""


class FrameFilesSource(FileBoxSource):
    """A data set in one of the layouts."""

    def __init__(
        self, path: Path, options: BoxOptions, layout: Layout, files: Sequence[Path] | None = None
    ) -> None:
        """Read `files`, or all of the data set."""
        super().__init__(path, options)
        self._layout = layout
        self._own = list(files) if files is not None else layout.finds(path)
        require_few_files(len(self._own), path)

    @property
    def sort(self) -> str:
        """The layout, part of the content hash."""
        return self._layout.name

    def parts(self) -> Sequence[FrameFilesSource]:
        """Return sources of some hundred files each."""
        options = replace(self.options, frames=None, is_part=True)
        starts = range(0, len(self._own), _FILES_PER_PART)
        return [
            FrameFilesSource(self.path, options, self._layout, self._own[at : at + _FILES_PER_PART])
            for at in starts
        ]

    def _files(self) -> list[Path]:
        more = (self._layout.beside(file) for file in self._own)
        return [*self._own, *(file for file in more if file is not None and file.is_file())]

    def _read(self, tally: ReadingTally, progress: Progress) -> Iterator[BoxBatch]:
        pending: list[BoxBatch] = []
        missing = 0
        tally.sequences = len({file.parent for file in self._own})
        for done, file in enumerate(self._own, start=1):
            for frame in self._layout.reads(file):
                missing += frame.without_box
                pending.append(self._batch(frame, tally))
                if len(pending) == _FRAMES_PER_BATCH:
                    yield join(pending)
                    pending = []
            progress(done / len(self._own))
        if missing:
            tally.notes.append(f"{missing:,} objects have no box in space and do not count")
        if pending:
            yield join(pending)

    def _batch(self, frame: FrameBoxes, tally: ReadingTally) -> BoxBatch:
        codes = np.asarray(self.options.classes.codes(frame.names), dtype=np.int64)
        tally.miss(
            (name for name, code in zip(frame.names, codes, strict=True) if code == UNMAPPED), frame.place
        )
        rows = np.flatnonzero(codes != UNMAPPED)
        centre, size = (
            np.asarray(values, np.float64).reshape(-1, 3)[rows] for values in (frame.centre_m, frame.size_m)
        )
        require_boxes(
            centre, size, lambda row, column: f"{frame.place}: object {rows[row] + 1}: {NUMBERS[column]}"
        )
        rotation = np.asarray(frame.rotation, np.float64).reshape(-1, 3, 3)[rows]
        number = np.full(rows.size, tally.frames)
        tally.frames += 1
        return BoxBatch(number, codes[rows].astype(np.uint8), centre, size, rotation)


# ---------------------------------------------------------------- ONCE


def _once_files(path: Path) -> list[Path]:
    """Return the file of a sequence, or those of the folder of one, of a split, or of a data set."""
    if path.is_file():
        return [path] if path.suffix == ".json" and _begins_with(path, '"calib"', '"annos"') else []
    places = (path / f"{path.resolve().name}.json", *path.glob("*/*.json"), *path.glob("data/*/*.json"))
    found = {place for place in places if place.is_file() and place.stem == place.resolve().parent.name}
    return sorted(place for place in found if _begins_with(place, '"calib"'))


def _begins_with(path: Path, *keys: str) -> bool:
    """Return whether the first bytes of a file hold all of these."""
    with open_regular(path, "a JSON file") as file:
        start = file.read(1 << 16).decode("utf-8", "replace")
    return all(key in start for key in keys)


def _once_frames(path: Path) -> Iterator[FrameBoxes]:
    frames = _at(_json(path), "frames", str(path), list)
    for number, frame in enumerate(frames, start=1):
        place = f"{path}: frame {number}"
        annos = frame.get("annos") if isinstance(frame, dict) else None
        if annos is None:  # not labelled
            continue
        names, boxes = _at(annos, "names", place, list), _at(annos, "boxes_3d", place, list)
        if len(names) != len(boxes):
            raise InputError(f"{place}: must have as many names as boxes (got {len(names)} and {len(boxes)})")
        found = FrameBoxes(place)
        for name, box in zip(names, boxes, strict=True):
            numbers = _numbers(box, 7, f"{place}: boxes_3d")
            found.add(name, _LEFT_BACK @ numbers[:3], numbers[3:6], _LEFT_BACK @ _yaw(numbers[6]))
        yield found


# ---------------------------------------------------------------- ZOD

_ZOD = "annotations/object_detection.json"


def _zod_files(path: Path) -> list[Path]:
    """Return the labels of a frame, of single_frames, or of the data set around it."""
    places = (path / _ZOD, *path.glob(f"*/{_ZOD}"), *path.glob(f"*/*/{_ZOD}"))
    return sorted(place for place in places if place.is_file())


def _zod_calibration(path: Path) -> Path:
    return path.parent.parent / "calibration.json"


def _zod_frames(path: Path) -> Iterator[FrameBoxes]:
    calibration = _zod_calibration(path)
    if not calibration.is_file():
        raise InputError(
            f"{calibration}: missing: it leads from the LiDAR, in which {path.name} is, to the car"
        )
    camera = _at(_json(calibration), "FC", str(calibration), dict)
    rows = _at(camera, "lidar_extrinsics", str(calibration), list)
    matrix = np.array([_numbers(row, 4, f"{calibration}: lidar_extrinsics") for row in rows[:3]])
    if matrix.shape != (3, 4) or not is_rotation(matrix[:, :3]):
        raise InputError(f"{calibration}: lidar_extrinsics: must be a rigid transform of 4 x 4 numbers")
    found = FrameBoxes(str(path))
    for entry in _listed(_json(path), str(path)):
        what = _at(entry, "properties", str(path), dict)
        if "location_3d" not in what:
            found.without_box += 1
            continue
        place = _numbers(_at(what["location_3d"], "coordinates", str(path), list), 3, f"{path}: location_3d")
        size = _fields(what, ("size_3d_length", "size_3d_width", "size_3d_height"), str(path))
        x, y, z, w = _fields(what, tuple(f"orientation_3d_q{part}" for part in "xyzw"), str(path))
        try:
            own = rotation_from_quaternion((x, y, z, w))
        except InputError as error:
            raise InputError(f"{path}: orientation_3d: {error}") from error
        name = what.get("object_type", what.get("type")) or what.get("class")
        found.add(name, matrix[:, :3] @ place + matrix[:, 3], size, matrix[:, :3] @ own)
    yield found


# ---------------------------------------------------------------- DAIR-V2X


def _dair_files(path: Path) -> list[Path]:
    """Return the labels of a vehicle's side."""
    return sorted(path.glob("label/lidar/*.json"))


def _dair_frames(path: Path) -> Iterator[FrameBoxes]:
    found = FrameBoxes(str(path))
    for entry in _listed(_json(path), str(path)):
        size = _fields(_at(entry, "3d_dimensions", str(path), dict), ("l", "w", "h"), str(path))
        centre = _fields(_at(entry, "3d_location", str(path), dict), ("x", "y", "z"), str(path))
        (yaw,) = _fields(entry, ("rotation",), str(path))
        if not size.any():  # labelled in the picture alone
            found.without_box += 1
            continue
        found.add(entry.get("type"), centre, size, _yaw(yaw))
    yield found


# ---------------------------------------------------------------- OPV2V

_FRAME = re.compile(r"[0-9]{4,8}\.yaml")


def _opv2v_files(path: Path) -> list[Path]:
    """Return the frames of an agent, or of the agents of a scenario; folders of agents are named by a number."""
    if not path.is_dir():
        return []
    agents = [path, *(one for one in path.iterdir() if one.is_dir() and re.fullmatch(r"-?[0-9]+", one.name))]
    found = (file for agent in agents for file in agent.glob("*.yaml") if _FRAME.fullmatch(file.name))
    return sorted(found)


def _opv2v_frames(path: Path) -> Iterator[FrameBoxes]:
    root = plain_value(parse_yaml(read_text(path, "a frame of OPV2V", MAX_YAML_BYTES, False), str(path)))
    ego_R, ego_m = _map_pose(_numbers(_at(root, "true_ego_pos", str(path), list), 6, f"{path}: true_ego_pos"))
    found = FrameBoxes(str(path))
    vehicles = root.get("vehicles") if isinstance(root, dict) else None
    for key, entry in _at({"vehicles": vehicles or {}}, "vehicles", str(path), dict).items():
        where = f"{path}: vehicles.{shown(str(key))}"
        angle, location, centre, extent = (
            _numbers(_at(entry, name, where, list), 3, f"{where}.{name}")
            for name in ("angle", "location", "center", "extent")
        )
        own_R, own_m = _map_pose(np.concatenate([location + centre, angle]))
        name = entry.get("obj_type") or "vehicle"
        found.add(name, ego_R.T @ (own_m - ego_m), 2.0 * extent, ego_R.T @ own_R)
    yield found


def _map_pose(numbers: Rows) -> tuple[Rows, Rows]:
    """Return rotation and place of x y z roll yaw pitch of CARLA in right-handed axes."""
    roll, yaw, pitch = (float(angle) for angle in numbers[3:])
    return rotation_from_rpy_deg((roll, -pitch, -yaw)), numbers[:3] * _MIRROR


# ---------------------------------------------------------------- plain data


def _yaw(angle: float) -> Rows:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def _json(path: Path) -> Any:
    """Return a JSON document; raise InputError for a file that is none, or too large."""
    with open_regular(path, "a JSON file") as file:
        data = file.read(MAX_JSON_BYTES + 1)
    if len(data) > MAX_JSON_BYTES:
        raise InputError(f"{path}: too large for a file of boxes (at most {MAX_JSON_BYTES >> 20} MiB)")
    try:
        return json.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        reason = error.msg if isinstance(error, json.JSONDecodeError) else type(error).__name__
        raise InputError(f"{path}: must be JSON ({reason})") from error


def _at(holder: object, key: str, place: str, kind: type) -> Any:
    """Return a field of that type; raise InputError where there is none."""
    value = holder.get(key) if isinstance(holder, dict) else None
    if not isinstance(value, (list, tuple) if kind is list else kind):
        what = "a list" if kind is list else "a mapping"
        raise InputError(f"{place}: {key}: must be {what}")
    if isinstance(value, list | tuple) and len(value) > MAX_OBJECTS:
        raise InputError(f"{place}: {key}: too many entries (at most {MAX_OBJECTS})")
    return value


def _listed(value: object, place: str) -> list[dict[str, Any]]:
    """Return a list of mappings."""
    if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
        raise InputError(f"{place}: must be a list of objects")
    return value


def _fields(holder: Mapping[str, Any], names: Sequence[str], place: str) -> Rows:
    """Return numbers in named fields; one written as a text is accepted too."""
    return np.array([_number(holder.get(name), f"{place}: {name}") for name in names])


def _numbers(value: object, count: int, place: str) -> Rows:
    if not isinstance(value, list | tuple) or len(value) != count:
        raise InputError(f"{place}: must be {count} numbers")
    return np.array([_number(one, place) for one in value])


def _number(value: object, place: str) -> float:
    """Return a finite number, of at most 1e9 so that sums of it are too."""
    try:
        number = (
            float(value) if isinstance(value, int | float | str) and not isinstance(value, bool) else math.nan
        )
    except (ValueError, OverflowError):
        number = math.nan
    if not abs(number) <= 1e9:
        raise InputError(f"{place}: must be a finite number (got {shown(str(value))})")
    return number


ONCE = Layout("once", _once_files, _once_frames)
ZOD = Layout("zod", _zod_files, _zod_frames, _zod_calibration)
DAIR = Layout("dair-v2x", _dair_files, _dair_frames)
OPV2V = Layout("opv2v", _opv2v_files, _opv2v_frames)
