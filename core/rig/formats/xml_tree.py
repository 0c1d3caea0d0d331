"""XML as a small tree of elements, without entities, document types or deep nesting."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from riglens.core.errors import InputError
from riglens.core.rig.yaml_nodes import shortened

MAX_DEPTH = 60
MAX_ELEMENTS = 50_000


@dataclass
class Element:
    """An element with its attributes, children and text; `line` from 1."""

    tag: str
    attributes: dict[str, str]
    line: int
    where: str
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def all(self, tag: str) -> Iterator[Element]:
        """The children of that tag."""
        return (child for child in self.children if child.tag == tag)

    def first(self, *path: str) -> Element | None:
        """The first child of that tag, its first child of the next, and so on; None when there is none."""
        found: Element | None = self
        for tag in path:
            found = next(found.all(tag), None) if found is not None else None
        return found

    def attribute(self, name: str) -> str:
        """An attribute that must be there."""
        if name not in self.attributes:
            raise self.error(f"attribute '{name}' is missing")
        return self.attributes[name]

    def error(self, complaint: str) -> InputError:
        """What is wrong with this element, with file and line."""
        return InputError(f"{self.where}:{self.line}: <{shortened(self.tag, 40)}>: {complaint}")


class _Builder:
    """Expat's callbacks."""

    def __init__(self, where: str) -> None:
        self._where = where
        self._stack: list[Element] = []
        self._count = 0
        self.root: Element | None = None
        self.parser = expat.ParserCreate("utf-8")
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._data
        self.parser.StartDoctypeDeclHandler = self._doctype
        self.parser.EntityDeclHandler = self._entity

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._count += 1
        line = self.parser.CurrentLineNumber
        if len(self._stack) >= MAX_DEPTH:
            raise InputError(f"{self._where}:{line}: nested more than {MAX_DEPTH} levels deep")
        if self._count > MAX_ELEMENTS:
            raise InputError(f"{self._where}:{line}: more than {MAX_ELEMENTS} elements")
        element = Element(tag, attributes, line, self._where)
        if self._stack:
            self._stack[-1].children.append(element)
        else:
            self.root = element
        self._stack.append(element)

    def _end(self, _: str) -> None:
        self._stack.pop()

    def _data(self, text: str) -> None:
        self._stack[-1].text += text

    def _doctype(self, *_: object) -> None:
        raise InputError(f"{self._where}:{self.parser.CurrentLineNumber}: document types are not accepted")

    def _entity(self, *_: object) -> None:
        raise InputError(f"{self._where}:{self.parser.CurrentLineNumber}: entities are not accepted")


def parse_xml(text: str, where: str) -> Element:
    """The root element; InputError `file:line: ...` for text that is not XML, or XML that could do harm."""
    builder = _Builder(where)
    try:
        builder.parser.Parse(text.encode("utf-8"), True)
    except expat.ExpatError as error:
        problem = expat.ErrorString(error.code)
        raise InputError(f"{where}:{error.lineno}: not valid XML: {problem}") from error
    assert builder.root is not None
    return builder.root
