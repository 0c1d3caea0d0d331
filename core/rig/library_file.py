"""A file of sensor models: its entries, read and checked; the bundled library and users' own look the same."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, ValidationError

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.frozen import Frozen
from riglens.core.rig.model import Camera, Length, Lidar, Positive, Sensor
from riglens.core.rig.text_file import read_text
from riglens.core.rig.yaml_nodes import Mapping, Node, parse_yaml, plain_value, shortened

MAX_ENTRIES = 500
OTHER_MAKER = "Other"
Text = Annotated[str, Field(min_length=3, max_length=100)]
LongText = Annotated[str, Field(min_length=10, max_length=2_000)]
Rate = Annotated[str, Field(pattern=r"^[0-9]{1,3}(\.[0-9]{1,3})?$")]


class Cylinder(Frozen):
    """The body of a spinning sensor in metres, its axis upright."""

    diameter: Length
    height: Length


class Block(Frozen):
    """The body of a sensor in metres: along its view, across, upright."""

    length: Length
    width: Length
    height: Length


class Entry(Frozen):
    """One sensor model: what it is, where its figures come from and the sensor fields it supplies.

    `azimuth_step_deg`: turns a second to degrees between neighbouring azimuths; `pixel_um`: edge of a pixel.
    """

    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9.+-]*$", max_length=60)]
    kind: Literal["lidar", "camera"]
    title: Text
    source: LongText
    maker: Text = OTHER_MAKER
    note: LongText | None = None
    body_m: Cylinder | Block | None = None
    azimuth_step_deg: dict[Rate, Positive] | None = None
    pixel_um: Positive | None = None
    lens: Text | None = None
    fields: dict[str, Any]

    def sensor(self, name: str, pose: Pose) -> Sensor:
        """A sensor of this model; raises pydantic's ValidationError when the entry's fields are wrong."""
        placed: dict[str, Any] = {"position": pose.position_m, "rpy_deg": pose.rpy_deg, "model": self.name}
        maker = Lidar if self.kind == "lidar" else Camera
        return maker(name=name, **placed, **self.fields)


_ABOUT = tuple(name for name in Entry.model_fields if name not in ("name", "fields"))
_ANGLES = ("elevations_deg", "azimuths_deg", "azimuth_offsets_deg")
_OWN = ("name", "model", "position", "rpy_deg", "enabled", "mirror_of")
"""What is said of a sensor on a car and never of a model."""


def read_entries(path: str | os.PathLike[str], where: str) -> tuple[Entry, ...]:
    """The entries of a library file; `where` names it in messages.

    Raises InputError `where:line: model: field: ...` for the first thing that is wrong.
    """
    root = parse_yaml(read_text(path, "a sensor library in YAML"), where)
    if not isinstance(root, Mapping):
        raise InputError(f"{where}:1: accepted is a mapping of model names to sensor fields")
    if len(root.entries) > MAX_ENTRIES:
        raise InputError(f"{where}: found {len(root.entries)} models; accepted are at most {MAX_ENTRIES}")
    return tuple(_entry(key.text, key.line, value, where) for key, value in root.entries)


def _entry(name: str, line: int, node: Node, where: str) -> Entry:
    place = f"{where}:{line}: {shortened(name)}"
    if not isinstance(node, Mapping):
        raise InputError(f"{place}: accepted are the fields of a sensor model")
    values: dict[str, Any] = plain_value(node)
    for key in _OWN:
        if key in values:
            raise InputError(f"{place}: {key}: a model does not say this; the rig does")
    for key in _ANGLES:
        if isinstance(values.get(key), str):
            values[key] = _numbers(values[key], f"{place}: {key}")
    about = {key: values[key] for key in _ABOUT if key in values}
    fields = {key: value for key, value in values.items() if key not in _ABOUT}
    try:
        entry = Entry(name=name, fields=fields, **about)
        sensor = entry.sensor(name, Pose())
    except ValidationError as error:
        raise InputError(_complaint(error, name, line, node, where)) from error
    _check_about(entry, place)
    return entry.model_copy(update={"fields": _complete(fields, sensor)})


def _numbers(text: str, place: str) -> tuple[float, ...]:
    """Numbers separated by blanks, commas or line ends: how long lists of angles are written."""
    numbers: list[float] = []
    for word in text.replace(",", " ").split():
        try:
            numbers.append(float(word))
        except ValueError:
            raise InputError(f"{place}: found '{shortened(word)}'; accepted are numbers of degrees") from None
    return tuple(numbers)


def _complaint(error: ValidationError, name: str, line: int, node: Mapping, where: str) -> str:
    """The first complaint, at the line of the field that it is about."""
    first = error.errors()[0]
    field = ".".join(str(part) for part in first["loc"])
    message = str(first["ctx"]["error"]) if first["type"] == "value_error" else first["msg"]
    value = node.get(field.partition(".")[0] or message.split()[0])
    where_in_file = f"{where}:{value.line if value is not None else line}: {shortened(name)}"
    return f"{where_in_file}: {field}: {message}" if field else f"{where_in_file}: {message}"


def _check_about(entry: Entry, place: str) -> None:
    strangers = ("pixel_um", "lens") if entry.kind == "lidar" else ("azimuth_step_deg",)
    for key in strangers:
        if getattr(entry, key) is not None:
            raise InputError(f"{place}: {key}: not a figure of a {entry.kind}")


def _complete(fields: dict[str, Any], sensor: Sensor) -> dict[str, Any]:
    """The fields with every coefficient of a lens said, so that they compare equal to a sensor's."""
    lens = sensor.distortion if isinstance(sensor, Camera) else None
    return fields if lens is None else fields | {"distortion": _dumped(lens)}


def _dumped(part: BaseModel) -> dict[str, Any]:
    return part.model_dump()


def library_path(folder: Path) -> Path:
    """Where a user's own library lies in a configuration folder."""
    return folder / "library.yaml"
