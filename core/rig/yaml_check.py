"""From YAML nodes to a valid rig, or to one line that says where the file is wrong and what is accepted."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic import ValidationError

from riglens.core.errors import InputError
from riglens.core.rig.library import supplied_fields
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml_fields import ACCEPTED, Path, field_path, key_of, path_text
from riglens.core.rig.yaml_nodes import Mapping, Node, Sequence, plain_value, shortened
from riglens.core.rig.yaml_problems import (
    Problem,
    first_of,
    found_text,
    key_problems,
    model_complaint,
    sensor_problems,
)
from riglens.core.rig.yaml_text import plain_fields, value_text

_LONG_LIST = 6


def rig_from_nodes(root: Node, where: str) -> Rig:
    """The rig that a document describes; fields that a sensor leaves out come from its library model.

    Raises InputError `file:line: field: found ...; accepted is ...` for the first problem in the file, with
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
    """A rig validated again (drags do not validate), numbers as plain floats; InputError names the field."""
    try:
        checked = Rig.model_validate(plain_fields(rig))
    except ValidationError as error:
        details = error.errors()[0]
        path = field_path(details["loc"])
        if details["type"] == "value_error":
            message = str(details["ctx"]["error"])
        else:
            message = (
                f"found {shortened(value_text(_value_at(rig, path)))}; accepted is {ACCEPTED[key_of(path)]}"
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


def _completed(root: Mapping) -> dict[str, Any]:
    """The values of the document, sensors completed from the library."""
    values: dict[str, Any] = plain_value(root)
    if isinstance(values.get("sensors"), tuple):
        values["sensors"] = tuple(
            supplied_fields(sensor) | sensor if isinstance(sensor, dict) else sensor
            for sensor in values["sensors"]
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
                inner.line, f"{place}: found {found_text(inner)}; accepted is {ACCEPTED[key_of(path)]}"
            )
        else:
            yield Problem(node.line, f"{path_text(path)}: missing; accepted is {ACCEPTED[key_of(path)]}")


def _rule_problem(path: Path, node: Node, message: str) -> Problem:
    """A rule over several fields; it stands at the field that its message starts with, if the file has it."""
    field = message.split()[0]
    if isinstance(node, Mapping) and (value := node.get(field)) is not None:
        return Problem(value.line, f"{path_text((*path, field))}: {message}")
    return Problem(node.line, f"{path_text(path)}: {message}")


def _is_other_way_to_say_angles(loc: tuple[str | int, ...], node: Node) -> bool:
    """Angles are a mapping or a list; a complaint that one is not the other helps nobody."""
    other = "tuple[" if isinstance(node, Mapping) else "EvenAngles" if isinstance(node, Sequence) else None
    return other is not None and any(other in str(part) for part in loc)


def _node_at(root: Mapping, path: Path) -> tuple[Node, bool]:
    """The node of a field and True, or the nearest node around it and False when there is none."""
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
    """The field as a whole, or the wrong number alone when it stands in a long list."""
    last = loc[-1]
    if isinstance(node, Sequence) and isinstance(last, int) and len(node.items) > _LONG_LIST:
        return path_text((*path, last)), node.items[last]
    return path_text(path), node


def _value_at(rig: Rig, path: Path) -> Any:
    value: Any = plain_fields(rig)
    for part in path:
        value = value[part]
    return value
