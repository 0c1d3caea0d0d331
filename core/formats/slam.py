"""Settings of SLAM and calibration tools: ORB-SLAM3, LIO-SAM, R3LIVE, direct_visual_lidar_calibration (import).

- ORB-SLAM3: OpenCV YAML of one or two cameras; IMU.T_b_c1 (Tbc) takes points of the first, in optical axes, to the IMU,
  Stereo.T_c1_c2 (Tlr) those of the second to the first; rectified pairs have the base line alone (Stereo.b, or
  Camera.bf times the focal length). Source: ORB-SLAM3, Calibration_Tutorial.pdf, src/Settings.cc.
- LIO-SAM, and LVI-SAM's params_lidar.yaml: parameters of a node. One LiDAR, whose frame is the rig's: extrinsicRot and
  extrinsicTrans place the IMU on it. Source: LIO-SAM, include/utility.h, config/params.yaml.
- R3LIVE: parameters of a node. camera_ext_R and camera_ext_t take points of the camera, in optical axes, to the IMU;
  the LiDAR stands there with the IMU's axes, offset by Lidar_offset_to_IMU, a constant of the program (Livox Avia).
  Source: R3LIVE, r3live/src/r3live_vio.cpp, r3live/src/loam/include/common_lib.h, config/r3live_config.yaml.
- direct_visual_lidar_calibration: calib.json; results.T_lidar_camera, x y z qx qy qz qw, takes points of the camera, in
  optical axes, to the LiDAR. Source: its docs/calibration.md, include/camera.
Metres; LiDARs have x forward, y left, z up. Where the IMU or LiDAR is on the car no file says.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, from_optical, kind_of, rotation_from_wxyz, se3
from riglens.core.formats.lenses import brown_conrady, kannala_brandt, sphere_fields
from riglens.core.formats.matrices import add_by_imu, rigid, rigid_of, rotation_of
from riglens.core.formats.mounts import Mounting
from riglens.core.formats.source import YAML, Source, Value, ros_parameters
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.nodes import shortened

_FIRST = ("Camera1", "Camera")
_RADIAL, _FISHEYE = ("k1", "k2", "p1", "p2", "k3"), ("k1", "k2", "k3", "k4")
_FOCAL = ("fx", "fy", "cx", "cy")
_TO_IMU, _TO_FIRST = ("IMU.T_b_c1", "Tbc"), ("Stereo.T_c1_c2", "Tlr")
_DEPTH = ("RGBD.DepthMapFactor", "DepthMapFactor")


def _first(root: Value) -> str | None:
    """Return the name under which the first camera is."""
    return next((name for name in _FIRST if f"{name}.fx" in root), None)


# ---------------------------------------------------------------- ORB-SLAM3


def _is_orb(source: Source) -> bool:
    return source.yaml.is_mapping and _first(source.yaml) is not None


def _read_orb(source: Source, mounting: Mounting) -> Rig:
    root, notes = source.yaml, mounting.notes
    name = _first(root) if root.is_mapping else None
    if name is None:
        root.refuse("settings with Camera1.fx or Camera.fx", "others")
    second = _second(root, name, mounting)
    cameras = {"camera1": (np.eye(4), _orb_lens(root, name, "camera1", mounting))}
    if second is not None:
        other = "Camera2" if "Camera2.fx" in root else name
        cameras["camera2"] = second, _orb_lens(root, other, "camera2", mounting)
    to_imu = next((root.item(key) for key in _TO_IMU if key in root), None)
    if to_imu is not None:
        imu_SE3_first = rigid(to_imu, "camera1", notes)
        add_by_imu({key: (imu_SE3_first @ pose, lens) for key, (pose, lens) in cameras.items()}, mounting)
    else:
        notes.approximated("pose of the camera not in the file: it faces straight ahead", "camera1")
        for key, (pose, lens) in cameras.items():
            mounting.add("camera", key, from_optical(_AHEAD @ pose), **lens)
    notes.converted("cameras from optical axes")
    return mounting.rig(source.name)


_AHEAD: Matrix = se3(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), np.zeros(3))
"""An optical frame that looks along x of the rig."""


def _second(root: Value, first: str, mounting: Mounting) -> Matrix | None:
    """Return the pose of the second camera in the first; None for a single or a depth camera."""
    found = next((root.item(key) for key in _TO_FIRST if key in root), None)
    if found is not None:
        return _upper_rows(found, mounting)
    if any(key in root for key in _DEPTH):
        return None
    if "Stereo.b" in root:
        return se3(np.eye(3), np.array([root.item("Stereo.b").number(), 0.0, 0.0]))
    if f"{first}.bf" not in root:
        return None
    shift = root.item(f"{first}.bf").number() / root.item(f"{first}.fx").number(1e-6)
    return se3(np.eye(3), np.array([shift, 0.0, 0.0]))


def _upper_rows(value: Value, mounting: Mounting) -> Matrix:
    """Return a transform of three or four rows."""
    data = value.item("data") if value.is_mapping else value
    if len(data.elements()) == 12:
        for side in ("rows", "cols"):
            value.item(side).whole(3, 4)
        return rigid_of(value, np.array(data.numbers(12)).reshape(3, 4), mounting.notes, "camera2")
    return rigid(value, "camera2", mounting.notes)


def _orb_lens(root: Value, key: str, name: str, mounting: Mounting) -> dict[str, Any]:
    fx, fy, cx, cy = root.field_numbers(*(f"{key}.{part}" for part in _FOCAL))
    lens: dict[str, Any] = {"fx": fx, "fy": fy, "cx": cx, "cy": cy}
    has_size = "Camera.width" in root and "Camera.height" in root
    lens["image"] = (
        root.image("Camera.width", "Camera.height")
        if has_size
        else mounting.unknown_image(name, (max(1, round(2 * cx)), max(1, round(2 * cy))), lens)
    )
    model = root.item("Camera.type", "PinHole").text().lower()
    if model == "rectified":
        return lens
    if model == "kannalabrandt8":
        bend = root.field_numbers(*(f"{key}.{part}" for part in _FISHEYE))
        return lens | kannala_brandt(root, bend, name, mounting.notes)
    if model != "pinhole":
        mounting.notes.approximated(
            f"lens of model '{shortened(model, 20)}' as a pinhole with its focal lengths", name
        )
        return lens
    bend = [root.item(f"{key}.{part}", 0.0).number() for part in _RADIAL]
    return lens | brown_conrady(root, bend, name, mounting.notes)


# ---------------------------------------------------------------- LIO-SAM

_LIDARS = {
    ("velodyne", 16): "Velodyne VLP-16", ("velodyne", 32): "Velodyne HDL-32E",
    ("velodyne", 64): "Velodyne HDL-64E", ("velodyne", 128): "Velodyne VLS-128",
    ("ouster", 32): "Ouster OS1-32", ("ouster", 64): "Ouster OS1-64", ("ouster", 128): "Ouster OS1-128",
    ("livox", 6): "Livox Horizon",
}  # fmt: skip
"""Usual LiDARs of a sensor type and its number of rows."""


def _lio(source: Source) -> Value:
    root = ros_parameters(source.yaml)
    return next((root.item(group) for group in ("lio_sam", "lvi_sam") if group in root), root)


def _is_lio(source: Source) -> bool:
    root = _lio(source)
    return "N_SCAN" in root and ("extrinsicRot" in root or "sensor" in root)


def _read_lio(source: Source, mounting: Mounting) -> Rig:
    root, notes = _lio(source), mounting.notes
    kind, rows = root.item("sensor", "").text().lower(), root.item("N_SCAN").whole(1, 1000)
    model = _LIDARS.get((kind, rows))
    frame = root.item("lidarFrame", "lidar").text()
    name = frame if kind_of(frame) == "lidar" else "lidar"
    if model is not None:
        notes.approximated(f"sensor {kind} of {rows} rows: taken for a {model}", name)
    mounting.add("lidar", name, np.eye(4), said=model or f"{kind} of {rows} rows".strip())
    notes.ignored("IMU: extrinsicRot, extrinsicRPY and extrinsicTrans place it on the LiDAR")
    notes.converted("axes of the LiDAR: x forward, y left, z up already (REP-105)")
    return mounting.rig(source.name)


# ---------------------------------------------------------------- R3LIVE

_CAMERA, _FRONT_END = "r3live_vio", "Lidar_front_end"
_AVIA_IN_IMU: Matrix = se3(np.eye(3), np.array([0.04165, 0.02326, -0.0284]))
_AVIA = 1
"""lidar_type of a Livox Avia."""


def _is_r3live(source: Source) -> bool:
    root = ros_parameters(source.yaml)
    camera = root.get(_CAMERA) if root.is_mapping else None
    return camera is not None and "camera_ext_R" in camera


def _read_r3live(source: Source, mounting: Mounting) -> Rig:
    root, notes = ros_parameters(source.yaml), mounting.notes
    found = root.item(_CAMERA)
    matrix = np.array(found.item("camera_intrinsic").numbers(9)).reshape(3, 3)
    lens: dict[str, Any] = {"image": found.image("image_width", "image_height")}
    lens |= {"fx": matrix[0, 0], "fy": matrix[1, 1], "cx": matrix[0, 2], "cy": matrix[1, 2]}
    bend = found.item("camera_dist_coeffs")
    lens |= brown_conrady(bend, bend.numbers(5), "camera", notes)
    turned = found.item("camera_ext_R")
    rotation = rotation_of(turned, np.array(turned.numbers(9)).reshape(3, 3), notes)
    turn = add_by_imu({"camera": (se3(rotation, found.item("camera_ext_t").vector()), lens)}, mounting)
    front = root.get(_FRONT_END)
    if front is not None and "lidar_type" in front:
        is_avia = front.item("lidar_type").whole(0, 1000) == _AVIA
        mounting.add("lidar", "lidar", turn @ _AVIA_IN_IMU, said="Livox Avia" if is_avia else None)
        notes.approximated("pose of the LiDAR not in the file: R3LIVE's constant for a Livox Avia", "lidar")
    notes.converted("camera from optical axes")
    return mounting.rig(source.name)


# ---------------------------------------------------------------- direct_visual_lidar_calibration

_FITTED = ("T_lidar_camera", "init_T_lidar_camera", "init_T_lidar_camera_auto")
"""The result, else a first guess."""


def _is_vlcal(source: Source) -> bool:
    root = source.json
    camera = root.get("camera") if root.is_mapping else None
    return camera is not None and "camera_model" in camera and "results" in root


def _read_vlcal(source: Source, mounting: Mounting) -> Rig:
    root, notes = source.json, mounting.notes
    results = root.item("results")
    key = next((key for key in _FITTED if key in results), _FITTED[0])
    if key != _FITTED[0]:
        notes.approximated(f"no T_lidar_camera: the first guess {key}", "camera")
    x, y, z, qx, qy, qz, qw = results.item(key).numbers(7)
    pose = se3(rotation_from_wxyz(results.item(key), [qw, qx, qy, qz]), np.array([x, y, z]))
    mounting.add("camera", "camera", from_optical(pose), **_vlcal_lens(root.item("camera"), mounting))
    mounting.add("lidar", "lidar", np.eye(4))
    notes.converted("camera from optical axes and a quaternion x y z w")
    return mounting.rig(source.name)


def _vlcal_lens(value: Value, mounting: Mounting) -> dict[str, Any]:
    model, notes = value.item("camera_model").text().lower(), mounting.notes
    numbers, bend = value.item("intrinsics"), value.item("distortion_coeffs")
    if model == "equirectangular":
        value.item("camera_model").refuse("plumb_bob, rational_polynomial, fisheye or omnidir")
    found = numbers.numbers()[:5]
    if len(found) < 4:
        numbers.refuse("4 numbers or more")
    fx, fy, cx, cy, *more = found
    lens: dict[str, Any] = {"fx": fx, "fy": fy, "cx": cx, "cy": cy}
    image = mounting.unknown_image("camera", (max(1, round(2 * cx)), max(1, round(2 * cy))), lens)
    lens["image"] = image
    if model in ("plumb_bob", "rational_polynomial"):
        return lens | brown_conrady(bend, bend.numbers(), "camera", notes)
    if model in ("fisheye", "equidistant"):
        return lens | kannala_brandt(bend, bend.numbers(4), "camera", notes)
    if model in ("omnidir", "mei") and more:
        plane = bend.numbers()[:4]
        return sphere_fields("mei", more, (fx, fy, cx, cy), plane, image, numbers, "camera", notes)
    notes.approximated(
        f"lens of model '{shortened(model, 20)}' as a pinhole with its focal lengths", "camera"
    )
    return lens


ORB_SLAM = Format(
    "orb-slam3", "ORB-SLAM3 settings", YAML, _is_orb, _read_orb,
    harmless=r"ORBextractor\..*|Viewer\..*|IMU\.(Noise.*|.*Walk|Frequency|InsertKFsWhenLost)|File\.version|System\..*"
    r"|Camera\.(fps|RGB|bf)|(Stereo\.)?ThDepth|Camera[12]\.overlapping.*|loopClosing",
)  # fmt: skip
LIO_SAM = Format(
    "lio-sam", "LIO-SAM parameters", YAML, _is_lio, _read_lio,
    harmless="(imu|gps|odom|pointCloud).*|extrinsic.*|.*Threshold|.*LeafSize|.*ValidNum|surrounding.*|history.*"
    "|globalMap.*|loopClosure.*|mapping.*|z_tollerance|rotation_tollerance|.*Frame|use.*|save.*|numberOfCores"
    "|downsampleRate",
)  # fmt: skip
R3LIVE = Format(
    "r3live", "R3LIVE configuration", YAML, _is_r3live, _read_r3live,
    harmless=r"r3live_(common|lio).*|N_SCANS|using_raw_point|point_step|tracker_.*|.*time_delay",
)  # fmt: skip
VLCAL = Format(
    "vlcal", "direct_visual_lidar_calibration", (".json",), _is_vlcal, _read_vlcal,
    harmless="meta|init_.*|results",
)  # fmt: skip
