"""NVIDIA DriveWorks rig JSON.

Rig axes x forward, y left, z up; origin on the ground under the rear axle; metres; `roll-pitch-yaw` in degrees about
the fixed axes of the rig. Sensors, cameras too, stand in FLU axes (x forward, y left, z up). The pose is
R = R(nominalSensor2Rig_FLU) R(correction_sensor_R_FLU), t = nominalSensor2Rig_FLU.t + correction_rig_T.
The origin of the body's box (boundingBoxPosition) is the middle of its lower rear edge; the box holds the mirrors.
Source: DriveWorks SDK reference, "Rig File Format", dwVehicleBodyProperties, dwPinholeCameraConfig and
dwFThetaCameraConfig.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from riglens.core.formats.base import Format
from riglens.core.formats.frames import Matrix, pose_from_se3, se3
from riglens.core.formats.lens_export import ftheta_polynomial, most_off_deg, radial_only
from riglens.core.formats.lenses import RoundLens, brown_conrady, ftheta_fields
from riglens.core.formats.mounts import (
    REAR_AXLE,
    Mounting,
    rear_axle_on_ground,
    root_SE3_body,
    sensors_to_write,
)
from riglens.core.formats.report import Notes
from riglens.core.formats.source import MAX_ANGLE, Source, Value
from riglens.core.geometry import rotation_from_rpy_deg
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt, Rig, Sensor, Vehicle
from riglens.core.rig.yaml.nodes import shortened

VERSION = 2
NOMINAL, CORRECTION_R, CORRECTION_T = "nominalSensor2Rig_FLU", "correction_sensor_R_FLU", "correction_rig_T"
RPY = "roll-pitch-yaw"
_LENS = ("fx", "fy", "cx", "cy")
_LINEAR = (("linear-c", 1.0), ("linear-d", 0.0), ("linear-e", 0.0))
_RADIAL = ("k1", "k2", "k3")
_PLAIN_NAMES = ("rig", "vehicle", "config", "calibration", "rig_config")
_BACKWARD, _FORWARD = "pixeldistance-to-angle", "angle-to-pixeldistance"


def recognises(source: Source) -> bool:
    """Return whether this is a JSON object with rig.sensors."""
    rig = source.json.get("rig") if source.json.is_mapping else None
    return rig is not None and "sensors" in rig


def read(source: Source, mounting: Mounting) -> Rig:
    """Return cameras and LiDARs with their corrections applied, and the vehicle's size where it is given."""
    rig = source.json.item("rig")
    if mounting.options.vehicle is None:
        mounting.found(_vehicle(rig, mounting.notes))
    for index, sensor in enumerate(rig.item("sensors").elements()):
        _add(sensor, f"sensor {index}", mounting)
    return mounting.rig(_name(source))


def _name(source: Source) -> str:
    """Return the name of the file without its ending; a generic name is combined with that of the folder."""
    stem = source.path.name.removesuffix(".gz")
    stem = stem[: -len(".json")] if stem.lower().endswith(".json") else stem
    return f"{source.path.resolve().parent.name} {stem}".strip() if stem.lower() in _PLAIN_NAMES else stem


def _vehicle(rig: Value, notes: Notes) -> Vehicle | None:
    """Return the vehicle: its box without mirrors where the file knows that, and the rear axle; None if absent."""
    found = rig.get("vehicle")
    value = found.get("value") if found is not None and found.is_mapping else None
    sizes = (value.get("body") or value) if value is not None and value.is_mapping else None
    if sizes is None or not all(key in sizes for key in ("length", "width", "height")):
        return None
    length, width, height = (sizes.item(key).number(0.1, 100.0) for key in ("length", "width", "height"))
    notes.read("length, width and height of the vehicle")
    body_width = sizes.get("widthWithoutMirrors")
    if body_width is not None and 0.1 <= body_width.number(0.0, 100.0) < width:
        notes.converted(f"width without mirrors: {body_width.number():g} m, {width:g} m with them")
        width = body_width.number()
    rear_axle_x = _rear_axle_x(sizes, length, notes)
    return Vehicle(length=length, width=width, height=height, rear_axle_x=rear_axle_x)


def _rear_axle_x(sizes: Value, length: float, notes: Notes) -> float:
    """Return where the rear axle is: by its distance from the rear end, or by the box's rear edge in rig axes."""
    bumper, box = sizes.get("bumperRear"), sizes.get("boundingBoxPosition")
    if bumper is None and box is None:
        rear_axle_x = Vehicle().rear_axle_x
        notes.approximated(
            f"bumperRear not in the file: rear axle at x = {rear_axle_x:g} m", field="rear_axle_x"
        )
        return rear_axle_x
    if bumper is not None:
        what, rear_m = "bumperRear", bumper.number(-100.0, 100.0)
    else:
        assert box is not None
        x, y, _ = box.field_numbers("x", "y", "z") if box.is_mapping else box.vector(limit=100.0)
        what, rear_m = "boundingBoxPosition", -x
        if y != 0.0:
            notes.ignored(f"the body's box is {y:g} m off the rig's x axis: taken as centred")
    rear_axle_x = round(rear_m - length / 2, 12)
    notes.converted(f"{what} to the place of the rear axle: x = {rear_axle_x:g} m from the body centre")
    return rear_axle_x


def _add(sensor: Value, default_name: str, mounting: Mounting) -> None:
    name = sensor.item("name", default_name).text()
    kind = sensor.item("protocol", name).text().lower().replace(":", ".").split(".")[0]
    if kind not in _PROPERTIES:
        mounting.notes.ignored("neither camera nor LiDAR", name)
        return
    if NOMINAL not in sensor:
        mounting.notes.ignored(f"no {NOMINAL}: poses of older rig files are not read", name)
        return
    pose = _pose(sensor, name, mounting.notes)
    properties = sensor.get("properties")
    if kind == "camera":
        mounting.add(kind, name, pose, **_lens(properties, name, mounting))
    else:
        mounting.add(kind, name, pose, said=_model_words(sensor, properties))


def _pose(sensor: Value, name: str, notes: Notes) -> Matrix:
    """Return the nominal pose with both corrections."""
    nominal = sensor.item(NOMINAL)
    rotation = _rotation(nominal)
    position: Any = nominal.item("t").vector()
    correction_r, correction_t = sensor.get(CORRECTION_R), sensor.get(CORRECTION_T)
    if correction_r is not None:
        rotation = rotation @ _rotation(correction_r)
    if correction_t is not None:
        position = [one + more for one, more in zip(position, correction_t.vector(), strict=True)]
    if correction_r is not None or correction_t is not None:
        notes.converted("corrections of the calibration applied to the nominal pose", name)
    return se3(rotation, position)


def _rotation(value: Value) -> Matrix:
    return rotation_from_rpy_deg(value.item(RPY).vector(limit=MAX_ANGLE))


def _model_words(sensor: Value, properties: Value | None) -> str | None:
    """Return the model that the file names: in our own property, or as device=... in the sensor's parameters."""
    model = properties.get("model") if properties is not None and properties.is_mapping else None
    if model is not None:
        return model.text()
    parameter = sensor.get("parameter")
    pairs = [] if parameter is None else parameter.text()[:10_000].split(",")
    return next((pair.removeprefix("device=") for pair in pairs if pair.startswith("device=")), None)


def _lens(properties: Value | None, name: str, mounting: Mounting) -> dict[str, Any]:
    """Return image and lens of a camera; an f-theta lens becomes the nearest Kannala-Brandt lens."""
    if properties is None or "width" not in properties or "height" not in properties:
        return mounting.unknown_lens(name)
    notes = mounting.notes
    size = properties.image(quoted=True)
    model = properties.item("Model", "unknown").text().lower()
    if model == "pinhole" and "fx" in properties:
        lens = {key: properties.item(key).number(quoted=True) for key in _LENS}
        return {"image": size, **lens, **_pinhole_distortion(properties, name, notes)}
    if model == "ftheta":
        cx_px, cy_px = (properties.item(key).number(quoted=True) for key in ("cx", "cy"))
        coefficients, is_backward = _polynomial(properties)
        polynomial = np.polynomial.Polynomial(coefficients or (0.0,))
        bent = RoundLens(cx_px, cy_px, _stretch(properties, name, notes), polynomial, is_backward)
        return ftheta_fields(bent, coefficients, size, properties, name, notes)
    notes.approximated(f"lens of model '{shortened(model, 30)}' is not read: 90 degrees wide", name)
    return {"image": size, "hfov_deg": 90.0}


def _stretch(properties: Value, name: str, notes: Notes) -> float:
    """Return linear-c, pixels along u for one along v; all three of linear-c, -d, -e zero mean none."""
    c, d, e = (properties.item(key, usual).number(quoted=True) for key, usual in _LINEAR)
    if d != 0.0 or e != 0.0:
        notes.ignored(f"skew of the image (linear-d {d:g}, linear-e {e:g})", name)
    if (c, d, e) == (0.0, 0.0, 0.0):
        return 1.0
    if not 1e-3 <= c <= 1e3:
        properties.item("linear-c").refuse("a number from 0.001 to 1000")
    return c


def _pinhole_distortion(properties: Value, name: str, notes: Notes) -> dict[str, Any]:
    """Return the radial coefficients k1 k2 k3, from the ray to the pixel."""
    radial = _coefficients(properties, "distortion")
    if not any(radial):
        return {}
    if len(radial) > 3 or "pixel" in properties.item("polynomial-type", "").text().split("-to-")[0]:
        notes.ignored("lens distortion in another form than k1 k2 k3 from ray to pixel", name)
        return {}
    k1, k2, k3 = [*radial, 0.0, 0.0][:3]
    return brown_conrady(properties, (k1, k2, 0.0, 0.0, k3), name, notes)


def _polynomial(properties: Value) -> tuple[list[float], bool]:
    """Return the coefficients, lowest first, and whether they map pixels to radians (else radians to pixels)."""
    if "bw-poly" in properties:
        return _coefficients(properties, "bw-poly"), True
    kind = properties.item("polynomial-type").text()
    if kind not in (_BACKWARD, _FORWARD):
        properties.item("polynomial-type").refuse(f"{_BACKWARD} or {_FORWARD}")
    return _coefficients(properties, "polynomial"), kind == _BACKWARD


def _coefficients(properties: Value, key: str) -> list[float]:
    """Return the numbers separated by blanks, or a list of them."""
    found = properties.get(key)
    if found is None:
        return []
    if found.is_list:
        return found.numbers(limit=1e12)
    words = found.text().split()
    if len(words) > 20:
        found.refuse("at most 20 coefficients")
    return [Value(word, *found.place).number(-1e12, 1e12, quoted=True) for word in words]


def write(rig: Rig, notes: Notes) -> dict[str, str]:
    """Return the rig with nominal poses and no corrections; cameras as pinholes or f-theta lenses."""
    sensors = [_sensor(sensor, rig, notes) for sensor in sensors_to_write(rig, notes, _PROPERTIES)]
    notes.converted("origin from the body centre to the rear axle on the ground")
    notes.approximated("only the size of the vehicle is known: it is written, marked as not valid")
    document = {"rig": {"sensors": sensors, "vehicle": _vehicle_block(rig.vehicle)}, "version": VERSION}
    return {"rig.json": json.dumps(document, indent=4) + "\n"}


def _vehicle_block(vehicle: Vehicle) -> dict[str, object]:
    bumper_rear = vehicle.length / 2 + vehicle.rear_axle_x
    size = {"length": vehicle.length, "width": vehicle.width, "height": vehicle.height}
    return {"valid": False, "value": {**size, "bumperRear": bumper_rear}}


def _sensor(sensor: Sensor, rig: Rig, notes: Notes) -> dict[str, object]:
    pose = pose_from_se3(root_SE3_body(sensor, rear_axle_on_ground(rig.vehicle)))
    return {
        "name": sensor.name,
        NOMINAL: {RPY: list(pose.rpy_deg), "t": list(pose.position_m)},
        "parameter": "",
        "properties": _PROPERTIES[sensor.kind](sensor, notes),
        "protocol": f"{sensor.kind}.virtual",
    }


def _camera_properties(camera: Camera, notes: Notes) -> dict[str, str]:
    properties = _lens_properties(camera, notes)
    notes.written("pose, image and lens", camera.name)
    notes.ignored("ray lattice and range: the format cannot express them", camera.name)
    return properties


def _model_property(sensor: Sensor, notes: Notes) -> dict[str, str]:
    notes.written("pose and model" if sensor.model else "pose", sensor.name)
    figures = "beam angles" if sensor.kind == "lidar" else "field of view"
    notes.ignored(f"{figures} and range: the format cannot express them", sensor.name)
    return {"model": sensor.model} if sensor.model else {}


_PROPERTIES: dict[str, Callable[[Any, Notes], dict[str, str]]] = {
    "camera": _camera_properties,
    "lidar": _model_property,
    "radar": _model_property,
    "ultrasonic": _model_property,
}
"""Writers of a sensor's properties, by kind."""


def _lens_properties(camera: Camera, notes: Notes) -> dict[str, str]:
    """Return a pinhole with k1 k2 k3, or for a fisheye the f-theta polynomial from angles to pixels."""
    width, height = (str(side) for side in camera.image)
    fx, fy, cx, cy = camera.intrinsics_px()
    common = {"width": width, "height": height, "cx": repr(float(cx)), "cy": repr(float(cy))}
    if isinstance(camera.distortion, KannalaBrandt):
        coefficients, off_px = ftheta_polynomial(camera)
        if off_px > 0.0:
            notes.approximated(
                f"Kannala-Brandt lens as the nearest f-theta polynomial: at most {off_px:.2g} pixels off",
                camera.name,
            )
        notes.converted("fisheye lens to an f-theta polynomial", camera.name)
        polynomial = {"polynomial": _words(coefficients), "polynomial-type": _FORWARD}
        linear = {"linear-c": repr(float(fx / fy)), "linear-d": "0.0", "linear-e": "0.0"}
        return {"Model": "ftheta", **common, **polynomial, **linear}
    focal = {"fx": repr(float(fx)), "fy": repr(float(fy))}
    return {"Model": "pinhole", **common, **focal, "distortion": _radial(camera, notes)}


def _words(numbers: Iterable[float]) -> str:
    return " ".join(repr(float(number)) for number in numbers)


def _radial(camera: Camera, notes: Notes) -> str:
    """Return the distortion as k1 k2 k3; what that leaves out is reported."""
    found = camera.distortion
    if not isinstance(found, BrownConrady):
        return "0 0 0"
    left_out = [key for key in ("p1", "p2", "k4", "k5", "k6") if getattr(found, key)]
    if not left_out:
        return _words(getattr(found, key) for key in _RADIAL)
    written = radial_only(camera)
    notes.ignored(
        f"lens distortion: the format has k1 k2 k3 but no {' '.join(left_out)}; rays are up to "
        f"{most_off_deg(camera, written):.2f} deg off",
        camera.name,
    )
    return _words(getattr(written.distortion, key) for key in _RADIAL)


DRIVEWORKS = Format(
    "driveworks",
    "NVIDIA DriveWorks rig JSON",
    (".json",),
    recognises,
    read,
    write,
    origin=REAR_AXLE,
    harmless="version|valid",
)
