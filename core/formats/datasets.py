"""Calibrations of data sets with a matrix or quaternion for each camera: ONCE, ZOD, DDAD, DAIR-V2X, OPV2V (import).

Metres; cameras in optical axes, but OPV2V's, which are those of CARLA. Poses take points of the sensor to
- ONCE: `cam_to_velo`, to the LiDAR on the roof: x to the LEFT, y BACKWARDS, z up. Source: ONCE documentation,
  "Coordinate systems"; once_devkit, once.py.
- ZOD: `extrinsics` and `lidar_extrinsics`, to the car: x forward, y left, z up; the LiDAR itself has x to the RIGHT, y
  FORWARD. Four coefficients of a Kannala-Brandt lens. Source: zod, data_classes/calibration.py, utils/geometry.py.
- DDAD and others in TRI's DGP: `extrinsics`, to the ground under the rear axle: x forward, y left, z up. Its LiDARs are
  merged into one cloud in that frame. Source: dgp, proto/sample.proto and geometry.proto; DDAD, "Sensor placement".
- DAIR-V2X: `lidar_to_camera` takes points of the LiDAR (x forward, y left, z up) to the camera. Source: DAIR-V2X,
  data/README.md, tools/dataset_converter/gen_kitti.
- OPV2V, V2XSet: `cords`, `lidar_pose` and `true_ego_pos`: x y z roll yaw pitch in CARLA's map, y to the right, degrees.
  Source: OpenCOOD, data annotation tutorial, utils/transformation_utils.py.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from riglens.core.errors import InputError
from riglens.core.formats.apollo import VEHICLE_R_ROOT
from riglens.core.formats.base import Format
from riglens.core.formats.carla_toml import right_handed
from riglens.core.formats.frames import Matrix, from_optical, inverse, rotation_from_wxyz, se3
from riglens.core.formats.lenses import BROWN_CONRADY, KANNALA_BRANDT, brown_conrady, kannala_brandt, pinhole
from riglens.core.formats.matrices import rigid, rigid_of
from riglens.core.formats.mounts import ACTOR, ON_ROOF, REAR_AXLE, Mounting, Origin, rear_axle_on_ground
from riglens.core.formats.source import MAX_PIXELS, YAML, Source, Value
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.nodes import shortened

_LEFT_BACK = se3(np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.zeros(3))
"""From x left, y backwards, z up to x forward, y left, z up."""
_CALIBRATED = "calib"
_FROM_LIDAR, _INTRINSIC = "lidar_to_camera", "camera_intrinsic"
_CAMERA = re.compile(r"camera[0-9]{1,2}")


def _lens(matrix: Value) -> dict[str, Any]:
    """Return focal lengths and centre of a camera matrix: rows of 3 or 4 numbers, or 9 in a row."""
    rows = matrix.elements()
    if rows and rows[0].is_list:
        numbers = np.array([row.numbers(len(rows[0].elements()))[:3] for row in rows[:3]])
    else:
        numbers = np.array(matrix.numbers(9)).reshape(3, 3)
    if numbers.shape != (3, 3) or not (numbers[0, 0] > 0.0 and numbers[1, 1] > 0.0):
        matrix.refuse("a camera matrix with focal lengths", "another one")
    return pinhole(numbers)


# ---------------------------------------------------------------- ONCE


def _once_cameras(source: Source) -> dict[str, Value]:
    calib = source.json.get(_CALIBRATED) if source.json.is_mapping else None
    found = dict(calib.items()) if calib is not None and calib.is_mapping else {}
    return {name: one for name, one in found.items() if "cam_to_velo" in one}


def _is_once(source: Source) -> bool:
    return bool(_once_cameras(source))


def _read_once(source: Source, mounting: Mounting) -> Rig:
    notes, about = mounting.notes, source.json.get("meta_info")
    size = about.get("image_size") if about is not None and about.is_mapping else None
    for name, camera in _once_cameras(source).items():
        lens = _lens(camera.item("cam_intrinsic"))
        if size is not None:
            width, height = (side.whole(1, MAX_PIXELS) for side in size.elements(2))
            lens["image"] = width, height
        else:
            lens["image"] = mounting.unknown_image(name, (1920, 1020), lens)
        if "distortion" in camera:
            bend = camera.item("distortion")
            lens |= brown_conrady(bend, bend.numbers(), name, notes)
        pose = _LEFT_BACK @ rigid(camera.item("cam_to_velo"), name, notes)
        mounting.add("camera", name, from_optical(pose), **lens)
    notes.approximated("LiDAR of 40 beams by ONCE's paper: taken for a Hesai Pandar40P", "lidar_roof")
    mounting.add("lidar", "lidar_roof", np.eye(4), said="Hesai Pandar40P")
    notes.converted("from x left, y backwards and optical axes to x forward, y left")
    return mounting.rig(f"ONCE {source.name}")


# ---------------------------------------------------------------- ZOD


def _is_zod(source: Source) -> bool:
    camera = source.json.get("FC") if source.json.is_mapping else None
    return camera is not None and "extrinsics" in camera and "image_dimensions" in camera


def _read_zod(source: Source, mounting: Mounting) -> Rig:
    notes, camera = mounting.notes, source.json.item("FC")
    width, height = (side.whole(1, MAX_PIXELS) for side in camera.item("image_dimensions").elements(2))
    bend = camera.item("distortion")
    lens = _lens(camera.item("intrinsics")) | {"image": (width, height)}
    lens |= kannala_brandt(bend, bend.numbers(4), "FC", notes)
    mounting.add("camera", "FC", from_optical(rigid(camera.item("extrinsics"), "FC", notes)), **lens)
    if "lidar_extrinsics" in camera:
        own = rigid(camera.item("lidar_extrinsics"), "lidar", notes)
        turn = se3(VEHICLE_R_ROOT.T, np.zeros(3))  # its own x is forward once y was
        mounting.add("lidar", "lidar_velodyne", own @ turn, said="Velodyne VLS-128")
        notes.approximated("two VLP-16 beside the VLS-128 are not in the file", "lidar_velodyne")
    notes.converted("camera from optical axes, LiDAR from x right, y forward")
    return mounting.rig(f"ZOD {source.name}")


# ---------------------------------------------------------------- DDAD


def _is_ddad(source: Source) -> bool:
    root = source.json
    return root.is_mapping and all(
        isinstance(root.raw.get(key), list) for key in ("names", "intrinsics", "extrinsics")
    )


def _read_ddad(source: Source, mounting: Mounting) -> Rig:
    notes, root = mounting.notes, source.json
    names, lenses, poses = (root.item(key).elements() for key in ("names", "intrinsics", "extrinsics"))
    if not len(names) == len(lenses) == len(poses):
        root.refuse(
            "as many names as intrinsics and extrinsics", f"{len(names)}, {len(lenses)} and {len(poses)}"
        )
    for called, lens, pose in zip(names, lenses, poses, strict=True):
        name, place = called.text(), _dgp_pose(pose)
        if lens.is_mapping and lens.item("fx", 0.0).number() > 0.0:
            mounting.add("camera", name, from_optical(place), **_dgp_lens(lens, name, mounting))
        elif np.allclose(place, np.eye(4)):
            notes.ignored("points in the car's frame: where their LiDARs are is not in the file", name)
        else:
            mounting.add("lidar", name, place)
    notes.converted("cameras from optical axes and quaternions to roll, pitch, yaw")
    return mounting.rig(f"DGP {source.name}")


def _dgp_pose(value: Value) -> Matrix:
    """Return a Pose; numbers that are 0 are left out where protobuf wrote it."""
    rotation, position = value.item("rotation", {}), value.item("translation", {})
    wxyz = [rotation.item(key, 0.0).number() for key in ("qw", "qx", "qy", "qz")]
    xyz = [position.item(key, 0.0).number() for key in "xyz"]
    return se3(rotation_from_wxyz(rotation, wxyz), np.array(xyz))


def _dgp_lens(value: Value, name: str, mounting: Mounting) -> dict[str, Any]:
    fx, fy, cx, cy = value.field_numbers("fx", "fy", "cx", "cy")
    lens: dict[str, Any] = {"fx": fx, "fy": fy, "cx": cx, "cy": cy}
    lens["image"] = mounting.unknown_image(name, (1936, 1216), lens)
    model = value.item("fisheye", 0).number()
    if model > 1.0:
        mounting.notes.ignored(f"lens distortion of the model fisheye = {model:g}", name)
        return lens
    names = KANNALA_BRANDT if model else BROWN_CONRADY
    bend = [value.item(key, 0.0).number() for key in names]
    return lens | (kannala_brandt if model else brown_conrady)(value, bend, name, mounting.notes)


# ---------------------------------------------------------------- DAIR-V2X


def _dair_root(source: Source) -> Path | None:
    """Return the folder around `calib` of a vehicle's side, from it or from a file of a transform."""
    if not source.is_folder and source.folder.name not in (_FROM_LIDAR, _INTRINSIC):
        return None
    tops = (source.folder, source.folder.parent) if source.is_folder else (source.folder.parent.parent,)
    return next((top for top in tops if (top / _CALIBRATED / _FROM_LIDAR).is_dir()), None)


def _is_dair(source: Source) -> bool:
    return _dair_root(source) is not None


def _read_dair(source: Source, mounting: Mounting) -> Rig:
    notes, root = mounting.notes, _dair_root(source)
    if root is None:
        raise InputError(f"{source.where}: must be a folder with {_CALIBRATED}/{_FROM_LIDAR}")
    calib = source.another(root / _CALIBRATED)
    own = source.another(calib.path / _FROM_LIDAR)
    listed = [file.path.stem for file in own.siblings("*.json", most=100_000)]
    frame = mounting.options.token or (listed[0] if source.is_folder and listed else source.path.stem)
    pose, lens = (calib.path / folder / f"{frame}.json" for folder in (_FROM_LIDAR, _INTRINSIC))
    for file in (pose, lens):
        if frame not in listed or not file.is_file():
            raise InputError(
                f"{source.where}: calibration of frame '{shortened(frame)}' is missing: {file.name}"
            )
    notes.read(f"frame {frame} of {len(listed)}", field="token" if len(listed) > 1 else "")
    camera_SE3_lidar = _rotation_translation(source.another(pose).json, mounting)
    mounting.add(
        "camera",
        "camera",
        from_optical(inverse(camera_SE3_lidar)),
        **_dair_lens(source.another(lens).json, mounting),
    )
    notes.approximated("LiDAR of 40 beams by the paper: taken for a Hesai Pandar40P", "lidar")
    mounting.add("lidar", "lidar", np.eye(4), said="Hesai Pandar40P")
    notes.converted("camera from optical axes, through the LiDAR")
    return mounting.rig(f"DAIR-V2X {frame}")


def _rotation_translation(root: Value, mounting: Mounting) -> Matrix:
    """Return a transform of rows of `rotation`, and `translation` as three numbers or three rows of one."""
    value = root.item("transform") if "transform" in root else root
    shift = value.item("translation").elements(3)
    position = [(part.elements(1)[0] if part.is_list else part).number() for part in shift]
    matrix = np.column_stack([value.item("rotation").matrix(3, 3), position])
    return rigid_of(value.item("rotation"), matrix, mounting.notes, "camera")


def _dair_lens(root: Value, mounting: Mounting) -> dict[str, Any]:
    lens = _lens(root.item("cam_K"))
    has_size = "width" in root and "height" in root
    lens["image"] = root.image() if has_size else mounting.unknown_image("camera", (1920, 1080), lens)
    if "cam_D" not in root:
        return lens
    bend = root.item("cam_D")
    return lens | brown_conrady(bend, bend.numbers(), "camera", mounting.notes)


# ---------------------------------------------------------------- OPV2V


def _is_opv2v(source: Source) -> bool:
    root = source.yaml
    return "lidar_pose" in root and "true_ego_pos" in root


def _read_opv2v(source: Source, mounting: Mounting) -> Rig:
    notes, root = mounting.notes, source.yaml
    ego_SE3_map = inverse(map_pose(root.item("true_ego_pos")))
    for name, camera in root.items():
        if not _CAMERA.fullmatch(name):
            continue
        lens = _lens(camera.item("intrinsic"))
        lens["image"] = mounting.unknown_image(name, (800, 600), lens)
        mounting.add("camera", name, ego_SE3_map @ map_pose(camera.item("cords")), **lens)
    mounting.add("lidar", "lidar", ego_SE3_map @ map_pose(root.item("lidar_pose")))
    notes.converted("from CARLA's map, y to the right, to the car")
    return mounting.rig(f"OPV2V {source.name}")


def map_pose(value: Value) -> Matrix:
    """Return x y z roll yaw pitch in CARLA's axes as a transform in right-handed ones."""
    x, y, z, roll, yaw, pitch = value.numbers(6)
    return right_handed((x, y, z), (roll, pitch, yaw))


_AXLE = Origin("the origin", rear_axle_on_ground)
ONCE = Format(
    "once", "ONCE sequence", (".json",), _is_once, _read_once, origin=ON_ROOF,
    harmless="frames|meta_info|weather|period|point_feature_num",
)  # fmt: skip
ZOD = Format(
    "zod", "Zenseact Open Dataset calibration", (".json",), _is_zod, _read_zod, origin=_AXLE,
    harmless="undistortion|field_of_view",
)  # fmt: skip
DDAD = Format(
    "ddad", "DDAD (DGP) calibration", (".json",), _is_ddad, _read_ddad, origin=REAR_AXLE,
)  # fmt: skip
DAIR = Format(
    "dair-v2x", "DAIR-V2X calibration", (".json",), _is_dair, _read_dair, has_folders=True, origin=ON_ROOF,
    harmless="cam_K|P|R|header|distortion_model",
)  # fmt: skip
OPV2V = Format(
    "opv2v", "OPV2V frame", YAML, _is_opv2v, _read_opv2v, origin=ACTOR,
    harmless="ego_speed|plan_trajectory|predicted_ego_pos|vehicles|extrinsic|RSU",
)  # fmt: skip
