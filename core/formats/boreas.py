"""Boreas: the folder calib of a sequence, with T_applanix_lidar.txt, T_camera_lidar.txt and P_camera.txt (import).

T_a_b takes points of b to a: (4, 4), metres. The Applanix frame has x to the RIGHT, y FORWARD and z up: there the
camera, which looks ahead, looks along y. P_camera projects points in optical axes into the rectified images.
Source: pyboreas, DATA_REFERENCE.md, "Sensor Details" and "Lidar-to-Camera Extrinsics"; Burnett et al., Boreas (2022).
"""

from __future__ import annotations

import numpy as np

from riglens.core.errors import InputError
from riglens.core.formats.apollo import VEHICLE_R_ROOT
from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, from_optical, inverse, se3
from riglens.core.formats.lenses import pinhole
from riglens.core.formats.matrices import quoted_matrix, rigid_of
from riglens.core.formats.mounts import Mounting
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.nodes import shortened

IMAGE = (2448, 2048)
_LIDAR, _CAMERA, _RADAR, _LENS = (
    "T_applanix_lidar.txt",
    "T_camera_lidar.txt",
    "T_radar_lidar.txt",
    "P_camera.txt",
)
_KNOWN = (_LIDAR, _CAMERA, _RADAR, _LENS)


def recognises(source: Source) -> bool:
    """Return whether this is the folder, the sequence around it, or one of its files."""
    if source.is_folder:
        return _beside(source, _LIDAR) is not None
    return source.path.name in (_LIDAR, _CAMERA, _LENS)


def _beside(source: Source, name: str) -> Source | None:
    return source.sibling(name, f"calib/{name}")


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the LiDAR and the camera around the Applanix frame."""
    notes = mounting.notes
    lidar = _beside(source, _LIDAR)
    if lidar is None:
        raise InputError(f"{source.where}: {_LIDAR} is missing beside it")
    vehicle_SE3_lidar = se3(VEHICLE_R_ROOT, np.zeros(3)) @ _transform(lidar, notes)
    mounting.add("lidar", "lidar", vehicle_SE3_lidar, said="Velodyne VLS-128")
    camera, lens = _beside(source, _CAMERA), _beside(source, _LENS)
    if camera is None or lens is None:
        notes.ignored(f"{_CAMERA} or {_LENS} is missing", "camera")
    else:
        value, p = quoted_matrix(lens, 4, 4)
        if p[0, 1] or p[:3, 3].any():
            value.refuse("a projection without skew and offset", "another one")
        pose = vehicle_SE3_lidar @ inverse(_transform(camera, notes))
        image = mounting.unknown_image("camera", IMAGE, pinhole(p))
        mounting.add("camera", "camera", from_optical(pose), image=image, **pinhole(p))
    if _beside(source, _RADAR):
        notes.ignored("neither camera nor LiDAR", "radar")
    others = [file.path.name for file in lidar.siblings("*") if file.path.name not in _KNOWN]
    if others:
        notes.ignored("other files are not used", *(shortened(name, 40) for name in others))
    notes.converted("from x right, y forward, and optical axes, through the LiDAR")
    return mounting.rig(f"Boreas {source.name}")


def _transform(file: Source, notes: Notes) -> Matrix:
    return rigid_of(*quoted_matrix(file, 4, 4), notes, file.path.name)


BOREAS = Format("boreas", "Boreas calibration", (".txt",), recognises, read, has_folders=True)
