"""Say what is implausible about a rig, as rigs read from files of other programs are: axes, units and kinds mistaken.

A rig file of the user's own may have the same slips. Nothing is changed: each fact comes with what to look at. Limits
are our choice, wide enough for the presets and for the published rigs that the tests read.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.edits import mirrored_name
from riglens.core.rig.model import Camera, Lidar, Rig, Sensor
from riglens.core.sensors.camera import field_of_view_deg
from riglens.core.sensors.registry import kind_of

Axes = NDArray[np.float64]
_ON_ITS_SIDE = math.cos(math.radians(20.0))
_UNDER_GROUND_M = -0.05
_FAR_LENGTHS = 3.0
_SIDE_M = 0.15
"""Distance beyond the middle at which a sensor is on the side that its name denies."""
_LOOKS = 0.7
"""Part of a viewing direction along an axis: within 45 degrees of it."""
_SONAR_M, _SONAR_DEG = 10.0, 30.0
_NARROWEST_DEG, _WIDEST_PINHOLE_DEG = 3.0, 160.0
_OFF_MIDDLE, _UNEVEN = 0.28, 1.5
_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|[0-9]+")


def implausible(rig: Rig) -> list[str]:
    """Return one line for each implausible fact about the enabled sensors, with their names and what to look at."""
    enabled = tuple(sensor for sensor in rig.sensors if sensor.enabled)
    found: dict[str, list[str]] = {}
    for check in CHECKS:
        for name, fact in check(rig, enabled):
            found.setdefault(fact, []).append(name)
    return [f"{_listed(names)}: {fact}" for fact, names in found.items()]


def _listed(names: list[str]) -> str:
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")


Check = Callable[[Rig, tuple[Sensor, ...]], Iterator[tuple[str, str]]]
"""From a rig and its enabled sensors to names and facts; the same fact about several sensors is one line."""


def _rolled(_: Rig, sensors: tuple[Sensor, ...]) -> Iterator[tuple[str, str]]:
    """Find cameras on their side, upside down, or that look over every road."""
    for camera in sensors:
        if not isinstance(camera, Camera):
            continue
        (_, side_up, up), ahead_up = _axes(camera)[2], _axes(camera)[2][0]
        high_deg = field_of_view_deg(camera)[1]
        lower_edge_deg = math.degrees(math.asin(max(-1.0, min(1.0, ahead_up)))) - high_deg / 2.0
        if abs(side_up) > _ON_ITS_SIDE:
            yield (
                camera.name,
                "rolled by 90°, on the side: if the pose is that of an optical frame (z forward), turn it by "
                "rpy_deg -90 0 -90",
            )
        elif up < -_ON_ITS_SIDE:
            yield (
                camera.name,
                "rolled by 180°, upside down: check rpy_deg, and the axes that the file means",
            )
        elif lower_edge_deg > 0.0:
            yield camera.name, "looking above the horizon only: check the sign and the unit of pitch"


def _misplaced(rig: Rig, sensors: tuple[Sensor, ...]) -> Iterator[tuple[str, str]]:
    """Find sensors in the ground and far from the car."""
    reach_m = _FAR_LENGTHS * rig.vehicle.length
    for sensor in sensors:
        if sensor.position[2] < _UNDER_GROUND_M:
            yield sensor.name, "below the ground (z = 0): check the origin of the rig, and its axes"
        if math.hypot(*sensor.position) > reach_m:
            yield sensor.name, f"more than {reach_m:.0f} m from the car: check the unit of position"


def _against_names(_: Rig, sensors: tuple[Sensor, ...]) -> Iterator[tuple[str, str]]:
    """Find sensors on the other side than their name says, and cameras that look the other way."""
    by_name = {sensor.name: sensor for sensor in sensors}
    swapped: list[str] = []
    for sensor in sensors:
        words = {word.lower() for word in _WORD.findall(sensor.name)}
        y, ahead = sensor.position[1], _axes(sensor)[:, 0]
        narrow = kind_of(sensor.kind).view_deg(sensor)[0] < 200.0
        for side, sign in (("left", 1.0), ("right", -1.0)):
            if side not in words or {"left", "right"} <= words or (narrow and ahead[0] < -_LOOKS):
                continue
            partner = by_name.get(mirrored_name(sensor.name))
            is_beyond = sign * y < -_SIDE_M
            if partner is not None:
                is_beyond = sign * (y - partner.position[1]) < -_SIDE_M / 3.0
            if is_beyond and not (narrow and sign * ahead[1] > _LOOKS / 2.0 and abs(y) < 3.0 * _SIDE_M):
                swapped.append(sensor.name)
        is_front, is_rear = "front" in words, bool(words & {"rear", "back"})
        if is_front == is_rear or not narrow or not isinstance(sensor, Camera):
            continue
        sign = 1.0 if is_front else -1.0
        if (
            sign * ahead[0] < -_LOOKS
            and (is_rear or sensor.position[0] < 0.0)
            and not words & {"left", "right"}
        ):
            yield (
                sensor.name,
                f"looking {'back' if is_front else 'ahead'}, against the name: check yaw and axes",
            )
    fact = "on the other side than the name says: check whether y of the file points left"
    if len(swapped) > 2:
        fact = "on the other side than the names say: the rig is mirrored, y of the file points right"
    yield from ((name, fact) for name in swapped)


def _lenses(_: Rig, sensors: tuple[Sensor, ...]) -> Iterator[tuple[str, str]]:
    """Find lenses whose numbers contradict each other or the image."""
    for camera in sensors:
        if not isinstance(camera, Camera) or camera.fx is None:
            continue
        fx, fy, *centre = camera.intrinsics_px()
        wide_deg = math.degrees(2.0 * math.atan(camera.image[0] / 2.0 / fx))
        off = max(abs(at - side / 2.0) / side for at, side in zip(centre, camera.image, strict=True))
        if off > _OFF_MIDDLE:
            yield camera.name, "principal point far from the middle of the image: check the image size"
        elif not 1.0 / _UNEVEN <= fx / fy <= _UNEVEN:
            yield (
                camera.name,
                f"focal lengths {fx:.4g} and {fy:.4g} px differ: check them and the image size",
            )
        elif camera.distortion is None and not _NARROWEST_DEG <= wide_deg <= _WIDEST_PINHOLE_DEG:
            yield (
                camera.name,
                f"a pinhole {wide_deg:.3g}° wide: check whether the focal length is in pixels of this image",
            )


def _sonars(_: Rig, sensors: tuple[Sensor, ...]) -> Iterator[tuple[str, str]]:
    """Find LiDARs that see like a sonar, and those with a single row of rays."""
    for lidar in sensors:
        if not isinstance(lidar, Lidar):
            continue
        wide_deg, high_deg = kind_of("lidar").view_deg(lidar)
        if lidar.range_m[1] <= _SONAR_M and max(wide_deg, high_deg) <= _SONAR_DEG:
            yield (
                lidar.name,
                f"a LiDAR of {wide_deg:.0f}° and {lidar.range_m[1]:g} m: is it an ultrasonic sensor?",
            )
        elif lidar.rays is None and lidar.resolution[1] == 1:
            yield lidar.name, "a LiDAR with one row of rays: unless it is planar, its elevations are missing"


CHECKS: tuple[Check, ...] = (_rolled, _misplaced, _against_names, _lenses, _sonars)
"""Checks of plausibility; a new one is a function and its place here."""


def _axes(sensor: Sensor) -> Axes:
    """Return the rotation (3, 3) from the sensor's frame to the vehicle's: its columns are the sensor's axes."""
    return np.asarray(sensor.pose.vehicle_SE3_sensor()[:3, :3])
