"""Read the true points that a recording has on its objects, and the rigs that recorded it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.feather as feather
import pyarrow.parquet as parquet
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import open_regular, read_csv
from riglens.core.geometry import Pose, rpy_deg_from_rotation
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Lidar, LinearAngles, Rig
from riglens.core.scene.boxes import rotations_from_quaternions
from riglens.core.scene.readers.argoverse_files import is_feather
from riglens.core.scene.readers.classes import ANY_TABLE, ARGOVERSE, UNMAPPED, ClassTable

COLUMNS = ("num_lidar_pts", "num_interior_pts")
"""Names in nuScenes and Argoverse 2 of the number of points in a box."""
MAX_RIGS_BYTES = 1 << 24
MODEL = "velodyne-hdl-32e"
NUSCENES_AZIMUTHS = 1085


def true_points(path: Path, overrides: Mapping[str, str]) -> NDArray[np.int64]:
    """Return the points of every box that belongs to a class, in the order in which the box reader gives them.

    Read a table or log with the column `num_lidar_pts` or `num_interior_pts`, which the box reader has accepted;
    overrides of its classes as for the reader. Raise InputError when there is none, or a number below 0.
    """
    is_log = is_feather(path)
    name, order = "category" if is_log else "cls", "timestamp_ns" if is_log else None
    table, column = _columns(path, name, order)
    classes = ClassTable(ARGOVERSE if is_log else ANY_TABLE, overrides)
    encoded = table[name].cast(pa.string()).combine_chunks().dictionary_encode()
    codes = np.asarray(classes.codes(encoded.dictionary.to_pylist()), np.int64)[encoded.indices.to_numpy()]
    rows = np.flatnonzero(codes != UNMAPPED)
    if order is not None:
        _, frame = np.unique(table[order].cast(pa.int64()).to_numpy(), return_inverse=True)
        rows = rows[np.argsort(frame[rows], kind="stable")]
    try:
        points = np.asarray(table[column].cast(pa.int64()).to_numpy()[rows], np.int64)
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError) as error:
        raise InputError(f"{path}: column '{column}': must be integers") from error
    if points.size and points.min() < 0:
        raise InputError(f"{path}: column '{column}': must be integers ≥ 0 (got {points.min()})")
    return points


def _columns(path: Path, name: str, order: str | None) -> tuple[Any, str]:
    """Return the columns needed of a file, and what that of the points is called."""
    try:
        if order is not None:
            table = feather.read_table(path)
        elif path.suffix.lower() in (".parquet", ".pq"):
            table = parquet.read_table(path)
        else:
            table = read_csv(path)
    except (pa.ArrowInvalid, OSError) as error:
        raise InputError(f"{path}: cannot be read: {str(error).splitlines()[0]}") from error
    found = next((column for column in COLUMNS if column in table.column_names), None)
    if found is None:
        raise InputError(f"{path}: needs a column of true points: {' or '.join(COLUMNS)}")
    return table.select([name, found, *([order] if order else [])]), found


@dataclass(frozen=True)
class Recorder:
    """Recording LiDAR: its model and its number of azimuths."""

    model: str = MODEL
    azimuths: int = NUSCENES_AZIMUTHS

    def lidar(self, name: str, pose: Pose) -> Lidar:
        """Return the LiDAR at a place; InputError for a model that is not a LiDAR."""
        sensor = sensor_from_model(self.model, name, pose)
        if not isinstance(sensor, Lidar):
            raise InputError(f"must be a LiDAR of the library (got the camera '{self.model}')", "model")
        return sensor.replace(azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=self.azimuths))


def rigs_by_sequence(path: Path, recorder: Recorder) -> dict[str, Rig]:
    """Return the LiDARs of each sequence from JSON {sequence: {sensor: {translation, rotation_wxyz}}} as in nuScenes'
    calibration; sensors with `camera_intrinsic` are left out. Raise InputError for anything else."""
    try:
        with open_regular(path, "rigs by sequence in JSON") as file:
            content = file.read(MAX_RIGS_BYTES + 1)
        if len(content) > MAX_RIGS_BYTES:
            raise InputError(f"{path}: too large for rigs by sequence (at most {MAX_RIGS_BYTES >> 20} MiB)")
        document = json.loads(content)
        return {str(name): _rig(str(name), sensors, recorder) for name, sensors in document.items()}
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"{path}: must be {{sequence: {{sensor: {{translation, rotation_wxyz}}}}}} in JSON"
        ) from error


def _rig(name: str, sensors: Mapping[str, Any], recorder: Recorder) -> Rig:
    lidars = []
    for sensor, placed in sensors.items():
        if "camera_intrinsic" in placed:
            continue
        x, y, z = (float(value) for value in placed["translation"])
        turn = np.array([[float(value) for value in placed["rotation_wxyz"]]])
        if turn.shape != (1, 4) or not np.linalg.norm(turn) > 0.0:
            raise ValueError(turn)
        pose = Pose((x, y, z), rpy_deg_from_rotation(rotations_from_quaternions(turn)[0]))
        lidars.append(recorder.lidar(str(sensor), pose))
    return Rig(name=name[:200], sensors=tuple(lidars))
