"""YAML of a user's own as checked data: limits as for rig files, and one line that says where a file is wrong."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from riglens.core.errors import InputError
from riglens.core.rig.yaml.nodes import (
    Mapping,
    Node,
    Sequence,
    parse_yaml,
    plain_mapping,
    read_text,
    shortened,
    shown_path,
)
from riglens.core.rig.yaml.text import value_text

M = TypeVar("M", bound=BaseModel)
Location = tuple[str | int, ...]
Problem = tuple[Location, str]
"""A place in a document, and what is wrong there."""


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
    """As `read_checked`, from a text; `where` names it in messages, `problems` finds what the model cannot."""
    root = parse_yaml(text, where)
    if not isinstance(root, Mapping):
        raise InputError(f"{where}:{root.line}: found no mapping, accepted is {accepted}")
    try:
        found = model.model_validate(plain_mapping(root))
    except ValidationError as error:
        raise InputError(f"{where}:{_complaint(root, model, error)}") from error
    for place, message in problems(found):
        path, node = _place(root, place)
        raise InputError(f"{where}:{node.line}: {path}: {message}")
    return found


def line_of(text: str, place: Location) -> int:
    """Return the line of a place in a text that has been checked."""
    return _place(parse_yaml(text, ""), place)[1].line


def _complaint(root: Mapping, model: type[BaseModel], error: ValidationError) -> str:
    """Line, field and what is wrong with it; an unknown key first, for it may be why another one is missing."""
    errors = error.errors()
    found = next((one for one in errors if one["type"] == "extra_forbidden"), errors[0])
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    if found["type"] == "extra_forbidden":
        return _unknown_key(root, model, found["loc"]) + more
    path, node = _place(root, found["loc"])
    message = shortened(str(found["msg"]), 200)
    value = "" if isinstance(found["input"], dict) else f"found {shortened(value_text(found['input']))}, "
    if found["type"] == "missing":
        value = ""
    return f"{node.line}: {shortened(path) or 'file'}: {value}{message}{more}"


def _unknown_key(root: Mapping, model: type[BaseModel], location: Location) -> str:
    *above, key = location
    path, node = _place(root, tuple(above))
    for part in above:
        if isinstance(part, str):
            model = _model_of(model, part)
    known = [str(info.alias or name) for name, info in model.model_fields.items()]
    close = difflib.get_close_matches(str(key), known, n=1)
    hint = f"did you mean '{close[0]}'?" if close else f"known keys: {', '.join(known)}"
    line = node.key(str(key)).line if isinstance(node, Mapping) else node.line
    return f"{line}: {shortened(path + '.' if path else '')}{shortened(str(key))}: unknown key ({hint})"


def _model_of(model: type[BaseModel], key: str) -> type[BaseModel]:
    """The model of what a key of a model holds; the model itself where the key holds none."""
    for name, info in model.model_fields.items():
        if key in (name, info.alias):
            return next(_models_in(info.annotation), model)
    return model


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models_in(part)


def _place(root: Node, location: Location) -> tuple[str, Node]:
    """The path of a field in words, and the node that stands there or nearest above it."""
    path, node = "", root
    for part in location:
        if isinstance(part, int) and isinstance(node, Sequence) and part < len(node.items):
            path, node = f"{path}[{part}]", node.items[part]
        elif isinstance(part, str) and isinstance(node, Mapping) and node.get(part) is not None:
            path, node = f"{path}.{part}", node.get(part) or node
        elif isinstance(part, str) and isinstance(node, Mapping):
            path = f"{path}.{part}"
    return path.removeprefix("."), node
