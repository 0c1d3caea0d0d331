"""nuScenes: the tables calibrated_sensor.json and sensor.json, plain or .gz.

Axes of the vehicle x forward, y left, z up; origin on the ground under the rear axle; metres; quaternions
w, x, y, z. Cameras stand in optical axes (x right, y down, z forward). LIDAR_TOP has x to the right and y
forward; its own axes are kept, which only turns where its full circle begins.
Source: nuScenes schema (calibrated_sensor: "all extrinsic parameters are given with respect to the ego body frame").
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from riglens.core.errors import InputError
from riglens.core.formats.base import Format
from riglens.core.formats.frames import (
    Matrix,
    from_optical,
    rotation_from_wxyz,
    se3,
    to_optical,
    wxyz_from_rotation,
)
from riglens.core.formats.lens_export import report_lens
from riglens.core.formats.lenses import brown_conrady, pinhole
from riglens.core.formats.lidar_points import Rings, rings_of, sweep_file
from riglens.core.formats.mounts import (
    REAR_AXLE,
    Mounting,
    find_model,
    rear_axle_on_ground,
    root_SE3_body,
    sensors_to_write,
)
from riglens.core.formats.report import Notes
from riglens.core.formats.source import MAX_PIXELS, Source, Value
from riglens.core.geometry import Vec3
from riglens.core.rig.model import Camera, Rig, Sensor, Vehicle
from riglens.core.rig.yaml.nodes import shortened
from riglens.core.scene.readers.json_records import json_records
from riglens.core.scene.readers.nuscenes_tables import table_file, version_folder

ZOE = Vehicle(body="sedan", length=4.084, width=1.73, height=1.562, rear_axle_x=-1.35)
IMAGE = (1600, 900)
MAX_ROWS = 200_000
MAX_SCANNED = 300_000
"""Records of sample_data that are searched for the size of the images."""
_TABLES = ("calibrated_sensor", "sensor")
_CAMERAS = ("FRONT", "FRONT_LEFT", "FRONT_RIGHT", "BACK", "BACK_LEFT", "BACK_RIGHT")
OWN_CHANNELS = frozenset(f"CAM_{place}" for place in _CAMERAS) | {"LIDAR_TOP"}
"""Cameras and LiDAR of the car of nuScenes itself."""
OWN_MODELS = {"lidar": "nuscenes-lidar-top", "radar": "Continental ARS 408-21"}
"""An HDL-32E at 20 turns a second, and radars, of the car of nuScenes (Caesar et al., CVPR 2020)."""


def recognises(source: Source) -> bool:
    """Return whether this is one of the tables, or a folder with one of them, or with both in one folder inside."""
    if source.is_folder:
        return any(table_file(source.path, name) for name in _TABLES) or _home(source) is not None
    first = source.json.raw[0] if source.json.is_list and source.json.raw else None
    return isinstance(first, dict) and ("sensor_token" in first or "modality" in first)


def read(source: Source, mounting: Mounting) -> Rig:
    """Return one rig of the tables: that of `options.token` (any row of the rig), or the first."""
    source = (_home(source) or source) if source.is_folder else source
    channels = _channels(_table(source, "sensor").json)
    rigs = _rigs(_table(source, "calibrated_sensor").json, channels)
    if len({_channels_of(rows, channels) for rows in rigs}) > 1:
        rigs = _rigs_by_sample(rigs, source, mounting.notes)
    rows, which = _chosen(rigs, mounting.options.token, source.where)
    mounting.notes.read(which, field="token")
    recorded = _recorded(source, [row.item("token").text() for row in rows])
    named = (_named(row, channels) for row in rows)
    names = {channel for channel, modality in named if modality in ("camera", "lidar")}
    is_own = names <= OWN_CHANNELS and all(_size(fields) in (None, IMAGE) for fields in recorded.values())
    roots = (source.folder.parent, source.folder)
    for row in rows:
        (channel, modality), fields = _named(row, channels), recorded.get(row.item("token").text(), {})
        if modality not in _LEFT_OUT:
            mounting.notes.ignored(f"RigLens has no {shortened(modality, 30)}s", channel)
            continue
        rotation = row.item("rotation")
        turn = rotation_from_wxyz(rotation, rotation.numbers(4, limit=2.0))
        pose = se3(turn, row.item("translation").vector())
        if modality == "camera":
            _add_camera(row, channel, pose, _size(fields), mounting)
        elif modality == "lidar" and not is_own:
            _add_unknown_lidar(channel, pose, sweep_file(roots, fields.get("filename")), mounting)
        else:
            mounting.add(modality, channel, pose, said=OWN_MODELS[modality] if is_own else None)
    mounting.notes.converted(
        "cameras from optical axes and quaternions w x y z to roll, pitch, yaw of the body"
    )
    return mounting.rig(f"nuScenes {rows[0].item('token').text()[:8]}")


def _home(source: Source) -> Source | None:
    """Return the folder that holds both tables: the source itself, or one inside it."""
    found = version_folder(source.path, _TABLES)
    return None if found is None else source.another(found)


def _named(row: Value, channels: dict[str, tuple[str, str]]) -> tuple[str, str]:
    """Return channel and modality of a calibrated sensor."""
    return channels[row.item("sensor_token").text()]


def _recorded(source: Source, tokens: list[str]) -> dict[str, dict[str, object]]:
    """Return the first record of each calibrated sensor by its token, from sample_data if present."""
    path = table_file(source.folder, "sample_data")
    wanted = set(tokens)
    found: dict[str, dict[str, object]] = {}
    for record in () if path is None else json_records(path, lambda _share: source.time.check()):
        token = record.fields.get("calibrated_sensor_token")
        if isinstance(token, str) and token in wanted:
            wanted.remove(token)
            found[token] = {key: record.fields.get(key) for key in ("width", "height", "filename")}
        if not wanted or record.number >= MAX_SCANNED:
            break
    return found


def _size(fields: dict[str, object]) -> tuple[int, int] | None:
    """Return width and height of a record, None if it has none: those of LiDARs and radars are 0."""
    width, height = fields.get("width"), fields.get("height")
    if not (isinstance(width, int) and isinstance(height, int)):
        return None
    return (width, height) if 0 < width <= MAX_PIXELS and 0 < height <= MAX_PIXELS else None


def _table(source: Source, name: str) -> Source:
    """Return the table of that name in the folder, or next to the file, that the user named."""
    if not source.is_folder and source.path.name.split(".")[0] == name:
        return source
    found = source.sibling(f"{name}.json", f"{name}.json.gz")
    if found is None:
        place = "in it" if source.is_folder else "next to it"
        raise InputError(
            f"{source.where}: {name}.json is missing {place}: {' and '.join(_TABLES)} are both needed"
        )
    return found


def _channels(table: Value) -> dict[str, tuple[str, str]]:
    """Return channel and modality of every sensor token."""
    rows = table.elements()
    if len(rows) > MAX_ROWS:
        table.refuse(f"at most {MAX_ROWS} rows")
    fields = ((row.item("token").text(), row.item("channel"), row.item("modality")) for row in rows)
    return {token: (channel.text(), modality.text()) for token, channel, modality in fields}


def _rigs(table: Value, channels: dict[str, tuple[str, str]]) -> list[list[Value]]:
    """Return the rows divided into rigs: the table holds the sensors of one log after those of another."""
    rows = table.elements()
    if not 0 < len(rows) <= MAX_ROWS:
        table.refuse(f"1 to {MAX_ROWS} rows")
    rigs: list[list[Value]] = [[]]
    seen: set[str] = set()
    for row in rows:
        token = row.item("sensor_token")
        if token.text() not in channels:
            token.refuse("a token of sensor.json")
        channel = channels[token.text()][0]
        if channel in seen:
            rigs.append([])
            seen.clear()
        rigs[-1].append(row)
        seen.add(channel)
    return rigs


def _channels_of(rows: list[Value], channels: dict[str, tuple[str, str]]) -> frozenset[str]:
    return frozenset(_named(row, channels)[0] for row in rows)


def _rigs_by_sample(rigs: list[list[Value]], source: Source, notes: Notes) -> list[list[Value]]:
    """Return the rows divided by the samples that hold their data, where the order of the rows does not say the rig.

    That is so in tables sorted by sensor. Without samples the division by order stays, and is reported.
    """
    rows = {row.item("token").text(): row for rig in rigs for row in rig}
    samples: dict[str, set[str]] = {}
    path = table_file(source.folder, "sample_data")
    for record in () if path is None else json_records(path, lambda _share: source.time.check()):
        token, sample = (record.fields.get(key) for key in ("calibrated_sensor_token", "sample_token"))
        if isinstance(token, str) and token in rows and isinstance(sample, str) and sample:
            samples.setdefault(sample, set()).add(token)
        if record.number >= MAX_SCANNED:
            break
    found = dict.fromkeys(frozenset(tokens) for tokens in samples.values())
    whole = [tokens for tokens in found if not any(tokens < other for other in found)]
    if not whole:
        notes.approximated(
            "which sensors are on one car is not in the tables: taken by the order of the rows"
        )
        return rigs
    notes.read("which sensors are on one car, by the samples of their data")
    order = list(rows)
    return [[rows[token] for token in sorted(tokens, key=order.index)] for tokens in whole]


def _chosen(rigs: list[list[Value]], token: str | None, where: str) -> tuple[list[Value], str]:
    """Return the rows of one rig, and words that say which one it is."""
    if token is None:
        first = rigs[0][0].item("token").text()
        return rigs[0], f"rig 1 of {len(rigs)}, its first row is {shortened(first, 40)}"
    for number, rows in enumerate(rigs, 1):
        if any(row.item("token").text() == token for row in rows):
            return rows, f"rig {number} of {len(rigs)}, the one with row {shortened(token, 40)}"
    raise InputError(f"{where}: token: must be a token of calibrated_sensor (got '{shortened(token)}')")


def _add_camera(
    row: Value, channel: str, pose: Matrix, size: tuple[int, int] | None, mounting: Mounting
) -> None:
    k = row.item("camera_intrinsic").matrix(3, 3)
    if k[0, 1] != 0.0:
        mounting.notes.ignored("skew of the image axes", channel)
    lens: dict[str, Any] = pinhole(k)
    lens["image"] = size or mounting.unknown_image(channel, IMAGE, lens)
    bend = row.get("camera_distortion")
    if bend is not None:  # of nuImages and of tables by T4: k1 k2 p1 p2 k3, and perhaps k4
        lens |= brown_conrady(bend, bend.numbers(), channel, mounting.notes)
    mounting.add("camera", channel, from_optical(pose), **lens)


def _add_unknown_lidar(channel: str, pose: Matrix, sweep: Path | None, mounting: Mounting) -> None:
    """Add a LiDAR of another car: a model that its channel names, else beams from its points, else assumed ones."""
    rings = None if sweep is None or find_model(channel) else rings_of(sweep)
    if isinstance(rings, Rings):
        beams = f"{len(rings.elevations_deg)} beams and their elevations"
        mounting.notes.read(
            f"{beams} are those of its points (one sweep, {rings.unmeasured} rings without)", channel
        )
        mounting.notes.approximated(
            "azimuths and range not in the tables: those of a LiDAR of RigLens", channel
        )
        mounting.add("lidar", channel, pose, elevations_deg=rings.elevations_deg)
        return
    if isinstance(rings, str):
        mounting.notes.approximated(f"the sweep of its points {rings}", channel)
    mounting.add("lidar", channel, pose)


def write(rig: Rig, notes: Notes) -> dict[str, str]:
    """Return the tables, in a folder; tokens follow from the rig's name and the sensors' names."""
    origin_m = rear_axle_on_ground(rig.vehicle)
    sensors = sensors_to_write(rig, notes, _LEFT_OUT)
    tables = {
        "sensor.json": [_sensor_row(rig, sensor) for sensor in sensors],
        "calibrated_sensor.json": [_calibrated_row(rig, sensor, origin_m) for sensor in sensors],
        "sample_data.json": [_image_row(rig, sensor) for sensor in sensors if isinstance(sensor, Camera)],
    }
    for sensor in sensors:
        if isinstance(sensor, Camera):
            report_lens(sensor, sensor.replace(distortion=None), "a pinhole", notes)
        written, left_out = _LEFT_OUT[sensor.kind]
        notes.written(written, sensor.name)
        notes.ignored(f"{left_out} and range: the format cannot express them", sensor.name)
    notes.converted("origin from the body centre to the rear axle on the ground; cameras to optical axes")
    notes.ignored("vehicle: the format cannot express it")
    return {name: json.dumps(rows, indent=1) + "\n" for name, rows in tables.items()}


_LEFT_OUT = {
    "camera": ("pose, lens and image size", "ray lattice"),
    "lidar": ("pose", "beam angles, model"),
    "radar": ("pose", "scans, model"),
}
"""Fields that are written of each kind, and fields that are not."""


def _sensor_row(rig: Rig, sensor: Sensor) -> dict[str, object]:
    token = _token(rig, "sensor", sensor.name)
    return {"token": token, "channel": sensor.name, "modality": sensor.kind}


def _calibrated_row(rig: Rig, sensor: Sensor, origin_m: Vec3) -> dict[str, object]:
    pose = root_SE3_body(sensor, origin_m)
    intrinsic: list[list[float]] = []
    if isinstance(sensor, Camera):
        pose = to_optical(pose)
        fx, fy, cx, cy = sensor.intrinsics_px()
        intrinsic = [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]
    return {
        "token": _token(rig, "calibrated_sensor", sensor.name),
        "sensor_token": _token(rig, "sensor", sensor.name),
        "translation": [float(part) for part in pose[:3, 3]],
        "rotation": wxyz_from_rotation(pose[:3, :3]),
        "camera_intrinsic": intrinsic,
    }


def _image_row(rig: Rig, camera: Camera) -> dict[str, object]:
    """Return a record of sample_data without an image: it is where nuScenes holds the size of images."""
    width_px, height_px = camera.image
    unknown = {
        "sample_token": "",
        "ego_pose_token": "",
        "filename": "",
        "prev": "",
        "next": "",
        "timestamp": 0,
    }
    return {
        "token": _token(rig, "sample_data", camera.name),
        "calibrated_sensor_token": _token(rig, "calibrated_sensor", camera.name),
        "width": width_px,
        "height": height_px,
        "fileformat": "jpg",
        "is_key_frame": True,
        **unknown,
    }


def _token(rig: Rig, table: str, sensor: str) -> str:
    """Return 32 hexadecimal digits, the same for the same rig and sensor."""
    return hashlib.sha256("\0".join((rig.name, table, sensor)).encode()).hexdigest()[:32]


NUSCENES = Format(
    "nuscenes", "nuScenes tables", (".json",), recognises, read, write, is_folder=True, has_folders=True,
    vehicle=ZOE, car="a Renault Zoe, the car of nuScenes", origin=REAR_AXLE,
)  # fmt: skip
