"""Argoverse 2: calibration/egovehicle_SE3_sensor.feather with intrinsics.feather (import).

Poses of the sensors in the frame of the car: x forward, y left, z up, origin at the middle of the rear axle, which is
0.33 m above the ground; quaternions w, x, y, z; metres; cameras in optical axes. LiDARs are those without intrinsics.
Source: av2-api (SensorDataloader, PinholeCamera); published images are without distortion (av2-api, issues 219 and
226); two VLP-32C on the roof: Wilson et al., Argoverse 2 (NeurIPS 2021).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from riglens.core.errors import InputError
from riglens.core.formats.base import Format
from riglens.core.formats.frames import from_optical, kind_of, rotation_from_wxyz, se3
from riglens.core.formats.mounts import Mounting, Origin
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source, Value
from riglens.core.rig.model import Rig, Vehicle
from riglens.core.rig.yaml.nodes import shortened
from riglens.core.scene.readers.argoverse_files import REAR_AXLE_M

FUSION = Vehicle(body="sedan", length=4.87, width=1.85, height=1.48, rear_axle_x=REAR_AXLE_M[0])
POSES, LENSES = "egovehicle_SE3_sensor.feather", "intrinsics.feather"
_QUATERNION = ("qw", "qx", "qy", "qz")
_POSITION = ("tx_m", "ty_m", "tz_m")
_PIXELS = ("fx_px", "fy_px", "cx_px", "cy_px")
_RADIAL = ("k1", "k2", "k3")
_Rows = dict[str, Value]


def recognises(source: Source) -> bool:
    """Return whether this is one of both files, the folder of them, or a log with that folder in it."""
    if source.is_folder:
        return _folder(source) is not None
    return source.path.name in (POSES, LENSES)


def _folder(source: Source) -> Path | None:
    places = (source.folder, source.folder / "calibration")
    return next((place for place in places if (place / POSES).is_file()), None)


def read(source: Source, mounting: Mounting) -> Rig:
    """Return cameras and LiDARs."""
    folder = _folder(source)
    if folder is None:
        raise InputError(f"{source.where}: a calibration needs {POSES} in the same folder")
    has_lenses = (folder / LENSES).is_file()
    in_lenses = (*_PIXELS, *_RADIAL, "width_px", "height_px")
    lenses = _rows(source.another(folder / LENSES), in_lenses) if has_lenses else {}
    poses = _rows(source.another(folder / POSES), (*_QUATERNION, *_POSITION))
    for name, row in poses.items():
        _add(name, row, lenses.get(name), mounting)
    for name in lenses.keys() - poses.keys():
        mounting.notes.ignored(f"not in {POSES}: its pose is unknown", name)
    mounting.notes.converted(
        "cameras from optical axes and quaternions w x y z to roll, pitch, yaw of the body"
    )
    return mounting.rig(f"Argoverse 2 {_log(folder)}")


def _log(folder: Path) -> str:
    """Return the first characters of the log's name, which is the folder's or the one above."""
    resolved = folder.resolve()
    return shortened(resolved.parent.name if resolved.name == "calibration" else resolved.name, 40)


def _add(name: str, row: Value, lens: Value | None, mounting: Mounting) -> None:
    wxyz = row.field_numbers(*_QUATERNION)
    pose = se3(rotation_from_wxyz(row, wxyz), np.array(row.field_numbers(*_POSITION)))
    if lens is not None:
        mounting.add("camera", name, from_optical(pose), **_lens(lens, name, mounting.notes))
    elif kind_of(name) == "lidar":
        mounting.add("lidar", name, pose, said="Velodyne VLP-32C")
        mounting.notes.approximated(
            "LiDAR model not in the file: a Velodyne VLP-32C, as on the cars of Argoverse", name
        )
    else:
        mounting.notes.ignored(f"no LiDAR by its name and no camera in {LENSES}", name)


def _lens(row: Value, name: str, notes: Notes) -> dict[str, Any]:
    """Return image and pinhole; ignore the radial distortion, which published images do not have."""
    fx, fy, cx, cy = row.field_numbers(*_PIXELS)
    if any(row.field_numbers(*_RADIAL)):
        notes.ignored("k1 k2 k3: published images are without distortion", name)
    return {"image": row.image("width_px", "height_px"), "fx": fx, "fy": fy, "cx": cx, "cy": cy}


def _rows(file: Source, numbers: tuple[str, ...]) -> _Rows:
    """Return the rows of a Feather file by their `sensor_name`, each with these numbers; raise InputError."""
    # imported late: loading pyarrow takes longer than reading any other format
    from riglens.core.scene.readers.common import readable
    from riglens.core.scene.readers.feather import FeatherLimits, read_feather

    limits = FeatherLimits("a calibration of Argoverse 2", 1_000_000, memory_bytes=16_000_000, rows=1_000)
    with readable(file.path):
        table = read_feather(file.path, ("sensor_name", *numbers), limits, with_others=True)
    rows: _Rows = {}
    for index, row in enumerate(table.to_pylist(), 1):
        name = Value(row.pop("sensor_name"), file.where, f"row {index}.sensor_name").text()
        if name in rows:
            raise InputError(f"{file.where}: row {index}: sensor '{shortened(name)}' is given twice")
        rows[name] = file.value(row, f"row {index}")
    return rows


ARGOVERSE = Format(
    "argoverse", "Argoverse 2 calibration", (".feather",), recognises, read, has_folders=True, vehicle=FUSION,
    car="a Ford Fusion, the car of Argoverse",
    origin=Origin("the rear axle", lambda car: (car.rear_axle_x, 0.0, REAR_AXLE_M[2]), is_known=True),
)  # fmt: skip
