"""Read cameras as OpenCV, ROS and VINS write them in YAML, OpenCV also in JSON and XML (import).

One camera: camera_matrix, distortion_coefficients and image size (OpenCV's calibration, ROS camera_info files), the
fields of a CameraInfo message (K, D, height, width), VINS' projection_parameters, or Autoware.AI's CameraMat with the
place of the camera on the LiDAR. Several: the configuration of
VINS, whose body_T_cam0 takes points of camera 0 to the IMU, with a file for each camera beside it. Metres; cameras
in optical axes. A file of one camera does not say where it stands: straight ahead from the origin, on the roof.
Source: ROS camera_calibration_parsers, sensor_msgs/CameraInfo; VINS-Fusion, config and camera_models.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from riglens.core.errors import InputError
from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, from_optical
from riglens.core.formats.lenses import (
    BROWN_CONRADY,
    KANNALA_BRANDT,
    brown_conrady,
    kannala_brandt,
    sphere_fields,
)
from riglens.core.formats.matrices import add_by_imu, rigid
from riglens.core.formats.mounts import Mounting
from riglens.core.formats.report import Notes
from riglens.core.formats.source import MAX_PIXELS, YAML, Source, Value
from riglens.core.rig.model import Camera, KannalaBrandt, Rig
from riglens.core.rig.yaml.nodes import shortened, value_text

_MATRIX, _PROJECTION = "camera_matrix", "projection_parameters"
_EXTRINSIC = re.compile(r"body_T_cam([0-9]{1,2})")
_MATRICES = (_MATRIX, "cameraMatrix", "CameraMat", "K", "k")
_TO_LIDAR = "CameraExtrinsicMat"
"""Of Autoware.AI: takes points of the camera, in optical axes, to the LiDAR (x forward, y left, z up)."""
_COEFFICIENTS = (
    "distortion_coefficients", "D", "d", "dist_coeffs", "dist_coeff", "distCoeffs", "DistCoeff",
    "distortion_coeffs", "distortion",
)  # fmt: skip
"""Names under which calibrators and examples write the coefficients in OpenCV's order."""
_FISHEYES = ("equidistant", "fisheye", "kannala_brandt")
_BROWN = ("plumb_bob", "rational_polynomial", "radtan", "pinhole")
_SIZES = (("image_width", "image_height"), ("width", "height"))
_FISHEYE_FIELDS = ("k2", "k3", "k4", "k5")


def recognises(source: Source) -> bool:
    """Return whether this is a YAML mapping with the intrinsics of a camera, or with extrinsics as VINS names them."""
    if source.suffix == ".xml" and source.xml.tag != "opencv_storage":
        return False
    root = source.storage
    return _is_camera(root) or (
        root.is_mapping and any(_EXTRINSIC.fullmatch(name) for name, _ in root.items())
    )


def _is_camera(root: Value) -> bool:
    if not root.is_mapping:
        return False
    is_message = {"width", "height"} <= root.raw.keys() and any(
        isinstance(root.raw.get(key), list | tuple) for key in "Kk"
    )
    return any(key in root for key in (_MATRIX, "cameraMatrix", "CameraMat", _PROJECTION)) or is_message


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the one camera, or those of a configuration."""
    if _is_camera(source.storage):
        _add_one(source.storage, source, mounting)
    else:
        _add_chain(source, mounting)
    mounting.notes.converted("cameras from optical axes")
    return mounting.rig(source.name)


def _add_one(root: Value, source: Source, mounting: Mounting) -> None:
    named = next((root.item(key) for key in ("camera_name", "frame_id") if key in root), None)
    name = source.name if named is None else named.text()
    lens = read_lens(root, name, mounting.notes)
    if _TO_LIDAR in root:
        pose = from_optical(rigid(root.item(_TO_LIDAR), name, mounting.notes))
        mounting.notes.approximated(
            "the LiDAR of CameraExtrinsicMat: x forward, y left, z up on the roof", name
        )
        mounting.add("camera", name, pose, **lens)
        return
    mounting.notes.approximated("pose of the camera not in the file: it faces straight ahead", name)
    mounting.add("camera", name, np.eye(4), **lens)


def _add_chain(source: Source, mounting: Mounting) -> None:
    """Add the cameras of a VINS configuration; each has its intrinsics in a file next to it."""
    notes = mounting.notes
    found: dict[str, tuple[Matrix, dict[str, Any]]] = {}
    cameras = {name: value for name, value in source.storage.items() if _EXTRINSIC.fullmatch(name)}
    for name, value in cameras.items():
        camera = name.removeprefix("body_T_")
        lens = _beside(source, f"{camera}_calib")
        if lens is None:
            notes.ignored(
                f"its intrinsics are missing: '{camera}_calib' names no file in the folder of the configuration",
                camera,
            )
            continue
        found[camera] = rigid(value, camera, notes), read_lens(lens, camera, notes)
    add_by_imu(found, mounting)
    if not found:
        raise InputError(
            f"{source.where}: intrinsics are missing: name their file by cam0_calib: FILE for body_T_cam0"
        )


def _beside(source: Source, key: str) -> Value | None:
    """Return the mapping in the file that a field names, which must lie in the same folder; None without one."""
    named = source.storage.get(key)
    if named is None:
        return None
    name = named.text()
    if name != name.strip() or "/" in name or "\\" in name or name in ("", ".", ".."):
        named.refuse("the name of a file in the same folder")
    found = source.sibling(name)
    return None if found is None else found.storage


def read_lens(root: Value, name: str, notes: Notes) -> dict[str, Any]:
    """Return image and lens of a YAML mapping as OpenCV, ROS or VINS write it; raise InputError."""
    if "ImageSize" in root:
        width, height = (side.whole(1, MAX_PIXELS) for side in root.item("ImageSize").elements(2))
        image = width, height
    else:
        image = root.image(*next((keys for keys in _SIZES if keys[0] in root), _SIZES[0]))
    if _PROJECTION in root:
        return {"image": image} | _vins(root, image, name, notes)
    return _windowed(root, {"image": image} | _ros(root, name, notes), name, notes)


def _windowed(root: Value, lens: dict[str, Any], name: str, notes: Notes) -> dict[str, Any]:
    """Return image and lens of the window (roi) that a CameraInfo says its pictures show, and of binned pixels.

    The matrix is that of the whole sensor; a window of size 0 is the whole, binning by 0 or 1 none.
    Source: sensor_msgs/CameraInfo.
    """
    width, height = lens["image"]
    roi = root.get("roi")
    if (
        roi is not None
        and roi.is_mapping
        and all(roi.item(side, 0).number() > 0 for side in ("width", "height"))
    ):
        left, top = roi.field_numbers("x_offset", "y_offset")
        width, height = roi.image()
        lens |= {"cx": lens["cx"] - left, "cy": lens["cy"] - top}
        notes.converted(f"roi: pictures show a window of {width} x {height} pixels", name)
    steps = [max(1, root.item(key, 1).whole(0, 1_000)) for key in ("binning_x", "binning_y")]
    for (focal, centre), step in zip((("fx", "cx"), ("fy", "cy")), steps, strict=True):
        lens |= {focal: lens[focal] / step, centre: lens[centre] / step}
    if max(steps) > 1:
        notes.converted(f"binning: {steps[0]} x {steps[1]} pixels of the sensor are one of the picture", name)
    return lens | {"image": (max(1, width // steps[0]), max(1, height // steps[1]))}


def _ros(root: Value, name: str, notes: Notes) -> dict[str, Any]:
    """Return the lens of OpenCV and ROS: a matrix, and coefficients in OpenCV's order."""
    k = _numbers(root, _MATRICES)
    if k is None or len(k.elements()) != 9:
        root.refuse("a camera matrix of 9 numbers")
    fx, skew, cx, _, fy, cy, *_ = k.numbers(9)
    if skew:
        notes.ignored("skew of the image axes", name)
    lens: dict[str, Any] = {"fx": fx, "fy": fy, "cx": cx, "cy": cy}
    is_fisheye = "fisheye_model" in root and root.item("fisheye_model").number() != 0.0
    model = root.item("distortion_model", "fisheye" if is_fisheye else "plumb_bob").text().lower()
    coefficients = _numbers(root, _COEFFICIENTS)
    if coefficients is None or not coefficients.elements():
        return lens
    return lens | _distortion(model, coefficients, name, notes)


def _numbers(root: Value, keys: tuple[str, ...]) -> Value | None:
    """Return the list under the first of these names: plain, or the `data` of a matrix."""
    found = next((root.item(key) for key in keys if key in root), None)
    return found.item("data") if found is not None and found.is_mapping else found


def _distortion(model: str, value: Value, name: str, notes: Notes) -> dict[str, Any]:
    if model in _FISHEYES:
        return kannala_brandt(value, value.numbers(4), name, notes)
    if model in _BROWN:
        numbers = value.numbers()
        if any(numbers[8:]):
            notes.ignored("thin prism and tilt of the lens (coefficients 9 to 14)", name)
        return brown_conrady(value, numbers[:8], name, notes)
    notes.ignored(f"lens distortion of model '{shortened(model, 20)}'", name)
    return {}


def _vins(root: Value, image: tuple[int, int], name: str, notes: Notes) -> dict[str, Any]:
    """Return the lens of VINS: a pinhole with k1 k2 p1 p2, a fisheye with k2 to k5, or the fisheye nearest to MEI."""
    model = root.item("model_type").text().lower()
    projection = root.item(_PROJECTION)
    if model == "kannala_brandt":
        fx, fy, cx, cy = projection.field_numbers("mu", "mv", "u0", "v0")
        coefficients = projection.field_numbers(*_FISHEYE_FIELDS)
        return _pinhole(fx, fy, cx, cy) | kannala_brandt(projection, coefficients, name, notes)
    distortion = root.get("distortion_parameters")
    bend = [] if distortion is None else distortion.field_numbers("k1", "k2", "p1", "p2")
    names = ("fx", "fy", "cx", "cy") if "fx" in projection else ("gamma1", "gamma2", "u0", "v0")
    fx, fy, cx, cy = projection.field_numbers(*names)
    if model == "mei":
        xi = root.item("mirror_parameters").field_numbers("xi")
        return sphere_fields(model, xi, (fx, fy, cx, cy), bend, image, projection, name, notes)
    if model != "pinhole":
        notes.approximated(
            f"lens of model '{shortened(model, 20)}' as a pinhole with its focal lengths", name
        )
    elif distortion is not None:
        return _pinhole(fx, fy, cx, cy) | brown_conrady(distortion, bend, name, notes)
    return _pinhole(fx, fy, cx, cy)


def _pinhole(fx: float, fy: float, cx: float, cy: float) -> dict[str, Any]:
    return {"fx": fx, "fy": fy, "cx": cx, "cy": cy}


def camera_info_text(camera: Camera) -> str:
    """Return a camera's image and lens as a camera_info file of ROS (camera_calibration_parsers)."""
    fx, fy, cx, cy = camera.intrinsics_px()
    bend = camera.distortion
    is_fisheye = isinstance(bend, KannalaBrandt)
    names = KANNALA_BRANDT if is_fisheye else BROWN_CONRADY
    coefficients = [0.0 if bend is None else float(getattr(bend, name)) for name in names]
    if not is_fisheye and not any(coefficients[5:]):
        coefficients = coefficients[:5]
    model = "equidistant" if is_fisheye else "plumb_bob" if len(coefficients) == 5 else "rational_polynomial"
    matrices = {
        "camera_matrix": (3, 3, [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]),
        "distortion_coefficients": (1, len(coefficients), coefficients),
        "rectification_matrix": (3, 3, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
        "projection_matrix": (3, 4, [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]),
    }
    lines = [
        f"image_width: {camera.image[0]}",
        f"image_height: {camera.image[1]}",
        f"camera_name: {value_text(camera.name)}",
        f"distortion_model: {model}",
    ]
    for name, (rows, columns, numbers) in matrices.items():
        lines += [
            f"{name}:",
            f"  rows: {rows}",
            f"  cols: {columns}",
            f"  data: {value_text(tuple(numbers))}",
        ]
    return "\n".join([*lines, ""])


UNUSED = (
    "type_id|rectification_matrix|projection_matrix|[RPrp]|header|seq|stamp|camera_name|frame_id|do_rectify"
    "|Reprojection Error"
)
"""Fields of a camera's file for rectified pictures, or that name something."""
_OF_VINS = (
    "imu|num_of_cam|.*_topic|output_path|multiple_thread|max_(cnt|solver_time|num_iterations)|min_dist|freq|F_threshold"
    "|show_track|flow_back|equalize|fisheye|keyframe_parallax|(acc|gyr)_[nw]|g_norm|estimate_td|td|rolling_shutter.*"
    "|load_previous_pose_graph|pose_graph_save_path|save_image|loop_closure|fast_relocalization|visualize_.*"
)
"""Settings of VINS' tracker and solver."""
OPENCV = Format(
    "opencv",
    "OpenCV, ROS or VINS camera",
    (*YAML, ".json", ".xml"),
    recognises,
    read,
    harmless=f"{UNUSED}|{_OF_VINS}",
)
