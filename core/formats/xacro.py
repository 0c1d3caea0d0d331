"""Expand xacro: properties, arguments, macros, conditions, includes and expressions, without running code.

What stands in ${...} is worked out by `xacro_sums`. Files are included, and YAML is loaded, from the folder of the
rig's file and below it, or from its ROS package, and only from there: of `$(find package)/urdf/wheel.xacro` the end
that lies there. The environment is not asked: of $(optenv NAME DEFAULT) the default is taken. Source: ROS wiki "xacro".
"""

from __future__ import annotations

import re
from collections import ChainMap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath

from riglens.core.errors import InputError
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Element, Source
from riglens.core.formats.xacro_sums import ACCEPTED, MAX_LETTERS, Names, Worked, as_text, typed, worked_out
from riglens.core.rig.yaml.nodes import shortened

MAX_STEPS, MAX_TEXTS, MAX_DEPTH, MAX_FILES = 20_000, 200_000, 30, 60
"""Elements made, texts worked out, macros and properties within one another, and files included."""
MAX_ENTRIES = 1_000_000
"""Entries of lists and dictionaries that all expressions of a file copy or compare."""
MAX_PARENTS = 4
"""Number of folders searched for the description of the package, starting with that of the rig's file."""
PREFIX = "xacro:"
_PIECES = re.compile(r"\$\$(?=[{(])|\$\{([^}]*)\}|\$\(([^)]*)\)")
_PARAMETER = re.compile(r"(\*{0,2})([A-Za-z_]\w*)(?::?=(\^?\|?)('[^']*'|\"[^\"]*\"|\S*))?")


def is_xacro(root: Element) -> bool:
    """Return whether a document has macros or expressions in it."""
    return any(
        element.tag.startswith(PREFIX)
        or any("${" in value or "$(" in value for value in element.attributes.values())
        for element in root.walk()
    )


def expanded(source: Source, notes: Notes) -> Element:
    """Return the document without macros and expressions; raise InputError for unsupported ones."""
    expander = _Expander(source, notes)
    made = list(expander.expand(source.xml, _Scope(), 0))
    notes.read(f"xacro, expanded here: {expander.steps} elements, {expander.files} files included")
    return made[0]


@dataclass(frozen=True)
class _Scope:
    """Values and blocks of elements by their names; missing ones are looked up in the scopes outside."""

    values: ChainMap[str, Worked] = field(default_factory=ChainMap)
    blocks: ChainMap[str, list[Element]] = field(default_factory=ChainMap)

    def inner(self) -> _Scope:
        """Return a scope within this one."""
        return _Scope(self.values.new_child(), self.blocks.new_child())

    def outer(self, levels: int) -> _Scope:
        """Return the scope the given number of levels further out."""
        return _Scope(ChainMap(*self.values.maps[levels:]), ChainMap(*self.blocks.maps[levels:]))


@dataclass(frozen=True)
class _Macro:
    parameters: tuple[tuple[str, str, str | None, bool], ...]
    """Stars, name, default, and whether the value outside comes before it."""
    body: tuple[Element, ...]


class _Expander:
    """Expander that walks through a document and counts its output."""

    def __init__(self, source: Source, notes: Notes) -> None:
        folder = source.path.parent.resolve()
        self._source, self._folders, self._notes = source, (folder, _package(folder)), notes
        self._loaded: dict[Path, Worked] = {}
        self._macros: dict[str, _Macro] = {}
        self._arguments: dict[str, str] = {}
        self.steps = self.files = self._texts = self._entries = 0

    # ------------------------------------------------------------------ elements
    def expand(self, element: Element, scope: _Scope, depth: int) -> Iterator[Element]:
        """Yield what an element becomes."""
        self.steps += 1
        self._source.time.check()
        if self.steps > MAX_STEPS or depth > MAX_DEPTH:
            raise element.error(
                f"xacro expands to more than {MAX_STEPS} elements or more than {MAX_DEPTH} levels"
            )
        if not element.tag.startswith(PREFIX):
            attributes = {key: self.text(value, element, scope) for key, value in element.attributes.items()}
            inner = [made for child in element.children for made in self.expand(child, scope, depth + 1)]
            text = self.text(element.text, element, scope) if len(element.text) <= MAX_LETTERS else ""
            yield Element(element.tag, attributes, element.line, element.where, inner, text)
            return
        name = element.tag.removeprefix(PREFIX)
        if name in ("if", "unless"):
            if _truth(self.value(element.attribute("value"), element, scope), element) == (name == "if"):
                yield from self._all(element.children, scope, depth)
        elif name == "include":
            yield from self._include(element, scope, depth)
        elif name == "insert_block":
            said = self.text(element.attribute("name"), element, scope)
            yield from self._all(scope.blocks.get(said, []), scope, depth)
        elif name == "property":
            self._define_property(element, scope)
        elif name == "arg":
            if "default" in element.attributes:  # there is no other value
                self._arguments.setdefault(element.attribute("name"), element.attributes["default"])
        elif name == "macro":
            self._define_macro(element)
        else:
            yield from self._call(name, element, scope, depth)

    def _all(
        self, elements: list[Element] | tuple[Element, ...], scope: _Scope, depth: int
    ) -> Iterator[Element]:
        for element in elements:
            yield from self.expand(element, scope, depth + 1)

    def _define_property(self, element: Element, scope: _Scope) -> None:
        """Keep a property: a text that is worked out where it is used, or a block of elements."""
        name, said = element.attribute("name"), element.attributes.get("scope")
        outermost = len(scope.values.maps) - 1
        levels = outermost if said == "global" else min(1, outermost) if said == "parent" else 0
        value = element.attributes.get("value", element.attributes.get("default"))
        if value is None:
            scope.blocks.maps[levels][name] = element.children
        elif "value" in element.attributes or name not in scope.values:
            own = f"${{{name}}}" in value.replace(" ", "")
            kept = self._kept(value, element, scope) if own or levels else value
            scope.values.maps[levels][name] = kept

    def _define_macro(self, element: Element) -> None:
        found = _PARAMETER.finditer(element.attributes.get("params", "")[:MAX_LETTERS])
        parameters = tuple(
            (
                stars,
                name,
                None if default is None or (outer and not default) else default.strip("'\""),
                bool(outer),
            )
            for stars, name, outer, default in (match.groups() for match in found)
        )
        name = element.attribute("name").removeprefix(PREFIX)
        self._macros[name] = _Macro(parameters, tuple(element.children))

    def _call(self, name: str, element: Element, scope: _Scope, depth: int) -> Iterator[Element]:
        macro = self._macros.get(name)
        if macro is None:
            self._notes.ignored("macro that no file in the rig's folder defines", shortened(name, 60))
            return
        inner = scope.inner()  # a macro knows what is known where it is called
        blocks = list(element.children)
        for stars, parameter, default, is_outer in macro.parameters:
            if stars:
                block = blocks.pop(0) if blocks else None
                found = [] if block is None else block.children if stars == "**" else [block]
                inner.blocks[parameter] = [
                    made for one in found for made in self.expand(one, scope, depth + 1)
                ]
            elif parameter in element.attributes:
                inner.values[parameter] = self._kept(element.attributes[parameter], element, scope)
            elif is_outer and parameter in scope.values:
                inner.values[parameter] = self._kept(f"${{{parameter}}}", element, scope)
            elif default is not None:
                inner.values[parameter] = self._kept(default, element, scope)
            else:
                raise element.error(f"parameter '{shortened(parameter, 60)}' is missing")
        yield from self._all(macro.body, inner, depth)

    def _include(self, element: Element, scope: _Scope, depth: int) -> Iterator[Element]:
        said = self.text(element.attribute("filename"), element, scope)
        found = self._file(said)
        if found is None:
            package = PurePosixPath(said).parts[1:2]
            whose = f" (package {shortened(package[0], 60)})" if said.startswith("/") and package else ""
            self._notes.ignored(f"included file that is not in the rig's folder{whose}", shortened(said, 80))
            return
        self._count_file(element)
        yield from self._all(self._source.another(found).xml.children, scope, depth)

    def _count_file(self, element: Element) -> None:
        self.files += 1
        if self.files > MAX_FILES:
            raise element.error(f"too many included files (at most {MAX_FILES})")

    def _spend(self, entries: int, element: Element) -> None:
        self._entries += entries
        if self._entries > MAX_ENTRIES:
            raise element.error(f"lists and dictionaries of more than {MAX_ENTRIES} entries in all")

    def _load_yaml(self, said: str, element: Element) -> Worked:
        """Return the content of a YAML file, read once."""
        found = self._file(said)
        if found is None:
            raise element.error(
                f"load_yaml: '{shortened(said, 80)}' is not in the rig's folder or package; expand it first, with xacro"
            )
        if found not in self._loaded:
            self._count_file(element)
            self._loaded[found] = self._source.another(found).yaml.raw
        return self._loaded[found]

    def _file(self, said: str) -> Path | None:
        """Return a file in the rig's folder, its package or below that the end of a path names."""
        parts = [part for part in PurePosixPath(said.replace("\0", "/..")).parts if part != "/"]
        for start in range(len(parts)):
            if ".." in parts[start:]:
                continue
            for folder in self._folders:
                try:
                    place = (folder / Path(*parts[start:])).resolve()
                    if place.is_relative_to(folder) and place.is_file():
                        return place
                except (OSError, RuntimeError):  # a name that no file can have, or links in a circle
                    continue
        return None

    # ------------------------------------------------------------------ texts
    def text(self, said: str, element: Element, scope: _Scope, depth: int = 0) -> str:
        """Return a text with its expressions worked out."""
        return _text_of(self.value(said, element, scope, depth), element)

    def _kept(self, said: str, element: Element, scope: _Scope) -> Worked:
        """Return the value of a name from now on: a list, a dictionary, or a text."""
        value = self.value(said, element, scope)
        return value if isinstance(value, (tuple, Mapping)) else _text_of(value, element)

    def value(self, said: str, element: Element, scope: _Scope, depth: int = 0) -> Worked:
        """Return a text, or the value of the one expression that it consists of."""
        self._texts += 1
        if len(said) > MAX_LETTERS or depth > MAX_DEPTH or self._texts > MAX_TEXTS:
            raise element.error(
                f"text of more than {MAX_LETTERS} characters, or properties that need one another"
            )
        whole = _PIECES.fullmatch(said)
        if whole is not None and whole[0] != "$$":
            return self._piece(whole, element, scope, depth)
        made = _PIECES.sub(lambda piece: _text_of(self._piece(piece, element, scope, depth), element), said)
        if len(made) > MAX_LETTERS:
            raise element.error(f"text of more than {MAX_LETTERS} characters")
        return made

    def _piece(self, piece: re.Match[str], element: Element, scope: _Scope, depth: int) -> Worked:
        expression, command = piece.groups()
        if expression is not None:
            return self._worked_out(expression, element, scope, depth)
        if command is None:
            return "$"
        word, _, rest = command.strip().partition(" ")
        if word == "arg":
            return self._argument(rest.strip(), element, scope, depth)
        if word == "find":
            return "/" + rest.strip()
        if word == "optenv":
            return self.text(rest.strip().partition(" ")[2].strip(), element, scope, depth + 1)
        if word == "eval":
            return self._worked_out(rest, element, scope, depth)
        raise element.error(
            f"'{shortened(piece[0], 60)}' is not supported; use $(arg), $(find), $(optenv NAME DEFAULT) or $(eval)"
        )

    def _argument(self, name: str, element: Element, scope: _Scope, depth: int) -> Worked:
        if name not in self._arguments:
            raise element.error(
                f"argument '{shortened(name, 60)}' has no default; expand it first, with xacro"
            )
        return self.value(self._arguments[name], element, scope, depth + 1)

    def _worked_out(self, expression: str, element: Element, scope: _Scope, depth: int) -> Worked:
        if "$(" in expression:
            expression = self.text(expression, element, scope, depth + 1)

        def known(name: str) -> Worked:
            levels = next((k for k, values in enumerate(scope.values.maps) if name in values), None)
            if levels is None:
                raise element.error(f"'{shortened(name, 60)}' has no value here")
            said = scope.values[name]
            if not isinstance(said, str):
                return typed(said)
            return typed(self.value(said, element, scope.outer(levels), depth + 1))

        names = Names(
            known,
            lambda name: self._argument(name, element, scope, depth),
            lambda said: self._load_yaml(said, element),
            lambda entries: self._spend(entries, element),
        )
        try:
            return worked_out(expression, names)
        except (ArithmeticError, TypeError, ValueError, LookupError, RecursionError) as error:
            if isinstance(error, InputError):
                raise
            shown = shortened(expression, 60)
            raise element.error(f"'${{{shown}}}' may only use {ACCEPTED}") from error


def _truth(value: Worked, element: Element) -> bool:
    truth = typed(value)
    if isinstance(truth, str):
        raise element.error(f"must be true, false or a number (got '{shortened(truth, 60)}')")
    return bool(truth)


def _package(folder: Path) -> Path:
    """Return the folder of the ROS package that a folder lies in, or the folder itself."""
    for place in (folder, *folder.parents)[:MAX_PARENTS]:
        if (place / "package.xml").is_file():
            return place
    return folder


def _text_of(value: Worked, element: Element) -> str:
    try:
        return as_text(value)
    except ValueError as error:
        raise element.error(f"list or dictionary of more than {MAX_LETTERS} characters") from error
