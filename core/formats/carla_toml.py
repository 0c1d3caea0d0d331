"""CARLA, TOML of the published multi-sensor placement code: lidar_*.toml with [lidar] and perhaps [camera].

CARLA's left-handed axes: x forward, y to the RIGHT, z up; positive pitch looks UP, positive yaw turns RIGHT,
positive roll as in ROS. LiDARs have no yaw; x, y, z in metres. Two forms: flat lists of the LiDARs of one rig, roll and
pitch in radians; or lists of lists, whose rows are `sets`, alternatives of `num` LiDARs each, roll and pitch in degrees
(Place3D). Cameras (T_CAM_*, R_CAM_*, FOV_CAM_*): roll, pitch, yaw in degrees. Origin: the vehicle's actor, on the
ground under the middle of its bounding box.
Source: the published code's LiDARSetup; carla_common/transforms.py of the ROS bridge for the signs.
"""

from __future__ import annotations

import json
import math
from typing import Any

from riglens.core.formats.base import Format
from riglens.core.formats.carla_lidar import TURNS_PER_SECOND, azimuth_count, rays_to_write
from riglens.core.formats.carla_objects import fov_deg
from riglens.core.formats.frames import Matrix, pose_from_se3, se3_from_rpy_deg
from riglens.core.formats.mounts import ACTOR, Mounting, sensors_to_write
from riglens.core.formats.ray_export import FULL_TURN_DEG, turn_ends_deg
from riglens.core.formats.report import Notes
from riglens.core.formats.source import MAX_ANGLE, Source, Value
from riglens.core.geometry import Vec3
from riglens.core.rig.model import Camera, Lidar, LinearAngles, Rig, Sensor
from riglens.core.rig.yaml.nodes import shortened, value_text

IMAGE = (1600, 900)
RANGE_M = 100.0
_LISTS = ("x", "y", "z", "roll", "pitch")
_COMMON = ("channels", "lower_fov", "upper_fov")
_OPTIONAL = ("lidar_range_in_meters", "rotation_frequency", "points_per_channel")
_POINTS_PER_CHANNEL = 20_000.0
_PUBLISHED_TURNS = 20.0
_MAX_LIDARS = 255


def recognises(source: Source) -> bool:
    """Return whether this is a TOML file with a table [lidar]."""
    return "lidar" in source.toml


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the LiDARs, and the cameras where the file has any."""
    notes = mounting.notes
    lidars, chosen = _lidars(source.toml.item("lidar"), mounting.options.token, notes)
    for index, fields in enumerate(lidars):
        _add_lidar(f"lidar_{index}", fields, mounting)
    camera = source.toml.get("camera")
    if camera is not None:
        _add_cameras(camera, mounting)
    notes.converted("left-handed axes to right-handed: y, pitch and yaw change sign")
    return mounting.rig(f"{source.name}{chosen}")


def _lidars(table: Value, token: str | None, notes: Notes) -> tuple[list[dict[str, Value]], str]:
    """Return the fields of the LiDARs of one rig, and words for its name: all of flat lists, or those of one set."""
    count = len(table.item("x").elements())
    if count > _MAX_LIDARS:
        table.item("x").refuse(f"at most {_MAX_LIDARS} LiDARs")
    is_in_sets = count > 0 and table.item("x").elements()[0].is_list
    index = _chosen_set(table, count, token, notes) if is_in_sets else 0
    members = _members(table, count, index if is_in_sets else None)
    notes.read(
        f"roll and pitch of LiDARs as {'degrees' if is_in_sets else 'radians'}, as the published files have it"
    )
    for fields in members:
        for key in ("roll", "pitch"):
            unit = 1.0 if is_in_sets else math.degrees(1.0)
            limit = MAX_ANGLE if is_in_sets else 10.0
            fields[key] = Value(fields[key].number(-limit, limit) * unit, *fields[key].place)
    return members, f" set {index + 1}" if is_in_sets and count > 1 else ""


def _columns(table: Value, count: int) -> dict[str, Value]:
    """Return the named columns: lists of one entry for each LiDAR or set, or one value for all."""
    for key in _LISTS:
        table.item(key).elements(count)
    names = [key for key in _OPTIONAL if key in table]
    return {key: table.item(key) for key in (*_LISTS, *_COMMON, *names)}


def _members(table: Value, count: int, index: int | None) -> list[dict[str, Value]]:
    """Return the LiDARs of flat lists, or of the set of that index: the first `num` of its entries, or all of them."""
    columns, num = _columns(table, count), table.get("num")
    if index is not None:
        columns = {key: v.elements(count)[index] if v.is_list else v for key, v in columns.items()}
    size = len(columns["x"].elements())
    entries = {key: v.elements(size) if v.is_list else [v] * size for key, v in columns.items()}
    if index is not None and num is not None and num.is_list:
        size = num.elements(count)[index].whole(0, size)
    return [{key: values[member] for key, values in entries.items()} for member in range(size)]


def _chosen_set(table: Value, count: int, token: str | None, notes: Notes) -> int:
    """Return the index of the set that is read: sets are alternatives, counted from 1."""
    names = [str(number) for number in range(1, count + 1)]
    if token is not None and token not in names:
        table.item("x").refuse(f"a token from 1 to {count}", f"set '{shortened(token)}'")
    index = 0 if token is None else names.index(token)
    notes.read(f"set {index + 1} of {count}: sets are alternatives", field="token" if count > 1 else "")
    return index


def _add_lidar(name: str, fields: dict[str, Value], mounting: Mounting) -> None:
    x, y, z = (fields[key].number() for key in ("x", "y", "z"))
    roll, pitch = (fields[key].number() for key in ("roll", "pitch"))
    channels = fields["channels"].whole(1, 1000)
    lower, upper = (fields[key].number(-90.0, 90.0) for key in ("lower_fov", "upper_fov"))
    if lower > upper:
        fields["lower_fov"].refuse("an angle not above upper_fov")
    if channels == 1 and lower < upper:
        mounting.notes.read("one beam, which CARLA casts at upper_fov", name)
        lower = upper
    turns = _number(fields, "rotation_frequency", _PUBLISHED_TURNS)
    points = _number(fields, "points_per_channel", _POINTS_PER_CHANNEL)
    if "points_per_channel" not in fields:
        mounting.notes.approximated(
            f"points not in the file: {_POINTS_PER_CHANNEL:g} a second and beam", name
        )
    mounting.add(
        "lidar",
        name,
        right_handed((x, y, z), (roll, pitch, 0.0)),
        elevations_deg=LinearAngles(from_=lower, to=upper, count=channels),
        azimuths_deg=LinearAngles(from_=-180.0, to=180.0, count=azimuth_count(points, turns, 1)),
        range_m=(0.0, _number(fields, "lidar_range_in_meters", RANGE_M)),
    )


def _number(fields: dict[str, Value], key: str, default: float) -> float:
    return fields[key].number(1e-3, 1e6) if key in fields else default


def right_handed(position: Vec3, rpy_deg: Vec3) -> Matrix:
    """Return a pose of CARLA in right-handed axes: mirrored in the plane of x and z."""
    (x, y, z), (roll, pitch, yaw) = position, rpy_deg
    return se3_from_rpy_deg((x, -y, z), (roll, -pitch, -yaw))


def _add_cameras(table: Value, mounting: Mounting) -> None:
    for key, value in table.items():
        if not key.startswith("T_"):
            continue
        name = key.removeprefix("T_")
        roll, pitch, yaw = table.item(f"R_{name}").vector(limit=1e6)
        pose = right_handed(value.vector(), (roll, pitch, yaw))
        fov = table.item(f"FOV_{name}").number(1e-3, 179.9)
        mounting.notes.approximated("image size not in the file: 1600 x 900 pixels", name)
        mounting.add("camera", name, pose, image=IMAGE, hfov_deg=fov)


def write(rig: Rig, notes: Notes) -> dict[str, str]:
    """Return [lidar] as one set with an entry per LiDAR, and [camera] with lines for poses and fields of view."""
    sensors = sensors_to_write(rig, notes, ("lidar", "camera"))
    lidars = [_lidar_fields(sensor, notes) for sensor in sensors if isinstance(sensor, Lidar)]
    height_m = lidars[0]["z"] if lidars else rig.vehicle.height
    notes.approximated(
        f"GLOBAL_HEIGHT_POS is not in the rig: {height_m:g} m, the height of the first LiDAR or the roof"
    )
    lines = ["[lidar]", "sets = 1", f"num = [{len(lidars)}]", f"GLOBAL_HEIGHT_POS = {_text(float(height_m))}"]
    for key in (*_LISTS, *_COMMON, *_OPTIONAL):
        lines.append(f"{key} = [[{', '.join(_text(one[key]) for one in lidars)}]]")
    cameras = [line for sensor in sensors if isinstance(sensor, Camera) for line in _camera(sensor, notes)]
    notes.converted("right-handed axes to CARLA's left-handed: y, pitch and yaw change sign")
    notes.ignored("vehicle: the format cannot express it")
    text = "\n".join([*lines, *(["", "[camera]", *cameras] if cameras else []), ""])
    return {"rig.toml": text}


def _left_handed(sensor: Sensor) -> tuple[Vec3, Vec3]:
    """Return the position in metres and roll, pitch, yaw in degrees in CARLA's axes."""
    pose = pose_from_se3(sensor.pose.vehicle_SE3_sensor())
    (x, y, z), (roll, pitch, yaw) = pose.position_m, pose.rpy_deg
    return (x, -y + 0.0, z), (roll, -pitch + 0.0, -yaw + 0.0)


def _lidar_fields(lidar: Lidar, notes: Notes) -> dict[str, Any]:
    (x, y, z), (roll, pitch, yaw) = _left_handed(lidar)
    rays = rays_to_write(lidar, notes)
    notes.ignored("the name: the file numbers LiDARs", lidar.name)
    if yaw != 0.0:
        notes.ignored(f"yaw: the file has none for LiDARs; heading {abs(yaw):.2f} deg off", lidar.name)
    low_deg, high_deg = turn_ends_deg(lidar)
    if high_deg - low_deg < FULL_TURN_DEG:
        notes.ignored(
            f"azimuths {low_deg:g} to {high_deg:g} deg: the file has full turns only, "
            f"{FULL_TURN_DEG - high_deg + low_deg:g} deg more",
            lidar.name,
        )
    pose = {"x": x, "y": y, "z": z, "roll": roll, "pitch": pitch}
    points = rays["points_per_second"] / rays["channels"]
    extra = {
        "lidar_range_in_meters": rays["range"],
        "rotation_frequency": TURNS_PER_SECOND,
        "points_per_channel": points,
    }
    return pose | {key: rays[key] for key in _COMMON} | extra


def _camera(camera: Camera, notes: Notes) -> list[str]:
    """Return the three keys of a camera; the published code expects the names CAM_FRONT, CAM_FRONT_LEFT and so on."""
    position, rpy_deg = _left_handed(camera)
    fov = fov_deg(camera, notes)
    notes.written("pose and field of view", camera.name)
    notes.ignored("image size, ray lattice and range: the format cannot express them", camera.name)
    values = (("T", value_text(position)), ("R", value_text(rpy_deg)), ("FOV", value_text(fov)))
    return [f"{_key(f'{prefix}_{camera.name}')} = {text}" for prefix, text in values]


def _key(name: str) -> str:
    """Return a quoted key: JSON's escapes are those of TOML, except for DEL."""
    return json.dumps(name, ensure_ascii=False).replace("\x7f", "\\u007f")


def _text(number: float) -> str:
    return value_text(float(number)) if isinstance(number, float) else str(number)


CARLA_TOML = Format(
    "carla-toml", "CARLA TOML of the published placement code", (".toml",), recognises, read, write, (".toml",),
    origin=ACTOR, harmless="sets|num|GLOBAL_HEIGHT_POS",
)  # fmt: skip
