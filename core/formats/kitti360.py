"""KITTI-360: the folder calibration with calib_cam_to_pose.txt (import).

image_00 to image_03 (3, 4) take points of the cameras, in optical axes, to the GPS/IMU: x forward, y to the RIGHT,
z DOWN. calib_cam_to_velo.txt leads from camera 0 to the Velodyne. perspective.txt holds the pinholes of cameras 0 and 1
as in raw drives of KITTI, image_02.yaml and image_03.yaml the fisheyes as MEI models. The cameras are 1.55 m above the
ground, which puts the IMU at 0.48 m; that it is over the rear axle is assumed.
Source: KITTI-360 documentation; kitti360Scripts, loadCalibration.py and project.py.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from riglens.core.errors import InputError
from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, from_optical, inverse
from riglens.core.formats.kitti import (
    PASSAT,
    PASSAT_WORDS,
    UNUSED,
    Lines,
    image_size,
    raw_lens,
    table_matrix,
    table_of,
)
from riglens.core.formats.lenses import pinhole
from riglens.core.formats.matrices import quoted_matrix, rigid_of
from riglens.core.formats.mounts import Mounting, Origin
from riglens.core.formats.opencv_yaml import read_lens
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source
from riglens.core.rig.model import Rig

IMU_HEIGHT_M = 0.48
VEHICLE_SE3_IMU: Matrix = np.diag([1.0, -1.0, -1.0, 1.0])
_POSES, _VELO, _SICK, _PINHOLES = (
    "calib_cam_to_pose.txt",
    "calib_cam_to_velo.txt",
    "calib_sick_to_velo.txt",
    "perspective.txt",
)


def recognises(source: Source) -> bool:
    """Return whether this is the folder, the one above, or one of its text files."""
    files = (_POSES, _VELO, _SICK, _PINHOLES)
    return _beside(source, _POSES) is not None if source.is_folder else source.path.name in files


def _beside(source: Source, name: str) -> Source | None:
    return source.sibling(name, f"calibration/{name}")


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the four cameras and the Velodyne."""
    notes = mounting.notes
    found = _beside(source, _POSES)
    if found is None:
        raise InputError(f"{source.where}: {_POSES} is missing")
    poses = table_of(found)
    pinholes = _beside(source, _PINHOLES)
    table = table_of(pinholes) if pinholes is not None else {}
    for index in range(4):
        name = f"image_{index:02d}"
        if name in poses:
            lens = _beside(source, f"{name}.yaml") if index > 1 else None
            _add(name, _pose(poses, name, notes), table, lens, mounting)
    velo = _beside(source, _VELO)
    if velo is not None and "image_00" in poses:
        velo_SE3_camera0 = rigid_of(*quoted_matrix(velo, 3, 4), notes, _VELO)
        pose = _pose(poses, "image_00", notes) @ inverse(velo_SE3_camera0)
        mounting.add("lidar", "velodyne", pose, said="Velodyne HDL-64E")
    if _beside(source, _SICK):
        notes.ignored(
            "laser scanners that look at the street's sides: their beams are not in the files", "SICK"
        )
    notes.converted("from the axes of the IMU, y right, z down, and optical axes")
    return mounting.rig(f"KITTI-360 {source.name}")


def _pose(poses: Lines, name: str, notes: Notes) -> Matrix:
    return VEHICLE_SE3_IMU @ rigid_of(*table_matrix(poses, (name,), 3, 4), notes)


def _add(name: str, pose: Matrix, table: Lines, lens: Source | None, mounting: Mounting) -> None:
    """Add a camera with the lens of its file, or with that of perspective.txt, raw or rectified."""
    notes, number = mounting.notes, name.removeprefix("image_")
    fields: dict[str, Any]
    if lens is not None:
        fields = read_lens(lens.yaml, name, notes)
    elif f"K_{number}" in table:
        fields = raw_lens(table, number, name, notes)
    elif f"P_rect_{number}" in table:
        pose = pose @ inverse(rigid_of(*table_matrix(table, (f"R_rect_{number}",), 3, 3), notes))
        _, p = table_matrix(table, (f"P_rect_{number}",), 3, 4)
        fields = {"image": image_size(table, f"S_rect_{number}"), **pinhole(p)}
        notes.approximated(f"K_{number} not in the file: the rectified camera of P_rect_{number}", name)
    else:
        notes.ignored("its intrinsics are missing", name)
        return
    mounting.add("camera", name, from_optical(pose), **fields)


KITTI_360 = Format(
    "kitti-360", "KITTI-360 calibration", (".txt",), recognises, read, has_folders=True, vehicle=PASSAT,
    car=PASSAT_WORDS, origin=Origin("the IMU", lambda car: (car.rear_axle_x, 0.0, IMU_HEIGHT_M)),
    harmless=f"{UNUSED}|camera_name",
)  # fmt: skip
