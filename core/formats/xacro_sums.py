"""Evaluate the ${...} expressions of a xacro file, and numbers in Python files, without running any code.

Expressions are parsed by `ast`, and only what is named here has a meaning: numbers, texts, names, arithmetic,
comparisons, the functions of FUNCTIONS, lists and dictionaries with their entries. Source: ROS wiki "xacro".
"""

from __future__ import annotations

import ast
import math
import operator
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

MAX_LETTERS, MAX_NODES, MAX_SIZE = 2_000, 100, 1e12
"""Of a text, of the parts of an expression, and of a number in it."""
MAX_NESTED = 20
"""Lists and dictionaries within one another, where one is shown as a text."""
MAX_KEPT = 256
"""Number of parsed expressions that are cached: macros repeat them."""
Worked: TypeAlias = "float | int | bool | str | tuple[Worked, ...] | Mapping[Key, Worked] | None"
"""Value of an expression: plain data."""
Key: TypeAlias = "float | int | bool | str"
MAX_DIGITS = 15
"""Decimal digits of a rounding, either way: Python's round works out 10 to that power."""


def _rounded(value: float, *digits: int) -> float:
    if any(not abs(count) <= MAX_DIGITS for count in digits):
        raise ValueError
    return round(value, *digits)


FUNCTIONS: dict[str, Callable[..., float]] = {
    **{name: getattr(math, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sqrt")},
    **{name: getattr(math, name) for name in ("radians", "degrees", "floor", "ceil", "hypot")},
    "abs": abs, "min": min, "max": max, "float": float, "int": int, "round": _rounded,
}  # fmt: skip
ACCEPTED = (
    "sums of numbers and properties, entries of lists and dictionaries, load_yaml of a file in the rig's folder, and "
    + ", ".join(FUNCTIONS)
)
_CONSTANTS: dict[str, Worked] = {
    "pi": math.pi, "e": math.e, "true": True, "false": False, "True": True, "False": False
}  # fmt: skip
_ARITHMETIC: dict[type, Callable[[float, float], float]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod,
}  # fmt: skip
_COMPARISONS: dict[type, Callable[[Key, Key], bool]] = {
    ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}  # fmt: skip
_SIGNS = {ast.USub: -1, ast.UAdd: 1}


@dataclass(frozen=True)
class Names:
    """Lookups of an expression: the value of a name, an argument of the file, the content of a YAML file."""

    value: Callable[[str], Worked]
    argument: Callable[[str], Worked]
    load_yaml: Callable[[str], Worked]
    spend: Callable[[int], None]
    """Count entries that are copied or compared; raise InputError beyond the limit for a file."""


def worked_out(expression: str, names: Names) -> Worked:
    """Return the value of an expression; raise ValueError, TypeError, LookupError or ArithmeticError for others."""
    value = evaluated(_parsed(expression.strip()), names)
    is_large = isinstance(value, str) and len(value) > MAX_LETTERS
    if is_large or (isinstance(value, (int, float)) and not abs(value) <= MAX_SIZE):
        raise ValueError
    return value


@lru_cache(MAX_KEPT)
def _parsed(expression: str) -> ast.expr:
    try:
        with warnings.catch_warnings(action="ignore"):  # such as of `1or 2`
            tree = ast.parse(expression, mode="eval")
    except (SyntaxError, RecursionError, MemoryError) as error:
        raise ValueError from error
    if sum(1 for _ in ast.walk(tree)) > MAX_NODES:
        raise ValueError
    return tree.body


def typed(value: Worked) -> Worked:
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


def as_text(value: Worked) -> str:
    """Return a value as xacro writes it; raise ValueError for lists and dictionaries that are long or deep."""
    if isinstance(value, (tuple, Mapping)):
        return _shown(value, [MAX_LETTERS], 0)
    return str(value).lower() if isinstance(value, bool) else str(value)


def _shown(value: Worked, left: list[int], depth: int) -> str:
    """Return a value of at most as many letters as are `left`: entries may be shared very often."""
    is_plain = not isinstance(value, (tuple, Mapping))
    left[0] -= 2 + (len(repr(value)) if is_plain else 0)
    if left[0] < 0 or (not is_plain and depth >= MAX_NESTED):
        raise ValueError
    if isinstance(value, tuple):
        return f"[{', '.join(_shown(entry, left, depth + 1) for entry in value)}]"
    if isinstance(value, Mapping):
        pairs = (f"{key!r}: {_shown(entry, left, depth + 1)}" for key, entry in value.items())
        return f"{{{', '.join(pairs)}}}"
    return repr(value)


def evaluated(node: ast.expr, names: Names) -> Worked:
    """Return the value of one node of a parsed expression; KeyError or TypeError for unsupported ones."""
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float, str)):
        return node.value
    if isinstance(node, ast.Name):
        return _CONSTANTS[node.id] if node.id in _CONSTANTS else names.value(node.id)
    if isinstance(node, (ast.UnaryOp, ast.BinOp)):
        return _summed(node, names)
    if isinstance(node, ast.BoolOp):
        return _first_that(isinstance(node.op, ast.Or), (evaluated(part, names) for part in node.values))
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        return _compared(node, names)
    if isinstance(node, ast.IfExp):
        return evaluated(node.body if evaluated(node.test, names) else node.orelse, names)
    if isinstance(node, ast.Call):
        return _called(node, names)
    if isinstance(node, (ast.List, ast.Tuple)):
        return tuple(evaluated(part, names) for part in node.elts)
    if isinstance(node, ast.Dict):
        pairs = zip(node.keys, node.values, strict=True)
        return {_key(key, names): evaluated(value, names) for key, value in pairs}
    if isinstance(node, (ast.Subscript, ast.Attribute)):
        return _entry(node, names)
    raise TypeError


def _summed(node: ast.UnaryOp | ast.BinOp, names: Names) -> Worked:
    if isinstance(node, ast.UnaryOp):
        inner = evaluated(node.operand, names)
        return not inner if isinstance(node.op, ast.Not) else _SIGNS[type(node.op)] * _number(inner)
    left, right = evaluated(node.left, names), evaluated(node.right, names)
    if isinstance(node.op, ast.Pow):
        return math.pow(_number(left), _number(right))
    if isinstance(node.op, ast.Add) and isinstance(left, str) and isinstance(right, str):
        return left + right
    return _ARITHMETIC[type(node.op)](_number(left), _number(right))


def _compared(node: ast.Compare, names: Names) -> bool:
    """Compare plain values, or look one up among the entries of a list or the keys of a dictionary."""
    left, right = _plain(evaluated(node.left, names)), evaluated(node.comparators[0], names)
    if isinstance(node.ops[0], (ast.In, ast.NotIn)):
        if not isinstance(right, (tuple, Mapping)):
            raise TypeError
        names.spend(len(right))
        return (left in right) == isinstance(node.ops[0], ast.In)
    return _COMPARISONS[type(node.ops[0])](left, _plain(right))


def _called(node: ast.Call, names: Names) -> Worked:
    """Call one of the functions that are known by name, also as `math.` and `xacro.` have them."""
    function, values = _function(node.func), [evaluated(part, names) for part in node.args]
    if function == "dict":
        return _dictionary(values, node.keywords, names)
    if node.keywords:
        raise TypeError
    if function == "len" and len(values) == 1 and isinstance(values[0], (str, tuple, Mapping)):
        return len(values[0])
    if function in ("load_yaml", "arg") and len(values) == 1 and isinstance(values[0], str):
        return names.load_yaml(values[0]) if function == "load_yaml" else names.argument(values[0])
    return FUNCTIONS[function](*map(_number, values))


def _function(node: ast.expr) -> str:
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        of_math = node.value.id == "math" and node.attr in FUNCTIONS
        return node.attr if of_math or node.value.id == "xacro" else ""
    if isinstance(node, ast.Name) and node.id != "arg":
        return node.id
    raise TypeError


def _dictionary(values: list[Worked], keywords: list[ast.keyword], names: Names) -> Mapping[Key, Worked]:
    """Return dict(a=1), dict(other, a=1) or dict([('a', 1)])."""
    made: dict[Key, Worked] = {}
    for value in values:
        if isinstance(value, Mapping):
            names.spend(len(value))
            made.update(value)
            continue
        names.spend(len(value) if isinstance(value, tuple) else 1)
        for pair in value if isinstance(value, tuple) else (None,):
            if not isinstance(pair, tuple) or len(pair) != 2:
                raise TypeError
            made[_plain(pair[0])] = pair[1]
    for keyword in keywords:
        if keyword.arg is None:
            raise TypeError
        made[keyword.arg] = evaluated(keyword.value, names)
    return made


def _entry(node: ast.Subscript | ast.Attribute, names: Names) -> Worked:
    """Return an entry of a list or a dictionary, or a piece of a list; dots are another way to write a key."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "math":
        return _CONSTANTS[node.attr]
    inside = evaluated(node.value, names)
    if isinstance(node, ast.Attribute):
        if not isinstance(inside, Mapping):
            raise TypeError
        return inside[node.attr]
    if isinstance(node.slice, ast.Slice):
        if not isinstance(inside, tuple) or node.slice.step is not None:
            raise TypeError
        ends = (node.slice.lower, node.slice.upper)
        first, last = (None if end is None else _whole(evaluated(end, names)) for end in ends)
        names.spend(len(inside))
        return inside[first:last]
    if isinstance(inside, Mapping):
        key = _key(node.slice, names)
        return inside[key] if key in inside else inside[str(key)]  # a YAML file's keys are texts
    if isinstance(inside, tuple):
        return inside[_whole(evaluated(node.slice, names))]
    raise TypeError


def _first_that(is_true: bool, values: Iterator[Worked]) -> Worked:
    """Return the first value that is true, or false; the last one when there is none."""
    value: Worked = False
    for value in values:
        if bool(value) == is_true:
            break
    return value


def _key(node: ast.expr | None, names: Names) -> Key:
    if node is None:
        raise TypeError
    return _plain(evaluated(node, names))


def _plain(value: Worked) -> Key:
    if not isinstance(value, (int, float, str)):
        raise TypeError
    return value


def _whole(value: Worked) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise TypeError
    return value


def _number(value: Worked) -> float | int:
    if not isinstance(value, (int, float)):
        raise TypeError
    if abs(value) > MAX_SIZE:
        raise OverflowError
    return value
