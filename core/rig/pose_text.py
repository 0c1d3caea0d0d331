"""Convert poses to and from text for the clipboard: YAML as in a rig file, numbers, a quaternion or a 4 x 4 matrix.

All forms mean the sensor's pose in the vehicle frame, in metres and degrees, whatever a window displays.
A copied YAML or numbers text reads back to the same doubles.
"""

from __future__ import annotations

import math
import re
from typing import Literal, TypeGuard

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.geometry import Pose, Vec3, is_rotation, rpy_deg_from_rotation
from riglens.core.rig.yaml.nodes import Plain, parse_yaml, plain_value, shortened

PoseFormat = Literal["yaml", "numbers", "quaternion", "matrix"]
POSE_FORMATS: dict[PoseFormat, str] = {
    "yaml": "YAML, as in a rig file",
    "numbers": "x y z roll pitch yaw (m, deg)",
    "quaternion": "x y z qx qy qz qw (m)",
    "matrix": "4 × 4 matrix, sensor to vehicle",
}
ACCEPTED = (
    "must be `position: [x, y, z]` with `rpy_deg: [roll, pitch, yaw]`, the six numbers "
    "x y z roll pitch yaw, the seven x y z qx qy qz qw, or a 4 x 4 matrix"
)
MAX_CHARACTERS = 4000
MAX_METRES, MAX_DEGREES = 1e7, 1e6
_RIGID_TOLERANCE = 1e-3
"""Matrices and quaternions are often printed with four digits; anything farther from a rotation is refused."""
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_KEY_LINE = re.compile(r"^\W*(?:position|rpy_deg|quaternion)", re.M)


def pose_text(pose: Pose, form: PoseFormat = "yaml") -> str:
    """Return the pose in one of POSE_FORMATS, in full precision."""
    position, rpy = ([repr(float(value)) for value in values] for values in (pose.position_m, pose.rpy_deg))
    if form == "yaml":
        return f"position: [{', '.join(position)}]\nrpy_deg: [{', '.join(rpy)}]\n"
    if form == "numbers":
        return " ".join((*position, *rpy))
    if form == "quaternion":
        return " ".join((*position, *(repr(part) for part in quaternion_xyzw(pose.rpy_deg))))
    rows = pose.vehicle_SE3_sensor().tolist()
    return "\n".join("  ".join(repr(value) for value in row) for row in rows) + "\n"


def parse_pose(text: str) -> Pose:
    """Return the pose in a text in one of POSE_FORMATS; raise InputError with what was found when there is none."""
    if len(text) > MAX_CHARACTERS:
        raise InputError(f"pose {ACCEPTED} (got a text of {len(text)} characters)")
    pose = _from_mapping(text) if _KEY_LINE.search(text) else None
    return _checked(pose or _from_numbers(text))


def quaternion_xyzw(rpy_deg: Vec3) -> tuple[float, float, float, float]:
    """Return the unit quaternion (x, y, z, w) of R = Rz(yaw) Ry(pitch) Rx(roll), angles in degrees."""
    roll, pitch, yaw = (math.radians(angle) / 2 for angle in rpy_deg)
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def rotation_from_quaternion(xyzw: tuple[float, ...]) -> NDArray[np.float64]:
    """Return the rotation matrix (3, 3) of a quaternion (x, y, z, w); raise InputError unless its length is about 1."""
    length = math.sqrt(sum(part * part for part in xyzw))
    if not abs(length - 1.0) <= 10 * _RIGID_TOLERANCE:
        raise InputError(f"quaternion: length must be 1 (got {length:.4g})")
    x, y, z, w = (part / length for part in xyzw)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _from_mapping(text: str) -> Pose:
    """Return a pose from the keys of a rig file; other keys of a copied sensor are ignored."""
    dedented = re.sub(r"^(\s*)- ", r"\1  ", text, flags=re.M)
    indent = min(
        (len(line) - len(line.lstrip()) for line in dedented.splitlines() if line.strip()), default=0
    )
    found = plain_value(parse_yaml("\n".join(line[indent:] for line in dedented.splitlines()), "pose"))
    if not isinstance(found, dict):
        raise InputError(f"pose {ACCEPTED}")
    position = _floats(found.get("position"), "position", 3)
    if "quaternion_xyzw" in found:
        turned = rotation_from_quaternion(_floats(found["quaternion_xyzw"], "quaternion_xyzw", 4))
        return _pose(position, rpy_deg_from_rotation(turned))
    return _pose(position, _floats(found.get("rpy_deg", (0.0, 0.0, 0.0)), "rpy_deg", 3))


def _from_numbers(text: str) -> Pose:
    """Return the pose of six, seven, twelve or sixteen numbers with anything but letters between them."""
    rest = _NUMBER.sub(" ", text)
    numbers = tuple(float(match) for match in _NUMBER.findall(text))
    if len(numbers) not in (6, 7, 12, 16) or re.search(r"[^\s,;|()\[\]{}]", rest):
        raise InputError(f"pose {ACCEPTED} (got '{shortened(text.strip())}')")
    if len(numbers) == 6:
        return _pose(numbers[:3], numbers[3:])
    if len(numbers) == 7:
        return _pose(numbers[:3], rpy_deg_from_rotation(rotation_from_quaternion(numbers[3:])))
    return _from_matrix(np.array(numbers).reshape(-1, 4))


def _from_matrix(matrix: NDArray[np.float64]) -> Pose:
    """Return a pose from the transform (3 or 4, 4) from sensor to vehicle."""
    rotation = matrix[:3, :3]
    if not is_rotation(rotation):
        raise InputError("pose: the matrix must be a rotation, without scale or reflection")
    if len(matrix) == 4 and np.abs(matrix[3] - (0.0, 0.0, 0.0, 1.0)).max() > _RIGID_TOLERANCE:
        raise InputError("pose: the last row of the matrix must be 0 0 0 1")
    left, _, right = np.linalg.svd(rotation)
    return _pose(tuple(matrix[:3, 3].tolist()), rpy_deg_from_rotation(left @ right))


def _floats(values: Plain, field: str, count: int) -> tuple[float, ...]:
    numbers = [float(value) for value in values if _is_number(value)] if isinstance(values, tuple) else []
    if not isinstance(values, tuple) or not len(numbers) == len(values) == count:
        raise InputError(f"pose: {field} must be {count} numbers in brackets")
    return tuple(numbers)


def _is_number(value: Plain) -> TypeGuard[float]:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _pose(position_m: tuple[float, ...], rpy_deg: tuple[float, ...]) -> Pose:
    (x, y, z), (roll, pitch, yaw) = position_m, rpy_deg
    return Pose((x, y, z), (roll, pitch, yaw))


def _checked(pose: Pose) -> Pose:
    is_near = all(abs(metres) <= MAX_METRES for metres in pose.position_m)  # which no NaN is
    if not is_near or not all(abs(degrees) <= MAX_DEGREES for degrees in pose.rpy_deg):
        raise InputError(
            f"pose: numbers must be finite, and within ±{MAX_METRES:g} m and ±{MAX_DEGREES:g} degrees"
        )
    return pose
