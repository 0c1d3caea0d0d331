"""YAML of a user's own as checked data: limits as for rig files, and one line that says where a file is wrong."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TypeVar

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


def read_checked(path: str | os.PathLike[str], model: type[M], accepted: str) -> M:
    """Return the one document of a file as a model; InputError `file:line: field: what is wrong`.

    `accepted` describes in messages what the file should have been.
    """
    return checked(read_text(Path(path), accepted), model, accepted, shown_path(path))


def checked(text: str, model: type[M], accepted: str, where: str) -> M:
    """As `read_checked`, from a text; `where` names it in messages."""
    root = parse_yaml(text, where)
    if not isinstance(root, Mapping):
        raise InputError(f"{where}:{root.line}: found no mapping, accepted is {accepted}")
    try:
        return model.model_validate(plain_mapping(root))
    except ValidationError as error:
        found = error.errors()[0]
        path, node = _place(root, found["loc"])
        more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
        message = shortened(str(found["msg"]), 200)
        value = "" if isinstance(found["input"], dict) else f"found {shortened(value_text(found['input']))}, "
        if found["type"] == "missing":
            value = ""
        raise InputError(
            f"{where}:{node.line}: {shortened(path) or 'file'}: {value}{message}{more}"
        ) from error


def _place(root: Node, location: tuple[str | int, ...]) -> tuple[str, Node]:
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
