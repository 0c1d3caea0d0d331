"""The fields of a rig file: what each accepts, in words, and how a field is named."""

from __future__ import annotations

from riglens.core.rig.distortion import COEFFICIENTS
from riglens.core.rig.model import FORMAT_VERSION, MAX_SENSORS

Path = tuple[str | int, ...]
_ANGLES = "{{from: {0}, to: {0}, count: 1 to 100000}} with from <= to, or a list of angles of {0} degrees"
_ANGLE = "a number of degrees, for elevations -90 to 90, for azimuths -360 to 360"
_PIXELS = "[width, height] in whole pixels, each 1 to 20000"
ACCEPTED = {
    "": "a mapping with riglens, name, vehicle and sensors",
    "riglens": f"the format version {FORMAT_VERSION}",
    "name": "a text of 1 to 200 characters",
    "vehicle": "a mapping with body, length, width, height, rear_axle_x and mesh",
    "vehicle.body": "sedan, suv, van, truck or the path of a mesh file",
    "vehicle.length": "metres above 0, at most 100",
    "vehicle.width": "metres above 0, at most 100",
    "vehicle.height": "metres above 0, at most 100",
    "vehicle.rear_axle_x": "metres, -1e7 to 1e7",
    "vehicle.mesh": "a mapping with scale, rpy_deg and offset",
    "vehicle.mesh.scale": "a factor, 1e-6 to 1e6",
    "vehicle.mesh.rpy_deg": "[roll, pitch, yaw] in degrees, finite numbers",
    "vehicle.mesh.offset": "[x, y, z] in metres, each -1e7 to 1e7",
    "sensors": f"a list of at most {MAX_SENSORS} sensors",
    "sensors[]": "a mapping with name, kind, position and the other fields of a sensor",
    "sensors[].name": "a text of 1 to 200 characters, unique in the file",
    "sensors[].kind": "lidar or camera",
    "sensors[].model": "the name of an entry of the sensor library",
    "sensors[].position": "[x, y, z] in metres, each -1e7 to 1e7",
    "sensors[].rpy_deg": "[roll, pitch, yaw] in degrees, finite numbers",
    "sensors[].range_m": "[min, max] in metres with 0 <= min < max; max may be .inf",
    "sensors[].enabled": "true or false",
    "sensors[].mirror_of": "the name of another sensor of the same kind",
    "sensors[].elevations_deg": _ANGLES.format("-90 to 90"),
    "sensors[].elevations_deg.from": _ANGLE,
    "sensors[].elevations_deg.to": _ANGLE,
    "sensors[].elevations_deg.count": "a whole number, 1 to 100000",
    "sensors[].azimuths_deg": _ANGLES.format("-360 to 360"),
    "sensors[].azimuths_deg.from": _ANGLE,
    "sensors[].azimuths_deg.to": _ANGLE,
    "sensors[].azimuths_deg.count": "a whole number, 1 to 100000",
    "sensors[].azimuth_offsets_deg": "a list of degrees, one per beam, each -360 to 360",
    "sensors[].image": _PIXELS,
    "sensors[].hfov_deg": "degrees above 0 and below 180",
    "sensors[].fx": "pixels, above 0",
    "sensors[].fy": "pixels, above 0",
    "sensors[].cx": "pixels, a finite number",
    "sensors[].cy": "pixels, a finite number",
    "sensors[].distortion": "{model: brown_conrady, k1, k2, p1, p2, k3 to k6} or "
    "{model: kannala_brandt, k1 to k4}, with fx, fy, cx, cy",
    "sensors[].distortion.model": "brown_conrady or kannala_brandt",
    **{f"sensors[].distortion.{name}": "a number, -1e9 to 1e9" for name in COEFFICIENTS},
    "sensors[].cast": _PIXELS + ", at most the image",
}
"""What each field of a rig file accepts, in words; the keys are field paths without list indices."""


def path_text(path: Path) -> str:
    """A field path as a person writes it: sensors[1].elevations_deg.count."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


def key_of(path: Path) -> str:
    """The key of a field path in ACCEPTED."""
    text = "".join("[]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


def field_path(loc: tuple[str | int, ...]) -> Path:
    """The path of the field that a pydantic location lies in, without union members and items."""
    path: Path = ()
    for part in loc:
        if key_of((*path, part)) in ACCEPTED:
            path = (*path, part)
    return path
