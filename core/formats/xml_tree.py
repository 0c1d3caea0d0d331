"""An XML document as elements, of which each knows what was read; entities and document types are refused."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any
from xml.parsers import expat

from riglens.core.errors import InputError
from riglens.core.formats.unread import Unread
from riglens.core.rig.yaml.nodes import shortened

MAX_DEPTH = 60
MAX_ELEMENTS = 50_000


class Attributes(dict[str, str]):
    """Attributes of an element; `used` are those that were asked for by name."""

    def __init__(self, given: Mapping[str, str]) -> None:
        super().__init__(given)
        self.used: set[str] = set()

    def __getitem__(self, name: str) -> str:
        self.used.add(name)
        return super().__getitem__(name)

    def get(self, name: str, default: Any = None) -> Any:
        """Return the attribute of that name, or a default."""
        self.used.add(name)
        return super().get(name, default)


@dataclass
class Element:
    """An element with its attributes, children and the words of its text; `line` from 1."""

    tag: str
    attributes: Attributes
    line: int
    where: str
    children: list[Element] = field(default_factory=list)
    words: str = ""
    is_read: bool = False

    @property
    def text(self) -> str:
        """The text inside; the element counts as used from then on."""
        self.is_read = True
        return self.words

    @property
    def is_used(self) -> bool:
        """Use of its text, an attribute or anything inside."""
        return any(one.is_read or one.attributes.used & one.attributes.keys() for one in self.walk())

    def walk(self) -> Iterator[Element]:
        """Yield the element and all that are in it."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting.extend(element.children)

    def unread(self, parent: str) -> Iterator[Unread]:
        """Yield the attributes and elements inside that were not used; `parent` says what the element is of."""
        for name, value in self.attributes.items():
            if name not in self.attributes.used and not name.startswith("xmlns"):
                yield Unread(parent, name, shortened(value, 60))
        for child in self.children:
            if child.is_used:
                yield from child.unread(parent)
            else:
                parts = [f"{one.tag} {one.words.strip()}".strip() for one in child.walk() if one is not child]
                words = " ".join(child.words.split()) or "; ".join(parts)
                said = words or " ".join(child.attributes.values()) or "given"
                yield Unread(parent, child.tag, shortened(said, 60))

    def all(self, tag: str) -> Iterator[Element]:
        """Yield the children of that tag."""
        return (child for child in self.children if child.tag == tag)

    def first(self, *path: str) -> Element | None:
        """Return the first child of that tag, its first child of the next, and so on; None when there is none."""
        found: Element | None = self
        for tag in path:
            found = next(found.all(tag), None) if found is not None else None
        return found

    def attribute(self, name: str) -> str:
        """Return an attribute that must be there."""
        if name not in self.attributes:
            raise self.error(f"attribute '{name}' is missing")
        return self.attributes[name]

    def error(self, complaint: str) -> InputError:
        """Return an InputError about this element, with file and line."""
        return InputError(f"{self.where}:{self.line}: <{shortened(self.tag, 40)}>: {complaint}")


class _ElementBuilder:
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
        element = Element(tag, Attributes(attributes), line, self._where)
        if self._stack:
            self._stack[-1].children.append(element)
        else:
            self.root = element
        self._stack.append(element)

    def _end(self, _: str) -> None:
        self._stack.pop()

    def _data(self, text: str) -> None:
        self._stack[-1].words += text

    def _doctype(self, *_: object) -> None:
        raise InputError(f"{self._where}:{self.parser.CurrentLineNumber}: document types are not accepted")

    def _entity(self, *_: object) -> None:
        raise InputError(f"{self._where}:{self.parser.CurrentLineNumber}: entities are not accepted")


def parse_xml(text: str, where: str) -> Element:
    """Return the root element; raise InputError `file:line: ...` for text that is not XML, or harmful XML."""
    builder = _ElementBuilder(where)
    try:
        builder.parser.Parse(text.encode("utf-8"), True)
    except expat.ExpatError as error:
        problem = expat.ErrorString(error.code)
        raise InputError(f"{where}:{error.lineno}: not valid XML: {problem}") from error
    assert builder.root is not None
    return builder.root
