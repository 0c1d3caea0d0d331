"""Where a sensor sits when it is put on a surface: point and outward normal in, pose out. Vehicle frame, metres."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.geometry import Pose, rpy_deg_from_rotation

Vector = NDArray[np.float64]
_STEEP = math.sin(math.radians(50.0))
_FLAT = 0.2


def placed_on(point_m: Vector, normal: Vector, kind: Literal["lidar", "camera"], box_m: Vector) -> Pose:
    """The pose of a sensor whose body touches a surface at a point with unit normal (3,), from outside.

    A LiDAR's up axis is the normal, and it looks ahead as far as the surface lets it. A camera looks along the
    normal with a level horizon; on a roof, a bonnet or a windscreen, where the normal rises by more than
    50 degrees, it stands level instead and looks the way the surface falls, ahead on a flat one.
    `box_m` (2, 3) are the lowest and highest corner of the body in the sensor's frame.
    """
    angles = _lidar_rpy_deg(normal) if kind == "lidar" else _camera_rpy_deg(normal)
    roll, pitch, yaw = (round(angle, 2) + 0.0 for angle in angles)
    turned = Pose((0.0, 0.0, 0.0), (roll, pitch, yaw))
    corners = np.stack(np.meshgrid(*np.asarray(box_m).T), axis=-1).reshape(-1, 3) @ turned.rotation().T
    position = np.asarray(point_m) - float((corners @ normal).min()) * np.asarray(normal)
    x, y, z = (round(float(value), 4) + 0.0 for value in position)
    return Pose((x, y, z), turned.rpy_deg)


def _lidar_rpy_deg(normal: Vector) -> tuple[float, float, float]:
    """Upright on the surface: z along the normal, x as near to the car's x axis as can be."""
    up = np.asarray(normal, dtype=np.float64)
    ahead = np.array([1.0, 0.0, 0.0])
    if abs(float(up @ ahead)) > 0.99:  # on the very front or rear: its x axis looks down or up
        ahead = np.array([0.0, 0.0, -math.copysign(1.0, float(up[0]))])
    left = np.cross(up, ahead)
    left /= np.linalg.norm(left)
    return rpy_deg_from_rotation(np.stack([np.cross(left, up), left, up], axis=1))


def _camera_rpy_deg(normal: Vector) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in normal)
    flat = math.hypot(x, y)
    if abs(z) > _STEEP:
        return (0.0, 0.0, math.degrees(math.atan2(y, x)) if flat > _FLAT else 0.0)
    return (0.0, math.degrees(math.atan2(-z, flat)), math.degrees(math.atan2(y, x)))
