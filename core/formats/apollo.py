"""Baidu Apollo: a folder of calibration data with *_extrinsics.yaml and *_intrinsics.yaml; transforms of ROS (import).

Each extrinsic file holds one transform from child_frame_id to header.frame_id, or several as /tf_static has them:
metres, a quaternion x, y, z, w. Of the root base_link the axes are those of ROS (REP-105). Frames
are chained to one root, usually `novatel` or `localization`: x to the RIGHT, y FORWARD, z up, at the rear axle. Cameras
have optical axes; intrinsics are messages sensor_msgs/CameraInfo. LiDARs have x forward, y left, z up. What a frame
holds follows from the folder of its file (camera_params, velodyne_params, lidar_params, radar_params), else its name.
Source: Apollo, docs "Apollo coordinate systems"; modules/calibration/data.
"""

from __future__ import annotations

import re

import numpy as np

from riglens.core.formats.base import Format
from riglens.core.formats.frames import (
    BASES,
    FrameTree,
    Matrix,
    from_optical,
    kind_of,
    rotation_from_wxyz,
    se3,
)
from riglens.core.formats.mounts import ON_ROOF, Mounting, Origin, rear_axle_on_ground
from riglens.core.formats.opencv_yaml import UNUSED, read_lens
from riglens.core.formats.source import YAML, Source, Value
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.nodes import shortened

VEHICLE_R_ROOT: Matrix = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""From x right, y forward, z up to x forward, y left, z up."""
_KINDS = {"camera": "camera", "velodyne": "lidar", "lidar": "lidar", "radar": "radar"}
_ROOTS = "novatel, localization or imu"
_APOLLO = re.compile("novatel|localization|imu")
_VELODYNE = re.compile(r"velodyne_?(16|32|64|128)")
_MODELS = {"16": "VLP-16", "32": "HDL-32E", "64": "HDL-64E", "128": "VLS-128"}


def recognises(source: Source) -> bool:
    """Return whether this is an extrinsic file, or a folder with such files in it or in its folders *_params."""
    if source.is_folder:
        return any(_is_transform(file) for file in _files(source, "extrinsics")[:8])
    return _is_transform(source)


def _is_transform(file: Source) -> bool:
    return bool(_transforms(file))


def _transforms(file: Source) -> list[Value]:
    """Return the transforms of a file: one message TransformStamped, or those of a message TFMessage, as /tf_static."""
    if not file.text.strip():  # as left by a calibration that was never made
        return []
    root = file.yaml
    listed = root.get("transforms") if root.is_mapping else None
    found = [root] if listed is None or not listed.is_list else listed.elements()
    return found if all(_is_stamped(one) for one in found) else []


def _is_stamped(message: Value) -> bool:
    header = message.raw.get("header") if message.is_mapping else None
    return (
        "transform" in message
        and "child_frame_id" in message
        and isinstance(header, dict)
        and "frame_id" in header
    )


def _files(source: Source, what: str) -> list[Source]:
    """Return the files of that kind in the folder and in its folders; of a file in *_params, those of all."""
    folder = (
        source.folder.resolve().parent if source.folder.resolve().name.endswith("_params") else source.folder
    )
    top = source.another(folder)
    return [*top.siblings(f"*_{what}*.yaml"), *top.siblings(f"*_params/*_{what}*.yaml")]


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the cameras and LiDARs of all files, chained to their root."""
    tree = FrameTree(source.where)
    kinds: dict[str, str | None] = {}
    given: dict[str, str] = {}
    for file in _files(source, "extrinsics") or [source]:
        found = _transforms(file)
        if not found:
            mounting.notes.ignored("it does not name its frames", file.path.name)
        for message in found:
            _attach(message, file, tree, kinds, given, mounting)
    lenses = {_frame(file): file.yaml for file in _files(source, "intrinsics") if file.yaml.is_mapping}
    turn = _root_axes(tree, mounting)
    for frame in tree.frames():
        _add(frame, turn @ tree.root_SE3(frame), kinds[frame], lenses, tree, mounting)
    mounting.notes.converted("cameras from optical axes; quaternions to roll, pitch, yaw")
    return mounting.rig(f"Apollo {source.name}")


def _attach(
    message: Value,
    file: Source,
    tree: FrameTree,
    kinds: dict[str, str | None],
    given: dict[str, str],
    mounting: Mounting,
) -> None:
    """Attach the frame of a transform, unless an earlier one is of the same frame."""
    name = message.item("child_frame_id").text()
    if name in given:
        said = f"a second transform of {shortened(name, 40)}: that of {given[name]} is taken"
        mounting.notes.ignored(said, file.path.name)
        return
    given[name] = file.path.name
    parent = message.item("header").item("frame_id").text()
    tree.add(parent, name, _transform(message.item("transform")))
    group = file.path.resolve().parent.name.removesuffix("_params")
    kinds[name] = _KINDS.get(group) or kind_of(name)


def _transform(value: Value) -> Matrix:
    rotation, position = value.item("rotation"), value.item("translation")
    wxyz = rotation.field_numbers("w", "x", "y", "z")
    return se3(rotation_from_wxyz(rotation, wxyz), np.array(position.field_numbers("x", "y", "z")))


def _frame(file: Source) -> str:
    """Return the frame of an intrinsic file: that of its header, else its name."""
    header = file.yaml.get("header")
    said = header.get("frame_id") if header is not None and header.is_mapping else None
    return (said.text() if said is not None else "") or re.sub(r"_intrinsics.*", "", file.name)


def _root_axes(tree: FrameTree, mounting: Mounting) -> Matrix:
    """Return the transform from the root's axes; a root that is a LiDAR stands on the roof and has its own."""
    root = tree.root()
    if kind_of(root) == "lidar":
        mounting.origin = ON_ROOF
        mounting.notes.approximated(f"the root {root} is a LiDAR: x forward, y left, z up on the roof")
        mounting.add("lidar", root, np.eye(4), said=_model(root))
        return np.eye(4)
    if root in BASES:
        mounting.notes.converted(f"axes of {root} are x forward, y left, z up already (REP-105)")
        return np.eye(4)
    said = f"axes of {shortened(root, 40)}, x right, y forward, to x forward, y left"
    if _APOLLO.search(root.lower()):
        mounting.notes.converted(said)
    else:
        mounting.notes.approximated(f"{said}: as those of Apollo's {_ROOTS}")
    return se3(VEHICLE_R_ROOT, np.zeros(3))


def _model(frame: str) -> str | None:
    found = _VELODYNE.search(frame.lower())
    return f"Velodyne {_MODELS[found[1]]}" if found else None


def _add(
    frame: str,
    vehicle_SE3_frame: Matrix,
    kind: str | None,
    lenses: dict[str, Value],
    tree: FrameTree,
    mounting: Mounting,
) -> None:
    if frame in lenses or kind == "camera":
        if frame in lenses:
            lens = read_lens(lenses[frame], frame, mounting.notes)
        else:
            lens = mounting.unknown_lens(frame, "no intrinsics beside it", (1920, 1080))
        mounting.add("camera", frame, from_optical(vehicle_SE3_frame), **lens)
    elif kind == "lidar":
        mounting.add("lidar", frame, vehicle_SE3_frame, said=_model(frame))
    elif frame not in tree.inner_frames():
        mounting.notes.ignored("neither camera nor LiDAR, judging by its folder or name", frame)


_AXLE = Origin("the origin", rear_axle_on_ground)
APOLLO = Format(
    "apollo", "Apollo calibration", YAML, recognises, read, has_folders=True, origin=_AXLE, harmless=UNUSED
)
