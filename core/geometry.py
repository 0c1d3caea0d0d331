"""Poses in the vehicle frame (x forward, y left, z up; ISO 8855, REP-103), metres and degrees."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vec3 = tuple[float, float, float]
_ROTATION_TOLERANCE = 1e-3
"""Largest error of a rotation's products of rows: what writers round to."""


def rotation_from_rpy_deg(rpy_deg: Vec3) -> NDArray[np.float64]:
    """Return the rotation matrix R = Rz(yaw) Ry(pitch) Rx(roll), (3, 3); angles in degrees.

    Intrinsic z-y'-x''; positive pitch looks down, positive yaw turns left. Written out, not multiplied by
    a library, because its doubles are part of what "exact" means for the rays.
    """
    roll, pitch, yaw = (math.radians(angle) for angle in rpy_deg)
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ],
        dtype=np.float64,
    )


def is_rotation(matrix: NDArray[np.float64]) -> bool:
    """Return whether a matrix (3, 3) turns, but for rounding, without scale or reflection; any finite numbers."""
    if np.abs(matrix).max() > 2.0:  # products of larger numbers may overflow
        return False
    error = np.abs(matrix @ matrix.T - np.eye(3)).max()
    return bool(error <= _ROTATION_TOLERANCE and np.linalg.det(matrix) > 0.0)


def triple(vector: ArrayLike) -> Vec3:
    """Return three numbers of any sequence or array as a tuple; raise ValueError for another number of them."""
    if isinstance(vector, tuple) and len(vector) == 3:
        return vector
    x, y, z = np.asarray(vector, np.float64).tolist()
    return x, y, z


@dataclass(frozen=True, init=False)
class Pose:
    """Pose of a sensor in the vehicle frame: `position_m` in metres, `rpy_deg` roll, pitch, yaw in degrees.

    Lists and arrays become tuples.
    """

    position_m: Vec3
    rpy_deg: Vec3

    def __init__(self, position_m: ArrayLike = (0.0, 0.0, 0.0), rpy_deg: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        object.__setattr__(self, "position_m", triple(position_m))
        object.__setattr__(self, "rpy_deg", triple(rpy_deg))

    def rotation(self) -> NDArray[np.float64]:
        """Return the rotation from the sensor to the vehicle frame, (3, 3)."""
        return rotation_from_rpy_deg(self.rpy_deg)

    def vehicle_SE3_sensor(self) -> NDArray[np.float64]:
        """Return the homogeneous transform from the sensor to the vehicle frame, (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation()
        matrix[:3, 3] = self.position_m
        return matrix

    def transform(self, points_m: ArrayLike) -> NDArray[np.float64]:
        """Convert points, (3,) or (..., 3) metres, from the sensor frame to the vehicle frame, in the same shape."""
        moved: NDArray[np.float64] = np.asarray(points_m, np.float64) @ self.rotation().T + self.position_m
        return moved

    def inverse(self) -> Pose:
        """Return the pose of the vehicle in the sensor frame: its `transform` converts points to the sensor frame."""
        rotation = self.rotation().T
        return _pose_from(rotation, -rotation @ np.array(self.position_m))

    def compose(self, part: Pose) -> Pose:
        """Return the pose in the vehicle frame of a part given in this sensor's frame: this pose, then that.

        `a.compose(b).transform(p)` is `a.transform(b.transform(p))`.
        """
        return _pose_from(self.rotation() @ part.rotation(), self.transform(part.position_m))


def _pose_from(rotation: NDArray[np.float64], position_m: NDArray[np.float64]) -> Pose:
    x_m, y_m, z_m = position_m.tolist()
    return Pose((x_m, y_m, z_m), rpy_deg_from_rotation(rotation))


def rpy_deg_from_rotation(rotation: NDArray[np.float64]) -> Vec3:
    """Return the roll, pitch, yaw in degrees of a rotation matrix (3, 3); at pitch +-90 deg roll is set to zero.

    Roll is measured after yaw is undone, so that near +-90 deg it compensates for the error of yaw.
    """
    level = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(-rotation[2, 0], level)
    if level < 1e-12:
        roll, yaw = 0.0, math.atan2(-rotation[0, 1], rotation[1, 1])
    else:
        yaw = math.atan2(rotation[1, 0], rotation[0, 0])
        sy, cy = math.sin(yaw), math.cos(yaw)
        roll = math.atan2(
            sy * rotation[0, 2] - cy * rotation[1, 2], cy * rotation[1, 1] - sy * rotation[0, 1]
        )
    return (math.degrees(roll), math.degrees(pitch), math.degrees(yaw))


_SAME_DEG = 1e-9


def rpy_deg_near(rotation: NDArray[np.float64], before_deg: Vec3) -> Vec3:
    """Return the roll, pitch, yaw in degrees of a rotation matrix (3, 3); unchanged angles keep every bit."""
    roll, pitch, yaw = (
        old if abs((new - old + 180.0) % 360.0 - 180.0) < _SAME_DEG else new
        for old, new in zip(before_deg, rpy_deg_from_rotation(rotation), strict=True)
    )
    return roll, pitch, yaw
