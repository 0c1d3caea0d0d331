"""From YAML nodes to a valid rig, or to one line that says where the file is wrong and what is accepted."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ValidationError

from riglens.core.errors import InputError
from riglens.core.rig.library import default_library, supplied_fields
from riglens.core.rig.model import (
    FORMAT_VERSION,
    MAX_SENSORS,
    MAX_SPOTS,
    BrownConrady,
    EvenAngles,
    KannalaBrandt,
    MeshPlacement,
    Rig,
    Vehicle,
    mirror_problem,
)
from riglens.core.rig.yaml.nodes import (
    Mapping,
    Node,
    Plain,
    Scalar,
    Sequence,
    plain_mapping,
    plain_value,
    shortened,
)
from riglens.core.rig.yaml.text import plain_fields, value_text
from riglens.core.sensors.registry import kind_named, kind_names, kinds

Path = tuple[str | int, ...]
ACCEPTED = {
    "": "a mapping with riglens, name, vehicle and sensors",
    "riglens": f"the format version {FORMAT_VERSION}",
    "name": "a text of 1 to 200 characters",
    "self_occlusion": "true or false",
    "body": "ignored or blocks, another spelling of self_occlusion",
    "vehicle": "a mapping with body, length, width, height, rear_axle_x and mesh",
    "vehicle.body": "sedan, suv, van, truck or the path of a mesh file",
    "vehicle.length": "metres, 0.1 to 100",
    "vehicle.width": "metres, 0.1 to 100",
    "vehicle.height": "metres, 0.1 to 100",
    "vehicle.rear_axle_x": "metres, -1e7 to 1e7",
    "vehicle.mesh": "a mapping with scale, rpy_deg and offset",
    "vehicle.mesh.scale": "a factor, 1e-6 to 1e6",
    "vehicle.mesh.rpy_deg": "[roll, pitch, yaw] in degrees, each -1e6 to 1e6",
    "vehicle.mesh.offset": "[x, y, z] in metres, each -1e7 to 1e7",
    "keep_out": f"a list of at most {MAX_SPOTS} spots on the car's skin",
    "keep_out[]": "[x, y, z, radius] in metres, the radius 0.005 to 2",
    "sensors": f"a list of at most {MAX_SENSORS} sensors",
    "sensors[]": "a mapping with name, kind, position and the other fields of a sensor",
    "sensors[].name": "a text of 1 to 200 characters, unique in the file",
    "sensors[].model": "the name of an entry of the sensor library",
    "sensors[].position": "[x, y, z] in metres, each -1e7 to 1e7",
    "sensors[].rpy_deg": "[roll, pitch, yaw] in degrees, each -1e6 to 1e6",
    "sensors[].range_m": "[min, max] in metres with 0 <= min < max; max may be .inf",
    "sensors[].enabled": "true or false",
    "sensors[].mirror_of": "the name of another sensor of the same kind",
    "sensors[].fails_with": "a list of 1 to 16 names of what the sensor fails with",
}
"""What each field of a rig file accepts, in words; the keys are field paths without list indices. See `accepted`."""


def accepted(key: str) -> str | None:
    """Return what a field accepts, those of each kind of sensor included; None when there is no such field."""
    if key == "sensors[].kind":
        return " or ".join(kind_names())
    if key in ACCEPTED:
        return ACCEPTED[key]
    own = key.removeprefix("sensors[].")
    return next((kind.accepted[own] for kind in kinds() if own != key and own in kind.accepted), None)


def path_text(path: Path) -> str:
    """Return a field path in readable form: sensors[1].elevations_deg.count."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


def key_of(path: Path) -> str:
    """Return the key of a field path for `accepted`."""
    text = "".join("[]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


def field_path(loc: tuple[str | int, ...]) -> Path:
    """Return the path of the field that a pydantic location lies in, without union members and items."""
    path: Path = ()
    for part in loc:
        if accepted(key_of((*path, part))) is not None:
            path = (*path, part)
    return path


_LENSES: dict[object, type[BaseModel]] = {"brown_conrady": BrownConrady, "kannala_brandt": KannalaBrandt}


@dataclass(frozen=True)
class Problem:
    """What is wrong, and in which line of the file."""

    line: int
    text: str


def first_of(problems: list[Problem], where: str) -> str:
    """Return one line about the first problem in the file, with the number of further ones."""
    first, *others = sorted(problems, key=lambda problem: problem.line)
    more = f" (and {len(others)} more)" if others else ""
    return f"{where}:{first.line}: {first.text}{more}"


def key_problems(root: Mapping) -> Iterable[Problem]:
    """Yield the unknown keys of the document, the vehicle, the sensors and their angles."""
    yield from _unknown_keys(root, (), Rig)
    vehicle = root.get("vehicle")
    yield from _unknown_keys(vehicle, ("vehicle",), Vehicle)
    if isinstance(vehicle, Mapping):
        yield from _unknown_keys(vehicle.get("mesh"), ("vehicle", "mesh"), MeshPlacement)
    for index, sensor in _sensor_nodes(root):
        path: Path = ("sensors", index)
        kind = _scalar(sensor.get("kind"))
        known = kind_named(kind)
        if known is not None:
            yield from _unknown_keys(sensor, path, known.model)
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
    known += Rig.OTHER_SPELLINGS if model is Rig else ()
    for key, _ in node.entries:
        if key.text not in known:
            close = difflib.get_close_matches(key.text, known, n=1)
            hint = f"did you mean '{close[0]}'? " if close else ""
            accepted = f"unknown field; {hint}accepted are {', '.join(known)}"
            yield Problem(key.line, f"{path_text((*path, shortened(key.text)))}: {accepted}")


def sensor_problems(root: Mapping) -> Iterable[Problem]:
    """Yield what concerns a sensor beyond its own fields: kind, library model, names used twice."""
    lines: dict[str, int] = {}
    for index, sensor in _sensor_nodes(root):
        path = path_text(("sensors", index))
        yield from _name_problems(sensor, path, lines)
        yield from _kind_problems(sensor, path)
        yield from _model_problems(sensor, path)
    yield from _mirror_problems(_sensor_nodes(root))


def _mirror_problems(sensors: list[tuple[int, Mapping]]) -> Iterable[Problem]:
    """Yield a `mirror_of` that makes no pair; the other fields are judged elsewhere."""
    said: list[tuple[str, str, str | None]] = []
    for _, sensor in sensors:
        name, kind, other = (_scalar(sensor.get(key)) for key in ("name", "kind", "mirror_of"))
        if isinstance(name, str) and (other is None or isinstance(other, str)):
            said.append((name, str(kind), other))
    if len(said) == len(sensors):
        problem = mirror_problem(said)
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
    kind, names = sensor.get("kind"), accepted("sensors[].kind")
    if kind is None:
        yield Problem(sensor.line, f"{path}.kind: missing; accepted is {names}")
    elif kind_named(_scalar(kind)) is None:
        yield Problem(kind.line, f"{path}.kind: found {found_text(kind)}; accepted is {names}")


def _model_problems(sensor: Mapping, path: str) -> Iterable[Problem]:
    node = sensor.get("model")
    model = _scalar(node)
    if node is not None and isinstance(model, str):
        complaint = model_complaint(model, _scalar(sensor.get("kind")))
        if complaint:
            yield Problem(node.line, f"{path}.{complaint}")


def model_complaint(model: str | None, kind: object) -> str:
    """Return why a sensor of that kind cannot be of that library model ("model: ..."); empty when it can."""
    if model is None:
        return ""
    library = default_library()
    try:
        entry = library.entry(model)
    except InputError as error:
        return str(error)
    if kind_named(kind) is None or entry.kind == kind:
        return ""
    hint = f"`riglens library --kind {kind}` lists the models of a {kind}"
    return f"model: found '{model}', a {entry.kind}, but this sensor is a {kind}; {hint}"


def found_text(node: Node) -> str:
    """Return what stands in the file, shortened."""
    if isinstance(node, Scalar) and node.start == node.end:
        return "nothing"
    value = plain_value(node)
    if isinstance(node, Scalar) and node.plain:
        return shortened(node.text)
    return shortened(value_text(value))


def _scalar(node: Node | None) -> Plain:
    return plain_value(node) if isinstance(node, Scalar) else None


def _sensor_nodes(root: Mapping) -> list[tuple[int, Mapping]]:
    """Return the sensors of the document that are mappings, with their place in the list."""
    sensors = root.get("sensors")
    items = sensors.items if isinstance(sensors, Sequence) else ()
    return [(index, item) for index, item in enumerate(items) if isinstance(item, Mapping)]


_LONG_LIST = 6


def rig_from_nodes(root: Node, where: str) -> Rig:
    """Return the rig that a document describes; fields that a sensor omits come from its library model.

    Raise InputError `file:line: field: found ...; accepted is ...` for the first problem in the file, with
    the number of further ones.
    """
    if not isinstance(root, Mapping):
        raise InputError(f"{where}:{root.line}: found {found_text(root)}; accepted is {ACCEPTED['']}")
    _check_version(root, where)
    problems = [*key_problems(root), *sensor_problems(root)]
    if not problems:
        try:
            return Rig.model_validate(_completed(root))
        except ValidationError as error:
            problems = list(_validation_problems(root, error))
    raise InputError(first_of(problems, where))


def check_rig(rig: Rig) -> Rig:
    """Validate a rig again (drags do not) and make its numbers plain floats; an InputError names the field."""
    try:
        checked = Rig.model_validate(plain_fields(rig))
    except ValidationError as error:
        details = error.errors()[0]
        path = field_path(details["loc"])
        if details["type"] == "value_error":
            message = str(details["ctx"]["error"])
        else:
            message = (
                f"found {shortened(value_text(_value_at(rig, path)))}; accepted is {accepted(key_of(path))}"
            )
        raise InputError(f"{path_text(path) or 'rig'}: {message}") from error
    for index, sensor in enumerate(checked.sensors):
        complaint = model_complaint(sensor.model, sensor.kind)
        if complaint:
            raise InputError(f"sensors[{index}].{complaint}")
    return checked


def _check_version(root: Mapping, where: str) -> None:
    node = root.get("riglens")
    if node is None:
        raise InputError(f"{where}:{root.line}: riglens: missing; accepted is 'riglens: {FORMAT_VERSION}'")
    version = plain_value(node)
    if not isinstance(version, int) or isinstance(version, bool):
        raise InputError(
            f"{where}:{node.line}: riglens: found {found_text(node)}; accepted is {ACCEPTED['riglens']}"
        )
    if version > FORMAT_VERSION:
        raise InputError(
            f"{where}:{node.line}: riglens: found format version {shortened(str(version))}, "
            f"newer than this program reads; accepted is {FORMAT_VERSION}; please update RigLens"
        )


def _completed(root: Mapping) -> dict[str, Plain]:
    """Return the values of the document, sensors completed from the library."""
    values = plain_mapping(root)
    sensors = values.get("sensors")
    if isinstance(sensors, tuple):
        values["sensors"] = tuple(
            supplied_fields(sensor) | sensor if isinstance(sensor, dict) else sensor for sensor in sensors
        )
    return values


def _validation_problems(root: Mapping, error: ValidationError) -> Iterable[Problem]:
    seen: set[Path] = set()
    for details in error.errors():
        path = field_path(details["loc"])
        node, is_there = _node_at(root, path)
        angles, _ = _node_at(root, path[:3])  # sensors, index, elevations_deg or azimuths_deg
        if path in seen or _is_other_way_to_say_angles(details["loc"], angles):
            continue
        seen.add(path)
        if details["type"] == "value_error":
            yield _rule_problem(path, node, str(details["ctx"]["error"]))
        elif is_there:
            place, inner = _exact_place(path, node, details["loc"])
            yield Problem(
                inner.line, f"{place}: found {found_text(inner)}; accepted is {accepted(key_of(path))}"
            )
        else:
            yield Problem(node.line, f"{path_text(path)}: missing; accepted is {accepted(key_of(path))}")


def _rule_problem(path: Path, node: Node, message: str) -> Problem:
    """Return the problem with a rule over several fields, at the field that its message starts with, if present."""
    field = message.split()[0]
    if isinstance(node, Mapping) and (value := node.get(field)) is not None:
        return Problem(value.line, f"{path_text((*path, field))}: {message}")
    return Problem(node.line, f"{path_text(path)}: {message}")


def _is_other_way_to_say_angles(loc: tuple[str | int, ...], node: Node) -> bool:
    """Return whether a complaint only says that a mapping of angles is not a list or vice versa, which helps nobody."""
    other = "tuple[" if isinstance(node, Mapping) else "EvenAngles" if isinstance(node, Sequence) else None
    return other is not None and any(other in str(part) for part in loc)


def _node_at(root: Mapping, path: Path) -> tuple[Node, bool]:
    """Return the node of a field and True, or the nearest node around it and False when there is none."""
    node: Node = root
    for part in path:
        inner: Node | None = None
        if isinstance(part, int) and isinstance(node, Sequence) and part < len(node.items):
            inner = node.items[part]
        elif isinstance(part, str) and isinstance(node, Mapping):
            inner = node.get(part)
        if inner is None:
            return node, False
        node = inner
    return node, True


def _exact_place(path: Path, node: Node, loc: tuple[str | int, ...]) -> tuple[str, Node]:
    """Return the field as a whole, or the wrong number alone when it stands in a long list."""
    last = loc[-1]
    if isinstance(node, Sequence) and isinstance(last, int) and len(node.items) > _LONG_LIST:
        return path_text((*path, last)), node.items[last]
    return path_text(path), node


def _value_at(rig: Rig, path: Path) -> object:
    value: Any = plain_fields(rig)
    for part in path:
        value = value[part]
    return value
