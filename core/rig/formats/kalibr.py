"""Kalibr: camchain.yaml (import).

T_cam_imu takes points of the IMU to the camera, T_cn_cnm1 those of the camera before to this one; (4, 4), metres;
cameras in optical axes. The file knows no vehicle: with an IMU its axes are taken as x forward, y left, z up and its
origin as that of the file; without, the first camera looks straight ahead from the origin.
Source: Kalibr wiki, "YAML formats" and "supported models".
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from riglens.core.geometry import Vec3
from riglens.core.rig.formats.base import Format, Imported
from riglens.core.rig.formats.frames import (
    ROUNDED_OFF_RAD,
    Matrix,
    from_optical,
    inverse,
    nearest_rotation,
    se3,
    to_optical,
)
from riglens.core.rig.formats.lenses import brown_conrady, kannala_brandt
from riglens.core.rig.formats.mounts import MAX_PIXELS, Mounting, ReadOptions
from riglens.core.rig.formats.report import Notes
from riglens.core.rig.formats.source import Source, Value
from riglens.core.rig.model import Vehicle
from riglens.core.rig.yaml.nodes import shortened

TITLE = "Kalibr camchain"
_CAMERA = re.compile(r"cam[0-9]{1,3}")
_EXTRA = {"omni": 1, "eucm": 2, "ds": 2}
"""How many numbers precede fx, fy, cx, cy in other models."""


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
    mounting = Mounting(source.where, notes, vehicle, options.origin_m or _roof(vehicle))
    before: Matrix | None = None
    for name, value in source.yaml.items():
        if _CAMERA.fullmatch(name):
            before = _root_SE3_optical(value, before, name, notes)
            mounting.add_camera(name, from_optical(before), **_lens(value, name, notes))
        else:
            notes.ignored("entry that is not a camera", name)
    notes.converted("cameras from optical axes and inverse transforms")
    x, y, z = mounting.origin_m
    if options.origin_m is None:
        notes.approximated(
            f"where the origin is on the vehicle is not in the file: {x:g} {y:g} {z:g} m", option="--origin"
        )
    if options.vehicle is None:
        notes.approximated("vehicle not in the file: a sedan", option="--vehicle")
    return Imported(mounting.rig(source.name), notes.report(TITLE))


def _roof(vehicle: Vehicle) -> Vec3:
    return 0.0, 0.0, vehicle.height


def _root_SE3_optical(value: Value, before: Matrix | None, name: str, notes: Notes) -> Matrix:
    """Return where the optical frame of a camera stands: by the IMU, by the camera before, or straight ahead."""
    if "T_cam_imu" in value:
        notes.approximated("the IMU's axes are taken as x forward, y left, z up")
        return inverse(_rigid(value.item("T_cam_imu"), name, notes))
    if before is None:
        notes.approximated("no IMU in the file: the first camera looks straight ahead", name)
        return to_optical(np.eye(4))
    return before @ inverse(_rigid(value.item("T_cn_cnm1"), name, notes))


def _rigid(value: Value, name: str, notes: Notes) -> Matrix:
    matrix = value.matrix(4, 4)
    rotation, error = nearest_rotation(value, matrix[:3, :3])
    if error > ROUNDED_OFF_RAD:
        notes.approximated("rotation matrix not orthonormal: the nearest one that is", name)
    return se3(rotation, matrix[:3, 3])


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
