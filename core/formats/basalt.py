"""Basalt: calibration.json of cameras around an IMU (import).

T_imu_cam takes points of each camera, in optical axes, to the IMU: px, py, pz in metres and a quaternion; `intrinsics`
names the model of each lens and its numbers, `resolution` the images. The file is the value `value0` of a document, as
the library cereal writes it. It knows neither the vehicle nor how the IMU is mounted in it.
Source: Basalt (Usenko et al., RA-L 2020), Calibration.md; basalt-headers, camera/*.hpp.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, rotation_from_wxyz, se3
from riglens.core.formats.lenses import (
    BROWN_CONRADY,
    KANNALA_BRANDT,
    brown_conrady,
    kannala_brandt,
    sphere_fields,
)
from riglens.core.formats.matrices import add_by_imu
from riglens.core.formats.mounts import Mounting
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source, Value
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.nodes import shortened

_SPHERES = {"ds": ("xi", "alpha"), "eucm": ("alpha", "beta")}
"""Models by way of a unit sphere, and their numbers in the order of `sphere_fields`."""
_PINHOLE = ("fx", "fy", "cx", "cy")
_UNUSED = "calib_.*|.*_noise_std|.*_bias_std|imu_update_rate|cam_time_offset_ns|.*mocap.*|T_imu_marker|vignette|rpmax"


def recognises(source: Source) -> bool:
    """Return whether this is a JSON mapping with T_imu_cam and intrinsics, alone or as value0."""
    root = _root(source)
    return "T_imu_cam" in root and "intrinsics" in root


def _root(source: Source) -> Value:
    root = source.json
    return root.item("value0") if "value0" in root else root


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the cameras."""
    root = _root(source)
    poses, lenses, sizes = (root.item(key).elements() for key in ("T_imu_cam", "intrinsics", "resolution"))
    if not len(poses) == len(lenses) == len(sizes):
        root.refuse(
            "as many T_imu_cam as intrinsics and resolution", f"{len(poses)}, {len(lenses)} and {len(sizes)}"
        )
    cameras = {
        f"cam{number}": (_pose(pose), _lens(lens, size, f"cam{number}", mounting.notes))
        for number, (pose, lens, size) in enumerate(zip(poses, lenses, sizes, strict=True))
    }
    add_by_imu(cameras, mounting)
    mounting.notes.converted("cameras from optical axes and quaternions x y z w")
    return mounting.rig(source.name)


def _pose(value: Value) -> Matrix:
    wxyz = value.field_numbers("qw", "qx", "qy", "qz")
    return se3(rotation_from_wxyz(value, wxyz), np.array(value.field_numbers("px", "py", "pz")))


def _lens(entry: Value, size: Value, name: str, notes: Notes) -> dict[str, Any]:
    model, numbers = entry.item("camera_type").text(), entry.item("intrinsics")
    width, height = (side.whole(1, 20_000) for side in size.elements(2))
    fx, fy, cx, cy = numbers.field_numbers(*_PINHOLE)
    image = (width, height)
    if model in _SPHERES:
        own = numbers.field_numbers(*_SPHERES[model])
        return sphere_fields(model, own, (fx, fy, cx, cy), (), image, numbers, name, notes)
    lens: dict[str, Any] = {"image": image, "fx": fx, "fy": fy, "cx": cx, "cy": cy}
    if model == "kb4":
        return lens | kannala_brandt(numbers, numbers.field_numbers(*KANNALA_BRANDT), name, notes)
    if model == "pinhole-radtan8":
        bend = [numbers.item(key, 0.0).number() for key in BROWN_CONRADY]
        return lens | brown_conrady(numbers, bend, name, notes)
    if model != "pinhole":
        notes.approximated(
            f"lens of model '{shortened(model, 20)}' as a pinhole with its focal lengths", name
        )
    return lens


BASALT = Format("basalt", "Basalt calibration", (".json",), recognises, read, harmless=_UNUSED)
