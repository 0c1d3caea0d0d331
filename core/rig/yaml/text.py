"""Rig values as YAML text: numbers that read back to the same bits, strings that read back to themselves."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import TypeGuard, cast

from pydantic import BaseModel

from riglens.core.rig.library import BUNDLED, LENS_MATRIX, default_library, supplied_fields
from riglens.core.rig.model import MeshPlacement, Rig, Sensor, Vehicle
from riglens.core.rig.yaml.nodes import Plain, scalar_value

_PLAIN = re.compile(r"[A-Za-z_]([A-Za-z0-9_+./ -]*[A-Za-z0-9_+./-])?")
_OLD_YAML_BOOLS = frozenset(("y", "n", "yes", "no", "on", "off"))
_OPTIONS = (
    *("model", "azimuth_offsets_deg", "range_m", "enabled", "mirror_of", "fails_with"),
    *("hfov_deg", "fx", "fy", "cx", "cy", "distortion"),
)
_LENS = ("image", "hfov_deg", "fx", "fy", "cx", "cy", "distortion", "cast")
FIELD_ORDER = (
    *("name", "kind", "model", "position", "rpy_deg", "elevations_deg", "azimuths_deg"),
    "azimuth_offsets_deg",
    *(*_LENS, "range_m", "enabled", "mirror_of", "fails_with"),
)
"""The order in which the fields of a sensor are written; those of other kinds follow."""


def plain_fields(item: BaseModel) -> dict[str, Plain]:
    """Return the fields of a part of a rig as plain numbers, strings, tuples and dicts, under their YAML names."""
    fields = type(item).model_fields
    return {str(info.alias or name): plain(getattr(item, name)) for name, info in fields.items()}


def plain(value: object) -> Plain:
    """Return a value of a rig as plain data; NumPy's floats become Python's."""
    if isinstance(value, BaseModel):
        return plain_fields(value)
    if isinstance(value, (tuple, list)):
        return tuple(plain(item) for item in value)
    return float(value) if isinstance(value, float) else cast(Plain, value)


def written_fields(sensor: Sensor) -> dict[str, Plain]:
    """Return the fields of a sensor that a new file holds, in the order in which they are written.

    Left out are options at their defaults, and what a bundled library model supplies. Of a model of the user's own
    everything is written, so that the file keeps its figures where that library is not.
    """
    fields, defaults, implied = plain_fields(sensor), _default_fields(sensor), implied_fields(sensor)
    supplied = default_library().entry(sensor.model).fields if _is_bundled(sensor.model) else {}
    silent = [
        key
        for key in (*_OPTIONS, *supplied)
        if key in fields
        and same_value(fields[key], implied[key])
        and (key in supplied or same_value(fields[key], defaults[key]))
    ]
    ordered = dict.fromkeys((*FIELD_ORDER, *fields))
    return {key: fields[key] for key in ordered if key in fields and key not in silent}


def _is_bundled(model: str | None) -> TypeGuard[str]:
    return model is not None and default_library().origins.get(model) == BUNDLED


def vehicle_fields(vehicle: Vehicle) -> dict[str, Plain]:
    """Return the fields of a vehicle that a new file holds; the placement of a mesh only when it is not the default."""
    fields = plain_fields(vehicle)
    if same_value(fields["mesh"], plain_fields(MeshPlacement())):
        del fields["mesh"]
    return fields


def implied_fields(sensor: Sensor) -> dict[str, Plain]:
    """Return the values of a sensor's fields when a file omits them: those of the library model, or the defaults."""
    fields = plain_fields(sensor)
    said = {key: fields.get(key) for key in ("model", "elevations_deg", "hfov_deg", *LENS_MATRIX)}
    return _default_fields(sensor) | supplied_fields(said)


def _default_fields(sensor: Sensor) -> dict[str, Plain]:
    known = type(sensor).model_fields.items()
    return {name: plain(info.default) for name, info in known if name != "kind" and not info.is_required()}


def rig_text(rig: Rig) -> str:
    """Return a fresh rig file in the layout of the documentation, with LF line ends."""
    lines = [f"riglens: {rig.riglens}", f"name: {value_text(rig.name)}"]
    if not rig.self_occlusion:
        lines.append("self_occlusion: false")
    lines.append(f"vehicle: {value_text(vehicle_fields(rig.vehicle))}")
    if rig.keep_out:
        lines.append(f"keep_out: {value_text(plain(rig.keep_out))}")
    if not rig.sensors:
        return "\n".join([*lines, "sensors: []", ""])
    lines.append("sensors:")
    for sensor in rig.sensors:
        lines += sensor_lines(sensor, indent=2)
    return "\n".join([*lines, ""])


def sensor_lines(sensor: Sensor, indent: int) -> list[str]:
    """Return a sensor as an item of a block list whose dash is indented by `indent` columns."""
    entries = [f"{key}: {value_text(value)}" for key, value in written_fields(sensor).items()]
    return [" " * indent + ("- " if index == 0 else "  ") + entry for index, entry in enumerate(entries)]


def value_text(value: object) -> str:
    """Return a value in one line of YAML (flow style)."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {value_text(item)}" for key, item in value.items()) + "}"
    if isinstance(value, tuple):
        return "[" + ", ".join(value_text(item) for item in value) + "]"
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    return _number(value) if isinstance(value, float) else _string(str(value))


def _number(value: float) -> str:
    if math.isnan(value):
        return ".nan"
    if math.isinf(value):
        return ".inf" if value > 0 else "-.inf"
    text = float.__repr__(value)
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


def _string(value: str) -> str:
    is_word = _PLAIN.fullmatch(value) and "  " not in value and value.lower() not in _OLD_YAML_BOOLS
    if is_word and isinstance(scalar_value(value), str):
        return value
    return '"' + "".join(_escaped(character) for character in value) + '"'


def _escaped(character: str) -> str:
    if character in '"\\':
        return "\\" + character
    if character.isprintable():
        return character
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def same_value(one: object, other: object) -> bool:
    """Return whether two plain values, or parts of rigs, are the same to the last bit.

    -0.0 is not 0.0, and 25 is the number 25.0. What two rigs share is not looked at: a drag changes one sensor of many.
    """
    if one is other:
        return True
    if isinstance(one, bool) or isinstance(other, bool) or isinstance(one, str) or isinstance(other, str):
        return type(one) is type(other) and bool(one == other)
    if isinstance(one, (int, float)) and isinstance(other, (int, float)):
        return float(one) == float(other) and math.copysign(1.0, one) == math.copysign(1.0, other)
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(same_value, one, other))
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(same_value(one[key], other[key]) for key in one)
    if isinstance(one, BaseModel) and type(one) is type(other):
        return all(same_value(getattr(one, name), getattr(other, name)) for name in type(one).model_fields)
    return False


def line_end(text: str, position: int) -> int:
    """Return where the line around a position ends, before its line break."""
    end = text.find("\n", position)
    if end < 0:
        return len(text)
    return end - 1 if end > position and text[end - 1] == "\r" else end
