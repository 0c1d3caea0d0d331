"""Plain data from a foreign file with its place in it: every access is checked, every error names file and field."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.geometry import Vec3
from riglens.core.rig.yaml_nodes import shortened

MAX_METRES = 1e6
MAX_ANGLE = 1e6


class Value:
    """A value of a JSON, YAML or TOML document; `path` is how a person would name the field."""

    def __init__(self, value: Any, where: str, path: str = "") -> None:
        self.raw = value
        self._where = where
        self._path = path

    def refuse(self, accepted: str, found: str | None = None) -> NoReturn:
        """Raise InputError `file: field: found ...; accepted is ...`."""
        said = self._shown() if found is None else found
        place = f"{self._path}: " if self._path else ""
        raise InputError(f"{self._where}: {place}found {said}; accepted is {accepted}")

    @property
    def place(self) -> tuple[str, str]:
        """File and field, for a value that is made out of this one."""
        return self._where, self._path

    @property
    def is_mapping(self) -> bool:
        """Whether this has named fields."""
        return isinstance(self.raw, dict)

    @property
    def is_list(self) -> bool:
        """Whether this is a list."""
        return isinstance(self.raw, (list, tuple))

    def __contains__(self, key: str) -> bool:
        return isinstance(self.raw, dict) and self.raw.get(key) is not None

    def get(self, key: str) -> Value | None:
        """The field of that name, None when it is missing or null; refused when this is no mapping."""
        if not isinstance(self.raw, dict):
            self.refuse("a mapping of names to values")
        found = self.raw.get(key)
        return None if found is None else self._inner(found, key)

    def item(self, key: str) -> Value:
        """The field of that name; refused when it is missing."""
        found = self.get(key)
        if found is None:
            place = f"{self._path}.{key}" if self._path else key
            raise InputError(f"{self._where}: {shortened(place, 120)}: missing")
        return found

    def items(self) -> Iterator[tuple[str, Value]]:
        """Names and values of a mapping, in the order of the file."""
        if not isinstance(self.raw, dict):
            self.refuse("a mapping of names to values")
        for key, value in self.raw.items():
            yield str(key), self._inner(value, str(key))

    def elements(self, count: int | None = None) -> list[Value]:
        """The elements of a list, of exactly `count` of them where that is given."""
        if not isinstance(self.raw, (list, tuple)):
            self.refuse("a list")
        if count is not None and len(self.raw) != count:
            self.refuse(f"a list of {count}", f"a list of {len(self.raw)}")
        return [Value(value, self._where, f"{self._path}[{index}]") for index, value in enumerate(self.raw)]

    def text(self) -> str:
        """A text; JSON can say halves of characters (surrogates), which no file can hold."""
        if not isinstance(self.raw, str) or not is_encodable(self.raw):
            self.refuse("a text")
        return self.raw

    def number(self, low: float = -MAX_METRES, high: float = MAX_METRES, quoted: bool = False) -> float:
        """A finite number in [low, high]; with `quoted` one written as a text is accepted too."""
        value = self.raw
        if quoted and isinstance(value, str):
            value = _number_in(value)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
            self.refuse(f"a number from {low:g} to {high:g}")
        return float(value)

    def whole(self, low: int, high: int, quoted: bool = False) -> int:
        """A whole number in [low, high]."""
        value = self.number(low, high, quoted)
        if value != int(value):
            self.refuse(f"a whole number from {low} to {high}")
        return int(value)

    def numbers(self, count: int | None = None, limit: float = MAX_METRES) -> list[float]:
        """A list of finite numbers within ±limit."""
        return [element.number(-limit, limit) for element in self.elements(count)]

    def vector(self, limit: float = MAX_METRES) -> Vec3:
        """Three finite numbers within ±limit."""
        x, y, z = self.numbers(3, limit)
        return x, y, z

    def matrix(self, rows: int, columns: int) -> NDArray[np.float64]:
        """A matrix as a list of rows."""
        return np.array([row.numbers(columns) for row in self.elements(rows)])

    def field_numbers(self, *names: str) -> list[float]:
        """Numbers in named fields, one for each name; all must be there."""
        return [self.item(name).number() for name in names]

    def _inner(self, value: Any, key: str) -> Value:
        place = shortened(key)
        return Value(value, self._where, f"{self._path}.{place}" if self._path else place)

    def _shown(self) -> str:
        if isinstance(self.raw, dict):
            return "a mapping"
        if isinstance(self.raw, (list, tuple)):
            return f"a list of {len(self.raw)}"
        if self.raw is None:
            return "nothing"
        if isinstance(self.raw, int) and abs(self.raw) > 1 << 64:
            return "a very large number"
        return shortened(str(self.raw))


def is_encodable(text: str) -> bool:
    """Whether a text can be written as UTF-8."""
    return text.isascii() or not any("\ud800" <= letter <= "\udfff" for letter in text)


def _number_in(text: str) -> float:
    """The number that a text says; not a number when it says something else."""
    try:
        return float(text) if len(text) < 100 and "_" not in text else math.nan
    except ValueError:
        return math.nan
