"""What can be wrong in a rig file beyond single values: unknown fields, kinds, library models, names, mirror pairs."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from riglens.core.errors import InputError
from riglens.core.rig.distortion import BrownConrady, KannalaBrandt
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Camera, EvenAngles, Lidar, MeshPlacement, Rig, Vehicle, mirror_problem
from riglens.core.rig.yaml_fields import ACCEPTED, Path, path_text
from riglens.core.rig.yaml_nodes import Mapping, Node, Scalar, Sequence, plain_value, shortened
from riglens.core.rig.yaml_text import value_text

_KINDS: dict[Any, type[BaseModel]] = {"lidar": Lidar, "camera": Camera}
_LENSES: dict[Any, type[BaseModel]] = {"brown_conrady": BrownConrady, "kannala_brandt": KannalaBrandt}


@dataclass(frozen=True)
class Problem:
    """What is wrong, and in which line of the file."""

    line: int
    text: str


def first_of(problems: list[Problem], where: str) -> str:
    """The line of text about the first problem in the file, with the number of the others."""
    first, *others = sorted(problems, key=lambda problem: problem.line)
    more = f" (and {len(others)} more)" if others else ""
    return f"{where}:{first.line}: {first.text}{more}"


def key_problems(root: Mapping) -> Iterable[Problem]:
    """Unknown keys of the document, the vehicle, the sensors and their angles."""
    yield from _unknown_keys(root, (), Rig)
    vehicle = root.get("vehicle")
    yield from _unknown_keys(vehicle, ("vehicle",), Vehicle)
    if isinstance(vehicle, Mapping):
        yield from _unknown_keys(vehicle.get("mesh"), ("vehicle", "mesh"), MeshPlacement)
    for index, sensor in _sensor_nodes(root):
        path: Path = ("sensors", index)
        kind = _scalar(sensor.get("kind"))
        if kind in _KINDS:
            yield from _unknown_keys(sensor, path, _KINDS[kind])
        for key in ("elevations_deg", "azimuths_deg"):
            yield from _unknown_keys(sensor.get(key), (*path, key), EvenAngles)
        lens = sensor.get("distortion")
        model = _scalar(lens.get("model")) if isinstance(lens, Mapping) else None
        if model in _LENSES:
            yield from _unknown_keys(lens, (*path, "distortion"), _LENSES[model])


def _unknown_keys(node: Node | None, path: Path, model: type[BaseModel]) -> Iterable[Problem]:
    if not isinstance(node, Mapping):
        return
    known = [str(info.alias or name) for name, info in model.model_fields.items()]
    for key, _ in node.entries:
        if key.text not in known:
            close = difflib.get_close_matches(key.text, known, n=1)
            hint = f"did you mean '{close[0]}'? " if close else ""
            accepted = f"unknown field; {hint}accepted are {', '.join(known)}"
            yield Problem(key.line, f"{path_text((*path, shortened(key.text)))}: {accepted}")


def sensor_problems(root: Mapping) -> Iterable[Problem]:
    """What concerns a sensor beyond its own fields: kind, library model, names used twice."""
    lines: dict[str, int] = {}
    for index, sensor in _sensor_nodes(root):
        path = path_text(("sensors", index))
        yield from _name_problems(sensor, path, lines)
        yield from _kind_problems(sensor, path)
        yield from _model_problems(sensor, path)
    yield from _mirror_problems(_sensor_nodes(root))


def _mirror_problems(sensors: list[tuple[int, Mapping]]) -> Iterable[Problem]:
    """A `mirror_of` that makes no pair; the other fields are judged elsewhere."""
    keys = ("name", "kind", "mirror_of")
    said = [tuple(_scalar(sensor.get(key)) for key in keys) for _, sensor in sensors]
    if all(isinstance(name, str) and (other is None or isinstance(other, str)) for name, _, other in said):
        problem = mirror_problem((name, str(kind), other) for name, kind, other in said)
        if problem is not None:
            index, sensor = sensors[problem[0]]
            node = sensor.get("mirror_of") or sensor
            yield Problem(node.line, f"{path_text(('sensors', index))}.{shortened(problem[1], 300)}")


def _name_problems(sensor: Mapping, path: str, lines: dict[str, int]) -> Iterable[Problem]:
    name = sensor.get("name")
    if isinstance(name, Scalar) and isinstance(plain_value(name), str):
        if name.text in lines:
            used = f"already used in line {lines[name.text]}"
            text = f"found '{shortened(name.text)}', {used}; names must be unique"
            yield Problem(name.line, f"{path}.name: {text}")
        lines.setdefault(name.text, name.line)


def _kind_problems(sensor: Mapping, path: str) -> Iterable[Problem]:
    kind, accepted = sensor.get("kind"), ACCEPTED["sensors[].kind"]
    if kind is None:
        yield Problem(sensor.line, f"{path}.kind: missing; accepted is {accepted}")
    elif _scalar(kind) not in _KINDS:
        yield Problem(kind.line, f"{path}.kind: found {found_text(kind)}; accepted is {accepted}")


def _model_problems(sensor: Mapping, path: str) -> Iterable[Problem]:
    node = sensor.get("model")
    model = _scalar(node)
    if node is not None and isinstance(model, str):
        complaint = model_complaint(model, _scalar(sensor.get("kind")))
        if complaint:
            yield Problem(node.line, f"{path}.{complaint}")


def model_complaint(model: str | None, kind: Any) -> str:
    """Why a sensor of that kind cannot be of that library model ("model: ..."); empty when it can."""
    if model is None:
        return ""
    library = default_library()
    try:
        entry = library.entry(model)
    except InputError as error:
        return str(error)
    if kind not in _KINDS or entry.kind == kind:
        return ""
    hint = f"`riglens library --kind {kind}` lists the models of a {kind}"
    return f"model: found '{model}', a {entry.kind}, but this sensor is a {kind}; {hint}"


def found_text(node: Node) -> str:
    """What stands in the file, shortened."""
    if isinstance(node, Scalar) and node.start == node.end:
        return "nothing"
    value = plain_value(node)
    if isinstance(node, Scalar) and node.plain:
        return shortened(node.text)
    return shortened(value_text(value))


def _scalar(node: Node | None) -> Any:
    return plain_value(node) if isinstance(node, Scalar) else None


def _sensor_nodes(root: Mapping) -> list[tuple[int, Mapping]]:
    """The sensors of the document that are mappings, with their place in the list."""
    sensors = root.get("sensors")
    items = sensors.items if isinstance(sensors, Sequence) else ()
    return [(index, item) for index, item in enumerate(items) if isinstance(item, Mapping)]
