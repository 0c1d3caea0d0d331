"""Numbers as people type them into a field (plain, a sum such as 1.2+0.05, with a unit), and as fields show them."""

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
    """Unit of a field that shows a stored value: `per_base` of this unit make one of the stored unit.

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
        raise ValueError("must be a number such as 1.25 (got nan)")
    return value


def parse_quantity(text: str, unit: Unit) -> float:
    """Return a value in the stored unit from text in `unit`, or in a unit of the same kind that follows the number."""
    found = re.fullmatch(r"(.*?[\d.)∞])\s*([a-z°]+)", text.strip(), re.S)
    given = _SUFFIXES.get(found[2]) if found is not None else None
    if found is not None and given is not None and given.quantity == unit.quantity:
        return _to_base(parse_number(found[1]), given)
    return _to_base(parse_number(text), unit)


_CHANGE = re.compile(r"\s*([-+*/])=\s*(.*)", re.S)
_DECIMALS = 12


@dataclass(frozen=True)
class Change:
    """Change of any number: `times` as much, and `plus` in the stored unit."""

    plus: float = 0.0
    times: float = 1.0

    def of(self, value: object) -> float:
        """Return the number after the change; tenths stay tenths. Raise ValueError when there is no number."""
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise ValueError("must hold a number to change, such as 1.25")
        return round(value * self.times + self.plus, _DECIMALS)


def parse_change(text: str, unit: Unit) -> Change | None:
    """Return the change in "+=0.1", "-=0.1 m", "*=2" or "/=2"; None for any other text.

    Raise ValueError where the number behind the sign is wrong.
    """
    found = _CHANGE.fullmatch(text.translate(_SIGNS))
    if found is None:
        return None
    sign, amount = found[1], found[2]
    if sign in "+-":
        plus = parse_quantity(amount, unit)
        return Change(plus=plus if sign == "+" else -plus)
    factor = parse_number(amount)
    if sign == "/" and factor == 0.0:
        raise ValueError(f"must not divide by zero (got '{text.strip()[:40]}')")
    return Change(times=factor if sign == "*" else 1.0 / factor)


def _to_base(value: float, unit: Unit) -> float:
    return value if unit.per_base == 1.0 else value / unit.per_base


def _evaluated(text: str, shown: str) -> float:
    problem = ValueError(f"must be a number such as 1.25 or 1.2+0.05 (got '{shown[:40]}')")
    if len(text) > MAX_CHARACTERS:
        raise problem
    try:
        return _value(ast.parse(text.strip(), mode="eval").body)
    except ZeroDivisionError:
        raise ValueError(f"must not divide by zero (got '{shown[:40]}')") from None
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


SHOWN_DECIMALS = 4
LARGE = 1e5
"""From here on a number without room is shown as digits and a power of ten."""


def short_number(value: float) -> str:
    """Return at most four decimals, no trailing zeros; what an unfocused field shows."""
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    text = f"{value:.{SHOWN_DECIMALS}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def full_number(value: float) -> str:
    """Return the shortest text that reads back as the same double."""
    return short_number(value) if math.isinf(value) else repr(value).removesuffix(".0")


def fitted_number(value: float, text: str, fits: Callable[[str], bool]) -> str:
    """Return `text`, or the number with as many decimals, or else digits and a power of ten, as have room.

    Numbers below `LARGE` keep all digits before the point: -180 is never shown as -2e2.
    """
    if fits(text) or not math.isfinite(value) or abs(value) < 1.0:
        return text
    shorter = [short_number(round(value, places)) for places in range(SHOWN_DECIMALS - 1, -1, -1)]
    if abs(value) >= LARGE:
        shorter += [power_of_ten(value, digits) for digits in range(6, 0, -1)]
    return next((found for found in shorter if fits(found)), shorter[-1])


def power_of_ten(value: float, digits: int) -> str:
    """Return a number with at most `digits` digits, such as 1.5e7."""
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa.rstrip('0').rstrip('.') if '.' in mantissa else mantissa}e{int(exponent)}"


def short_text(value: float, unit: Unit) -> str:
    """Return a stored value in a unit, as `short_number`; one without a unit is never shown as 0 unless it is."""
    shown = short_number(value * unit.per_base)
    return power_of_ten(value, SHOWN_DECIMALS) if shown == "0" and value and unit == NO_UNIT else shown


def full_text(value: float, unit: Unit) -> str:
    """Return a stored value in a unit: every digit in the stored one, twelve in another."""
    if unit.per_base == 1.0 or math.isinf(value):
        return full_number(value)
    return full_number(float(f"{value * unit.per_base:.12g}"))
