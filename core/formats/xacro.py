"""xacro expanded: properties, arguments, macros, conditions, includes and sums, by a reader that runs no code.

Expressions are parsed by `ast` and are numbers, texts, names, arithmetic, comparisons and the functions of FUNCTIONS;
nothing else is accepted. Files are included from the folder of the rig's file and below it, and only from there: of
`$(find package)/urdf/wheel.xacro` the end that lies there. What the environment would say is not asked.
Source: ROS wiki "xacro".
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import NoReturn

from riglens.core.errors import InputError
from riglens.core.formats.report import Notes
from riglens.core.formats.source import Element, Source
from riglens.core.rig.yaml.nodes import shortened

MAX_STEPS, MAX_TEXTS, MAX_DEPTH, MAX_FILES = 20_000, 200_000, 30, 60
"""Elements made, texts worked out, macros and properties within one another, and files included."""
MAX_LETTERS, MAX_NODES, MAX_SIZE = 2_000, 100, 1e12
"""Of a text, of the parts of an expression, and of a number in it."""
PREFIX = "xacro:"
Plain = float | int | bool | str
FUNCTIONS: dict[str, Callable[..., float]] = {
    **{name: getattr(math, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt")},
    **{name: getattr(math, name) for name in ("radians", "degrees", "floor", "ceil", "hypot")},
    "abs": abs, "min": min, "max": max, "float": float, "int": int, "round": round,
}  # fmt: skip
_ARITHMETIC: dict[type, Callable[[float, float], float]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod,
}  # fmt: skip
_COMPARISONS: dict[type, Callable[[Plain, Plain], bool]] = {
    ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}  # fmt: skip
_PIECES = re.compile(r"\$\$(?=[{(])|\$\{([^}]*)\}|\$\(([^)]*)\)")
_PARAMETER = re.compile(r"(\*{0,2})([A-Za-z_]\w*)(?::?=(\^?\|?)('[^']*'|\"[^\"]*\"|\S*))?")


def is_xacro(root: Element) -> bool:
    """Return whether a document has macros or expressions in it."""
    waiting = [root]
    while waiting:
        element = waiting.pop()
        values = element.attributes.values()
        if element.tag.startswith(PREFIX) or any("${" in value or "$(" in value for value in values):
            return True
        waiting.extend(element.children)
    return False


def expanded(source: Source, notes: Notes) -> Element:
    """Return the document without macros and expressions; raise InputError when that takes what is not accepted."""
    expander = _Expander(source, notes)
    made = list(expander.expand(source.xml, _Scope(), 0))
    notes.read(f"xacro, expanded here: {expander.steps} elements, {expander.files} files included")
    return made[0]


@dataclass
class _Scope:
    """Names and what they stand for; what is not here is looked for in the scope outside."""

    outside: _Scope | None = None
    values: dict[str, str] = field(default_factory=dict)
    blocks: dict[str, list[Element]] = field(default_factory=dict)

    def owner(self, name: str) -> _Scope | None:
        """Return the scope in which a name has a value."""
        found: _Scope | None = self
        while found is not None and name not in found.values:
            found = found.outside
        return found

    def block(self, name: str) -> list[Element] | None:
        """Return the elements that a name stands for."""
        found: _Scope | None = self
        while found is not None and name not in found.blocks:
            found = found.outside
        return None if found is None else found.blocks[name]


@dataclass(frozen=True)
class _Macro:
    parameters: tuple[tuple[str, str, str | None, bool], ...]
    """Stars, name, default, and whether the value outside comes before it."""
    body: tuple[Element, ...]


class _Expander:
    """Walks through a document and counts what it makes."""

    def __init__(self, source: Source, notes: Notes) -> None:
        self._source, self._folder, self._notes = source, source.path.parent.resolve(), notes
        self._macros: dict[str, _Macro] = {}
        self._arguments: dict[str, str] = {}
        self.steps = self.files = self._texts = 0

    # ------------------------------------------------------------------ elements
    def expand(self, element: Element, scope: _Scope, depth: int) -> Iterator[Element]:
        """Yield what an element becomes."""
        self.steps += 1
        self._source.time.check()
        if self.steps > MAX_STEPS or depth > MAX_DEPTH:
            raise element.error(
                f"xacro makes more than {MAX_STEPS} elements, or goes more than {MAX_DEPTH} deep; accepted is a rig"
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
            yield from self._all(scope.block(said) or [], scope, depth)
        elif name not in _DEFINITIONS:
            yield from self._call(name, element, scope, depth)
        else:
            _DEFINITIONS[name](self, element, scope)

    def _all(
        self, elements: list[Element] | tuple[Element, ...], scope: _Scope, depth: int
    ) -> Iterator[Element]:
        for element in elements:
            yield from self.expand(element, scope, depth + 1)

    def define_property(self, element: Element, scope: _Scope) -> None:
        """Keep a property: a text that is worked out where it is used, or a block of elements."""
        name, place = element.attribute("name"), scope
        if element.attributes.get("scope") in ("global", "parent"):
            while place.outside is not None:
                place = place.outside
        value = element.attributes.get("value", element.attributes.get("default"))
        if value is None:
            place.blocks[name] = element.children
        elif "value" in element.attributes or scope.owner(name) is None:
            own = f"${{{name}}}" in value.replace(" ", "")
            place.values[name] = self.text(value, element, scope) if own or place is not scope else value

    def define_argument(self, element: Element, scope: _Scope) -> None:
        """Keep the default of an argument: nobody is there to give another value."""
        if "default" in element.attributes:
            self._arguments.setdefault(element.attribute("name"), element.attributes["default"])

    def define_macro(self, element: Element, scope: _Scope) -> None:
        """Keep a macro."""
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
        outermost = scope
        while outermost.outside is not None:
            outermost = outermost.outside
        inner, blocks = _Scope(outermost), list(element.children)
        for stars, parameter, default, is_outer in macro.parameters:
            if stars:
                block = blocks.pop(0) if blocks else None
                found = [] if block is None else block.children if stars == "**" else [block]
                inner.blocks[parameter] = [
                    made for one in found for made in self.expand(one, scope, depth + 1)
                ]
            elif parameter in element.attributes:
                inner.values[parameter] = self.text(element.attributes[parameter], element, scope)
            elif is_outer and scope.owner(parameter) is not None:
                inner.values[parameter] = self.text(f"${{{parameter}}}", element, scope)
            elif default is not None:
                inner.values[parameter] = self.text(default, element, scope)
            else:
                raise element.error(f"parameter '{shortened(parameter, 60)}' is missing")
        yield from self._all(macro.body, inner, depth)

    def _include(self, element: Element, scope: _Scope, depth: int) -> Iterator[Element]:
        said = self.text(element.attribute("filename"), element, scope)
        found = self._file(said)
        if found is None:
            self._notes.ignored("included file that is not in the rig's folder", shortened(said, 80))
            return
        self.files += 1
        if self.files > MAX_FILES:
            raise element.error(f"more than {MAX_FILES} files included; accepted are at most that many")
        yield from self._all(self._source.another(found).xml.children, scope, depth)

    def _file(self, said: str) -> Path | None:
        """Return a file in the rig's folder or below it that the end of a path names."""
        parts = [part for part in PurePosixPath(said.replace("\0", "/..")).parts if part != "/"]
        for start in range(len(parts)):
            if ".." in parts[start:]:
                continue
            place = (self._folder / Path(*parts[start:])).resolve()
            if place.is_relative_to(self._folder) and place.is_file():
                return place
        return None

    # ------------------------------------------------------------------ texts
    def text(self, said: str, element: Element, scope: _Scope, depth: int = 0) -> str:
        """Return a text with its expressions worked out."""
        return _as_text(self.value(said, element, scope, depth))

    def value(self, said: str, element: Element, scope: _Scope, depth: int = 0) -> Plain:
        """Return a text, or the value of the one expression that it consists of."""
        self._texts += 1
        if len(said) > MAX_LETTERS or depth > MAX_DEPTH or self._texts > MAX_TEXTS:
            raise element.error(
                f"text of more than {MAX_LETTERS} letters, or properties that need one another"
            )
        whole = _PIECES.fullmatch(said)
        if whole is not None and whole[0] != "$$":
            return self._piece(whole, element, scope, depth)
        made = _PIECES.sub(lambda piece: _as_text(self._piece(piece, element, scope, depth)), said)
        if len(made) > MAX_LETTERS:
            raise element.error(f"text of more than {MAX_LETTERS} letters")
        return made

    def _piece(self, piece: re.Match[str], element: Element, scope: _Scope, depth: int) -> Plain:
        expression, command = piece.groups()
        if expression is not None:
            return self._worked_out(expression, element, scope, depth)
        if command is None:
            return "$"
        word, _, rest = command.strip().partition(" ")
        if word == "arg" and rest.strip() in self._arguments:
            return self.value(self._arguments[rest.strip()], element, scope, depth + 1)
        if word == "find":
            return "/" + rest.strip()
        if word == "eval":
            return self._worked_out(rest, element, scope, depth)
        if word == "arg":
            raise element.error(
                f"argument '{shortened(rest, 60)}' has no default; expand it first, with xacro"
            )
        raise element.error(f"found '{shortened(piece[0], 60)}'; accepted are $(arg), $(find) and sums")

    def _worked_out(self, expression: str, element: Element, scope: _Scope, depth: int) -> Plain:
        try:
            tree = ast.parse(expression.strip(), mode="eval")
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            _refuse(expression, element)
        if sum(1 for _ in ast.walk(tree)) > MAX_NODES:
            _refuse(expression, element)

        def known(name: str) -> Plain:
            owner = scope.owner(name)
            if owner is None:
                raise element.error(f"'{shortened(name, 60)}' has no value here")
            return _typed(self.value(owner.values[name], element, owner, depth + 1))

        try:
            return _limited(_evaluated(tree.body, known), expression, element)
        except (ArithmeticError, TypeError, ValueError, KeyError) as error:
            if isinstance(error, InputError):
                raise
            _refuse(expression, element)


_DEFINITIONS: dict[str, Callable[[_Expander, Element, _Scope], None]] = {
    "property": _Expander.define_property,
    "arg": _Expander.define_argument,
    "macro": _Expander.define_macro,
}


def _evaluated(node: ast.expr, known: Callable[[str], Plain]) -> Plain:
    """Work out one node; KeyError or TypeError for what is not accepted."""
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float, str)):
        return node.value
    if isinstance(node, ast.Name):
        constants: dict[str, Plain] = {"pi": math.pi, "e": math.e, "true": True, "false": False}
        return constants[node.id] if node.id in constants else known(node.id)
    if isinstance(node, ast.UnaryOp):
        inner = _evaluated(node.operand, known)
        return not inner if isinstance(node.op, ast.Not) else _SIGNS[type(node.op)] * _number(inner)
    if isinstance(node, ast.BinOp):
        left, right = _evaluated(node.left, known), _evaluated(node.right, known)
        if isinstance(node.op, ast.Pow):
            return math.pow(_number(left), _number(right))
        if isinstance(node.op, ast.Add) and isinstance(left, str) and isinstance(right, str):
            return left + right
        return _ARITHMETIC[type(node.op)](_number(left), _number(right))
    if isinstance(node, ast.BoolOp):
        return _first_that(isinstance(node.op, ast.Or), (_evaluated(part, known) for part in node.values))
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        left, right = _evaluated(node.left, known), _evaluated(node.comparators[0], known)
        return _COMPARISONS[type(node.ops[0])](left, right)
    if isinstance(node, ast.IfExp):
        return _evaluated(node.body if _evaluated(node.test, known) else node.orelse, known)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        return FUNCTIONS[node.func.id](*(_number(_evaluated(part, known)) for part in node.args))
    raise TypeError


def _first_that(is_true: bool, values: Iterator[Plain]) -> Plain:
    """Return the first value that is true, or false; the last one when there is none."""
    value: Plain = False
    for value in values:
        if bool(value) == is_true:
            break
    return value


_SIGNS = {ast.USub: -1, ast.UAdd: 1}


def _number(value: Plain) -> float | int:
    if isinstance(value, str):
        raise TypeError
    if abs(value) > MAX_SIZE:
        raise OverflowError
    return value


def _limited(value: Plain, expression: str, element: Element) -> Plain:
    is_large = len(value) > MAX_LETTERS if isinstance(value, str) else not abs(value) <= MAX_SIZE
    if is_large or isinstance(value, complex):
        _refuse(expression, element)
    return value


def _refuse(expression: str, element: Element) -> NoReturn:
    accepted = f"sums of numbers and properties, and {', '.join(FUNCTIONS)}"
    raise element.error(f"found '${{{shortened(expression, 60)}}}'; accepted are {accepted}")


def _typed(value: Plain) -> Plain:
    """Return a text that is a number or a truth value as such."""
    if not isinstance(value, str):
        return value
    word = value.strip()
    if word.lower() in ("true", "false"):
        return word.lower() == "true"
    for kind in (int, float):
        if len(word) < 50 and "_" not in word:
            try:
                return kind(word)
            except ValueError:
                continue
    return value


def _truth(value: Plain, element: Element) -> bool:
    typed = _typed(value)
    if isinstance(typed, str):
        raise element.error(f"found '{shortened(typed, 60)}'; accepted is true, false or a number")
    return bool(typed)


def _as_text(value: Plain) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
