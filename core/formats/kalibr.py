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

import numpy as np

from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, from_optical, inverse, to_optical
from riglens.core.formats.lenses import kalibr_lens
from riglens.core.formats.matrices import level_axes, rigid
from riglens.core.formats.mounts import Mounting
from riglens.core.formats.report import Notes
from riglens.core.formats.source import YAML, Source, Value
from riglens.core.rig.model import Rig

_CAMERA = re.compile(r"cam[0-9]{1,3}")
_FROM_IMU, _TO_IMU, _STEP = "T_cam_imu", "T_imu_cam", "T_cn_cnm1"
_SAME_M, _SAME_DEG = 1e-4, 0.01


def recognises(source: Source) -> bool:
    """Return whether this is a YAML mapping with a cam0 that has intrinsics."""
    first = source.yaml.get("cam0") if source.yaml.is_mapping else None
    return first is not None and "intrinsics" in first


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the cameras of the chain."""
    notes = mounting.notes
    cameras = {name: value for name, value in source.yaml.items() if _CAMERA.fullmatch(name)}
    for name, _ in source.yaml.items():
        if name not in cameras:
            notes.ignored("entry that is not a camera", name)
    chain = dict(sorted(cameras.items(), key=lambda item: int(item[0].removeprefix("cam"))))
    for name, pose in _poses(chain, notes).items():
        mounting.add(
            "camera", name, from_optical(pose), **kalibr_lens(chain[name], "distortion_coeffs", name, notes)
        )
    notes.converted("cameras from optical axes and inverse transforms")
    return mounting.rig(source.name)


def _poses(chain: Mapping[str, Value], notes: Notes) -> dict[str, Matrix]:
    """Return the poses of the optical frames: by the IMU, by the camera before or after, or the first straight
    ahead."""
    if not chain:
        return {}
    by_imu = {
        name: pose for name, value in chain.items() if (pose := _by_imu(value, name, notes)) is not None
    }
    steps = {name: rigid(value.item(_STEP), name, notes) for name, value in chain.items() if _STEP in value}
    names = list(chain)
    anchor = names.index(next(iter(by_imu), names[0]))
    poses = {names[anchor]: by_imu.get(names[anchor], to_optical(np.eye(4)))}
    if not by_imu:
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
        step = steps[name] if name in steps else rigid(chain[name].item(_STEP), name, notes)
        poses[after] = poses[name] @ step
    if names[0] in steps:
        notes.ignored(f"{_STEP} of the first camera: no camera is before it", names[0])
    turn = level_axes(poses.values(), notes) if by_imu else np.eye(4)
    return {name: turn @ poses[name] for name in names}


def _by_imu(value: Value, name: str, notes: Notes) -> Matrix | None:
    """Return the pose of the optical frame in the IMU's, None if the file lacks it."""
    found = [key for key in (_FROM_IMU, _TO_IMU) if key in value]
    if not found:
        return None
    matrices = {key: rigid(value.item(key), name, notes) for key in found}
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


KALIBR = Format(
    "kalibr", "Kalibr camchain", YAML, recognises, read, harmless="rostopic|cam_overlaps|timeshift_cam_imu"
)
