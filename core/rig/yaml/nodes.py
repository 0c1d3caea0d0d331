"""YAML text as ruamel's nodes, which know their places in it, and plain values as YAML text.

Only plain data is accepted: scalars, lists and mappings. Tags, anchors and aliases are refused (they build
objects or blow up a small file), and so are duplicate keys, deep nesting and very large or very full files.
Numbers are those of the YAML 1.2 core schema; they read back to the same bits, and strings to themselves.
"""

from __future__ import annotations

import gzip
import math
import os
import re
import zlib
from collections.abc import Mapping
from typing import Any, NoReturn, TypeAlias

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import AliasEvent
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

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
Path: TypeAlias = "tuple[str | int, ...]"
"""Keys and list indices that lead to a value of a document."""

_WORDS: dict[str, Plain] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((f"{sign}.{word}" for sign in ("", "+") for word in ("inf", "Inf", "INF")), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), float("-inf")),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}


def parse_yaml(text: str, where: str) -> Node:
    """Return the one document of a YAML text; `where` is the name of the file in messages.

    Raise InputError `file:line: ...` for text that is not YAML or uses features that this format excludes.
    """
    if len(text) > MAX_BYTES:
        raise InputError(f"{where}: must have at most {MAX_BYTES} characters (got {len(text)})")
    if tag := _LONG_TAG.search(text):
        line = text.count("\n", 0, tag.start()) + 1
        raise InputError(f"{where}:{line}: tags are not accepted (got {shortened(tag[0])})")
    yaml = YAML(typ="base", pure=True)
    yaml.Composer = _PlainComposer
    try:
        root: Node | None = yaml.compose(text)
    except _NotPlain as error:
        raise InputError(f"{where}:{error.problem_mark.line + 1}: {error.problem}") from error
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        problem = ", ".join(filter(None, (error.context, error.problem)))
        raise InputError(
            f"{where}:{mark.line + 1 if mark else 1}: not valid YAML: {_one_line(problem)}"
        ) from error
    except YAMLError as error:
        line = text.count("\n", 0, getattr(error, "position", 0)) + 1
        raise InputError(
            f"{where}:{line}: not valid YAML: {_one_line(getattr(error, 'reason', error))}"
        ) from error
    if root is None:
        raise InputError(f"{where}:1: the file is empty")
    return root


class _NotPlain(MarkedYAMLError):
    """More than plain data, or more of it than the limits."""


class _PlainComposer(Composer):
    """Composer that stops at the first value that is not plain data, before the parser has read on."""

    count = 0

    def compose_document(self) -> Any:
        event = self.parser.peek_event()
        if event.version not in (None, (1, 2), [1, 2]) or event.tags:
            _refuse(event, "YAML directives (%) are not accepted, except '%YAML 1.2'")
        return super().compose_document()

    def compose_node(self, parent: Any, index: Any) -> Any:
        event = self.parser.peek_event()
        if isinstance(event, AliasEvent) or event.anchor is not None:
            _refuse(event, "anchors and aliases (& and *) are not accepted; write the values out")
        if event.tag is not None:
            _refuse(event, f"tags are not accepted (got {shortened(str(event.tag))})")
        self.count += 1
        if self.count > MAX_VALUES:
            _refuse(event, f"more than {MAX_VALUES} values")
        if self.depth > MAX_DEPTH:
            _refuse(event, f"nested more than {MAX_DEPTH} levels deep")
        return super().compose_node(parent, index)

    def compose_scalar_node(self, anchor: Any) -> Any:
        node = super().compose_scalar_node(anchor)
        if any("\ud800" <= character <= "\udfff" for character in node.value):
            _refuse(node, f"text must consist of whole characters (got {shortened(node.value)})")
        return node

    def compose_mapping_node(self, anchor: Any) -> Any:
        node = super().compose_mapping_node(anchor)
        lines: dict[str, int] = {}
        for key, _ in node.value:
            if not isinstance(key, ScalarNode):
                _refuse(key, "a key must be a word, not a list or a mapping")
            if key.value in lines:
                _refuse(key, f"key {shortened(key.value)} is given twice, first in line {lines[key.value]}")
            lines[key.value] = key.start_mark.line + 1
        return node


def _refuse(piece: Any, complaint: str) -> NoReturn:
    raise _NotPlain(problem=complaint, problem_mark=piece.start_mark)


def plain_value(node: Node) -> Plain:
    """Return the value of a node: None, bool, int, float, str, tuple or dict (YAML 1.2 core schema)."""
    if isinstance(node, ScalarNode):
        return str(node.value) if node.style else scalar_value(node.value)
    if isinstance(node, SequenceNode):
        return tuple(map(plain_value, node.value))
    return {key.value: plain_value(value) for key, value in node.value}


def scalar_value(text: str) -> Plain:
    """Return the value of an unquoted word: None, bool, int, float or the word itself."""
    if text in _WORDS:
        return _WORDS[text]
    if _INT.fullmatch(text):
        return int(text) if len(text) <= 300 else float(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    return text


def entries_of(node: Node | None) -> dict[str, tuple[Node, Node]]:
    """Return the nodes of keys and values of a mapping by the keys' words; nothing for any other node."""
    return {key.value: (key, value) for key, value in node.value} if isinstance(node, MappingNode) else {}


def line_of(root: Node, path: Path) -> int:
    """Return the line of a value, from 1: that of its key or its list item; for a missing one, that around it."""
    place = node = root
    for part in path:
        if isinstance(part, str) and part in (entries := entries_of(node)):
            place, node = entries[part]
        elif isinstance(part, int) and isinstance(node, SequenceNode) and part < len(node.value):
            place = node = node.value[part]
        else:
            break
    return int(place.start_mark.line) + 1


_WORD = re.compile(r"[A-Za-z_]([A-Za-z0-9_+./ -]*[A-Za-z0-9_+./-])?")
_OLD_YAML_BOOLS = frozenset(("y", "n", "yes", "no", "on", "off"))


def value_text(value: object) -> str:
    """Return a value in one line of YAML (flow style)."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {value_text(item)}" for key, item in value.items()) + "}"
    if isinstance(value, tuple):
        return "[" + ", ".join(value_text(item) for item in value) + "]"
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    return _number(value) if isinstance(value, float) else _string(str(value))


def _number(value: float) -> str:
    if math.isnan(value):
        return ".nan"
    if math.isinf(value):
        return ".inf" if value > 0 else "-.inf"
    text = float.__repr__(value)
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


def _string(value: str) -> str:
    is_word = _WORD.fullmatch(value) and "  " not in value and value.lower() not in _OLD_YAML_BOOLS
    if is_word and isinstance(scalar_value(value), str):
        return value
    return '"' + "".join(_escaped(character) for character in value) + '"'


def _escaped(character: str) -> str:
    if character in '"\\':
        return "\\" + character
    if character.isprintable():
        return character
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def shortened(text: str, limit: int = 60) -> str:
    """Return a piece of a file on one line, quoted when it is not printable, truncated when it is long."""
    flat = " ".join(text.split())
    if not flat.isprintable():
        flat = repr(flat)
    return flat if len(flat) <= limit else flat[: limit - 3] + "..."


def _one_line(problem: object) -> str:
    return shortened(str(problem), 200)


def read_text(
    path: str | os.PathLike[str], accepted: str, limit: int = MAX_BYTES, is_packed: bool = False
) -> str:
    """Return the text of a file; raise InputError when it is missing, unreadable, too large or not text.

    `accepted` describes in messages what the file should have been: "a rig YAML file"; `is_packed`: whether it is
    gzip-compressed.
    """
    where = shown_path(path)
    content = _content(path, where, accepted, limit, is_packed)
    if b"\0" in content:
        raise InputError(f"{where}: must be {accepted} in UTF-8 (got a file that is not text)")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        found = f"got byte 0x{content[error.start]:02x}"
        raise InputError(f"{where}:{line}: must be UTF-8 text ({found})") from error


def shown_path(path: str | os.PathLike[str]) -> str:
    """Return a path on one line, for messages."""
    return shortened(os.fspath(path), 200)


def _content(path: str | os.PathLike[str], where: str, accepted: str, limit: int, is_packed: bool) -> bytes:
    try:
        with open_regular(path, accepted) as file, gzip.open(file) if is_packed else file as stream:
            content: bytes = stream.read(limit + 1)
    except FileNotFoundError as error:
        raise InputError(f"{where}: no such file") from error
    except IsADirectoryError as error:
        raise InputError(f"{where}: must be {accepted} (got a folder)") from error
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise InputError(f"{where}: not a complete gzip file") from error
    except OSError as error:
        raise InputError(f"{where}: cannot be read: {error.strerror or error}") from error
    if len(content) > limit:
        raise InputError(f"{where}: too large for {accepted} (at most {limit / 1e6:g} MB)")
    return content
