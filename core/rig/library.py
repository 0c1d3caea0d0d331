"""The library of sensor models: published beam angles and camera lenses that a rig names by `model:`."""

from __future__ import annotations

import difflib
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from assets import asset_path
from core.errors import InputError
from core.geometry import Pose
from core.rig.model import Camera, Lidar
from core.rig.yaml_nodes import Mapping, Node, parse_yaml, plain_value

LENS_MATRIX = ("fx", "fy", "cx", "cy")
_ABOUT = ("kind", "title", "source")


class Entry(BaseModel):
    """One sensor model: what it is, where its figures come from and the sensor fields it supplies."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9.+-]*$")]
    kind: Literal["lidar", "camera"]
    title: Annotated[str, Field(min_length=3)]
    source: Annotated[str, Field(min_length=10)]
    fields: dict[str, Any]

    def sensor(self, name: str, pose: Pose) -> Lidar | Camera:
        """A sensor of this model; raises pydantic's ValidationError when the entry's fields are wrong."""
        placed: dict[str, Any] = {"position": pose.position_m, "rpy_deg": pose.rpy_deg, "model": self.name}
        maker = Lidar if self.kind == "lidar" else Camera
        return maker(name=name, **placed, **self.fields)


class Library:
    """The sensor models by name, in the order of the file."""

    def __init__(self, entries: tuple[Entry, ...]) -> None:
        self._entries = {entry.name: entry for entry in entries}

    def entries(self, kind: Literal["lidar", "camera"] | None = None) -> tuple[Entry, ...]:
        """All entries, or those of one kind."""
        return tuple(entry for entry in self._entries.values() if kind in (None, entry.kind))

    def entry(self, model: str) -> Entry:
        """The entry of that name; InputError that lists the known names when there is none."""
        if model in self._entries:
            return self._entries[model]
        close = [name for name in self._entries if model.lower() in name]
        close = close or difflib.get_close_matches(model.lower(), self._entries, n=1)
        hint = f"did you mean '{close[0]}'? " if close else ""
        raise InputError(f"model: unknown sensor model '{model}'; {hint}known are {', '.join(self._entries)}")


@cache
def default_library() -> Library:
    """The library that ships with the program, read once."""
    return load_library(asset_path("library.yaml"))


def supplied_fields(sensor: dict[str, Any]) -> dict[str, Any]:
    """Fields that the library gives to a sensor with these fields.

    A lens is said in one way: a field of view leaves out the model's focal lengths and distortion. Azimuth offsets
    belong to beams: with another number of beams they are left out.
    """
    model = sensor.get("model")
    if not isinstance(model, str):
        return {}
    fields = dict(default_library().entry(model).fields)
    if any(sensor.get(key) is not None for key in LENS_MATRIX):
        fields.pop("hfov_deg", None)
    if sensor.get("hfov_deg") is not None:
        for key in (*LENS_MATRIX, "distortion"):
            fields.pop(key, None)
    offsets, beams = fields.get("azimuth_offsets_deg"), sensor.get("elevations_deg")
    if offsets is not None and beams is not None and _beam_count(beams) != len(offsets):
        del fields["azimuth_offsets_deg"]
    return fields


def _beam_count(beams: Any) -> Any:
    """Number of beams that a field says, if it says one."""
    if isinstance(beams, dict):
        return beams.get("count")
    return len(beams) if isinstance(beams, tuple) else None


def load_library(path: Path) -> Library:
    """Read and check a library file; InputError with file, line and model when an entry is wrong."""
    root = parse_yaml(path.read_text(encoding="utf-8"), path.name)
    if not isinstance(root, Mapping):
        raise InputError(f"{path.name}:1: accepted is a mapping of model names to sensor fields")
    return Library(tuple(_entry(key.text, key.line, value, path.name) for key, value in root.entries))


def sensor_from_model(model: str, name: str, pose: Pose) -> Lidar | Camera:
    """A sensor called `name` of a library model at that pose; InputError for an unknown model."""
    return default_library().entry(model).sensor(name, pose)


def _entry(name: str, line: int, node: Node, where: str) -> Entry:
    values = plain_value(node)
    if not isinstance(values, dict):
        raise InputError(f"{where}:{line}: {name}: accepted are the fields of a sensor model")
    about = {key: values[key] for key in _ABOUT if key in values}
    fields = {key: value for key, value in values.items() if key not in _ABOUT}
    try:
        entry = Entry(name=name, fields=fields, **about)
        entry.sensor(name, Pose())
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        raise InputError(f"{where}:{line}: {name}: {field}: {first['msg']}") from error
    return entry
