"""Sensors of Gazebo (SDFormat) inside a URDF: cameras and LiDARs both ways.

A sensor looks along the x axis of its link; angles in radians; a scan has `samples` angles with both ends.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from riglens.core.formats.frames import (
    Matrix,
    SensorKind,
    rotation_from_wxyz,
    se3,
    se3_from_rpy_deg,
    se3_from_rpy_rad,
)
from riglens.core.formats.lenses import brown_conrady
from riglens.core.formats.mounts import Mounting
from riglens.core.formats.report import Notes
from riglens.core.formats.source import MAX_PIXELS, Value
from riglens.core.formats.unread import report_unread
from riglens.core.formats.xml_tree import Element
from riglens.core.rig.model import KannalaBrandt, LinearAngles
from riglens.core.rig.yaml.nodes import shortened

WIDE_ANGLE, EQUIDISTANT, PINHOLE = "wideanglecamera", "equidistant", "gnomonical"
KINDS: dict[str, SensorKind] = {
    **dict.fromkeys(
        (
            "camera",
            "multicamera",
            WIDE_ANGLE,
            "wide_angle_camera",
            "depth",
            "depth_camera",
            "rgbd_camera",
            "rgbd",
        ),
        "camera",
    ),
    **dict.fromkeys(("ray", "gpu_ray", "lidar", "gpu_lidar"), "lidar"),
    "sonar": "ultrasonic",
}
_MAX_SAMPLES = 100_000
_PLUGINS: tuple[tuple[str, SensorKind], ...] = (
    *((word, "camera") for word in ("camera", "kinect", "realsense", "prosilica")),
    *(
        (word, "lidar")
        for word in ("laser", "lidar", "velodyne", "ouster", "livox", "ray_sensor", "hesai", "robosense")
    ),
)
"""Words in the file names of Gazebo's plugins, as in libgazebo_ros_camera.so and libgazebo_ros_velodyne_laser.so."""
_RANGE_FINDERS = ("ros_range", "ros_sonar")
"""libgazebo_ros_range.so and libhector_gazebo_ros_sonar.so publish one distance of a sensor of type ray: a sonar."""
_RANGE_MESSAGE = "range"
"""Of ROS 2 the ray plugin says by its output type that it publishes one distance: sensor_msgs/Range."""
_HARMLESS = (
    "name|filename|topic|frame_name|topic_name|camera_name|visualize|format|save|ros|remapping|radiation|s"
    "|scale_to_hfov|noise|always_on|update_rate|resolution"
    "|.*[tT]opicName|frameName|cameraName|alwaysOn|updateRate|hackBaseline|autoDistortion"
)
"""Elements that change neither where a sensor stands nor what it sees; <resolution> is how ranges are interpolated."""
_SHORT_M = 10.0
"""A single ray of no more than this is a sonar, too: our choice."""


def plugin_kind(holder: Element) -> SensorKind | None:
    """Return the kind that the plugins of a <gazebo> or <sensor> publish, None when their names do not tell."""
    for plugin in holder.all("plugin"):
        said = f"{plugin.attributes.get('filename', '')} {plugin.attributes.get('name', '')}".lower()
        found = next((kind for word, kind in _PLUGINS if word in said), None)
        if found is not None:
            return found
    return None


def is_range_finder(sensor: Element) -> bool:
    """Return whether a sensor measures a single distance: as its plugin says, or with one ray of a few metres."""
    for plugin in sensor.all("plugin"):
        output = plugin.first("output_type")
        is_range = output is not None and output.text.strip().lower().rpartition("/")[2] == _RANGE_MESSAGE
        if is_range or any(word in plugin.attributes.get("filename", "") for word in _RANGE_FINDERS):
            return True
    lidar = sensor.first("lidar") or sensor.first("ray")
    scan = None if lidar is None else lidar.first("scan")
    if lidar is None or scan is None or scan.first("horizontal", "samples") is None:
        return False
    axes = [axis for axis in ("horizontal", "vertical") if scan.first(axis, "samples") is not None]
    is_one = all(_whole(scan, axis, "samples", most=_MAX_SAMPLES) == 1 for axis in axes)
    return is_one and _number(lidar, "range", "max", default=math.inf) <= _SHORT_M


def is_infrared(sensor: Element) -> bool:
    """Return whether a plugin of a range finder says that it measures by light."""
    tags = ("radiation", "radiation_type")
    said = (plugin.first(tag) for plugin in sensor.all("plugin") for tag in tags)
    return any(element is not None and "infrared" in element.text.lower() for element in said)


def sensor_kind(sensor: Element, notes: Notes) -> SensorKind | None:
    """Return the kind of a sensor by its type, or by the plugin that it names; others are reported, None."""
    name, said = sensor.attributes.get("name", "?"), sensor.attributes.get("type", "")
    if is_range_finder(sensor):
        if not is_infrared(sensor):
            return "ultrasonic"
        notes.ignored("range finder with a single distance by light", name)
        return None
    kind = KINDS.get(said.lower()) or plugin_kind(sensor)
    if kind is None:
        notes.ignored(f"Gazebo sensor of type '{shortened(said, 30)}'", name)
    return kind


def plugin_frame(holder: Element) -> str | None:
    """Return the frame in which a plugin publishes."""
    frames = (
        plugin.first(tag)
        for plugin in holder.all("plugin")
        for tag in ("frameName", "frame_name", "frame_id")
    )
    return next((frame.text.strip() for frame in frames if frame is not None and frame.text.strip()), None)


def numbers_in(element: Element, text: str, count: int) -> list[float]:
    """Return `count` finite numbers, separated by blanks."""
    words = text.split()
    try:
        found = [float(word) for word in words if len(word) < 100 and "_" not in word]
    except ValueError:
        found = []
    if len(found) != count or not all(abs(number) <= 1e6 for number in found):
        accepted = "a number" if count == 1 else f"{count} numbers"
        raise element.error(f"must be {accepted} within ±1e6 (got '{shortened(text, 40)}')")
    return found


def add_sdf_sensor(
    sensor: Element, kind: SensorKind, name: str, base_SE3_link: Matrix, mounting: Mounting
) -> None:
    """Add Gazebo's sensor to the rig, with the pose that it has on its link; several cameras in one are several."""
    name = sensor.attributes.get("name") or name
    base_SE3_sensor = base_SE3_link @ pose_of(sensor)
    if kind == "camera":
        cameras = [*sensor.all("camera")]
        for camera in cameras:
            own = f"{name}_{camera.attributes.get('name', 'camera')}" if len(cameras) > 1 else name
            fields = _camera_fields(camera, own, mounting)
            mounting.add(kind, own, base_SE3_sensor @ pose_of(camera), **fields)
        if not cameras:
            mounting.add(kind, name, base_SE3_sensor, **mounting.unknown_lens(name))
    else:
        read = _sonar_fields if kind == "ultrasonic" else _lidar_fields
        mounting.add(kind, name, base_SE3_sensor, **read(sensor, name, mounting))
    sensor.attributes.get("type")
    report_unread(sensor.unread(name), mounting.notes, _HARMLESS)


def pose_of(holder: Element) -> Matrix:
    """Return the <pose> of a link, sensor or camera: x y z, and roll pitch yaw, in degrees if so said, or x y z w."""
    pose = holder.first("pose")
    if pose is None:
        return np.eye(4)
    is_quaternion = pose.attributes.get("rotation_format", "euler_rpy") == "quat_xyzw"
    numbers = numbers_in(pose, pose.text, 7 if is_quaternion else 6)
    if is_quaternion:
        x, y, z, w = numbers[3:]
        return se3(
            rotation_from_wxyz(Value(pose.text, f"{pose.where}:{pose.line}"), [w, x, y, z]),
            np.array(numbers[:3]),
        )
    if pose.attributes.get("degrees", "false").strip().lower() in ("true", "1"):
        return se3_from_rpy_deg((numbers[0], numbers[1], numbers[2]), (numbers[3], numbers[4], numbers[5]))
    return se3_from_rpy_rad(numbers[:3], numbers[3:])


def _number(root: Element, *path: str, default: float | None = None) -> float:
    """Return the number in an element; ranges may be inf."""
    element = root.first(*path)
    if element is None:
        if default is None:
            raise root.error(f"<{'/'.join(path)}> is missing")
        return default
    text = element.text.strip()
    return math.inf if text.lower() in ("inf", "+inf") else numbers_in(element, text, 1)[0]


def _whole(root: Element, *path: str, most: int) -> int:
    value = _number(root, *path)
    if not (1 <= value <= most and value == int(value)):
        raise root.error(f"<{'/'.join(path)}>: must be an integer from 1 to {most} (got {value:g})")
    return int(value)


def _camera_fields(camera: Element, name: str, mounting: Mounting) -> dict[str, Any]:
    size = tuple(_whole(camera, "image", side, most=MAX_PIXELS) for side in ("width", "height"))
    fields: dict[str, Any] = {"image": size}
    intrinsics = camera.first("lens", "intrinsics")
    if intrinsics is not None:
        fields |= {key: _number(intrinsics, key) for key in ("fx", "fy", "cx", "cy")}
    else:
        fields |= _lens_of_type(camera, size[0], size[1], name, mounting)
    if camera.first("clip") is not None:
        fields["range_m"] = (_number(camera, "clip", "near", default=0.0), _number(camera, "clip", "far"))
    bend = camera.first("distortion")
    return fields if bend is None else fields | _distortion(bend, fields, name, mounting)


def _distortion(bend: Element, fields: dict[str, Any], name: str, mounting: Mounting) -> dict[str, Any]:
    """Return the lens with k1 k2 p1 p2 k3, as OpenCV has them; the centre is a share of the image.

    A field of view then is that of the pinhole that the distortion bends. Source: SDFormat specification, <distortion>.
    """
    numbers = [_number(bend, key, default=0.0) for key in ("k1", "k2", "p1", "p2", "k3")]
    if not any(numbers):
        return {}
    if "distortion" in fields:
        mounting.notes.ignored("lens distortion on top of a wide-angle lens", name)
        return {}
    bent = brown_conrady(Value(numbers, f"{bend.where}:{bend.line}"), numbers, name, mounting.notes)
    if "fx" in fields:
        return bent
    width, height = fields["image"]
    focal = width / 2.0 / math.tan(math.radians(fields["hfov_deg"]) / 2.0)
    centre = bend.first("center")
    share_x, share_y = (0.5, 0.5) if centre is None else numbers_in(centre, centre.text, 2)
    fields.pop("hfov_deg")
    return bent | {"fx": focal, "fy": focal, "cx": share_x * width, "cy": share_y * height}


def _lens_of_type(
    camera: Element, width_px: int, height_px: int, name: str, mounting: Mounting
) -> dict[str, Any]:
    """Return the lens of a field of view: a pinhole, or the equidistant fisheye of a wide-angle camera."""
    hfov_rad = _number(camera, "horizontal_fov", default=1.047)
    kind = camera.first("lens", "type")
    said = PINHOLE if kind is None else kind.text.strip().lower()
    if said == PINHOLE:
        return {"hfov_deg": math.degrees(hfov_rad)}
    if not 0.0 < hfov_rad <= 2.0 * math.pi:
        raise camera.error(f"<horizontal_fov>: must be above 0, at most 2 pi (got {hfov_rad:g})")
    if said != EQUIDISTANT:
        mounting.notes.approximated(
            f"lens of type '{shortened(said, 30)}' as an equidistant one of its field of view", name
        )
    focal_px = width_px / hfov_rad
    centre = {"cx": width_px / 2.0, "cy": height_px / 2.0}
    mounting.notes.read("equidistant lens of a wide-angle camera", name)
    return {"fx": focal_px, "fy": focal_px, **centre, "distortion": KannalaBrandt()}


def _lidar_fields(sensor: Element, _name: str, _mounting: Mounting) -> dict[str, Any]:
    lidar = sensor.first("lidar") or sensor.first("ray")
    scan = lidar.first("scan") if lidar is not None else None
    if lidar is None or scan is None:
        return {}
    fields: dict[str, Any] = {"azimuths_deg": _azimuths(scan), "elevations_deg": _elevations(scan)}
    if lidar.first("range") is not None:
        fields["range_m"] = (_number(lidar, "range", "min", default=0.0), _number(lidar, "range", "max"))
    return fields


def _sonar_fields(sensor: Element, name: str, mounting: Mounting) -> dict[str, Any]:
    """Return field of view and range of a sonar, or of a fan of rays whose nearest distance a plugin publishes."""
    ends: dict[str, tuple[float, float]] = {}
    far = near = None
    sonar, lidar = sensor.first("sonar"), sensor.first("lidar") or sensor.first("ray")
    if sonar is not None:
        near, far = _number(sonar, "min", default=0.0), _number(sonar, "max")
        half = math.degrees(math.atan2(_number(sonar, "radius", default=0.5), far))
        ends = {"azimuth_deg": (-half, half), "elevation_deg": (-half, half)}
    elif lidar is not None:
        if lidar.first("range") is not None:
            near, far = _number(lidar, "range", "min", default=0.0), _number(lidar, "range", "max")
        scan = lidar.first("scan")
        for field, axis in (("azimuth_deg", "horizontal"), ("elevation_deg", "vertical")):
            if scan is not None and scan.first(axis) is not None:
                low, high, count = _ends(scan, axis)
                ends |= {field: (low, high)} if count > 1 and low < high else {}
    if len(ends) < 2:
        mounting.notes.approximated("field of view of a sonar not in the file: assumed", name)
    if far is None or math.isinf(far):
        mounting.notes.approximated("range of a sonar not in the file: assumed", name)
        return dict(ends) or {"wall_range_m": _SHORT_M / 2.0}
    limits = {"pole_range_m": far, "wall_range_m": far}
    return {**ends, **limits, **({} if not near else {"range_m": (near, math.inf)})}


def _azimuths(scan: Element) -> LinearAngles:
    """Return the azimuths: SDF casts rays at both ends; here the end is open, one step further, at most a full turn."""
    low, high, count = _ends(scan, "horizontal")
    if count == 1:
        return _even(scan, low, low, 1)
    end = high + (high - low) / (count - 1)
    return _even(scan, low, min(end, low + 360.0), count)


def _elevations(scan: Element) -> LinearAngles:
    if scan.first("vertical") is None:
        return LinearAngles(from_=0.0, to=0.0, count=1)
    return _even(scan, *_ends(scan, "vertical"))


def _ends(scan: Element, axis: str) -> tuple[float, float, int]:
    """Return the lowest and highest angle in degrees, and the samples; Gazebo casts falling angles as well."""
    count = _whole(scan, axis, "samples", most=_MAX_SAMPLES)
    low, high = sorted(_angle(scan, axis, f"{end}_angle") for end in ("min", "max"))
    return low, high, count


def _angle(scan: Element, *path: str) -> float:
    return round(math.degrees(_number(scan, *path)), 12)


def _even(scan: Element, low: float, high: float, count: int) -> LinearAngles:
    if not -360.0 <= low <= high <= 360.0:
        raise scan.error(f"angles must be within ±360 degrees (got {low:g} to {high:g})")
    return LinearAngles(from_=low, to=high, count=count)
