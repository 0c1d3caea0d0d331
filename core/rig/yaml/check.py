"""Turn a YAML document into a valid rig, or into one line that locates the error and states the remedy."""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import ValidationError
from ruamel.yaml.nodes import Node

from riglens.core.errors import InputError
from riglens.core.rig.library import default_library, supplied_fields
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.nodes import Plain, plain_value
from riglens.core.rig.yaml.problems import (
    Problem,
    at_named_field,
    first_problem,
    problem_text,
    problems,
    shown,
)
from riglens.core.rig.yaml.text import plain_fields
from riglens.core.sensors.registry import kind_named
from riglens.core.sensors.scan import READER, RayRows, Reader


def rig_from_nodes(root: Node, where: str, reader: Reader | None = None) -> Rig:
    """Return the rig that a document describes; fields that a sensor omits come from its library model.

    `reader` reads the files with rays that it names. Raise InputError `file:line: field must be ... (got ...)` for the
    first problem in the file, with the number of further ones.
    """
    data = plain_value(root)
    outcome = _version_problems(data) or _valid_rig(data, reader)
    if isinstance(outcome, list):
        raise first_problem(outcome, data, root, where)
    return outcome


def check_rig(rig: Rig) -> Rig:
    """Validate a rig again (drags do not) and make its numbers plain floats; an InputError names the field."""
    data = plain_fields(rig)
    outcome = _valid_rig(data, read_again(rig))
    if isinstance(outcome, list):
        raise InputError(problem_text(outcome[0], data))
    return outcome


def read_again(rig: Rig) -> Reader:
    """Return a reader of the files with rays that a rig has read."""
    known = {sensor.table.file: sensor.table for sensor in rig.sensors if sensor.table is not None}

    def read(file: str) -> RayRows:
        if file not in known:
            raise ValueError(f"file {file!r:.60} has not been read")
        return known[file].read_again(file)

    return read


def _version_problems(data: Plain) -> list[Problem]:
    """Return why this program cannot read a document; called before other checks."""
    if not isinstance(data, dict):
        expected = f"a rig must be a mapping that starts with 'riglens: {FORMAT_VERSION}'"
        return [Problem((), f": {expected} (got {shown(data)})")]
    if "riglens" not in data:
        return [Problem(("riglens",), f" is missing; a rig starts with 'riglens: {FORMAT_VERSION}'")]
    version = data["riglens"]
    if type(version) is not int or version < FORMAT_VERSION:
        return [Problem(("riglens",), f" must be {FORMAT_VERSION} (got {shown(version)})")]
    if version > FORMAT_VERSION:
        newer = f": format version {shown(version)} is newer than this program reads ({FORMAT_VERSION})"
        return [Problem(("riglens",), f"{newer}; please update RigLens")]
    return []


def _valid_rig(data: Plain, reader: Reader | None) -> Rig | list[Problem]:
    """Return the rig that plain data describe, or their problems."""
    assert isinstance(data, dict)
    sensors = data.get("sensors")
    if isinstance(sensors, tuple):
        unknown = list(_library_problems(sensors))
        if unknown:
            return unknown
        completed = (supplied_fields(s) | s if isinstance(s, dict) else s for s in sensors)
        data = data | {"sensors": tuple(completed)}
    try:
        return Rig.model_validate(data, by_alias=True, by_name=False, context={READER: reader})
    except ValidationError as error:
        return problems(error, data)


def _library_problems(sensors: tuple[Plain, ...]) -> Iterator[Problem]:
    for index, sensor in enumerate(sensors):
        complaint = _model_complaint(sensor) if isinstance(sensor, dict) else ""
        if complaint:
            yield at_named_field(("sensors", index), complaint, {"sensors": sensors})


def _model_complaint(sensor: dict[str, Plain]) -> str:
    """Return why a sensor cannot be of the library model that it names; empty when it can."""
    model, kind = sensor.get("model"), sensor.get("kind")
    if not isinstance(model, str):
        return ""
    try:
        entry = default_library().entry(model)
    except InputError as error:
        return str(error)
    if kind_named(kind) is None or entry.kind == kind:
        return ""
    hint = f"see the library's models of a {kind}"
    return f"model '{model}' is a {entry.kind}, but this sensor is a {kind}; {hint}"
