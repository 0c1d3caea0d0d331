"""ROS URDF, written: base_link, a link per sensor on a fixed joint, optical frames, and Gazebo's sensors."""

from __future__ import annotations

import math
from xml.sax.saxutils import quoteattr

from riglens.core.geometry import Vec3
from riglens.core.rig.formats.base import Exported
from riglens.core.rig.formats.frames import pose_from_se3
from riglens.core.rig.formats.lenses import report_distortion
from riglens.core.rig.formats.mounts import rear_axle_on_ground, root_SE3_body, sensors_to_write
from riglens.core.rig.formats.report import Notes
from riglens.core.rig.model import Camera, EvenAngles, Lidar, Rig, Sensor

TITLE = "ROS URDF"
_OPTICAL_RPY = (-90.0, 0.0, -90.0)


def write(rig: Rig) -> Exported:
    """The URDF; base_link is the point on the ground under the rear axle."""
    notes = Notes()
    lines = ['<?xml version="1.0"?>', f"<robot name={_quoted(rig.name)}>", '  <link name="base_link"/>']
    for sensor in sensors_to_write(rig, notes):
        pose = pose_from_se3(root_SE3_body(sensor, rear_axle_on_ground(rig.vehicle)))
        link = "base_sensor_link" if sensor.name == "base" else f"{sensor.name}_link"
        lines += _link("base_link", link, pose.position_m, pose.rpy_deg)
        if isinstance(sensor, Camera):
            lines += _link(link, f"{sensor.name}_optical_frame", (0.0, 0.0, 0.0), _OPTICAL_RPY)
        lines += _gazebo(sensor, link, notes)
        if _quoted(sensor.name) != quoteattr(sensor.name):
            notes.approximated("characters that XML cannot hold are written as numbers", sensor.name)
    notes.converted("origin to the ground under the rear axle (base_link); angles to radians")
    notes.ignored("vehicle: the file has no place for it")
    text = "\n".join([*lines, "</robot>", ""])
    return Exported({"rig.urdf": text}, notes.report(TITLE))


def _quoted(text: str) -> str:
    """A text as an attribute: characters that XML 1.0 may not hold are written as their number, like u0007."""
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
    kind = "camera" if isinstance(sensor, Camera) else "gpu_lidar"
    inner = _camera(sensor, notes) if isinstance(sensor, Camera) else _lidar(sensor, notes)
    return [
        f"  <gazebo reference={_quoted(link)}>",
        f'    <sensor name={_quoted(sensor.name)} type="{kind}">',
        *(f"      {line}" for line in inner),
        "    </sensor>",
        "  </gazebo>",
    ]


def _camera(camera: Camera, notes: Notes) -> list[str]:
    notes.written("link, optical frame and Gazebo sensor", camera.name)
    notes.ignored("ray lattice: the file has no place for it", camera.name)
    report_distortion(camera, notes)
    fx, fy, cx, cy = camera.intrinsics_px()
    hfov_rad = 2.0 * math.atan(camera.image[0] / 2 / fx)
    lens = (
        ""
        if camera.hfov_deg is not None
        else (
            f"<lens><intrinsics><fx>{fx!r}</fx><fy>{fy!r}</fy><cx>{cx!r}</cx><cy>{cy!r}</cy><s>0</s></intrinsics></lens>"
        )
    )
    low, high = camera.range_m
    clip = (
        f"<clip><near>{low!r}</near><far>{high!r}</far></clip>" if camera.range_m != (0.0, math.inf) else ""
    )
    width, height = camera.image
    return [
        "<camera>",
        f"  <horizontal_fov>{hfov_rad!r}</horizontal_fov>",
        f"  <image><width>{width}</width><height>{height}</height></image>",
        *(f"  {part}" for part in (lens, clip) if part),
        "</camera>",
    ]


def _lidar(lidar: Lidar, notes: Notes) -> list[str]:
    notes.written("link and Gazebo sensor", lidar.name)
    if lidar.model is not None:
        notes.ignored("model name: the file has no place for it", lidar.name)
    beams, turn = lidar.elevations(), lidar.azimuths()
    if not isinstance(lidar.elevations_deg, EvenAngles) or not isinstance(lidar.azimuths_deg, EvenAngles):
        notes.approximated(
            "uneven angles: the file can say even ones only, from the least to the largest", lidar.name
        )
    if lidar.azimuth_offsets_deg is not None:
        notes.ignored("azimuth offsets of beams: the file has no place for them", lidar.name)
    low, high = lidar.range_m
    return [
        "<lidar>",
        "  <scan>",
        *(f"    {line}" for line in _scan("horizontal", turn.min(), turn.max(), len(turn))),
        *(f"    {line}" for line in _scan("vertical", beams.min(), beams.max(), len(beams))),
        "  </scan>",
        f"  <range><min>{low!r}</min><max>{high!r}</max></range>",
        "</lidar>",
    ]


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
