"""Turn pydantic's errors into sentences: field, fact, remedy."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

from pydantic import ValidationError
from ruamel.yaml.nodes import Node

from riglens.core.errors import InputError
from riglens.core.rig.yaml.nodes import Path, line_of, shortened, value_text

_PLAIN_WORDS = {
    **dict.fromkeys(("dict_type", "model_type", "model_attributes_type"), "a mapping"),
    **dict.fromkeys(("list_type", "tuple_type"), "a list"),
    **dict.fromkeys(("string_type", "string_unicode"), "a text"),
    "bool_type": "true or false",
    "int_type": "an integer",
}
"""Contents of a file in plain words, where pydantic speaks of Python's types."""
_PLAIN_RULES = {
    "be a valid ": "be a ",
    "greater than or equal to": "at least",
    "less than or equal to": "at most",
}
_MISSING, _UNKNOWN = " is missing", " is not a known field"
_SHAPES = ("must be a mapping", "must be a list")
_HEAD = re.compile(r"[A-Za-z_]\w*(?:\.\w+|\[\d+\])*")


@dataclass(frozen=True)
class Problem:
    """Problem with a value: the rest of a sentence that begins with its name, such as " must be a list"."""

    path: Path
    complaint: str


def problems(error: ValidationError, data: object) -> list[Problem]:
    """Return everything that pydantic found wrong with plain data, each field once."""
    found: dict[Path, list[str]] = {}
    for details in error.errors(include_url=False):
        problem = _problem(details, data)
        found.setdefault(problem.path, []).append(problem.complaint)
    around = {path[:length] for path in found for length in range(len(path))}
    # what is wrong inside a value explains what else is wrong with it: other members of a union, too few that fit
    return [
        Problem(path, _of_one_value(complaints, data, path))
        for path, complaints in found.items()
        if path not in around
    ]


def _of_one_value(complaints: list[str], data: object, path: Path) -> str:
    telling = [complaint for complaint in complaints if complaint.strip() not in _SHAPES]
    complaint = telling[0] if telling else " or ".join([complaints[0], *(c[9:] for c in complaints[1:])])
    is_there, value = _value_at(data, path)
    shows = is_there and complaint.startswith(" must ") and not re.search(r"found|\(got", complaint)
    return f"{complaint} (got {shown(value)})" if shows else complaint


def problem_text(problem: Problem, data: object) -> str:
    """Return the sentence about a problem: `lidar "roof": range_m must be a list (got 3)`."""
    owner, field = "", problem.path
    if problem.path[:1] == ("sensors",) and len(problem.path) > 1:
        owner, field = _sensor_name(data, problem.path[:2]), problem.path[2:]
    if not field:
        return f"{owner}{problem.complaint}" if owner else problem.complaint.lstrip(": ")
    return f"{owner}{': ' if owner else ''}{path_text(field)}{problem.complaint}"


def first_problem(found: Sequence[Problem], data: object, root: Node, where: str) -> InputError:
    """Return the error for the first problem in a file, `file:line: ...`, with the number of further ones."""
    lines = [line_of(root, problem.path) for problem in found]
    # in one line an unknown field comes first: it may be the reason why another is missing
    first = min(
        range(len(found)), key=lambda index: (lines[index], not found[index].complaint.startswith(_UNKNOWN))
    )
    more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
    return InputError(f"{where}:{lines[first]}: {problem_text(found[first], data)}{more}")


def at_named_field(path: Path, text: str, data: object) -> Problem:
    """Return the problem at the field that its text names first, as in "range_m must rise"."""
    head = match[0] if (match := _HEAD.match(text)) else ""
    inner = tuple(int(part) if part.isdecimal() else part for part in re.findall(r"\w+", head))
    if head and _value_at(data, path + inner)[0]:
        rest = shortened(text.removeprefix(head), 300)
        return Problem(path + inner, rest if rest.startswith(":") else f" {rest}")
    return Problem(path, f": {shortened(text, 300)}")


def path_text(path: Path) -> str:
    """Return a field path in readable form: sensors[1].elevations_deg.count."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{shortened(part)}" for part in path)
    return text.removeprefix(".")


def shown(value: object) -> str:
    """Return a value for a message."""
    return "nothing" if value is None else shortened(value_text(value))


def _problem(details: Any, data: object) -> Problem:
    path, kind, context = _path(details, data), details["type"], details.get("ctx", {})
    if kind == "value_error":
        return at_named_field(path, str(context["error"]), data)
    if kind == "unknown_field":
        return Problem((*path, context["field"]), f"{_UNKNOWN}{context['hint']}")
    if kind == "extra_forbidden":
        return Problem(path, _UNKNOWN)
    if kind == "missing":
        return Problem(path, _MISSING)
    if kind == "absent_field":
        return Problem((*path, context["field"]), _MISSING)
    if kind == "union_tag_not_found":
        return Problem((*path, context["discriminator"].strip("'")), _MISSING)
    if kind == "union_tag_invalid":
        accepted = context["expected_tags"].replace("'", "").replace(", ", " or ")
        return Problem((*path, context["discriminator"].strip("'")), f" must be {accepted}")
    if kind in _PLAIN_WORDS:
        return Problem(path, f" must be {_PLAIN_WORDS[kind]}")
    rule = re.sub(r"^\w+ should ", "must ", re.sub(" after validation.*", "", details["msg"]))
    for theirs, plain in _PLAIN_RULES.items():
        rule = rule.replace(theirs, plain)
    return Problem(path, f" {shortened(rule, 200)}")


def _path(details: Any, data: object) -> Path:
    """Return where in the data an error is, without pydantic's names of the members of unions."""
    path: Path = ()
    for place, part in enumerate(details["loc"], 1):
        is_missing = details["type"] == "missing" and place == len(details["loc"])
        if is_missing or _value_at(data, (*path, part))[0]:
            path = (*path, part)
    return path


def _value_at(data: object, path: Path) -> tuple[bool, object]:
    """Return whether there is such a value, and the value."""
    for part in path:
        is_item = isinstance(data, (tuple, list)) and isinstance(part, int) and part < len(data)
        if not is_item and not (isinstance(data, Mapping) and part in data):
            return False, None
        data = cast(Any, data)[part]
    return True, data


def _sensor_name(data: object, path: Path) -> str:
    _, sensor = _value_at(data, path)
    name, kind = (_value_at(sensor, (key,))[1] for key in ("name", "kind"))
    if not isinstance(name, str) or not name:
        return path_text(path)
    return f'{shortened(kind, 20) if isinstance(kind, str) else "sensor"} "{shortened(name)}"'
