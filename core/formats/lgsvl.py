"""LGSVL / SVL Simulator: the list of a vehicle's sensors in JSON (import).

Unity's left-handed axes: x to the RIGHT, y UP, z FORWARD, metres; degrees, turned about y, then x, then z: positive
pitch looks down, positive yaw turns right, positive roll tips the left side down. The origin is the vehicle's: the
examples put the rear axle 1.35 m behind it. FieldOfView of a camera is vertical; that of a LiDAR lies around
CenterAngle, positive below the horizon. What the file leaves out has the simulator's defaults.
Source: LGSVL documentation, "Sensor JSON options".
"""

from __future__ import annotations

import math
import re
from typing import Any

from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, se3_from_rpy_deg
from riglens.core.formats.mounts import Mounting, Origin
from riglens.core.formats.report import Notes
from riglens.core.formats.source import MAX_ANGLE, MAX_PIXELS, Source, Value
from riglens.core.rig.model import LinearAngles, Rig

_CAMERA, _LIDAR = re.compile("camera(sensor)?$"), re.compile("lidar(sensor)?$")
_DEFAULTS: dict[str, float] = {
    "Width": 1920, "Height": 1080, "LaserCount": 32, "MinDistance": 0.5, "MaxDistance": 100.0,
    "MeasurementsPerRotation": 1500, "CenterAngle": 10.0,
}  # fmt: skip
_VIEW_DEG = {"camera": 60.0, "lidar": 41.33}


def _sensors(source: Source) -> list[Value]:
    root = source.json
    listed = root.get("sensors") if root.is_mapping else root
    found = listed.elements() if listed is not None and listed.is_list else []
    return [one for one in found if one.is_mapping]


def recognises(source: Source) -> bool:
    """Return whether this is a list of sensors with a type and params or transform, alone or under `sensors`."""
    found = _sensors(source)
    return bool(found) and any(
        isinstance(one.raw.get("transform"), dict) and isinstance(one.raw.get("type"), str) for one in found
    )


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the cameras, LiDARs, radars and ultrasonic sensors."""
    for sensor in _sensors(source):
        _add(sensor, mounting)
    mounting.notes.converted("from x right, y up, z forward: pitch stays, yaw and roll change sign")
    return mounting.rig(source.name)


def _add(sensor: Value, mounting: Mounting) -> None:
    kind = sensor.item("type").text()
    name = sensor.item("name", kind).text()
    word = kind.lower().replace(" ", "").replace("-", "")
    params = sensor.item("params", {})
    if _CAMERA.search(word):
        mounting.add("camera", name, _pose(sensor), **_lens(params))
    elif _LIDAR.search(word):
        said = params.item("VelodyneLidarType", "").text() or None
        rays = {} if said else _rays(params, name, mounting.notes)
        mounting.add("lidar", name, _pose(sensor), said=said and f"Velodyne {said}", **rays)
    elif word.removesuffix("sensor") in ("radar", "ultrasonic"):
        mounting.add(word.removesuffix("sensor"), name, _pose(sensor))
    else:
        mounting.notes.ignored(f"not a camera, LiDAR, radar or ultrasonic sensor: {kind}", name)


def _pose(sensor: Value) -> Matrix:
    """Return a pose from Unity's axes: their z is forward, -x left and y up."""
    value = sensor.item("transform", {})
    x, y, z = (value.item(key, 0.0).number() for key in "xyz")
    angles = (value.item(key, 0.0).number(-MAX_ANGLE, MAX_ANGLE) for key in ("roll", "pitch", "yaw"))
    roll, pitch, yaw = angles
    return se3_from_rpy_deg((z, -x, y), (-roll, pitch, -yaw))


def _number(params: Value, key: str, low: float, high: float) -> float:
    return params.item(key, _DEFAULTS[key]).number(low, high)


def _lens(params: Value) -> dict[str, Any]:
    width, height = (int(_number(params, key, 1, MAX_PIXELS)) for key in ("Width", "Height"))
    high_deg = params.item("FieldOfView", _VIEW_DEG["camera"]).number(1e-3, 179.0)
    across = math.tan(math.radians(high_deg) / 2.0) * width / height
    return {"image": (width, height), "hfov_deg": math.degrees(2.0 * math.atan(across))}


def _rays(params: Value, name: str, notes: Notes) -> dict[str, Any]:
    """Return beams, azimuths and range."""
    azimuths = int(_number(params, "MeasurementsPerRotation", 1, 100_000))
    found: dict[str, Any] = {
        "azimuths_deg": LinearAngles(from_=-180.0, to=180.0, count=azimuths),
        "range_m": tuple(_number(params, f"{end}Distance", 0.0, 1e6) for end in ("Min", "Max")),
    }
    if "VerticalRayAngles" in params and params.item("VerticalRayAngles").elements():
        return found | {"elevations_deg": tuple(sorted(params.item("VerticalRayAngles").numbers(limit=90.0)))}
    left = [key for key in ("LaserCount", "FieldOfView", "CenterAngle") if key not in params]
    if left:
        notes.approximated(f"not in the file, the simulator's defaults: {', '.join(left)}", name)
    beams = int(_number(params, "LaserCount", 1, 1000))
    middle = -_number(params, "CenterAngle", -90.0, 90.0)
    half = params.item("FieldOfView", _VIEW_DEG["lidar"]).number(0.0, 180.0) / 2.0 if beams > 1 else 0.0
    return found | {"elevations_deg": LinearAngles(from_=middle - half, to=middle + half, count=beams)}


_VEHICLE = Origin("the vehicle's origin", lambda _: (0.0, 0.0, 0.0))
LGSVL = Format(
    "lgsvl", "LGSVL sensor configuration", (".json",), recognises, read, origin=_VEHICLE,
    harmless="Frequency|RotationFrequency|JpegQuality|Compensated|Point(Color|Size)|Topic|Frame|HostName|Udp.*"
    "|(Min|Max)Distance|plugin.*|parent|type",
)  # fmt: skip
