"""ASAM OSI, export: SensorViewConfiguration messages with their MountingPosition, as protobuf's JSON.

Vehicle coordinates of ISO 8855: x forward, y left, z up; origin in the middle of the rear AXLE, so as high as its
wheels' radius above the ground; metres; orientation roll, pitch, yaw in radians, turned yaw, then pitch, then roll.
Field names are those of the .proto files (snake_case), which protobuf's JSON parsers accept.
Source: osi_sensorviewconfiguration.proto, osi_common.proto (MountingPosition, Orientation3d) of OSI 3.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

from riglens.core.formats.base import Exported, Format
from riglens.core.formats.frames import pose_from_se3
from riglens.core.formats.lens_export import SMALLEST_TOLD_DEG, extent
from riglens.core.formats.mounts import root_SE3_body, sensors_to_write
from riglens.core.formats.ray_export import FULL_TURN_DEG, report_pattern, report_symmetric, turn_ends_deg
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Source
from riglens.core.rig.model import Camera, Lidar, Rig, Sensor
from riglens.core.sensing.rays import farthest_m
from riglens.core.sensors.sectors import Sectored

TITLE = "ASAM OSI sensor view configuration (JSON)"
WHEEL_RADIUS_M = 0.33
"""Assumed height of the rear axle, which a rig does not contain; 0.33 m is a 215/55 R17 tyre."""

VERSION = {"version_major": 3, "version_minor": 7, "version_patch": 0}


def recognises(_: Source) -> bool:
    """Return False: this format is only written."""
    return False


def write(rig: Rig) -> Exported:
    """Return a list of SensorViewConfiguration messages, one for each sensor, and an index of their names."""
    notes = Notes()
    sensors = sensors_to_write(rig, notes, _VIEWS)
    messages = [_message(sensor, number, rig, notes) for number, sensor in enumerate(sensors, 1)]
    notes.converted("origin from the body centre to the rear axle; angles to radians")
    notes.approximated(f"height of the rear axle is not in the rig: {WHEEL_RADIUS_M:g} m above the ground")
    notes.converted("names, for which OSI has no field, are kept next to the messages, by sensor_id")
    names = {str(number): sensor.name for number, sensor in enumerate(sensors, 1)}
    document = {"sensor_view_configuration": messages, "sensor_names": names}
    return Exported({"osi.json": json.dumps(document, indent=2) + "\n"}, notes.report(TITLE))


def _message(sensor: Sensor, number: int, rig: Rig, notes: Notes) -> dict[str, Any]:
    pose = pose_from_se3(root_SE3_body(sensor, (rig.vehicle.rear_axle_x, 0.0, WHEEL_RADIUS_M)))
    mounting = {
        "position": dict(zip("xyz", pose.position_m, strict=True)),
        "orientation": dict(zip(("roll", "pitch", "yaw"), map(math.radians, pose.rpy_deg), strict=True)),
    }
    common = {"sensor_id": {"value": number}, "mounting_position": mounting}
    wide_rad, high_rad, rays = _VIEWS[sensor.kind](sensor, notes)
    view = {"field_of_view_horizontal": wide_rad, "field_of_view_vertical": high_rad}
    message: dict[str, Any] = {"version": VERSION, **common, **view}
    if not math.isinf(far_m := farthest_m(sensor)):
        message["range"] = far_m
    if sensor.range_m[0] > 0.0:
        notes.ignored(f"smallest range {sensor.range_m[0]:g} m: OSI has no field for it", sensor.name)
    message[f"{sensor.kind}_sensor_view_configuration"] = [{**common, **view, **rays}]
    return message


def _camera(camera: Camera, notes: Notes) -> tuple[float, float, dict[str, int]]:
    """Return the symmetric fields of view in radians, as OSI has them, and the pixels."""
    width, height = camera.image
    found = extent(camera)
    notes.written("mounting position, field of view and pixels", camera.name)
    if camera.distortion is not None:
        notes.ignored(
            f"lens distortion: the format has no place for it; its field of view is written, {found.words()}",
            camera.name,
        )
    off_deg = max(abs(found.left_deg - found.right_deg), abs(found.up_deg - found.down_deg)) / 2.0
    if off_deg >= SMALLEST_TOLD_DEG:
        notes.approximated(
            f"OSI's field of view is symmetric: its edges are up to {off_deg:.2f} deg off", camera.name
        )
    notes.ignored("ray lattice: OSI has no field for it", camera.name)
    pixels = {"number_of_pixels_horizontal": width, "number_of_pixels_vertical": height}
    return math.radians(found.wide_deg), math.radians(found.high_deg), pixels


def _lidar(lidar: Lidar, notes: Notes) -> tuple[float, float, dict[str, int]]:
    """Return the symmetric fields of view in radians that hold every ray, as OSI has them, and the numbers of rays."""
    beams, turn = lidar.elevations(), lidar.azimuths()
    notes.written("mounting position, field of view and numbers of rays", lidar.name)
    low_deg, high_deg = turn_ends_deg(lidar)
    wide_deg = min(FULL_TURN_DEG, 2.0 * max(abs(low_deg), abs(high_deg)))
    tall_deg = 2.0 * float(abs(beams).max())
    report_pattern(lidar, "OSI", notes)
    notes.approximated("beam angles: OSI has a symmetric field of view and a number of rays", lidar.name)
    ends_deg = (float(beams.min()), float(beams.max()))
    report_symmetric("elevations", ends_deg, tall_deg, lidar, notes)
    if high_deg - low_deg < FULL_TURN_DEG:
        report_symmetric("azimuths", (low_deg, high_deg), wide_deg, lidar, notes)
    if lidar.model is not None:
        notes.ignored("model name: OSI has no field for it", lidar.name)
    rays = {"number_of_rays_horizontal": len(turn), "number_of_rays_vertical": len(beams)}
    return math.radians(wide_deg), math.radians(tall_deg), rays


def _sectored(sensor: Sectored, notes: Notes) -> tuple[float, float, dict[str, int]]:
    """Return the symmetric fields of view in radians that hold every sector, and the numbers of rays."""
    ends = [
        [abs(end) for s in sensor.sectors for end in getattr(s, name)]
        for name in ("azimuth_deg", "elevation_deg")
    ]
    wide_deg, high_deg = (2.0 * max(each) for each in ends)
    notes.written("mounting position, field of view and numbers of rays", sensor.name)
    what = "scans, cross sections and resolution" if sensor.kind == "radar" else "ranges by width"
    notes.ignored(f"{what}: OSI has one symmetric field of view and one range", sensor.name)
    columns, rows = sensor.resolution
    rays = {"number_of_rays_horizontal": columns, "number_of_rays_vertical": rows}
    return math.radians(wide_deg), math.radians(high_deg), rays


_VIEWS: dict[str, Callable[[Any, Notes], tuple[float, float, dict[str, int]]]] = {
    "camera": _camera,
    "lidar": _lidar,
    "radar": _sectored,
    "ultrasonic": _sectored,
}
"""Writers of a sensor, by kind."""
OSI = Format("osi", TITLE, recognises, write=write)
