"""Numbers as people type them into a field: plain, or a small sum such as 1.2+0.05, with a unit if wanted."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

MAX_CHARACTERS = 200
_BINARY: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_SIGNS = str.maketrans({"−": "-", "×": "*", "·": "*", "÷": "/"})


@dataclass(frozen=True)
class Unit:
    """How a field shows a stored value: `per_base` of this unit make one of the stored unit.

    `step` is what one step of the wheel or an arrow key changes, in this unit, where the field's own step is 1
    in the stored unit.
    """

    name: str
    quantity: Literal["", "length", "angle", "pixels"] = ""
    per_base: float = 1.0
    step: float = 1.0


NO_UNIT = Unit("")
METRES, MILLIMETRES = Unit("m", "length"), Unit("mm", "length", 1000.0, 1000.0)
DEGREES, RADIANS = Unit("°", "angle"), Unit("rad", "angle", math.pi / 180.0, 0.01)
PIXELS = Unit("px", "pixels")
_SUFFIXES = {
    "m": METRES,
    "cm": Unit("cm", "length", 100.0),
    "mm": MILLIMETRES,
    "°": DEGREES,
    "deg": DEGREES,
    "rad": RADIANS,
    "px": PIXELS,
}


def parse_number(text: str) -> float:
    """Return a double from a number or a sum with + - * / and brackets; raise ValueError with a reason.

    Infinity may be written ∞ or inf.
    """
    shown = text.strip()
    cleaned = shown.replace("∞", "inf").translate(_SIGNS)
    try:
        value = float(cleaned)
    except ValueError:
        value = _evaluated(cleaned, shown)
    if math.isnan(value):
        raise ValueError("found nan, accepted is a number such as 1.25")
    return value


def parse_quantity(text: str, unit: Unit) -> float:
    """Return a value in the stored unit from text in `unit`, or in a unit of the same kind that follows the number."""
    found = re.fullmatch(r"(.*?[\d.)∞])\s*([a-z°]+)", text.strip(), re.S)
    given = _SUFFIXES.get(found[2]) if found is not None else None
    if found is not None and given is not None and given.quantity == unit.quantity:
        return _to_base(parse_number(found[1]), given)
    return _to_base(parse_number(text), unit)


def _to_base(value: float, unit: Unit) -> float:
    return value if unit.per_base == 1.0 else value / unit.per_base


def _evaluated(text: str, shown: str) -> float:
    problem = ValueError(f"found '{shown[:40]}', accepted is a number such as 1.25 or 1.2+0.05")
    if len(text) > MAX_CHARACTERS:
        raise problem
    try:
        return _value(ast.parse(text.strip(), mode="eval").body)
    except ZeroDivisionError:
        raise ValueError(f"found '{shown[:40]}', which divides by zero") from None
    except (SyntaxError, ValueError, OverflowError, RecursionError, MemoryError):
        raise problem from None


def _value(node: ast.expr) -> float:
    """Return the value of a sum; raise ValueError for anything but numbers, signs and the four operations."""
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return float(node.value)  # type: ignore[arg-type]
    if isinstance(node, ast.Name) and node.id == "pi":
        return math.pi
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.UAdd | ast.USub):
        value = _value(node.operand)
        return -value if isinstance(node.op, ast.USub) else value
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        return _BINARY[type(node.op)](_value(node.left), _value(node.right))
    raise ValueError("not a sum of numbers")
