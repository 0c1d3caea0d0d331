"""ASAM OSI: SensorViewConfiguration messages with their MountingPosition, as protobuf's JSON.

Vehicle coordinates of ISO 8855: x forward, y left, z up; origin in the middle of the rear AXLE, so as high as its
wheels' radius above the ground; metres; orientation roll, pitch, yaw in radians, turned yaw, then pitch, then roll.
Field names are those of the .proto files (snake_case), which protobuf's JSON parsers accept, or lowerCamelCase, which
its printers write; 64-bit integers may be texts. Fields that are left out are 0 or unknown.
Source: osi_sensorviewconfiguration.proto, osi_common.proto (MountingPosition, Orientation3d) of OSI 3.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, pose_from_se3, se3_from_rpy_rad
from riglens.core.formats.lens_export import SMALLEST_TOLD_DEG, extent
from riglens.core.formats.mounts import Mounting, Origin, root_SE3_body, sensors_to_write
from riglens.core.formats.ray_export import FULL_TURN_DEG, report_pattern, report_symmetric, turn_ends_deg
from riglens.core.formats.report import Notes
from riglens.core.formats.source import MAX_ANGLE, MAX_PIXELS, Source, Value
from riglens.core.rig.model import Camera, KannalaBrandt, Lidar, LinearAngles, Rig, Sensor
from riglens.core.sensing.rays import farthest_m
from riglens.core.sensors.radar import RadarScan
from riglens.core.sensors.sectors import Sectored

WHEEL_RADIUS_M = 0.33
"""Assumed height of the rear axle, which a rig does not contain; 0.33 m is a 215/55 R17 tyre."""

VERSION = {"version_major": 3, "version_minor": 7, "version_patch": 0}


MOST_RAYS = 100_000
"""In a row or column, as in a rig file."""
WIDEST_PINHOLE_DEG = 170.0
"""Wider images are read as those of an equidistant lens (our choice): OSI names no lens."""


def recognises(source: Source) -> bool:
    """Return whether this is a JSON file with a message SensorViewConfiguration, or with a list of them."""
    return bool(_messages(source.json))


def _messages(root: Value) -> list[Value]:
    """Return the messages of a document, empty unless it is an OSI document."""
    listed = _get(root, "sensor_view_configuration") if root.is_mapping else root
    if listed is not None and listed.is_list:
        return [one for one in listed.elements() if one.is_mapping and _views(one)]
    return [root] if root.is_mapping and _views(root) else []


def _views(message: Value) -> list[tuple[str, Value]]:
    """Return the kinds of sensor that a message configures, with the messages of each."""
    found = [(kind, _get(message, f"{kind}_sensor_view_configuration")) for kind in (*_VIEWS, "generic")]
    return [(kind, views) for kind, views in found if views is not None]


def _get(message: Value, name: str) -> Value | None:
    """Return a field by its name in the .proto file, or as protobuf's printers write it."""
    first, *rest = name.split("_")
    found = message.get(name)
    return message.get(first + "".join(word.capitalize() for word in rest)) if found is None else found


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the sensors of all messages; names come from our own index, or from kind and sensor_id."""
    root = source.json
    names = _get(root, "sensor_names") if root.is_mapping else None
    messages = _messages(root)
    if not messages:
        root.refuse("a message SensorViewConfiguration of OSI, or a list of them")
    for message in messages:
        for kind, views in _views(message):
            for number, view in enumerate(views.elements(), 1):
                said = _id(view) or _id(message) or str(number)
                named = names.get(said) if names is not None else None
                name = f"{kind} {said}" if named is None else named.text()
                if kind == "generic":
                    mounting.notes.ignored("generic sensor: OSI does not say what it is", name)
                else:
                    found = _Views(view, message, name, mounting.notes)
                    mounting.add(kind, name, found.pose(), **_READERS[kind](found))
    mounting.notes.converted("angles from radians")
    return mounting.rig(source.name)


def _id(message: Value) -> str:
    """Return the sensor_id of a message, empty without one."""
    found = _get(message, "sensor_id")
    value = None if found is None else found.get("value")
    return "" if value is None else str(value.whole(0, (1 << 53) - 1, quoted=True))


@dataclass(frozen=True)
class _Views:
    """The message of a named sensor, and the one that holds it: fields that the first lacks are those of the second."""

    own: Value
    outer: Value
    name: str
    notes: Notes

    def get(self, name: str) -> Value | None:
        found = _get(self.own, name)
        return _get(self.outer, name) if found is None else found

    def pose(self) -> Matrix:
        """Return the mounting position in OSI's vehicle frame; what is left out is 0."""
        mounting = self.get("mounting_position")
        position, turn = (
            None if mounting is None else mounting.get(name) for name in ("position", "orientation")
        )
        return se3_from_rpy_rad(_three(position, "xyz"), _three(turn, ("roll", "pitch", "yaw")))

    def angle_deg(self, name: str, most_deg: float, default_deg: float, is_flat: bool = False) -> float:
        """Return a field of view in degrees, which may be 0 if flat; one that is left out is assumed and reported."""
        found = self.get(name)
        if found is None:
            self.notes.approximated(f"{name} not in the file: assumed {default_deg:g} deg", self.name)
            return default_deg
        angle_deg = round(math.degrees(found.number(0.0, 2.0 * math.pi * (1.0 + 1e-9))), 9)
        if not (angle_deg > 0.0 or is_flat) or angle_deg > most_deg:
            found.refuse(f"above 0 and at most {most_deg:g} deg", f"{angle_deg:g} deg")
        return angle_deg

    def count(self, name: str, most: int, default: int) -> int:
        """Return a number of rays or pixels; one that is left out is assumed and reported."""
        found = self.get(name)
        if found is None:
            self.notes.approximated(f"{name} not in the file: assumed {default}", self.name)
            return default
        return found.whole(1, most, quoted=True)

    def range_m(self) -> float:
        """Return the range, endless where it is left out."""
        found = self.get("range")
        return math.inf if found is None else found.number(1e-3)


def _three(value: Value | None, names: Sequence[str]) -> list[float]:
    found = [None if value is None else value.get(name) for name in names]
    return [0.0 if one is None else one.number(-MAX_ANGLE, MAX_ANGLE) for one in found]


def _read_camera(view: _Views) -> dict[str, Any]:
    """Return a centred pinhole, or for a wide image an equidistant lens."""
    wide_deg = view.angle_deg("field_of_view_horizontal", 360.0, 70.0)
    width = view.count("number_of_pixels_horizontal", MAX_PIXELS, 1600)
    height = view.count("number_of_pixels_vertical", MAX_PIXELS, 900)
    lens: dict[str, Any] = {"hfov_deg": wide_deg}
    if wide_deg > WIDEST_PINHOLE_DEG:
        focal_px = width / math.radians(wide_deg)
        lens = {"fx": focal_px, "fy": focal_px, "cx": width / 2.0, "cy": height / 2.0}
        lens["distortion"] = KannalaBrandt()
        view.notes.approximated("lens not in the file: an equidistant one", view.name)
    else:
        view.notes.approximated("lens not in the file: a pinhole, with square pixels", view.name)
    return {"image": (width, height), "range_m": (0.0, view.range_m()), **lens}


def _read_lidar(view: _Views) -> dict[str, Any]:
    """Return even beams and azimuths over the fields of view; without them those of a library model count."""
    found: dict[str, Any] = {"range_m": (0.0, view.range_m())}
    if view.get("number_of_rays_vertical") is None:
        return found
    if view.get("directions") is not None:
        view.notes.ignored("listed directions of rays: even ones over the field of view", view.name)
    wide_deg = view.angle_deg("field_of_view_horizontal", 360.0, 360.0)
    columns = view.count("number_of_rays_horizontal", MOST_RAYS, 1800)
    rows = view.count("number_of_rays_vertical", MOST_RAYS, 16)
    high_deg = view.angle_deg("field_of_view_vertical", 180.0, 30.0, is_flat=rows == 1)
    view.notes.read("fields of view and numbers of rays", view.name)
    found["elevations_deg"] = LinearAngles(from_=-high_deg / 2.0, to=high_deg / 2.0, count=rows)
    found["azimuths_deg"] = LinearAngles(from_=-wide_deg / 2.0, to=wide_deg / 2.0, count=columns)
    return found


def _sector(view: _Views, wide_deg: float, high_deg: float) -> dict[str, Any]:
    wide = view.angle_deg("field_of_view_horizontal", 360.0, wide_deg) / 2.0
    high = view.angle_deg("field_of_view_vertical", 180.0, high_deg) / 2.0
    return {"azimuth_deg": (-wide, wide), "elevation_deg": (-high, high)}


def _far_m(view: _Views, default_m: float) -> float:
    """Return the range of a radar or an ultrasonic sensor, which needs one."""
    if view.get("range") is None:
        view.notes.approximated(f"range not in the file: assumed {default_m:g} m", view.name)
        return default_m
    return min(view.range_m(), 1000.0)


def _read_radar(view: _Views) -> dict[str, Any]:
    """Return one scan; resolution and cross sections are assumed."""
    sector = _sector(view, 90.0, 20.0)
    scan = RadarScan(range_m=_far_m(view, 100.0), **sector)
    view.notes.approximated("one scan; resolution and reference cross section are not in OSI", view.name)
    return {"scans": (scan,)}


def _read_ultrasonic(view: _Views) -> dict[str, Any]:
    """Return the one range as that for a pole."""
    pole_m = _far_m(view, 2.5)
    fields = _sector(view, 120.0, 60.0)
    wall_m = max(5.5, pole_m)
    view.notes.approximated(f"OSI has one range: that for a pole; for a wall {wall_m:g} m", view.name)
    return {"pole_range_m": pole_m, "wall_range_m": wall_m, **fields}


_READERS: dict[str, Callable[[_Views], dict[str, Any]]] = {
    "camera": _read_camera,
    "lidar": _read_lidar,
    "radar": _read_radar,
    "ultrasonic": _read_ultrasonic,
}
"""Readers of a sensor's fields, by kind."""


def write(rig: Rig, notes: Notes) -> dict[str, str]:
    """Return a list of SensorViewConfiguration messages, one for each sensor, and an index of their names."""
    sensors = sensors_to_write(rig, notes, _VIEWS)
    messages = [_message(sensor, number, rig, notes) for number, sensor in enumerate(sensors, 1)]
    notes.converted("origin from the body centre to the rear axle; angles to radians")
    notes.approximated(f"height of the rear axle is not in the rig: {WHEEL_RADIUS_M:g} m above the ground")
    notes.converted("names, for which OSI has no field, are kept next to the messages, by sensor_id")
    notes.ignored("vehicle: the format cannot express it")
    names = {str(number): sensor.name for number, sensor in enumerate(sensors, 1)}
    document = {"sensor_view_configuration": messages, "sensor_names": names}
    return {"osi.json": json.dumps(document, indent=2) + "\n"}


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
    """Return the symmetric fields of view in radians that hold every sector, and the numbers of rays of a radar."""
    ends = [
        [abs(end) for s in sensor.sectors for end in getattr(s, name)]
        for name in ("azimuth_deg", "elevation_deg")
    ]
    wide_deg, high_deg = (2.0 * max(each) for each in ends)
    notes.written("mounting position, field of view and range", sensor.name)
    what = "scans, cross sections and resolution" if sensor.kind == "radar" else "ranges by width"
    notes.ignored(f"{what}: OSI has one symmetric field of view and one range", sensor.name)
    columns, rows = sensor.resolution
    rays = {"number_of_rays_horizontal": columns, "number_of_rays_vertical": rows}
    return math.radians(wide_deg), math.radians(high_deg), rays if sensor.kind == "radar" else {}


_VIEWS: dict[str, Callable[[Any, Notes], tuple[float, float, dict[str, int]]]] = {
    "camera": _camera,
    "lidar": _lidar,
    "radar": _sectored,
    "ultrasonic": _sectored,
}
"""Writers of a sensor, by kind."""
_AXLE = Origin("the rear axle", lambda vehicle: (vehicle.rear_axle_x, 0.0, WHEEL_RADIUS_M))
OSI = Format(
    "osi",
    "ASAM OSI sensor view configuration (JSON)",
    (".json",),
    recognises,
    read,
    write,
    origin=_AXLE,
    harmless="version|generic.*",
)
