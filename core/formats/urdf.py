"""ROS URDF: links on joints, with xacro expanded, with the sensors of Gazebo where there are any.

Axes x forward, y left, z up; metres; rpy are radians about the fixed axes of the parent link. Links called
..._optical... have camera axes (x right, y down, z forward; REP-103). A URDF knows links, not sensors: what a
link holds is told by <gazebo reference="link"><sensor> or <plugin>, else by its name or that of its mesh. base_link may
be anywhere on the vehicle (REP-105); here it is taken for the point on the ground under the rear axle unless the origin
says else.
Source: ROS wiki "urdf/XML"; SDFormat specification, <sensor>.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from riglens.core.formats.base import Format
from riglens.core.formats.frames import (
    BASES,
    FrameTree,
    Matrix,
    SensorKind,
    camera_body,
    inverse,
    kind_of,
    pose_from_se3,
    se3_from_rpy_rad,
    without_ending,
)
from riglens.core.formats.lens_export import equidistant, extent, pinhole_with_edges, report_lens
from riglens.core.formats.mounts import (
    Mounting,
    Origin,
    rear_axle_on_ground,
    root_SE3_body,
    sensors_to_write,
)
from riglens.core.formats.ray_export import report_uneven
from riglens.core.formats.report import Notes
from riglens.core.formats.sdf_sensor import (
    EQUIDISTANT,
    WIDE_ANGLE,
    add_sdf_sensor,
    numbers_in,
    plugin_frame,
    plugin_kind,
    sensor_kind,
)
from riglens.core.formats.source import Source
from riglens.core.formats.unread import note_comments, report_unread
from riglens.core.formats.xacro import expanded, is_xacro
from riglens.core.formats.xml_tree import Element
from riglens.core.geometry import Vec3
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Lidar, Rig, Sensor
from riglens.core.rig.yaml.nodes import shortened
from riglens.core.sensors.radar import Radar
from riglens.core.sensors.registry import kind_of as kind_of_sensor
from riglens.core.sensors.ultrasonic import Ultrasonic

_OPTICAL_RPY = (-90.0, 0.0, -90.0)


def write(rig: Rig, notes: Notes) -> dict[str, str]:
    """Return the URDF; base_link is the point on the ground under the rear axle."""
    lines = ['<?xml version="1.0"?>', f"<robot name={_quoted(rig.name)}>", '  <link name="base_link"/>']
    for sensor in sensors_to_write(rig, notes, _GAZEBO):
        pose = pose_from_se3(root_SE3_body(sensor, rear_axle_on_ground(rig.vehicle)))
        link = _link_of(sensor)
        lines += _link("base_link", link, pose.position_m, pose.rpy_deg)
        lines += _gazebo(sensor, link, notes)
        if _quoted(sensor.name) != quoteattr(sensor.name):
            notes.approximated("characters that XML cannot hold are written as numbers", sensor.name)
    notes.converted("origin to the ground under the rear axle (base_link); angles to radians")
    notes.ignored("vehicle: the format cannot express it")
    text = "\n".join([*lines, "</robot>", ""])
    return {"rig.urdf": text}


def _link_of(sensor: Sensor) -> str:
    """Return a link's name that is not the vehicle's and, where the name alone has to say it, tells the kind."""
    link = "base_sensor_link" if sensor.name == "base" else f"{sensor.name}_link"
    needs_kind = sensor.kind == "radar" and kind_of(link) != sensor.kind
    return f"{sensor.name}/{sensor.kind}_link" if needs_kind else link


def _quoted(text: str) -> str:
    """Return a text as an attribute; characters that XML 1.0 does not allow are written as numbers, like u0007."""
    return quoteattr("".join(letter if letter.isprintable() else f"u{ord(letter):04x}" for letter in text))


def _link(parent: str, child: str, position_m: Vec3, rpy_deg: Vec3) -> list[str]:
    xyz = " ".join(repr(float(part)) for part in position_m)
    rpy = " ".join(repr(math.radians(angle)) for angle in rpy_deg)
    return [
        f"  <link name={_quoted(child)}/>",
        f'  <joint name={_quoted(child + "_joint")} type="fixed">',
        f"    <parent link={_quoted(parent)}/>",
        f"    <child link={_quoted(child)}/>",
        f'    <origin xyz="{xyz}" rpy="{rpy}"/>',
        "  </joint>",
    ]


def _gazebo(sensor: Sensor, link: str, notes: Notes) -> list[str]:
    kind, inner, frame = _GAZEBO[sensor.kind](sensor, notes)
    if not kind:
        return []
    return [
        *(_link(link, f"{sensor.name}{frame}", (0.0, 0.0, 0.0), _OPTICAL_RPY) if frame else ()),
        f"  <gazebo reference={_quoted(link)}>",
        f'    <sensor name={_quoted(sensor.name)} type="{kind}">',
        *(f"      {line}" for line in inner),
        "    </sensor>",
        "  </gazebo>",
    ]


def _camera(camera: Camera, notes: Notes) -> tuple[str, list[str], str]:
    """Return Gazebo's type of the camera, its elements and the ending of its optical frame's name."""
    notes.written("link, optical frame and Gazebo sensor", camera.name)
    notes.ignored("ray lattice: the format cannot express it", camera.name)
    kind, lens = _lens(camera, notes)
    low, high = camera.range_m
    clip = f"<clip><near>{low!r}</near><far>{high!r}</far></clip>"
    width, height = camera.image
    hfov_rad = math.radians(extent(camera).wide_deg if camera.hfov_deg is None else camera.hfov_deg)
    return (
        kind,
        [
            "<camera>",
            f"  <horizontal_fov>{hfov_rad!r}</horizontal_fov>",
            f"  <image><width>{width}</width><height>{height}</height></image>",
            *(f"  {part}" for part in (lens, clip if camera.range_m != (0.0, math.inf) else "") if part),
            "</camera>",
        ],
        "_optical_frame",
    )


def _lens(camera: Camera, notes: Notes) -> tuple[str, str]:
    """Return Gazebo's type of the camera and its <lens>: a matrix, or an equidistant fisheye."""
    if camera.hfov_deg is not None:
        return "camera", ""
    bend = camera.distortion
    is_fisheye = isinstance(bend, KannalaBrandt)
    distortion = _distortion(bend) if isinstance(bend, BrownConrady) else ""
    if bend is None or distortion:
        written: Camera | None = camera
    else:
        written = None if is_fisheye else pinhole_with_edges(camera)
    if written is None:
        report_lens(camera, equidistant(camera), "an equidistant fisheye in the middle of its image", notes)
        return WIDE_ANGLE, f"<lens><type>{EQUIDISTANT}</type><scale_to_hfov>true</scale_to_hfov></lens>"
    if distortion:
        notes.written("lens distortion k1 k2 k3 p1 p2", camera.name)
    else:
        report_lens(camera, written, "a pinhole with the same edges", notes)
    values = zip(("fx", "fy", "cx", "cy"), written.intrinsics_px(), strict=True)
    inner = "".join(f"<{key}>{float(value)!r}</{key}>" for key, value in values)
    return "camera", f"<lens><intrinsics>{inner}<s>0</s></intrinsics></lens>{distortion}"


def _distortion(bend: BrownConrady) -> str:
    """Return <distortion>, which has no place for k4 to k6; empty for a lens with these."""
    if any((bend.k4, bend.k5, bend.k6)):
        return ""
    inner = "".join(f"<{key}>{getattr(bend, key)!r}</{key}>" for key in ("k1", "k2", "k3", "p1", "p2"))
    return f"<distortion>{inner}<center>0.5 0.5</center></distortion>"


def _lidar(lidar: Lidar, notes: Notes) -> tuple[str, list[str], str]:
    notes.written("link and Gazebo sensor", lidar.name)
    if lidar.model is not None:
        notes.ignored("model name: the format cannot express it", lidar.name)
    beams, turn = lidar.elevations(), lidar.azimuths()
    report_uneven(lidar, "Gazebo", notes)
    low, high = lidar.range_m
    return (
        "gpu_lidar",
        [
            "<lidar>",
            "  <scan>",
            *(f"    {line}" for line in _scan("horizontal", turn.min(), turn.max(), len(turn))),
            *(f"    {line}" for line in _scan("vertical", beams.min(), beams.max(), len(beams))),
            "  </scan>",
            f"  <range><min>{low!r}</min><max>{high!r}</max></range>",
            "</lidar>",
        ],
        "",
    )


def _radar(radar: Radar, notes: Notes) -> tuple[str, list[str], str]:
    notes.written("link", radar.name)
    notes.ignored("scans, cross sections and model: the format cannot express them", radar.name)
    return "", [], ""


def _ultrasonic(sensor: Ultrasonic, notes: Notes) -> tuple[str, list[str], str]:
    """Return the fan of rays whose nearest distance Gazebo's plugin publishes as a sensor_msgs/Range."""
    notes.written("link and Gazebo sensor", sensor.name)
    if sensor.wall_range_m != sensor.pole_range_m:
        notes.approximated(f"one range: that for a wall, {sensor.wall_range_m:g} m", sensor.name)
    return (
        "ray",
        [
            "<ray>",
            "  <scan>",
            *(f"    {line}" for line in _scan("horizontal", *sensor.azimuth_deg, _FAN)),
            *(f"    {line}" for line in _scan("vertical", *sensor.elevation_deg, _FAN)),
            "  </scan>",
            f"  <range><min>{sensor.range_m[0]!r}</min><max>{sensor.wall_range_m!r}</max></range>",
            "</ray>",
            f'<plugin name={_quoted(sensor.name + "_range")} filename="libgazebo_ros_ray_sensor.so">',
            "  <output_type>sensor_msgs/Range</output_type>",
            "  <radiation_type>ultrasound</radiation_type>",
            "</plugin>",
        ],
        "",
    )


_FAN = 9
"""Rays in a row of a sonar's fan."""
_GAZEBO: dict[str, Callable[[Any, Notes], tuple[str, list[str], str]]] = {
    "camera": _camera,
    "lidar": _lidar,
    "radar": _radar,
    "ultrasonic": _ultrasonic,
}
"""Writers of a sensor, by kind; a radar is a link alone, for which Gazebo has no sensor of its scans."""


def _scan(axis: str, low_deg: float, high_deg: float, count: int) -> list[str]:
    low, high = (math.radians(float(angle)) for angle in (low_deg, high_deg))
    return [
        f"<{axis}>",
        f"  <samples>{count}</samples>",
        "  <resolution>1</resolution>",
        f"  <min_angle>{low!r}</min_angle>",
        f"  <max_angle>{high!r}</max_angle>",
        f"</{axis}>",
    ]


MAX_JOINTS = 2_000


@dataclass(frozen=True)
class _Found:
    """A link that holds a sensor; `sensor` is Gazebo's element; `is_told`: not only a name suggests it."""

    link: str
    kind: SensorKind
    sensor: Element | None = None
    is_told: bool = False


def recognises(source: Source) -> bool:
    """Return whether this is an XML file whose root is <robot>."""
    return source.suffix != ".xml" or source.xml.tag == "robot"


def read(source: Source, mounting: Mounting) -> Rig:
    """Return the sensors of a robot, chained to base_link."""
    root, notes = source.xml, mounting.notes
    if root.tag != "robot":
        raise root.error("the root must be <robot>")
    note_comments(source.text, notes)
    if is_xacro(root):
        root = expanded(source, notes)
    tree = _joints(root, notes)
    base = _base(root, tree)
    mounting.origin = Origin(f"{base}, on the ground under the rear axle,", rear_axle_on_ground)
    for found in _sensors(root, tree, notes):
        if tree.root_of(found.link) != tree.root_of(base):
            notes.ignored(f"is not attached to {base}", found.link)
            continue
        _add(found, inverse(tree.root_SE3(base)) @ tree.root_SE3(found.link), mounting)
    notes.converted("angles from radians to degrees")
    if meshes := sum(element.tag == "mesh" for element in root.walk()):
        notes.ignored(f"{meshes} meshes: they are not opened")
    return mounting.rig(root.attributes.get("name", source.name))


def _joints(root: Element, notes: Notes) -> FrameTree:
    """Return the tree of links; joints that move are taken at zero."""
    tree = FrameTree(root.where)
    joints = list(root.all("joint"))
    if len(joints) > MAX_JOINTS:
        raise root.error(f"must be at most {MAX_JOINTS} joints (got {len(joints)})")
    for joint in joints:
        parent, child = joint.first("parent"), joint.first("child")
        if parent is None or child is None:
            raise joint.error("a joint needs <parent link=...> and <child link=...>")
        tree.add(parent.attribute("link"), child.attribute("link"), _origin(joint, notes))
        if joint.attributes.get("type") != "fixed":
            notes.approximated("movable joint, taken at zero", joint.attributes.get("name", "?"))
    return tree


def _origin(joint: Element, notes: Notes) -> Matrix:
    origin = joint.first("origin")
    if origin is None:
        return np.eye(4)
    pose = se3_from_rpy_rad(
        *(numbers_in(origin, origin.attributes.get(of, "0 0 0"), 3) for of in ("xyz", "rpy"))
    )
    report_unread(origin.unread(joint.attributes.get("name", "?")), notes)
    return pose


def _base(root: Element, tree: FrameTree) -> str:
    """Return the frame of the vehicle: base_footprint, base_link, or the root of the tree."""
    links = [link.attribute("name") for link in root.all("link")]
    if not links:
        raise root.error(
            "a robot needs at least one <link>; a file of macros is opened by the one that calls them"
        )
    named = next((base for base in BASES if base in links), None)
    return named or tree.root_of(links[0])


def _sensors(root: Element, tree: FrameTree, notes: Notes) -> list[_Found]:
    """Return Gazebo's sensors, then links recognised by name; of a kind's links on one branch the outermost counts."""
    links = {link.attribute("name") for link in root.all("link")}
    found = [*_gazebo_sensors(root, links, notes)]
    taken = {sensor.link for sensor in found}
    for link in root.all("link"):
        name = link.attribute("name")
        kind = kind_of(name)
        if kind is None and name not in (*BASES, *taken):
            kind = _kind_of_mesh(link)
            if kind is not None:
                notes.approximated(f"taken for a {kind_of_sensor(kind).title} by the name of its mesh", name)
        if kind is None and name not in (*BASES, *taken):
            notes.ignored("link whose name and mesh suggest no sensor", name)
        elif kind is not None and name not in taken:
            found.append(_Found(name, kind))
    return _outermost(found, tree, notes)


def _outermost(found: list[_Found], tree: FrameTree, notes: Notes) -> list[_Found]:
    """Drop links that are the mount, or another axes frame, of a sensor of the same kind in the list."""
    above = {(sensor.kind, frame) for sensor in found for frame in tree.above(sensor.link)}
    gazebo = {(sensor.kind, sensor.link) for sensor in found if sensor.is_told}
    kept: list[_Found] = []
    for sensor in found:
        is_below = any((sensor.kind, frame) in gazebo for frame in tree.above(sensor.link))
        if not sensor.is_told and (is_below or (sensor.kind, sensor.link) in above):
            notes.read("link belongs to the sensor on the same branch", sensor.link)
        else:
            kept.append(sensor)
    return kept


def _gazebo_sensors(root: Element, links: set[str], notes: Notes) -> Iterator[_Found]:
    """Yield sensors by their type, or by the plugin that they, or <gazebo> alone, name."""
    for gazebo in root.all("gazebo"):
        sensors = [*gazebo.all("sensor")]
        for sensor in sensors or ([gazebo] if plugin_kind(gazebo) else []):
            name, kind = sensor.attributes.get("name", "?"), sensor_kind(sensor, notes)
            if kind is None:
                continue
            link = gazebo.attributes.get("reference") or plugin_frame(sensor) or plugin_frame(gazebo)
            if link is None or link not in links:
                where = (
                    "names no link"
                    if link is None
                    else f"is on the link '{shortened(link, 40)}', which does not exist"
                )
                notes.ignored(f"Gazebo sensor that {where}", name)
            else:
                yield _Found(link, kind, sensor if sensor is not gazebo else None, is_told=True)


def _kind_of_mesh(link: Element) -> SensorKind | None:
    """Return the kind of sensor that the file of a link's shape names, as in velodyne_description/meshes/VLP16.dae."""
    for part in ("visual", "collision"):
        for shape in link.all(part):
            mesh = shape.first("geometry", "mesh")
            words = "" if mesh is None else PurePosixPath(mesh.attributes.get("filename", "")).stem
            kind = kind_of(words) if words else None
            if kind is not None:
                return kind
    return None


def _add(found: _Found, base_SE3_link: Matrix, mounting: Mounting) -> None:
    name = without_ending(found.link)
    if found.sensor is not None:
        add_sdf_sensor(found.sensor, found.kind, name, base_SE3_link, mounting)
    elif found.kind != "camera":
        mounting.add(found.kind, name, base_SE3_link)
    else:
        body = camera_body(found.link, base_SE3_link, mounting.notes)
        mounting.add("camera", name, body, **mounting.unknown_lens(name))


URDF = Format("urdf", "ROS URDF", (".urdf", ".xacro", ".xml"), recognises, read, write, endings=(".urdf",))
