"""Autoware: sensors_calibration.yaml and sensor_kit_calibration.yaml (all *_calibration.yaml of a folder).

Each file says {parent frame: {child frame: {x, y, z, roll, pitch, yaw}}} in metres and radians about the fixed
axes of the parent, x forward, y left, z up. base_link lies on the ground under the rear axle. Camera frames
(.../camera_link) look along x; names with "optical" have z forward. The sensor at a frame follows from the
macro that the kit's xacro calls there, else from the frame's name; frames with neither are left out.
Source: Autoware documentation, "Creating sensor and vehicle models"; individual_params.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from typing import Any

from riglens.core.formats.autoware_kit import (
    find_macros,
    find_vehicle,
    kind_of_macro,
    kit_name,
    vehicle_files,
)
from riglens.core.formats.base import Format
from riglens.core.formats.frames import (
    FrameTree,
    Matrix,
    from_optical,
    is_optical,
    kind_of,
    pose_from_se3,
    se3_from_rpy_rad,
    without_ending,
)
from riglens.core.formats.mounts import (
    ON_ROOF,
    REAR_AXLE,
    Mounting,
    rear_axle_on_ground,
    root_SE3_body,
    sensors_to_write,
)
from riglens.core.formats.opencv_yaml import camera_info_text, read_lens
from riglens.core.formats.report import Notes
from riglens.core.formats.source import MAX_ANGLE, YAML, Source, Value
from riglens.core.formats.unread import note_comments
from riglens.core.geometry import Vec3
from riglens.core.rig.model import Camera, Rig
from riglens.core.rig.yaml.nodes import shortened, value_text

BASE, KIT = "base_link", "sensor_kit_base_link"
POSITION, ANGLES = ("x", "y", "z"), ("roll", "pitch", "yaw")
FOOT = "_base_link"
_PLAIN_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,100}")
_MOUNT = re.compile(r"(^|_)(kit|unit)_base_link$|^base_link$")
_CAMERA_INFOS = ("{}/camera_info.yaml", "{}_camera_info.yaml", "{}_info.yaml")
"""Places of intrinsics: the first as in tier4's individual_params, a folder for each camera."""
_PLACES = ("sensors_calibration.yaml", "sensor_kit_calibration.yaml")


def recognises(source: Source) -> bool:
    """Return whether this is a folder with such files (or with a config/ that has them), or one such file."""
    if source.is_folder:
        return any(source.sibling(name, f"config/{name}") for name in _PLACES)
    parents = list(source.yaml.raw.values()) if source.yaml.is_mapping else []
    if source.path.name in _PLACES and source.yaml.is_mapping:
        return all(parent is None or parent == {} or _is_parent(parent) for parent in parents)
    return bool(parents) and all(_is_parent(parent) for parent in parents)


def _is_parent(parent: object) -> bool:
    children = list(parent.values()) if isinstance(parent, dict) else []
    return bool(children) and all(
        isinstance(child, dict) and set(POSITION) & set(child) for child in children
    )


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the sensors of all calibration files of the folder, chained to base_link."""
    files, tree, notes = _files(source), FrameTree(source.where), mounting.notes
    for file in files:
        note_comments(file.text, notes)
        for parent, child, pose in _rows(file, notes):
            tree.add(parent, child, pose)
    notes.read(f"{len(tree.frames())} frames of {', '.join(file.path.name for file in files)}")
    mounting.found(find_vehicle(source, notes))
    if tree.frames() and (root := tree.root()) != BASE and mounting.options.origin_m is None:
        mounting.origin = ON_ROOF._replace(what=f"{root}, the root of the frames,")
    macros, inner = find_macros(source, notes, mounting.options.kit), tree.inner_frames()
    leaves = [frame for frame in tree.frames() if frame not in inner]
    for frame in leaves:
        _add(frame, tree.root_SE3(frame), macros.get(frame), source, mounting)
    notes.converted("angles from radians to degrees")
    is_empty = all(_MOUNT.search(frame) for frame in leaves)
    return mounting.rig(kit_name(source), may_be_empty=is_empty)


def _files(source: Source) -> list[Source]:
    found = source.siblings("*_calibration.yaml") or source.siblings("config/*_calibration.yaml")
    is_among = any(file.path.name == source.path.name for file in found)
    return found if source.is_folder or is_among else [source]


def _rows(file: Source, notes: Notes) -> Iterator[tuple[str, str, Matrix]]:
    """Yield parent, child and pose of every frame of a file; an empty file, or a parent without frames, is reported."""
    is_blank = not any(line.partition("#")[0].strip() for line in file.text.splitlines())
    if is_blank or file.yaml.raw == {}:
        notes.read("the file holds no frames", file.path.name)
        return
    for parent, raw in file.yaml.raw.items() if file.yaml.is_mapping else ():
        if raw is None or raw == {}:
            notes.read("no frames on it", str(parent))
            continue
        for child, value in file.yaml.item(parent).items():
            yield str(parent), child, _transform(value)
    if not file.yaml.is_mapping:
        file.yaml.refuse("a mapping of names to values")


def _transform(value: Value) -> Matrix:
    angles = (value.item(name).number(-MAX_ANGLE, MAX_ANGLE) for name in ANGLES)
    return se3_from_rpy_rad(value.field_numbers(*POSITION), angles)


def _add(frame: str, root_SE3_frame: Matrix, macro: str | None, source: Source, mounting: Mounting) -> None:
    """Add the sensor of a frame: the one of the kit's xacro, or else the one that its name suggests."""
    kind = kind_of(frame) if macro is None else kind_of_macro(macro)
    if kind == "camera":
        body = from_optical(root_SE3_frame) if is_optical(frame) else root_SE3_frame
        name = without_ending(frame)
        mounting.add("camera", name, body, **_lens(name, source, mounting))
    elif kind is not None:
        if kind == "lidar" and frame.endswith(FOOT):
            mounting.notes.approximated(
                "the base of the LiDAR is taken as its centre, which is a few cm higher", frame
            )
        mounting.add(kind, without_ending(frame), root_SE3_frame, said=macro)
    elif macro is not None:
        mounting.notes.ignored(f"neither camera nor LiDAR: {shortened(macro, 40)} in the kit's xacro", frame)
    else:
        mounting.notes.ignored("neither camera nor LiDAR, judging by its name", frame)


def _lens(name: str, source: Source, mounting: Mounting) -> dict[str, Any]:
    """Return image and lens of a camera_info file next to the calibration, or assumed ones."""
    is_plain = _PLAIN_NAME.fullmatch(name) is not None
    found = source.sibling(*(place.format(name) for place in _CAMERA_INFOS)) if is_plain else None
    if found is None:
        return mounting.unknown_lens(name)
    mounting.notes.read("image and lens from its camera_info file", name)
    return read_lens(found.yaml, name, mounting.notes)


def write(rig: Rig, notes: Notes) -> dict[str, str]:
    """Return a folder: the kit on the middle of the roof, every sensor on the kit, a camera_info file per camera."""
    sensors = sensors_to_write(rig, notes, _FRAMES)
    rear_m, roof_m = rear_axle_on_ground(rig.vehicle), (0.0, 0.0, rig.vehicle.height)
    kit = {KIT: _pose_text(roof_m[0] - rear_m[0], roof_m[1], roof_m[2], (0.0, 0.0, 0.0))}
    children: dict[str, str] = {}
    infos: dict[str, str] = {}
    for sensor in sensors:
        pose = pose_from_se3(root_SE3_body(sensor, roof_m))
        children[_FRAMES[sensor.kind](sensor.name)] = _pose_text(*pose.position_m, pose.rpy_deg)
        notes.written("pose", sensor.name)
        if isinstance(sensor, Camera) and _PLAIN_NAME.fullmatch(sensor.name):
            infos[f"{sensor.name}_camera_info.yaml"] = camera_info_text(sensor)
            notes.written("image and lens, in a camera_info file", sensor.name)
            notes.ignored("ray lattice and range: the format cannot express them", sensor.name)
            continue
        notes.ignored("model, rays, lens and range: the format cannot express them", sensor.name)
    notes.converted(f"origin to the rear axle on the ground, {KIT} on the roof; angles to radians")
    texts = {_PLACES[0]: _file_text(BASE, kit), _PLACES[1]: _file_text(KIT, children)}
    return texts | infos | vehicle_files(rig.vehicle, notes)


def _lidar_frame(name: str) -> str:
    foot = f"{name}{FOOT}"
    return foot if kind_of(foot) == "lidar" else f"{name}/lidar_link"


# The frame of a sensor by the naming of Autoware's kits; an ambiguous name gets the word lidar
_FRAMES: dict[str, Callable[[str], str]] = {
    "camera": lambda name: f"{name}/camera_link",
    "lidar": _lidar_frame,
    "radar": lambda name: f"{name}/radar_link",
    "ultrasonic": lambda name: f"{name}/ultrasonic_link",
}


def _pose_text(x: float, y: float, z: float, rpy_deg: Vec3) -> str:
    numbers = (x, y, z, *(math.radians(angle) for angle in rpy_deg))
    lines = (
        f"    {name}: {value_text(number)}"
        for name, number in zip((*POSITION, *ANGLES), numbers, strict=True)
    )
    return "\n".join(lines)


def _file_text(parent: str, children: dict[str, str]) -> str:
    lines = [f"{parent}:"]
    for child, pose in children.items():
        lines += [f"  {value_text(child)}:", pose]
    return "\n".join([*lines, ""])


AUTOWARE = Format(
    "autoware", "Autoware sensor kit calibration", YAML, recognises, read, write, is_folder=True, has_folders=True,
    origin=REAR_AXLE, harmless="wheel_radius|wheel_width|max_steer_angle",
)  # fmt: skip
