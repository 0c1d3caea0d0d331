"""Frames of other programs: quaternions, optical and left-handed axes, chains of transforms, and names of frames.

Transforms are (4, 4) matrices named parent_SE3_child: they take coordinates in the child to the parent.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Value
from riglens.core.geometry import Pose, Vec3, rotation_from_rpy_deg, rpy_deg_from_rotation
from riglens.core.rig.pose_text import quaternion_xyzw, rotation_from_quaternion
from riglens.core.rig.yaml.nodes import shortened

SensorKind = Literal["camera", "lidar", "radar", "ultrasonic"]

_OTHER = re.compile(r"imu|gnss|gps|odom|antenna|(kit|unit)_base_link$")
"""Other sensors, and the mounts of kits."""
_RADAR = re.compile(r"radar|ars[45]|srr|umrr|esr[_0-9]|smartmicro|continental")
_ULTRASONIC = re.compile(r"sonar|ultrasonic|ultrasound")
_CAMERA = re.compile(
    r"camera|optical|(^|[^a-z])cam([^a-z]|$)|(^|[^a-z])zed([^a-z]|$)|blackfly|realsense|(^|[^a-z])d4[0-9]{2}([^0-9]|$)"
)
_LIDAR = re.compile(
    r"lidar|laser|velodyne|vlp|hdl|vls|pandar|hesai|livox|ouster|(^|[^a-z])os[0-2]([^0-9]|$)|rslidar|robosense|"
    r"helios|bpearl|rsbp|quanergy|innoviz|luminar|innovusion|seyond|aeva|qt64|qt128|ot128|at128|xt[-_]?(16|32)|jt128|falcon|robin|"
    r"(^|[/_])scan(ner)?(_link|_frame)?$|mid[-_]?(40|70|360)|(^|[^a-z])rs[-_]?(m1|m2|16|32|80|128|p128)([^0-9]|$)|(^|[^a-z])p128([^0-9]|$)|scala|valeo|ibeo|cepton|blickfeld"
)
_KINDS: dict[re.Pattern[str], SensorKind | None] = {
    _OTHER: None, _RADAR: "radar", _ULTRASONIC: "ultrasonic", _CAMERA: "camera", _LIDAR: "lidar"
}  # fmt: skip
"""The first pattern that fits a name decides."""
_ENDINGS = (
    "/camera_optical_link",
    "/camera_link",
    "/radar_link",
    "/ultrasonic_link",
    "/lidar_link",
    "_optical_frame",
    "_optical_link",
    "_optical",
    "_base_link",
)


def kind_of(frame: str) -> SensorKind | None:
    """Return the kind of sensor that a name suggests, None when it suggests none.

    What comes after the last slash decides if it says anything, as in camera0/camera_link.
    """
    name = frame.lower()
    last = name.rpartition("/")[2]
    for words in (last, name) if last != name else (name,):
        for pattern, kind in _KINDS.items():
            if pattern.search(words):
                return kind
    return None


def is_optical(frame: str) -> bool:
    """Return whether the name says optical axes (x right, y down, z forward; REP-103)."""
    return "optical" in frame.lower()


BASES = ("base_footprint", "base_link")
"""Names of the vehicle's own frame in ROS: x forward, y left, z up (REP-105)."""
_DOWN = -math.cos(math.radians(45.0))


def without_ending(frame: str) -> str:
    """Return the name of the sensor whose frame this is: the frame's name without words such as `link`."""
    for ending in _ENDINGS:
        if frame.endswith(ending) and len(frame) > len(ending):
            return frame.removesuffix(ending)
    return frame.removesuffix("_link") or frame


Matrix = NDArray[np.float64]

BODY_R_OPTICAL: Matrix = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""From optical axes (x right, y down, z forward) to the axes of a sensor's body (x forward, y left, z up)."""

ROUNDED_OFF_RAD = 1e-6
"""A rotation that is this close to orthonormal was merely written with few digits."""

_WORST_ROTATION = 0.02
_DECIMALS = 12


def se3(rotation: Matrix, position_m: Vec3 | Matrix) -> Matrix:
    """Return the transform with that rotation (3, 3) and position (3,) in metres."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = position_m
    return matrix


def se3_from_rpy_deg(position_m: Vec3, rpy_deg: Vec3) -> Matrix:
    """Return the transform with that position and fixed-axis roll, pitch, yaw in degrees."""
    return se3(rotation_from_rpy_deg(rpy_deg), position_m)


def se3_from_rpy_rad(position_m: Iterable[float], rpy_rad: Iterable[float]) -> Matrix:
    """Return the transform with that position and fixed-axis roll, pitch, yaw in radians."""
    (x, y, z), (roll, pitch, yaw) = position_m, map(math.degrees, rpy_rad)
    return se3_from_rpy_deg((x, y, z), (roll, pitch, yaw))


def inverse(transform: Matrix) -> Matrix:
    """Return the inverse of a rigid transform, (4, 4)."""
    rotation = transform[:3, :3].T
    return se3(rotation, -rotation @ transform[:3, 3])


def from_optical(parent_SE3_optical: Matrix) -> Matrix:
    """Return the transform of a camera's body from that of its optical frame."""
    return parent_SE3_optical @ se3(BODY_R_OPTICAL.T, (0.0, 0.0, 0.0))


def camera_body(frame: str, vehicle_SE3_frame: Matrix, notes: Notes) -> Matrix:
    """Return the transform of a camera's body from that of a frame, optical by its name or by how it stands.

    A frame whose y axis points down is optical: as x forward, z up the camera would lie on its side.
    """
    if is_optical(frame):
        return from_optical(vehicle_SE3_frame)
    if vehicle_SE3_frame[2, 1] < _DOWN:
        notes.approximated(
            "its y axis points down: taken for an optical frame, z forward, though its name does not say so",
            frame,
        )
        return from_optical(vehicle_SE3_frame)
    return vehicle_SE3_frame


def to_optical(parent_SE3_body: Matrix) -> Matrix:
    """Return the transform of a camera's optical frame from that of its body."""
    return parent_SE3_body @ se3(BODY_R_OPTICAL, (0.0, 0.0, 0.0))


def pose_from_se3(vehicle_SE3_sensor: Matrix) -> Pose:
    """Return the pose, rounded to 1e-12 m and 1e-12 degrees, so that 35 degrees read as 35."""
    x, y, z = (round(float(value), _DECIMALS) + 0.0 for value in vehicle_SE3_sensor[:3, 3])
    roll, pitch, yaw = (
        round(angle, _DECIMALS) + 0.0 for angle in rpy_deg_from_rotation(vehicle_SE3_sensor[:3, :3])
    )
    return Pose((x, y, z), (roll, pitch, yaw))


def rotation_from_wxyz(value: Value, wxyz: list[float]) -> Matrix:
    """Return the rotation (3, 3) of a quaternion; refused at `value` when it is far from length 1."""
    w, x, y, z = wxyz
    try:
        return rotation_from_quaternion((x, y, z, w))
    except InputError:
        value.refuse("a quaternion of length 1", f"length {math.hypot(*wxyz):.4g}")


def wxyz_from_rotation(rotation: Matrix) -> list[float]:
    """Return the unit quaternion w, x, y, z of a rotation (3, 3), with w >= 0."""
    x, y, z, w = quaternion_xyzw(rpy_deg_from_rotation(rotation))
    return [math.copysign(1.0, w) * part for part in (w, x, y, z)]


def nearest_rotation(value: Value, matrix: Matrix) -> tuple[Matrix, float]:
    """Return the rotation nearest to a matrix (3, 3), and the difference; rejected when it is not a rotation."""
    left, _, right = np.linalg.svd(matrix)
    rotation: Matrix = left @ right
    error = float(np.abs(rotation - matrix).max())
    if np.linalg.det(rotation) < 0.0 or error > _WORST_ROTATION:
        value.refuse("a rotation matrix, orthonormal and right-handed", "another matrix")
    return rotation, error


class FrameTree:
    """Frames in a tree, each attached to one parent."""

    def __init__(self, where: str) -> None:
        self.where = where
        self._parents: dict[str, tuple[str, Matrix]] = {}

    def add(self, parent: str, child: str, parent_SE3_child: Matrix) -> None:
        """Attach a frame to another; raise InputError when it is attached already, or to itself."""
        if child in self._parents or child == parent:
            raise InputError(
                f"{self.where}: frame '{shortened(child, 80)}' has two parents: frames must form a tree"
            )
        self._parents[child] = (parent, parent_SE3_child)

    def frames(self) -> list[str]:
        """Return the frames that are attached to another, in the order in which they were added."""
        return list(self._parents)

    def inner_frames(self) -> set[str]:
        """Return the frames that others are attached to."""
        return {parent for parent, _ in self._parents.values()}

    def above(self, frame: str) -> list[str]:
        """Return the ancestors of a frame, the nearest first; raise InputError when the chain is a loop."""
        found: list[str] = []
        seen = {frame}
        place = frame
        while place in self._parents:
            place = self._parents[place][0]
            if place in seen:
                raise InputError(
                    f"{self.where}: frame '{shortened(frame, 80)}' is its own ancestor: frames must form a tree"
                )
            seen.add(place)
            found.append(place)
        return found

    def root(self) -> str:
        """Return the root of all frames; raise InputError unless there is one."""
        roots = sorted({self.root_of(frame) for frame in self._parents})
        if len(roots) != 1:
            said = shortened(", ".join(roots), 160) or "none"
            raise InputError(f"{self.where}: frames must form one tree (got roots: {said})")
        return roots[0]

    def root_of(self, frame: str) -> str:
        """Return the frame at the other end of the chain."""
        return [frame, *self.above(frame)][-1]

    def root_SE3(self, frame: str) -> Matrix:
        """Return the transform from the root of the chain to that frame."""
        transform = np.eye(4)
        for place in [frame, *self.above(frame)][:-1]:
            transform = self._parents[place][1] @ transform
        return transform
