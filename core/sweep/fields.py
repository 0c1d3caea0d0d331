"""Fields of a rig by the paths of its file, such as `LIDAR_TOP.z` or `vehicle.height`, and rigs with other values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from pydantic import BaseModel, ValidationError

from riglens.core.errors import InputError
from riglens.core.rig.edits import in_step, partner_of, replaced
from riglens.core.rig.model import Rig
from riglens.core.rig.yaml.problems import problems

POSE = {
    **{name: ("position", place) for place, name in enumerate("xyz")},
    **{name: ("rpy_deg", place) for place, name in enumerate(("roll", "pitch", "yaw"))},
}
"""Short names of fields of a sensor."""
VEHICLE = "vehicle"
_METRES = ("position", "range_m", "length", "width", "height", "rear_axle_x", "offset")


@dataclass(frozen=True)
class RigField:
    """A number in a rig: of a sensor by its name, or of the vehicle if that is None; `path` are the steps to it."""

    name: str
    sensor: str | None
    path: tuple[str | int, ...]

    @property
    def unit(self) -> str:
        """Unit of the number; empty without one."""
        if any(isinstance(step, str) and step.endswith("_deg") for step in self.path):
            return "" if self.path[-1] == "count" else "°"
        return "m" if self.path[0] in _METRES or self.path[-1] in _METRES else ""

    @property
    def title(self) -> str:
        """Name with unit."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


def field_called(rig: Rig, name: str) -> RigField:
    """Return the field of that name; raise InputError when a rig has no such number."""
    sensors = [sensor for sensor in rig.sensors if name.startswith(f"{sensor.name}.")]
    if sensors:
        sensor = max(sensors, key=lambda one: len(one.name))  # names may contain dots
        rest = name[len(sensor.name) + 1 :]
        return RigField(name, sensor.name, POSE.get(rest) or _path(sensor, rest, name, tuple(POSE)))
    owner, _, rest = name.partition(".")
    if owner == VEHICLE:
        return RigField(name, None, _path(rig.vehicle, rest, name))
    known = [*(sensor.name for sensor in rig.sensors), VEHICLE]
    raise InputError(f"'{name}': rig '{rig.name}' has no sensor '{owner}'{_hint(owner, known)}")


def _path(item: object, text: str, name: str, more: Sequence[str] = ()) -> tuple[str | int, ...]:
    """Return the steps from an item to the number that a text names."""
    steps: tuple[str | int, ...] = ()
    for word in text.split("."):
        if isinstance(item, BaseModel):
            known = {str(info.alias or key): key for key, info in type(item).model_fields.items()}
            if word not in known:
                raise InputError(f"'{name}': no field '{word}'{_hint(word, [*known, *more])}")
            steps, item = (*steps, known[word]), getattr(item, known[word])
        elif isinstance(item, tuple) and word.isdecimal() and int(word) < len(item):
            steps, item = (*steps, int(word)), item[int(word)]
        else:
            accepted = f"0 to {len(item) - 1}" if isinstance(item, tuple) else "nothing more"
            raise InputError(f"'{name}': after '.' must come {accepted} (got '{word}')")
    if not isinstance(item, (int, float)):
        inner = ""
        if isinstance(item, BaseModel):
            inner = f"; it has {', '.join(str(info.alias or key) for key, info in type(item).model_fields.items())}"
        elif isinstance(item, tuple):
            inner = f"; it has 0 to {len(item) - 1}"
        raise InputError(f"'{name}' must be a number in the rig (got {type(item).__name__}){inner}")
    return steps


def _hint(word: str, known: Sequence[str]) -> str:
    close = get_close_matches(word, known, 1)
    return f" (did you mean '{close[0]}'?)" if close else f" (has {', '.join(known)})"


def fields_called(rig: Rig, names: Sequence[str]) -> tuple[RigField, ...]:
    """Return several fields; raise InputError when two cannot vary independently."""
    found = tuple(field_called(rig, name) for name in names)
    places = [(field.sensor, field.path) for field in found]
    for place, field in enumerate(found):
        if places[place] in places[:place]:
            raise InputError(f"'{field.name}' is named twice")
        partner = partner_of(rig, field.sensor) if field.sensor else None
        if partner is not None and partner in {other.sensor for other in found}:
            raise InputError(
                f"'{field.name}': {field.sensor} and {partner} are a mirror pair; vary only one of them"
            )
    return found


def value_of(rig: Rig, field: RigField) -> float:
    """Return the number in a rig."""
    item: Any = rig.vehicle if field.sensor is None else rig.sensor(field.sensor)
    for step in field.path:
        item = item[step] if isinstance(step, int) else getattr(item, step)
    number: float = item
    return number


def with_values(rig: Rig, values: Mapping[RigField, float]) -> Rig:
    """Return the rig with some numbers changed, mirror pairs in step; raise InputError where one does not fit."""
    changed = rig
    for field, value in values.items():
        owner: Any = changed.vehicle if field.sensor is None else changed.sensor(field.sensor)
        try:
            item = replaced(owner, field.path, _as_now(value_of(changed, field), value))
        except ValidationError as error:
            problem = problems(error, {})[0]
            raise InputError(f"'{field.name}' cannot be {value:g}:{_said(problem.complaint)}") from error
        if field.sensor is None:
            item = item.with_body_mesh(rig.vehicle.body_mesh)
            changed = changed.model_copy(update={"vehicle": item})
        else:
            changed = changed.with_sensor(field.sensor, item)
    return in_step(rig, changed)


def _said(complaint: str) -> str:
    return f" {complaint.strip().removeprefix(': ')}"


def _as_now(now: float, value: float) -> float:
    """Return a value as an integer or a switch where the present one is, if it can be."""
    return type(now)(value) if isinstance(now, int) and float(value).is_integer() else value
