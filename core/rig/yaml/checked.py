"""Read users' YAML as checked data: limits as for rig files, and one line that locates an error."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError
from ruamel.yaml.nodes import MappingNode

from riglens.core.errors import InputError
from riglens.core.rig.yaml import nodes
from riglens.core.rig.yaml.nodes import parse_yaml, plain_value, read_text, shown_path
from riglens.core.rig.yaml.problems import first_problem, path_text
from riglens.core.rig.yaml.problems import problems as problems_of

M = TypeVar("M", bound=BaseModel)
Location = tuple[str | int, ...]
Problem = tuple[Location, str]
"""A place in a document, and the problem there."""


def read_checked(path: str | os.PathLike[str], model: type[M], accepted: str) -> M:
    """Return the one document of a file as a model; InputError `file:line: field: what is wrong`.

    `accepted` describes in messages what the file should have been.
    """
    return checked(read_text(Path(path), accepted), model, accepted, shown_path(path))


def _none(_: object) -> Iterable[Problem]:
    return ()


def checked(
    text: str, model: type[M], accepted: str, where: str, problems: Callable[[M], Iterable[Problem]] = _none
) -> M:
    """Check a text as `read_checked` does; `where` names it in messages, `problems` finds errors beyond the model."""
    root = parse_yaml(text, where)
    data = plain_value(root)
    if not isinstance(root, MappingNode):
        raise InputError(f"{where}:{nodes.line_of(root, ())}: must be {accepted}, a mapping")
    try:
        found = model.model_validate(data)
    except ValidationError as error:
        raise first_problem(problems_of(error, data), data, root, where) from error
    for place, message in problems(found):
        raise InputError(f"{where}:{nodes.line_of(root, place)}: {path_text(place)}: {message}")
    return found


def line_of(text: str, place: Location) -> int:
    """Return the line of a place in a text that has been checked."""
    return nodes.line_of(parse_yaml(text, ""), place)
