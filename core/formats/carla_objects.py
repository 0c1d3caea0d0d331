"""CARLA, objects.json of the ROS bridge: sensors with spawn points relative to the vehicle's actor.

The bridge takes spawn points in ROS axes (x forward, y left, z up; metres; roll, pitch, yaw in degrees about the
fixed axes) and turns them into CARLA's left-handed ones itself, so pitch 20 looks down here and would be -20 in
CARLA. Origin: the vehicle's actor, on the ground under the middle of its bounding box.
Source: carla_spawn_objects.py and carla_common/transforms.py of the ROS bridge; CARLA sensor reference.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from riglens.core.errors import InputError
from riglens.core.formats.base import Format
from riglens.core.formats.carla_lidar import azimuth_count, rays_to_write
from riglens.core.formats.frames import pose_from_se3, se3_from_rpy_deg
from riglens.core.formats.lens_export import centred_pinhole, report_lens
from riglens.core.formats.mounts import ACTOR, Mounting, sensors_to_write
from riglens.core.formats.report import Notes
from riglens.core.formats.source import MAX_PIXELS, Source, Value
from riglens.core.rig.model import Camera, LinearAngles, Rig, Sensor
from riglens.core.rig.yaml.nodes import shortened
from riglens.core.sensors.radar import Radar

PINHOLE = "a pinhole of one focal length in the middle of its image"
_POSITION, _ANGLES = ("x", "y", "z"), ("roll", "pitch", "yaw")


RADAR_TYPE = "sensor.other.radar"
KNOWN = {
    "lidar": ("ray_cast", "ray_cast_semantic"),
    "camera": (
        *("rgb", "depth", "semantic_segmentation", "instance_segmentation", "dvs", "optical_flow", "normals"),
    ),
}
"""Types of CARLA's sensors whose view is known."""


def recognises(source: Source) -> bool:
    """Return whether this is a JSON object with a list of objects."""
    objects = source.json.get("objects") if source.json.is_mapping else None
    return objects is not None and objects.is_list


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the cameras and LiDARs of the first vehicle that has any sensor; token: the id of another vehicle."""
    vehicle = _vehicle(source, mounting.options.token, mounting.notes)
    for sensor in vehicle.item("sensors").elements():
        _add(sensor, mounting)
    mounting.notes.converted(
        "spawn points are in ROS axes already, relative to the actor: on the ground under the body centre"
    )
    return mounting.rig(vehicle.item("id", source.name).text())


def _vehicle(source: Source, token: str | None, notes: Notes) -> Value:
    """Return the vehicle to read; what else the file holds is reported."""
    chosen: Value | None = None
    for value in source.json.item("objects").elements():
        kind, name = value.item("type", "").text(), value.item("id", "?").text()
        fits = kind.startswith("vehicle.") and "sensors" in value and token in (None, name)
        if fits and chosen is None:
            chosen = value
            notes.read(f"vehicle '{shortened(name, 40)}' ({shortened(kind, 40)})")
        else:
            notes.ignored("object that is not the vehicle", shortened(name, 40))
    if chosen is None:
        named = "" if token is None else f" with id '{shortened(token)}'"
        raise InputError(f"{source.where}: objects: must hold a vehicle with sensors{named}")
    return chosen


def _add(sensor: Value, mounting: Mounting) -> None:
    kind, name = sensor.item("type").text(), sensor.item("id").text()
    family, _, model = kind.removeprefix("sensor.").partition(".")
    if kind == RADAR_TYPE:
        mounting.add("radar", name, _pose(sensor.item("spawn_point", {})), **_radar_fields(sensor))
        return
    if family not in ("camera", "lidar"):
        mounting.notes.ignored(f"neither camera nor LiDAR: {shortened(kind, 40)}", name)
        return
    if model not in KNOWN[family]:
        mounting.notes.approximated(
            f"unknown type '{shortened(kind, 40)}', read as a sensor.{family} of CARLA", name
        )
    pose = _pose(sensor.item("spawn_point", {}))
    if family == "lidar":
        mounting.add("lidar", name, pose, **lidar_fields(sensor, name, mounting.notes))
        return
    if model != "rgb":
        mounting.notes.read("camera of another kind, imported for its view", name)
    width, height = (
        sensor.item(f"image_size_{axis}", size).whole(1, MAX_PIXELS, quoted=True)
        for axis, size in (("x", 800), ("y", 600))
    )
    mounting.add("camera", name, pose, image=(width, height), hfov_deg=_number(sensor, "fov", 90.0))
    if any(key.startswith("lens_") for key, _ in sensor.items()):
        mounting.notes.ignored("lens distortion", name)


def _pose(spawn: Value) -> Any:
    x, y, z = (_number(spawn, key, 0.0) for key in _POSITION)
    roll, pitch, yaw = (_number(spawn, key, 0.0) for key in _ANGLES)
    return se3_from_rpy_deg((x, y, z), (roll, pitch, yaw))


def lidar_fields(sensor: Value, name: str, notes: Notes) -> dict[str, Any]:
    """Return the rays that CARLA casts: `channels` beams with both ends, points spread over the turns of a second."""
    channels = int(_number(sensor, "channels", 32, low=1, high=1000))
    lower, upper = _number(sensor, "lower_fov", -30.0), _number(sensor, "upper_fov", 10.0)
    if not -90.0 <= lower <= upper <= 90.0:
        sensor.refuse("lower_fov <= upper_fov, both within ±90", f"lower_fov {lower:g}, upper_fov {upper:g}")
    if channels == 1 and lower < upper:
        notes.read("one beam, which CARLA casts at upper_fov", name)
        lower = upper
    points = _number(sensor, "points_per_second", 56_000, low=1, high=1e9)
    turns = _number(sensor, "rotation_frequency", 10.0, low=1e-3, high=1e6)
    span = _number(sensor, "horizontal_fov", 360.0, low=1e-3, high=360.0)
    return {
        "elevations_deg": LinearAngles(from_=lower, to=upper, count=channels),
        "azimuths_deg": LinearAngles(
            from_=-span / 2, to=span / 2, count=azimuth_count(points, turns, channels)
        ),
        "range_m": (0.0, _number(sensor, "range", 10.0, low=1e-3, high=1e6)),
    }


def _radar_fields(sensor: Value) -> dict[str, Any]:
    """Return the one scan of CARLA's radar, which is symmetric about its axis, with the defaults of CARLA."""
    wide, high = (
        _number(sensor, f"{axis}_fov", 30.0, low=1e-3, high=180.0) / 2 for axis in ("horizontal", "vertical")
    )
    scan = {"azimuth_deg": (-wide, wide), "elevation_deg": (-high, high)}
    return {"scans": ({**scan, "range_m": _number(sensor, "range", 100.0, low=1e-3, high=1000.0)},)}


def _number(value: Value, key: str, default: float, low: float = -1e6, high: float = 1e6) -> float:
    return value.item(key, default).number(low, high, quoted=True)


def write(rig: Rig, notes: Notes) -> dict[str, str]:
    """Return one vehicle with all sensors."""
    sensors = [_sensor(sensor, notes) for sensor in sensors_to_write(rig, notes, _WRITERS)]
    ego = {"type": "vehicle.tesla.model3", "id": "ego_vehicle", "sensors": sensors}
    notes.approximated("the vehicle is written as CARLA's vehicle.tesla.model3")
    notes.converted("poses stay in ROS axes and degrees, relative to the actor")
    text = json.dumps({"objects": [ego]}, indent=4) + "\n"
    return {"objects.json": text}


def _sensor(sensor: Sensor, notes: Notes) -> dict[str, object]:
    pose = pose_from_se3(sensor.pose.vehicle_SE3_sensor())
    spawn = dict(zip((*_POSITION, *_ANGLES), (*pose.position_m, *pose.rpy_deg), strict=True))
    type_, write_fields = _WRITERS[sensor.kind]
    return {"type": type_, "id": sensor.name, "spawn_point": spawn, **write_fields(sensor, notes)}


def _fields_of_radar(radar: Radar, notes: Notes) -> dict[str, float]:
    """Return the scan that reaches farthest, as wide and as high as CARLA's symmetric field of view has to be."""
    scan = max(radar.scans, key=lambda scan: scan.range_m)
    ends = {"horizontal": scan.azimuth_deg, "vertical": scan.elevation_deg}
    fov = {f"{axis}_fov": 2.0 * max(map(abs, limits)) for axis, limits in ends.items()}
    notes.written("pose, field of view and range", radar.name)
    if len(radar.scans) > 1:
        notes.ignored(f"{len(radar.scans) - 1} scans of shorter range: CARLA's radar has one", radar.name)
    if any(low != -high for low, high in ends.values()):
        notes.approximated("CARLA's field of view is symmetric: it is written wide enough", radar.name)
    notes.ignored("cross sections, resolution and model: the format cannot express them", radar.name)
    return {**fov, "range": scan.range_m}


def _image_fields(camera: Camera, notes: Notes) -> dict[str, float]:
    width, height = camera.image
    fields = {"image_size_x": width, "image_size_y": height, "fov": fov_deg(camera, notes)}
    notes.written("pose, image size and field of view", camera.name)
    notes.ignored("ray lattice and range: the format cannot express them", camera.name)
    return fields


def fov_deg(camera: Camera, notes: Notes) -> float:
    """Return the horizontal field of view of the lens; CARLA's is a pinhole, centred on the image."""
    if camera.hfov_deg is not None:
        return camera.hfov_deg
    written = centred_pinhole(camera)
    report_lens(camera, written, PINHOLE, notes)
    assert written.hfov_deg is not None
    return written.hfov_deg


_WRITERS: dict[str, tuple[str, Callable[[Any, Notes], dict[str, Any]]]] = {
    "lidar": ("sensor.lidar.ray_cast", rays_to_write),
    "camera": ("sensor.camera.rgb", _image_fields),
    "radar": (RADAR_TYPE, _fields_of_radar),
}
"""CARLA's type of each kind, and how its fields are written."""
CARLA = Format("carla", "CARLA ROS bridge objects.json", (".json",), recognises, read, write, origin=ACTOR)
