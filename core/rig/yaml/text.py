"""Rigs as plain data and as fresh YAML text, in the layout of the documentation."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeGuard, cast

from pydantic import BaseModel

from riglens.core.rig.library import BUNDLED, LENS_MATRIX, default_library, supplied_fields
from riglens.core.rig.model import MeshPlacement, Rig, Sensor, Vehicle
from riglens.core.rig.yaml.nodes import Plain, value_text

_FIRST = ("name", "kind", "model", "position", "rpy_deg")
_LAST = ("range_m", "enabled", "mirror_of", "fails_with", "blocked")


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


def ordered_fields(sensor: Sensor) -> dict[str, Plain]:
    """Return all fields of a sensor in the order in which they are written: those of its kind amid the common ones."""
    fields = plain_fields(sensor)
    own = (key for key in fields if key not in _FIRST + _LAST)
    return {key: fields[key] for key in (*_FIRST, *own, *_LAST)}


def written_fields(sensor: Sensor) -> dict[str, Plain]:
    """Return the fields of a sensor that a new file holds, in the order of writing.

    Left out are options at their defaults, and what a bundled library model supplies. Of a model of the user's own
    everything is written, so that the file keeps its figures where that library is not.
    """
    defaults, implied = default_fields(type(sensor)), implied_fields(sensor)
    supplied = default_library().entry(sensor.model).fields if _is_bundled(sensor.model) else {}
    none = (key for key, value in defaults.items() if value in (None, ()))
    optional = {"range_m", "enabled", *sensor.idle_fields, *none}

    def is_silent(key: str, value: Plain) -> bool:
        is_default = key in optional and same_value(value, defaults[key])
        return (key in supplied or is_default) and same_value(value, implied[key])

    return {key: value for key, value in ordered_fields(sensor).items() if not is_silent(key, value)}


def _is_bundled(model: str | None) -> TypeGuard[str]:
    return model is not None and default_library().origins.get(model) == BUNDLED


def rig_fields(rig: Rig) -> dict[str, Plain]:
    """Return the fields of a rig that a new file holds, its sensors aside: options only where they are not default."""
    fields, defaults = plain_fields(rig), plain_fields(Rig())
    always = ("riglens", "name", "vehicle")
    written = {
        key: value
        for key, value in fields.items()
        if key in always or not (key == "sensors" or same_value(value, defaults[key]))
    }
    return written | {"vehicle": vehicle_fields(rig.vehicle)}


def vehicle_fields(vehicle: Vehicle) -> dict[str, Plain]:
    """Return the fields of a vehicle that a new file holds; the placement of a mesh only when it is not the default."""
    fields = plain_fields(vehicle)
    if same_value(fields["mesh"], plain_fields(MeshPlacement())):
        del fields["mesh"]
    return fields


def implied_fields(sensor: Sensor) -> dict[str, Plain]:
    """Return the values of a sensor's fields when a file omits them: those of the library model, or the defaults."""
    fields = plain_fields(sensor)
    said = {key: fields.get(key) for key in ("model", "elevations_deg", "rays", "hfov_deg", *LENS_MATRIX)}
    return default_fields(type(sensor)) | supplied_fields(said)


def default_fields(part: type[BaseModel]) -> dict[str, Plain]:
    """Return the values of those fields of a part of a rig that a file may omit."""
    known = part.model_fields.items()
    return {name: plain(info.default) for name, info in known if name != "kind" and not info.is_required()}


def rig_text(rig: Rig) -> str:
    """Return a fresh rig file in the layout of the documentation, with LF line ends."""
    lines = [f"{key}: {value_text(value)}" for key, value in rig_fields(rig).items()]
    lines.append("sensors:" if rig.sensors else "sensors: []")
    for sensor in rig.sensors:
        lines += sensor_lines(sensor, indent=2)
    return "\n".join([*lines, ""])


def sensor_lines(sensor: Sensor, indent: int) -> list[str]:
    """Return a sensor as an item of a block list whose dash is indented by `indent` columns."""
    entries = [f"{key}: {value_text(value)}" for key, value in written_fields(sensor).items()]
    return [" " * indent + ("- " if index == 0 else "  ") + entry for index, entry in enumerate(entries)]


def same_value(one: object, other: object) -> bool:
    """Return whether two plain values, or parts of rigs, are equal to the last bit.

    -0.0 is not 0.0, and 25 is the number 25.0. Shared parts of two rigs are skipped: a drag changes one sensor of many.
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
