"""Channels of a data set: the name, pose and axes of each sensor in it.

nuScenes' customs: the ego frame lies on the ground under the middle of the rear axle; a camera's x points to the right
in the picture, y down and z ahead; LIDAR_TOP's x points to the right of the car and y ahead.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Camera, Rig, Sensor

Doubles = NDArray[np.float64]
MERGED = "LIDAR_TOP"
_OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Axes of a nuScenes camera (columns) in those of a camera here: x ahead, y to the left, z up."""
_RIGHT_AHEAD = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, eq=False)
class Channel:
    """A source of files: place_m (3,) and rotation (3, 3) of its frame in the ego frame; intrinsic (3, 3) in pixels for
    cameras; `sensor`: its place among the rig's LiDARs or cameras, None for all LiDARs together."""

    name: str
    modality: Literal["lidar", "camera"]
    place_m: Doubles
    rotation: Doubles
    sensor: int | None = None
    intrinsic: Doubles | None = None
    size_px: tuple[int, int] = (0, 0)

    @property
    def ending(self) -> str:
        """Return the file name extension."""
        return ".jpg" if self.modality == "camera" else ".pcd.bin"

    def to_sensor(self, ego_m: Doubles) -> Doubles:
        """Convert points (n, 3) from the ego frame to the frame of the channel."""
        return np.asarray((ego_m - self.place_m) @ self.rotation)

    def to_ego(self, sensor_m: Doubles) -> Doubles:
        """Convert points (n, 3) from the frame of the channel to the ego frame."""
        return np.asarray(sensor_m @ self.rotation.T + self.place_m)


def ego_origin_m(rig: Rig) -> Doubles:
    """Return the ego frame's origin in the vehicle frame (3,)."""
    return np.array([rig.vehicle.rear_axle_x, 0.0, 0.0])


def channels_of(rig: Rig, with_cameras: bool = True) -> list[Channel]:
    """Return all LiDARs together, then each on its own where there are several, then the cameras."""
    origin_m, taken = ego_origin_m(rig), {MERGED}
    lidars, found = rig.enabled_lidars(), list[Channel]()
    if lidars:
        middle_m = np.mean([lidar.position for lidar in lidars], axis=0) - origin_m
        found.append(Channel(MERGED, "lidar", middle_m, _RIGHT_AHEAD))
    if len(lidars) > 1:
        for number, lidar in enumerate(lidars):
            place_m = np.array(lidar.position) - origin_m
            found.append(
                Channel(_name("LIDAR", lidar, taken), "lidar", place_m, lidar.pose.rotation(), number)
            )
    for number, camera in enumerate(rig.enabled_cameras() if with_cameras else ()):
        found.append(_camera(camera, number, _name("CAM", camera, taken), origin_m))
    return found


def _camera(camera: Camera, number: int, name: str, origin_m: Doubles) -> Channel:
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    return Channel(
        name,
        "camera",
        np.array(camera.position) - origin_m,
        camera.pose.rotation() @ _OPTICAL,
        number,
        np.array([[fx_px, 0.0, cx_px], [0.0, fy_px, cy_px], [0.0, 0.0, 1.0]]),
        camera.image,
    )


def _name(family: str, sensor: Sensor, taken: set[str]) -> str:
    """Return a unique name of capital letters, digits and _ that begins with LIDAR_ or CAM_."""
    words = re.sub(r"[^A-Z0-9]+", "_", sensor.name.upper()).strip("_")[:60] or "ONE"
    name = words if words.startswith(f"{family}_") else f"{family}_{words}"
    number, free = 2, name
    while free in taken:
        number, free = number + 1, f"{name}_{number}"
    taken.add(free)
    return free


def quaternions(rotation: Doubles) -> Doubles:
    """Return quaternions (n, 4), w, x, y, z, of rotations (n, 3, 3)."""
    from scipy.spatial.transform import Rotation

    xyzw = Rotation.from_matrix(rotation).as_quat(canonical=True)
    return np.asarray(xyzw[:, [3, 0, 1, 2]])
