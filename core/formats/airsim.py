"""AirSim: settings.json with cameras and LiDARs of its vehicles (import).

Axes of the vehicle: x forward, y to the RIGHT, z DOWN (NED), metres; roll, pitch, yaw in degrees, R = Rz(yaw) Ry(pitch)
Rx(roll): positive pitch looks up, positive yaw turns right. The origin is the vehicle's pawn; that this is the ground
under the middle of the body is assumed. What the settings leave out has AirSim's defaults.
Source: AirSim documentation, "Settings", "How to use Lidar in AirSim"; LidarSimpleParams.hpp.
"""

from __future__ import annotations

from typing import Any

from riglens.core.errors import InputError
from riglens.core.formats.base import Format
from riglens.core.formats.carla_lidar import azimuth_count
from riglens.core.formats.frames import Matrix, se3_from_rpy_deg
from riglens.core.formats.mounts import Mounting, Origin
from riglens.core.formats.report import Notes
from riglens.core.formats.source import MAX_ANGLE, Source, Value
from riglens.core.rig.model import LinearAngles, Rig
from riglens.core.rig.yaml.nodes import shortened

_LIDAR_TYPE = 6
_IMAGE = {"Width": 256.0, "Height": 144.0, "FOV_Degrees": 90.0}
_RAYS = {
    "NumberOfChannels": 16.0,
    "Range": 100.0,
    "PointsPerSecond": 100_000.0,
    "RotationsPerSecond": 10.0,
    "HorizontalFOVStart": 0.0,
    "HorizontalFOVEnd": 359.0,
    "VerticalFOVUpper": 10.0,
    "VerticalFOVLower": -10.0,
}
"""AirSim's defaults, those of vertical angles for cars."""
_FULL_TURN_DEG = 359.0


def recognises(source: Source) -> bool:
    """Return whether this is a JSON mapping with the vehicles of AirSim's settings."""
    root = source.json
    return "Vehicles" in root and ("SettingsVersion" in root or "SimMode" in root)


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the sensors of one vehicle: `options.token`, or the first that has some."""
    name, vehicle = _vehicle(source, mounting.options.token, mounting.notes)
    defaults = source.json.get("CameraDefaults")
    for camera, value in _named(vehicle, "Cameras"):
        image = _numbers(_IMAGE, _capture(value), None if defaults is None else _capture(defaults))
        size = Value(image, *value.place).image("Width", "Height")
        mounting.add("camera", camera, _pose(value), image=size, hfov_deg=image["FOV_Degrees"])
    for sensor, value in _named(vehicle, "Sensors"):
        _add_sensor(sensor, value, mounting)
    mounting.notes.converted("from y right, z down to y left, z up: y, z, pitch and yaw change sign")
    return mounting.rig(f"AirSim {shortened(name, 80)}")


def _vehicle(source: Source, token: str | None, notes: Notes) -> tuple[str, Value]:
    vehicles = dict(source.json.item("Vehicles").items())
    if token is not None and token not in vehicles:
        raise InputError(f"{source.where}: token must be the name of a vehicle (got '{shortened(token)}')")
    some = (name for name, value in vehicles.items() if "Cameras" in value or "Sensors" in value)
    name = token or next(some, next(iter(vehicles), ""))
    if not name:
        raise InputError(f"{source.where}: Vehicles: must name a vehicle")
    notes.read(f"sensors of {shortened(name, 40)}", field="token")
    for other in vehicles.keys() - {name}:
        notes.ignored("another vehicle", shortened(other, 40))
    return name, vehicles[name]


def _named(vehicle: Value, key: str) -> list[tuple[str, Value]]:
    return list(vehicle.item(key).items()) if key in vehicle else []


def _capture(camera: Value) -> Value | None:
    """Return the capture settings of pictures (ImageType 0), else the first."""
    listed = camera.item("CaptureSettings").elements() if "CaptureSettings" in camera else []
    scene = (one for one in listed if one.item("ImageType", 0.0).number() == 0.0)
    return next(scene, listed[0] if listed else None)


def _numbers(defaults: dict[str, float], *said: Value | None) -> dict[str, float]:
    """Return numbers under these keys, from the first value that has them."""
    return {
        key: next((value.item(key).number() for value in said if value is not None and key in value), default)
        for key, default in defaults.items()
    }


def _pose(value: Value) -> Matrix:
    x, y, z = (value.item(key, 0.0).number() for key in ("X", "Y", "Z"))
    roll, pitch, yaw = (
        value.item(key, 0.0).number(-MAX_ANGLE, MAX_ANGLE) for key in ("Roll", "Pitch", "Yaw")
    )
    return se3_from_rpy_deg((x, -y, -z), (roll, -pitch, -yaw))


def _add_sensor(name: str, value: Value, mounting: Mounting) -> None:
    if value.item("SensorType").number() != _LIDAR_TYPE:
        mounting.notes.ignored("neither camera nor LiDAR", name)
    elif "Enabled" in value and value.item("Enabled").use().raw is not True:
        mounting.notes.ignored("switched off in the file", name)
    else:
        mounting.add("lidar", name, _pose(value), **_rays(value, name, mounting.notes))


def _rays(value: Value, name: str, notes: Notes) -> dict[str, Any]:
    """Return beams, azimuths and range; AirSim counts azimuths to the right."""
    left = [key for key in _RAYS if key not in value]
    if left:
        notes.approximated(f"not in the file, AirSim's defaults for cars: {', '.join(left)}", name)
    rays = {
        key: Value(number, value.place[0], f"{value.place[1]}.{key}")
        for key, number in _numbers(_RAYS, value).items()
    }
    channels = rays["NumberOfChannels"].whole(1, 1000)
    low, high = sorted(rays[f"VerticalFOV{end}"].number(-90.0, 90.0) for end in ("Lower", "Upper"))
    right, left_deg = sorted(-rays[f"HorizontalFOV{end}"].number(-360.0, 360.0) for end in ("Start", "End"))
    if left_deg - right >= _FULL_TURN_DEG:
        right, left_deg = -180.0, 180.0
    points, turns = (rays[f"{what}PerSecond"].number(1e-3, 1e9) for what in ("Points", "Rotations"))
    return {
        "elevations_deg": LinearAngles(from_=low if channels > 1 else high, to=high, count=channels),
        "azimuths_deg": LinearAngles(from_=right, to=left_deg, count=azimuth_count(points, turns, channels)),
        "range_m": (0.0, rays["Range"].number(1e-3, 1e6)),
    }


_PAWN = Origin("the origin", lambda _: (0.0, 0.0, 0.0))
AIRSIM = Format(
    "airsim",
    "AirSim settings",
    (".json",),
    recognises,
    read,
    origin=_PAWN,
    harmless="Enabled|VehicleType|SettingsVersion|SimMode|ViewMode|ClockSpeed|ImageType|AutoCreate|DrawDebugPoints|DataFrame",
)
