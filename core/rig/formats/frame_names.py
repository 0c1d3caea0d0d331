"""What a frame holds, told by its name, where a format gives sensors no kind of their own (ROS, Autoware)."""

from __future__ import annotations

import re
from typing import Literal

SensorKind = Literal["camera", "lidar"]

_OTHER = re.compile(r"imu|gnss|gps|radar|ars4|sonar|ultrasonic|odom|antenna")
_CAMERA = re.compile(r"camera|optical|(^|[^a-z])cam([^a-z]|$)")
_LIDAR = re.compile(
    r"lidar|laser|velodyne|vlp|hdl|vls|pandar|hesai|livox|ouster|(^|[^a-z])os[0-2]([^0-9]|$)|rslidar|robosense|"
    r"helios|bpearl|innoviz|luminar|innovusion|seyond|aeva|qt128|ot128"
)
_ENDINGS = (
    "/camera_optical_link",
    "/camera_link",
    "_optical_frame",
    "_optical_link",
    "_optical",
    "_base_link",
)


def kind_of(frame: str) -> SensorKind | None:
    """Camera, LiDAR, or None when the name tells neither."""
    name = frame.lower()
    if _OTHER.search(name):
        return None
    if _CAMERA.search(name):
        return "camera"
    return "lidar" if _LIDAR.search(name) else None


def is_optical(frame: str) -> bool:
    """Whether the name says optical axes (x right, y down, z forward; REP-103)."""
    return "optical" in frame.lower()


def without_ending(frame: str) -> str:
    """The name of the sensor whose frame this is: without what says that it is a frame."""
    for ending in _ENDINGS:
        if frame.endswith(ending) and len(frame) > len(ending):
            return frame.removesuffix(ending)
    return frame.removesuffix("_link") or frame
