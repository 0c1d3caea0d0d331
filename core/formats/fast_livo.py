"""FAST-LIVO2: a configuration with extrin_calib, and the file of its camera beside it (import).

extrinsic_R and extrinsic_T take points of the LiDAR to the IMU, Rcl and Pcl those of the LiDAR to the camera in optical
axes; metres. The launch file, which is not read, says which camera file belongs to a configuration: here it is the one
whose name holds that of the configuration, or the only one, unless the configuration has the camera itself. The LiDAR's
axes are x forward, y left, z up. Versions for ROS 2 hold all of it as parameters of a node.
Source: FAST-LIVO2, src/LIVMapper.cpp, src/vio.cpp and include/common_lib.h.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, inverse, se3
from riglens.core.formats.lenses import brown_conrady, kannala_brandt
from riglens.core.formats.matrices import add_by_imu, rotation_of
from riglens.core.formats.mounts import Mounting
from riglens.core.formats.report import Notes
from riglens.core.formats.source import YAML, Source, Value, ros_parameters
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.nodes import shortened

_CALIBRATION, _RADIAL, _FISHEYE = (
    "extrin_calib",
    ("cam_d0", "cam_d1", "cam_d2", "cam_d3"),
    ("k1", "k2", "k3", "k4"),
)
_LIDARS = {1: "Livox Avia", 2: "Velodyne VLP-16", 5: "Hesai XT32", 6: "Hesai Pandar128"}
"""LiDARs of preprocess.lidar_type that name a model; 3 is an Ouster, 7 a RoboSense, 4 a depth camera."""


def recognises(source: Source) -> bool:
    """Return whether this is a YAML mapping with extrin_calib."""
    return _CALIBRATION in ros_parameters(source.yaml)


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the LiDAR and the camera around the IMU."""
    root, notes = ros_parameters(source.yaml), mounting.notes
    found = root.item(_CALIBRATION)
    imu_SE3_lidar = _transform(found, "extrinsic_R", "extrinsic_T", notes)
    camera_SE3_lidar = _transform(found, "Rcl", "Pcl", notes)
    camera = {"camera": (imu_SE3_lidar @ inverse(camera_SE3_lidar), _lens(root, source, mounting))}
    turn = add_by_imu(camera, mounting)
    mounting.add("lidar", "lidar", turn @ imu_SE3_lidar, said=_model(root))
    notes.converted("camera from optical axes, through the LiDAR")
    return mounting.rig(source.name)


def _transform(found: Value, rotation: str, position: str, notes: Notes) -> Matrix:
    numbers = np.array(found.item(rotation).numbers(9)).reshape(3, 3)
    return se3(rotation_of(found.item(rotation), numbers, notes), found.item(position).vector())


def _model(root: Value) -> str | None:
    settings = root.get("preprocess")
    kind = settings.get("lidar_type") if settings is not None and settings.is_mapping else None
    return None if kind is None else _LIDARS.get(kind.whole(0, 1000))


def _lens(root: Value, source: Source, mounting: Mounting) -> dict[str, Any]:
    if "cam_fx" in root:
        return _lens_in(root, mounting.notes)
    files = source.siblings("camera*.yaml")
    own = [file for file in files if source.name.lower() in file.name.lower()] or files
    if len(own) != 1:
        said = ", ".join(shortened(file.path.name, 40) for file in own) or "no camera*.yaml"
        return mounting.unknown_lens("camera", f"lens and image not in one file beside it ({said})")
    mounting.notes.read(f"image and lens from {shortened(own[0].path.name, 40)}", "camera")
    return _lens_in(ros_parameters(own[0].yaml), mounting.notes)


def _lens_in(root: Value, notes: Notes) -> dict[str, Any]:
    fx, fy, cx, cy = root.field_numbers("cam_fx", "cam_fy", "cam_cx", "cam_cy")
    lens = {"image": root.image("cam_width", "cam_height"), "fx": fx, "fy": fy, "cx": cx, "cy": cy}
    if root.item("scale", 1.0).number() != 1.0:
        notes.ignored("scale: the image is read at its full size", "camera")
    if root.item("cam_model").text().lower().startswith("equidistant"):
        return lens | kannala_brandt(root, root.field_numbers(*_FISHEYE), "camera", notes)
    numbers = [root.item(key, 0.0).number() for key in _RADIAL]
    return lens | brown_conrady(root, numbers, "camera", notes)


FAST_LIVO = Format("fast-livo", "FAST-LIVO2 configuration", YAML, recognises, read)
