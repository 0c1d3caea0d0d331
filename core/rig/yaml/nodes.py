"""YAML text as nodes that know their position, read within the limits that untrusted files need.

Only plain data is accepted: scalars, lists and mappings. Tags, anchors and aliases are refused (they build
objects or blow up a small file), and so are duplicate keys, deep nesting and very large or very full files.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NoReturn, TypeAlias

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
)

from riglens.core.errors import InputError
from riglens.core.files import open_regular

MAX_BYTES = 1_000_000
MAX_VALUES = 100_000
"""Words, numbers, lists and mappings: two seconds of reading."""
MAX_DEPTH = 12

_LONG_TAG = re.compile(r"(?<![^\s,:\[{])!\S{200}")
"""The parser's time grows with the square of a tag's length."""
_INT = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
Plain: TypeAlias = "bool | int | float | str | tuple[Plain, ...] | dict[str, Plain] | None"
"""Plain data, as documents hold them."""

_WORDS: dict[str, Plain] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((f"{sign}.{word}" for sign in ("", "+") for word in ("inf", "Inf", "INF")), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), float("-inf")),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}


@dataclass(frozen=True)
class Node:
    """A piece of the text: characters [start, end), no trailing blanks; `line` from 1, `column` from 0."""

    start: int
    end: int
    line: int
    column: int


@dataclass(frozen=True)
class Scalar(Node):
    """A word, number or string; `plain` when it is written without quotes."""

    text: str
    plain: bool


@dataclass(frozen=True)
class Sequence(Node):
    """A list; `flow` when it is written in brackets."""

    items: tuple[Node, ...]
    flow: bool


@dataclass(frozen=True)
class Mapping(Node):
    """Keys and values in the order of the text; `flow` when it is written in braces."""

    entries: tuple[tuple[Scalar, Node], ...]
    flow: bool

    def get(self, key: str) -> Node | None:
        """Return the value of that key, None when the mapping has no such key."""
        return next((value for name, value in self.entries if name.text == key), None)

    def key(self, key: str) -> Scalar:
        """Return the node of that key; raise KeyError when the mapping has no such key."""
        for name, _ in self.entries:
            if name.text == key:
                return name
        raise KeyError(key)


def parse_yaml(text: str, where: str) -> Node:
    """Return the one document of a YAML text; `where` is the name of the file in messages.

    Raise InputError `file:line: ...` for text that is not YAML or uses features that this format excludes.
    """
    if len(text) > MAX_BYTES:
        raise InputError(f"{where}: {len(text)} characters, accepted are at most {MAX_BYTES}")
    if tag := _LONG_TAG.search(text):
        line = text.count("\n", 0, tag.start()) + 1
        raise InputError(f"{where}:{line}: tags are not accepted, found {shortened(tag[0])}")
    try:
        return _NodeBuilder(text, where).document()
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = mark.line + 1 if mark else 1
        raise InputError(
            f"{where}:{line}: not valid YAML: {_one_line(error.problem or error.context)}"
        ) from error
    except YAMLError as error:
        line = text.count("\n", 0, getattr(error, "position", 0)) + 1
        raise InputError(
            f"{where}:{line}: not valid YAML: {_one_line(getattr(error, 'reason', error))}"
        ) from error


def plain_value(node: Node) -> Plain:
    """Return the value of a node: None, bool, int, float, str, tuple or dict (YAML 1.2 core schema)."""
    if isinstance(node, Scalar):
        return scalar_value(node.text) if node.plain else node.text
    if isinstance(node, Sequence):
        return tuple(plain_value(item) for item in node.items)
    assert isinstance(node, Mapping)
    return plain_mapping(node)


def plain_mapping(node: Mapping) -> dict[str, Plain]:
    """Return the values of a mapping by their keys, as `plain_value` gives them."""
    return {key.text: plain_value(value) for key, value in node.entries}


def scalar_value(text: str) -> Plain:
    """Return the value of an unquoted word: None, bool, int, float or the word itself."""
    if text in _WORDS:
        return _WORDS[text]
    if _INT.fullmatch(text):
        return int(text) if len(text) <= 300 else float(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    return text


class _NodeBuilder:
    """Turns the parser's events into nodes; stops at the first thing that is not plain data."""

    def __init__(self, text: str, where: str) -> None:
        self._text, self._where, self._count = text, where, 0
        self._events: Iterator[Event] = iter(YAML(typ="safe", pure=True).parse(text))

    def document(self) -> Node:
        root: Node | None = None
        for event in self._events:
            if isinstance(event, DocumentStartEvent):
                self._check_document(event, is_first=root is None)
                root = self._node(next(self._events), depth=0)
        if root is None:
            raise InputError(
                f"{self._where}:1: the file is empty; accepted is a mapping that starts with 'riglens: 1'"
            )
        return root

    def _check_document(self, event: DocumentStartEvent, is_first: bool) -> None:
        if not is_first:
            self._refuse(event, "a second YAML document ('---') is not accepted; one file holds one document")
        if event.version not in (None, (1, 2), [1, 2]) or event.tags:
            self._refuse(event, "YAML directives (%) are not accepted, except '%YAML 1.2'")

    def _node(self, event: Event, depth: int) -> Node:
        if isinstance(event, AliasEvent) or getattr(event, "anchor", None) is not None:
            self._refuse(event, "anchors and aliases (& and *) are not accepted; write the values out")
        if (tag := getattr(event, "tag", None)) is not None:
            self._refuse(event, f"tags are not accepted, found {shortened(str(tag))}")
        self._count += 1
        if self._count > MAX_VALUES:
            self._refuse(event, f"more than {MAX_VALUES} values")
        if depth > MAX_DEPTH:
            self._refuse(event, f"nested more than {MAX_DEPTH} levels deep")
        if isinstance(event, ScalarEvent):
            return self._scalar(event)
        if isinstance(event, SequenceStartEvent):
            return self._sequence(event, depth)
        assert isinstance(event, MappingStartEvent)
        return self._mapping(event, depth)

    def _scalar(self, event: ScalarEvent) -> Scalar:
        mark = event.start_mark
        end = mark.index + len(self._text[mark.index : event.end_mark.index].rstrip())
        plain = not event.style
        return Scalar(mark.index, end, mark.line + 1, mark.column, str(event.value), plain)

    def _sequence(self, event: SequenceStartEvent, depth: int) -> Sequence:
        items: list[Node] = []
        while not isinstance(following := next(self._events), SequenceEndEvent):
            items.append(self._node(following, depth + 1))
        mark, flow = event.start_mark, bool(event.flow_style)
        end = following.end_mark.index if flow or not items else items[-1].end
        return Sequence(mark.index, end, mark.line + 1, mark.column, tuple(items), flow)

    def _mapping(self, event: MappingStartEvent, depth: int) -> Mapping:
        entries: list[tuple[Scalar, Node]] = []
        lines: dict[str, int] = {}
        while not isinstance(following := next(self._events), MappingEndEvent):
            key = self._node(following, depth + 1)
            if not isinstance(key, Scalar):
                self._refuse(following, "a key must be a word, found a list or a mapping")
            if key.text in lines:
                self._refuse(
                    following, f"key {shortened(key.text)} is given twice, first in line {lines[key.text]}"
                )
            lines[key.text] = key.line
            entries.append((key, self._behind(key, self._node(next(self._events), depth + 1))))
        mark, flow = event.start_mark, bool(event.flow_style)
        end = following.end_mark.index if flow or not entries else entries[-1][1].end
        return Mapping(mark.index, end, mark.line + 1, mark.column, tuple(entries), flow)

    def _behind(self, key: Scalar, value: Node) -> Node:
        """Return a value at its right place: an empty one belongs behind its key's colon, not at the next word."""
        colon = self._text.find(":", key.end)
        if value.start == value.end and colon >= 0:
            return Scalar(colon + 1, colon + 1, key.line, key.column, "", plain=True)
        return value

    def _refuse(self, event: Event, complaint: str) -> NoReturn:
        raise InputError(f"{self._where}:{event.start_mark.line + 1}: {complaint}")


def shortened(text: str, limit: int = 60) -> str:
    """Return a piece of a file on one line, quoted when it is not printable, truncated when it is long."""
    flat = " ".join(text.split())
    if not flat.isprintable():
        flat = repr(flat)
    return flat if len(flat) <= limit else flat[: limit - 3] + "..."


def _one_line(problem: object) -> str:
    return shortened(str(problem), 200)


def read_text(path: str | os.PathLike[str], accepted: str) -> str:
    """Return the text of a file; raise InputError when it is missing, unreadable, too large or not text.

    `accepted` describes in messages what the file should have been: "a rig YAML file".
    """
    where = shown_path(path)
    content = _content(path, where, accepted)
    if b"\0" in content:
        raise InputError(f"{where}: not a text file; accepted is {accepted} in UTF-8")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        found = f"found byte 0x{content[error.start]:02x}"
        raise InputError(f"{where}:{line}: not UTF-8 text, {found}; accepted is UTF-8") from error


def shown_path(path: str | os.PathLike[str]) -> str:
    """Return a path on one line, for messages."""
    return shortened(os.fspath(path), 200)


def _content(path: str | os.PathLike[str], where: str, accepted: str) -> bytes:
    try:
        with open_regular(path, accepted) as stream:
            content = stream.read(MAX_BYTES + 1)
    except FileNotFoundError as error:
        raise InputError(f"{where}: no such file") from error
    except IsADirectoryError as error:
        raise InputError(f"{where}: this is a folder; accepted is {accepted}") from error
    except OSError as error:
        raise InputError(f"{where}: cannot be read: {error.strerror}") from error
    if len(content) > MAX_BYTES:
        raise InputError(f"{where}: larger than {MAX_BYTES / 1e6:g} MB; accepted is {accepted}")
    return content
