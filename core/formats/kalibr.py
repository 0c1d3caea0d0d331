"""Kalibr: camchain.yaml (import), also as OpenCV writes it for OpenVINS.

T_cam_imu takes points of the IMU to the camera, T_imu_cam back, T_cn_cnm1 those of the camera before to this one;
(4, 4) as rows, as 16 numbers or as an OpenCV matrix; metres; cameras in optical axes. The file knows no vehicle: with
an IMU its axes are taken as x forward, y left, z up and its origin as that of the file; without, the first camera
looks straight ahead from the origin.
Source: Kalibr wiki, "YAML formats" and "supported models"; OpenVINS documentation, "sensor calibration".
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from riglens.core.formats.base import Format, Imported
from riglens.core.formats.frames import (
    ROUNDED_OFF_RAD,
    Matrix,
    from_optical,
    inverse,
    nearest_rotation,
    se3,
    to_optical,
)
from riglens.core.formats.lenses import brown_conrady, kannala_brandt
from riglens.core.formats.mounts import MAX_PIXELS, Mounting, ReadOptions
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source, Value
from riglens.core.rig.model import Vehicle
from riglens.core.rig.yaml.nodes import shortened

TITLE = "Kalibr camchain"
_CAMERA = re.compile(r"cam[0-9]{1,3}")
_FROM_IMU, _TO_IMU, _STEP = "T_cam_imu", "T_imu_cam", "T_cn_cnm1"
_KNOWN = frozenset(
    {
        _FROM_IMU,
        _TO_IMU,
        _STEP,
        "camera_model",
        "intrinsics",
        "distortion_model",
        "distortion_coeffs",
        "resolution",
    }
    | {"rostopic", "cam_overlaps", "timeshift_cam_imu"}
)
"""Fields that are read, or that do not affect the pose and view of a camera."""
_SAME_M, _SAME_DEG = 1e-4, 0.01
_EXTRA = {"omni": 1, "eucm": 2, "ds": 2}
"""Number of parameters before fx, fy, cx, cy in other models."""


def recognises(source: Source) -> bool:
    """Return whether this is a YAML mapping with a cam0 that has intrinsics."""
    if source.is_folder or source.suffix not in (".yaml", ".yml") or not source.yaml.is_mapping:
        return False
    first = source.yaml.get("cam0")
    return first is not None and first.is_mapping and "intrinsics" in first


def read(source: Source, options: ReadOptions) -> Imported:
    """Return the cameras of the chain."""
    notes = Notes()
    vehicle = options.vehicle_or(Vehicle())
    mounting = Mounting(source.where, notes, vehicle, options.origin_m or (0.0, 0.0, vehicle.height))
    cameras = {name: value for name, value in source.yaml.items() if _CAMERA.fullmatch(name)}
    for name, _ in source.yaml.items():
        if name not in cameras:
            notes.ignored("entry that is not a camera", name)
    chain = dict(sorted(cameras.items(), key=lambda item: int(item[0].removeprefix("cam"))))
    for name, pose in _poses(chain, notes).items():
        mounting.add_camera(name, from_optical(pose), **_lens(chain[name], name, notes))
    notes.converted("cameras from optical axes and inverse transforms")
    mounting.tell_assumed(options)
    return Imported(mounting.rig(source.name), notes.report(TITLE))


def _poses(chain: Mapping[str, Value], notes: Notes) -> dict[str, Matrix]:
    """Return the poses of the optical frames: by the IMU, by the camera before or after, or the first straight
    ahead."""
    if not chain:
        return {}
    by_imu = {
        name: pose for name, value in chain.items() if (pose := _by_imu(value, name, notes)) is not None
    }
    steps = {name: _transform(value, _STEP, name, notes) for name, value in chain.items() if _STEP in value}
    names = list(chain)
    anchor = names.index(next(iter(by_imu), names[0]))
    poses = {names[anchor]: by_imu.get(names[anchor], to_optical(np.eye(4)))}
    if by_imu:
        notes.approximated("the IMU's axes are taken as x forward, y left, z up")
    else:
        notes.approximated("no IMU in the file: the first camera looks straight ahead", names[anchor])
    for before, name in pairwise(names[anchor:]):
        if name not in by_imu and name not in steps:
            chain[name].item(_STEP)
        chained = poses[before] @ inverse(steps[name]) if name in steps else by_imu[name]
        poses[name] = by_imu.get(name, chained)
        _remark_apart(
            poses[name], chained, f"{_STEP} leads elsewhere than the transform of the IMU", name, notes
        )
    for name, after in pairwise(reversed(names[: anchor + 1])):
        step = steps[name] if name in steps else _rigid(chain[name].item(_STEP), name, notes)
        poses[after] = poses[name] @ step
    if names[0] in steps:
        notes.ignored(f"{_STEP} of the first camera: no camera is before it", names[0])
    return {name: poses[name] for name in names}


def _by_imu(value: Value, name: str, notes: Notes) -> Matrix | None:
    """Return the pose of the optical frame in the IMU's, None where the file lacks it; report unread fields."""
    for key, _ in value.items():
        if key not in _KNOWN:
            what = "transform" if key.startswith("T_") else "field"
            notes.ignored(f"{what} '{shortened(key, 30)}' is not read", name)
    found = [key for key in (_FROM_IMU, _TO_IMU) if key in value]
    if not found:
        return None
    matrices = {key: _transform(value, key, name, notes) for key in found}
    poses = [inverse(matrix) if key == _FROM_IMU else matrix for key, matrix in matrices.items()]
    _remark_apart(
        poses[0], poses[-1], f"{_TO_IMU} is not the inverse of {_FROM_IMU}, which is taken", name, notes
    )
    return poses[0]


def _remark_apart(taken: Matrix, other: Matrix, what: str, name: str, notes: Notes) -> None:
    """Report a second transform that differs, with the difference."""
    apart = inverse(taken) @ other
    apart_m = float(np.linalg.norm(apart[:3, 3]))
    apart_deg = math.degrees(math.acos(min(1.0, max(-1.0, (float(np.trace(apart[:3, :3])) - 1.0) / 2.0))))
    if apart_m > _SAME_M or apart_deg > _SAME_DEG:
        notes.ignored(f"{what}: {apart_m:.3g} m and {apart_deg:.3g} deg apart", name)


def _transform(value: Value, key: str, name: str, notes: Notes) -> Matrix:
    return _rigid(value.item(key), name, notes)


def _rigid(value: Value, name: str, notes: Notes) -> Matrix:
    matrix = _matrix(value)
    rotation, error = nearest_rotation(value, matrix[:3, :3])
    if error > ROUNDED_OFF_RAD:
        notes.approximated("rotation matrix not orthonormal: the nearest one that is", name)
    return se3(rotation, matrix[:3, 3])


def _matrix(value: Value) -> Matrix:
    """Return a (4, 4) matrix given as four rows, as 16 numbers, or as OpenCV writes it: rows, cols, dt, data."""
    if value.is_mapping:
        for side in ("rows", "cols"):
            value.item(side).whole(4, 4)
        return np.array(value.item("data").numbers(16)).reshape(4, 4)
    elements = value.elements()
    if len(elements) == 16:
        return np.array(value.numbers(16)).reshape(4, 4)
    return value.matrix(4, 4)


def _lens(value: Value, name: str, notes: Notes) -> dict[str, Any]:
    """Return image and pinhole; of other camera models only focal lengths and centre are kept."""
    width, height = (side.whole(1, MAX_PIXELS) for side in value.item("resolution").elements(2))
    model = value.item("camera_model").text() if "camera_model" in value else "pinhole"
    extra = _EXTRA.get(model, 0)
    if model != "pinhole":
        notes.approximated(
            f"lens of model '{shortened(model, 20)}' as a pinhole with its focal lengths", name
        )
    fx, fy, cx, cy = value.item("intrinsics").numbers(4 + extra)[extra:]
    lens = {"image": (width, height), "fx": fx, "fy": fy, "cx": cx, "cy": cy}
    return lens | _distortion(value, name, model, notes)


def _distortion(value: Value, name: str, model: str, notes: Notes) -> dict[str, Any]:
    """Return the distortion: radtan is Brown-Conrady, equidistant Kannala-Brandt; both only with the pinhole model."""
    coefficients = value.get("distortion_coeffs")
    kind = value.item("distortion_model").text() if "distortion_model" in value else "none"
    if coefficients is None or kind == "none":
        return {}
    if model == "pinhole" and kind == "radtan":
        return brown_conrady(coefficients, coefficients.numbers(4), name, notes)
    if model == "pinhole" and kind == "equidistant":
        return kannala_brandt(coefficients, coefficients.numbers(4), name, notes)
    notes.ignored(f"lens distortion of model '{shortened(kind, 20)}'", name)
    return {}


KALIBR = Format("kalibr", TITLE, recognises, read)
