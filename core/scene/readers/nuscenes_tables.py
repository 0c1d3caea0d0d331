"""The tables of a nuScenes folder: which ego pose each sample has, and which category each object.

Source of the format: docs/schema_nuscenes.md of the nuScenes development kit. Every table is an array of flat
records; `sample_data` and `ego_pose` of the full set hold millions, so all of them are read record by record.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.scene.boxes import Progress, rotations_from_quaternions
from riglens.core.scene.limits import MAX_NAME_CHARS
from riglens.core.scene.readers.common import shown
from riglens.core.scene.readers.json_records import Record, json_records

CHANNELS = ("LIDAR_TOP", "LIDAR_CONCAT")
"""LiDARs whose sweeps give the time of a sample's boxes, the best first; any other LiDAR comes after them, by name."""
MAX_CHANNELS = 100
TABLES = (
    "sample",
    "sensor",
    "calibrated_sensor",
    "sample_data",
    "ego_pose",
    "category",
    "instance",
    "sample_annotation",
)
"""The tables that determine the boxes, in the order in which they are read."""

MAX_RECORDS = 50_000_000
MAX_KEPT_RECORDS = 1_000_000
"""Records of a table that is held in memory: samples, instances, categories, sensors and their calibrations."""
_QUATERNION_TOLERANCE = 0.01
_LATEST = 1e19
"""A time stamp in microseconds, or in nanoseconds, of this century."""
V = TypeVar("V")


class Table:
    """One table of the folder; its methods name file and record when a field is malformed."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def records(self, progress: Progress, most: int = MAX_RECORDS) -> Iterator[Record]:
        """Yield the records in the order of the file; raise InputError when there are more than `most`."""
        for record in json_records(self.path, progress):
            if record.number > most:
                raise InputError(f"{self.path}: too many records (at most {most})")
            yield record

    def fail(self, record: Record, name: str, accepted: str) -> InputError:
        """Return the error for a field of a record."""
        found = shown(str(record.fields[name])) if name in record.fields else "nothing"
        return InputError(f"{self.path}: record {record.number}: {name!r}: must be {accepted} (got {found})")

    def text(self, record: Record, name: str) -> str:
        """Return a field that is text, a token or a name."""
        value = record.fields.get(name)
        if not isinstance(value, str) or len(value) > MAX_NAME_CHARS:
            raise self.fail(record, name, f"text of at most {MAX_NAME_CHARS} characters")
        return value

    def found(self, record: Record, name: str, values: Mapping[str, V]) -> V:
        """Return the value that a token in a field refers to."""
        try:
            return values[self.text(record, name)]
        except KeyError:
            raise self.fail(record, name, "a token that its table holds") from None

    def numbers(self, record: Record, name: str, count: int) -> list[float]:
        """Return a field that is a list of finite numbers."""
        value = record.fields.get(name)
        accepted = f"a list of {count} finite numbers"
        if not isinstance(value, list) or len(value) != count:
            raise self.fail(record, name, accepted)
        try:
            if all(type(number) in (float, int) and math.isfinite(number) for number in value):
                return [float(number) for number in value]
        except OverflowError:  # a whole number larger than any double
            pass
        raise self.fail(record, name, accepted)

    def quaternion(self, record: Record, name: str) -> list[float]:
        """Return a rotation as w, x, y, z."""
        wxyz = self.numbers(record, name, 4)
        if abs(math.hypot(*wxyz) - 1.0) > _QUATERNION_TOLERANCE:
            raise self.fail(record, name, "a quaternion w, x, y, z of length 1")
        return wxyz


@dataclass(frozen=True)
class Samples:
    """The annotated moments: number by token, in order of scene and time, and the ego pose of each.

    global_SE3_ego is kept as rotation (n, 3, 3) and place (n, 3), metres, at the time of the sweep of `channel`.
    """

    number: dict[str, int]
    scenes: list[tuple[str, int]]
    """Name and number of samples of each scene, in the order of the samples."""
    channel: str
    rotation: NDArray[np.float64]
    place_m: NDArray[np.float64]


class NuscenesTables:
    """Tables of a folder, plain or gzip-compressed; raise InputError when one is missing."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._tables = {name: Table(path) for name, path in _table_files(folder).items()}
        self._sizes = [table.path.stat().st_size for table in self._tables.values()]

    def files(self) -> list[Path]:
        """Return all tables that are read."""
        return [table.path for table in self._tables.values()]

    def table(self, name: str) -> Table:
        """Return one of TABLES."""
        return self._tables[name]

    def share(self, name: str, progress: Progress) -> Progress:
        """Return a progress function for one table, by the bytes of all of them."""
        place = TABLES.index(name)
        before, own, total = sum(self._sizes[:place]), self._sizes[place], max(1, sum(self._sizes))
        return lambda fraction: progress((before + fraction * own) / total)

    def samples(self, progress: Progress) -> Samples:
        """Return all samples with the pose of the ego vehicle when the LiDAR took its sweep."""
        number, scenes = self._numbered_samples(progress)
        channel, pose_tokens = self._pose_tokens(number, self._calibrations(progress), progress)
        wanted = set(pose_tokens)
        poses: dict[str, tuple[list[float], list[float]]] = {}
        table = self.table("ego_pose")
        for record in table.records(self.share("ego_pose", progress)):
            token = table.text(record, "token")
            if token in wanted:
                poses[token] = (
                    table.numbers(record, "translation", 3),
                    table.quaternion(record, "rotation"),
                )
        for token in pose_tokens:
            if token not in poses:
                raise InputError(f"{table.path}: no pose {shown(token)}, which sample_data refers to")
        places = [poses[token][0] for token in pose_tokens]
        quaternions = np.array([poses[token][1] for token in pose_tokens]).reshape(-1, 4)
        return Samples(
            number, scenes, channel, rotations_from_quaternions(quaternions), np.array(places).reshape(-1, 3)
        )

    def category_of_instance(self, progress: Progress) -> dict[str, str]:
        """Return the category name by token of the instance; every name is kept once."""
        names = self._columns("category", "name", progress)
        table = self.table("instance")
        return {
            table.text(record, "token"): table.found(record, "category_token", names)
            for record in table.records(self.share("instance", progress), MAX_KEPT_RECORDS)
        }

    def _numbered_samples(self, progress: Progress) -> tuple[dict[str, int], list[tuple[str, int]]]:
        """Return frame by token, scenes in the order of their first sample, samples by time; and samples by scene."""
        table, scenes = self.table("sample"), dict[str, int]()
        rows, taken = [], set[tuple[int, float]]()
        for record in table.records(self.share("sample", progress), MAX_KEPT_RECORDS):
            scene = scenes.setdefault(table.text(record, "scene_token"), len(scenes))
            time = record.fields.get("timestamp")
            if isinstance(time, bool) or not isinstance(time, (int, float)) or not 0 <= time <= _LATEST:
                raise table.fail(record, "timestamp", f"a number from 0 to {_LATEST:g}")
            if (scene, time) in taken:
                raise table.fail(record, "timestamp", "a time that no other sample of the scene has")
            taken.add((scene, time))
            rows.append((scene, time, table.text(record, "token")))
        tokens = dict.fromkeys(token for *_, token in sorted(rows))
        count = Counter(scene for scene, *_ in rows)
        names = self._scene_names()
        counts = [(names.get(token, token), count[scene]) for token, scene in scenes.items()]
        return {token: place for place, token in enumerate(tokens)}, counts

    def _scene_names(self) -> dict[str, str]:
        """Return names by token from the optional table of scenes."""
        path = table_file(self._folder, "scene")
        if path is None:
            return {}
        table = Table(path)
        records = table.records(lambda _share: None, MAX_KEPT_RECORDS)
        return {table.text(record, "token"): table.text(record, "name") for record in records}

    def _calibrations(self, progress: Progress) -> dict[str, str]:
        """Return the channel by token of the calibrations of all LiDARs, one per vehicle or drive."""
        channels = self._columns("sensor", "channel", progress)
        sensors = self._columns("calibrated_sensor", "sensor_token", progress)
        lidars = {token: name for token, name in channels.items() if name.upper().startswith("LIDAR")}
        if not lidars or len(set(lidars.values())) > MAX_CHANNELS:
            raise InputError(
                f"{self.table('sensor').path}: must hold 1 to {MAX_CHANNELS} LiDARs, channels such as {CHANNELS[0]} "
                f"(got {len(set(lidars.values()))})"
            )
        return {token: lidars[sensor] for token, sensor in sensors.items() if sensor in lidars}

    def _pose_tokens(
        self, number: dict[str, int], calibrations: dict[str, str], progress: Progress
    ) -> tuple[str, list[str]]:
        """Return the best LiDAR that has a key frame for each sample, and the tokens of the ego poses of those."""
        if not number:
            return CHANNELS[0], []
        table = self.table("sample_data")
        found = {channel: [""] * len(number) for channel in _by_preference(calibrations.values())}
        for record in table.records(self.share("sample_data", progress)):
            if record.fields.get("is_key_frame") is not True:
                continue
            channel = calibrations.get(table.text(record, "calibrated_sensor_token"))
            if channel is not None:
                place = table.found(record, "sample_token", number)
                found[channel][place] = table.text(record, "ego_pose_token")
        for channel, tokens in found.items():
            if all(tokens):
                return channel, tokens
        first, tokens = next(iter(found.items()), (CHANNELS[0], [""] * len(number)))
        missing = next(sample for sample, place in number.items() if not tokens[place])
        raise InputError(f"{table.path}: no key frame of {first} for sample {shown(missing)}")

    def _columns(self, name: str, field: str, progress: Progress) -> dict[str, str]:
        """Return one text field by token."""
        table = self.table(name)
        records = table.records(self.share(name, progress), MAX_KEPT_RECORDS)
        return {table.text(record, "token"): table.text(record, field) for record in records}


def _by_preference(channels: Iterable[str]) -> list[str]:
    return sorted(
        set(channels), key=lambda name: (CHANNELS.index(name) if name in CHANNELS else len(CHANNELS), name)
    )


def tables_folder(path: Path) -> Path | None:
    """Return the folder with the tables of boxes: the path itself or one inside it; None when it is not nuScenes.

    Raise InputError when there are several versions to choose from, or when some of the tables are missing.
    """
    found = version_folder(path, ("sample_annotation",))
    if found is None and _has(path, ("sample", "instance")):
        raise InputError(f"{path / 'sample_annotation.json'}: missing: {_NEEDED}")
    return found


def version_folder(path: Path, names: Sequence[str]) -> Path | None:
    """Return the folder that holds these tables: the path itself, or the one folder up to two levels inside it.

    Raise InputError when there are several to choose from.
    """
    if _has(path, names):
        return path
    for pattern in ("v1.0-*", "*", "*/*"):
        places = {file.parent for file in path.glob(f"{pattern}/{names[0]}.json*")}
        versions = sorted(folder for folder in places if _has(folder, names))
        if len(versions) > 1:
            shorter = ", ".join(str(folder.relative_to(path)) for folder in versions[:20])
            raise InputError(f"{path}: holds several versions: choose one of {shorter}")
        if versions:
            return versions[0]
    return None


def table_file(folder: Path, name: str) -> Path | None:
    """Return the file of a table, plain or gzip-compressed, None when there is none."""
    files = (folder / f"{name}.json{ending}" for ending in ("", ".gz"))
    return next((file for file in files if file.is_file()), None)


_NEEDED = f"a nuScenes folder needs {', '.join(TABLES)}"


def _has(folder: Path, names: Sequence[str]) -> bool:
    return all(table_file(folder, name) is not None for name in names)


def _table_files(folder: Path) -> dict[str, Path]:
    files = {name: file for name in TABLES if (file := table_file(folder, name)) is not None}
    missing = [name for name in TABLES if name not in files]
    if missing:
        also = f" (and {', '.join(missing[1:])})" if len(missing) > 1 else ""
        raise InputError(f"{folder / missing[0]}.json: missing{also}: {_NEEDED}")
    return files
