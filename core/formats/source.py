"""A foreign file or folder as plain data, read within limits: size, depth, no aliases, no entities, no duplicates."""

from __future__ import annotations

import json
import math
import os
import re
import tomllib
from collections.abc import Callable, Iterator
from functools import cached_property
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.formats.unread import Key, Reads
from riglens.core.formats.xml_tree import Element, parse_xml
from riglens.core.geometry import Vec3
from riglens.core.reading_time import MAX_RIG_S, ReadingTime
from riglens.core.rig.yaml.nodes import parse_yaml, plain_value, read_text, shortened, shown_path

YAML = (".yaml", ".yml")
FOREIGN_ENDINGS = (".json", ".toml", ".urdf", ".xacro", ".sdf", ".world", ".xml", ".txt", ".py", ".feather")
"""Of rigs, also those of other programs."""
MAX_METRES = 1e6
MAX_ANGLE = 1e6
MAX_PIXELS = 20_000


class Value:
    """A value of a JSON, YAML or TOML document; `path` is the readable name of the field.

    `reads` records which fields were used; values inside know their holder and their key in it.
    """

    def __init__(
        self,
        value: Any,
        where: str,
        path: str = "",
        reads: Reads | None = None,
        holder: Value | None = None,
        key: Key = "",
    ) -> None:
        self.raw = value
        self._where = where
        self._path = path
        self._reads, self._holder, self._key = reads, holder, key

    def use(self) -> Value:
        """Note that the value is used, and return it; what returns content does that by itself."""
        one = self
        while one._reads and one._holder is not None and one._reads.use(one._holder.raw, one._key):
            one = one._holder
        return self

    def refuse(self, accepted: str, found: str | None = None) -> NoReturn:
        """Raise InputError `file: field: must be ... (got ...)`."""
        said = self._shown() if found is None else found
        place = f"{self._path}: " if self._path else ""
        raise InputError(f"{self._where}: {place}must be {accepted} (got {said})")

    @property
    def place(self) -> tuple[str, str]:
        """File and field, for a value derived from this one."""
        return self._where, self._path

    @property
    def is_mapping(self) -> bool:
        """Return whether this has named fields."""
        return isinstance(self.raw, dict)

    @property
    def is_list(self) -> bool:
        """Return whether this is a list."""
        return isinstance(self.raw, (list, tuple))

    def __contains__(self, key: str) -> bool:
        return isinstance(self.raw, dict) and self.raw.get(key) is not None

    def get(self, key: str) -> Value | None:
        """Return the field of that name, None when missing or null; raise InputError when this is not a mapping."""
        if not isinstance(self.raw, dict):
            self.refuse("a mapping of names to values")
        found = self.raw.get(key)
        return None if found is None else self._inner(found, key, key)

    def item(self, key: str, default: Any = None) -> Value:
        """Return the field of that name, or a default; raise InputError when it is missing and has none."""
        found = self.get(key)
        if found is None and default is None:
            place = f"{self._path}.{key}" if self._path else key
            raise InputError(f"{self._where}: {shortened(place, 120)}: missing")
        return Value(default, self._where, self._place_of(key)) if found is None else found

    def items(self) -> Iterator[tuple[str, Value]]:
        """Yield the names and values of a mapping, in the order of the file."""
        if not isinstance(self.raw, dict):
            self.refuse("a mapping of names to values")
        for key, value in self.raw.items():
            yield str(key), self._inner(value, str(key), key)

    def elements(self, count: int | None = None) -> list[Value]:
        """Return the elements of a list, which must have exactly `count` where that is given."""
        if not isinstance(self.raw, (list, tuple)):
            self.refuse("a list")
        if count is not None and len(self.raw) != count:
            self.refuse(f"a list of {count}", f"a list of {len(self.raw)}")
        place = (f"{self._path}[{index}]" for index in range(len(self.raw)))
        return [
            Value(value, self._where, next(place), self._reads, self, index)
            for index, value in enumerate(self.raw)
        ]

    def text(self) -> str:
        """Return a text; JSON can express halves of characters (surrogates), which no file can hold."""
        if not isinstance(self.raw, str) or not is_encodable(self.raw):
            self.refuse("a text")
        self.use()
        return self.raw

    def number(self, low: float = -MAX_METRES, high: float = MAX_METRES, quoted: bool = False) -> float:
        """Return a finite number in [low, high]; with `quoted` one written as a text is accepted too."""
        value = self.raw
        if quoted and isinstance(value, str):
            value = _number_in(value)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
            self.refuse(f"a number from {low:g} to {high:g}")
        self.use()
        return float(value)

    def whole(self, low: int, high: int, quoted: bool = False) -> int:
        """Return a whole number in [low, high]."""
        value = self.number(low, high, quoted)
        if value != int(value):
            self.refuse(f"an integer from {low} to {high}")
        return int(value)

    def numbers(self, count: int | None = None, limit: float = MAX_METRES) -> list[float]:
        """Return a list of finite numbers within ±limit."""
        return [element.number(-limit, limit) for element in self.elements(count)]

    def vector(self, limit: float = MAX_METRES) -> Vec3:
        """Return three finite numbers within ±limit."""
        x, y, z = self.numbers(3, limit)
        return x, y, z

    def matrix(self, rows: int, columns: int) -> NDArray[np.float64]:
        """Return a matrix as a list of rows."""
        return np.array([row.numbers(columns) for row in self.elements(rows)])

    def image(self, *names: str, quoted: bool = False) -> tuple[int, int]:
        """Return the width and height in named fields, pixels."""
        width, height = (
            self.item(name).whole(1, MAX_PIXELS, quoted) for name in names or ("width", "height")
        )
        return width, height

    def field_numbers(self, *names: str) -> list[float]:
        """Return the numbers in named fields, one for each name; all must be there."""
        return [self.item(name).number() for name in names]

    def _inner(self, value: Any, name: str, key: Key) -> Value:
        return Value(value, self._where, self._place_of(name), self._reads, self, key)

    def _place_of(self, name: str) -> str:
        place = shortened(name)
        return f"{self._path}.{place}" if self._path else place

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


def ros_parameters(root: Value) -> Value:
    """Return the parameters of a node of ROS 2, or the file itself where it is none."""
    node = next(iter(root.items()), None) if root.is_mapping else None
    return node[1].item("ros__parameters") if node is not None and "ros__parameters" in node[1] else root


def is_encodable(text: str) -> bool:
    """Return whether a text can be written as UTF-8."""
    return text.isascii() or not any("\ud800" <= letter <= "\udfff" for letter in text)


def _number_in(text: str) -> float:
    """Return the number in a text, NaN when there is none."""
    try:
        return float(text) if len(text) < 100 and "_" not in text else math.nan
    except ValueError:
        return math.nan


MAX_JSON_BYTES = 16_000_000
MAX_TEXT_BYTES = 1_000_000
MAX_YAML_BYTES = 200_000
MAX_CODE_BYTES = 300_000
MAX_TOML_BYTES = 200_000
MAX_JSON_VALUES = 2_000_000
"""Commas and brackets, which come before each value; an empty list of two characters takes 64 bytes of memory."""
MAX_DOTS = 500
"""In a line of TOML; the parser's time grows with the square of a key's parts."""
MAX_BYTES = {
    ".json": MAX_JSON_BYTES,
    ".py": MAX_CODE_BYTES,
    ".toml": MAX_TOML_BYTES,
}
_BOM = "\ufeff"
_OPENCV_HEADER = re.compile(r"\A%YAML:1\.[0-9][ \t]*(?:#[^\r\n]*)?(?=\r?$)", re.MULTILINE)
_OPENCV_KEY = re.compile(r"^([ \t]*[A-Za-z_][\w.]*):(?=[^\s:/\\])", re.MULTILINE)
"""A key without a space behind its colon, which OpenCV accepts."""
_OPENCV_MATRIX = re.compile(r"(:[ \t]+)!!opencv-matrix(?=[ \t\r]*(?:[{#]|$))", re.MULTILINE)


class Source:
    """File named by the user, read at most once, or a folder with files of known names.

    All files of a rig share one limit of `time`, and the record of which of their fields were used.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        time: ReadingTime | None = None,
        reads: Reads | None = None,
    ) -> None:
        self.path = Path(path)
        self.where = shown_path(self.path)
        self.time = time or ReadingTime(self.where, MAX_RIG_S)
        self.reads = reads or Reads()
        self.is_folder = self.path.is_dir()
        name = self.path.name.lower()
        self.suffix = Path(name.removesuffix(".gz")).suffix
        self.is_packed = name.endswith(".gz")

    @property
    def folder(self) -> Path:
        """The folder itself, or the one that the file lies in."""
        return self.path if self.is_folder else self.path.parent

    @property
    def name(self) -> str:
        """The name without its ending, for a rig that has none."""
        stem = self.path.resolve().name if self.is_folder else self.path.name.split(".")[0]
        return shortened(stem, 100) or "imported"

    def sibling(self, *names: str) -> Source | None:
        """Return the first file of those names in the folder, None when there is none."""
        for name in names:
            if (self.folder / name).is_file():
                return self.another(self.folder / name)
        return None

    def siblings(self, pattern: str, most: int = 64) -> list[Source]:
        """Return the files of the folder that match a pattern, by name; refused when they are very many."""
        paths = sorted(path for path in self.folder.glob(pattern) if path.is_file())
        if len(paths) > most:
            raise InputError(f"{self.where}: must be at most {most} files {pattern} (got {len(paths)})")
        return [self.another(path) for path in paths]

    def another(self, path: Path) -> Source:
        """Return a file that belongs to this one, under the same limit of time."""
        return Source(path, self.time, self.reads)

    def value(self, raw: Any, path: str = "") -> Value:
        """Return a document, or a part of one, whose fields are accounted for."""
        self.reads.add(raw)
        return Value(raw, self.where, path, self.reads)

    @cached_property
    def written(self) -> str:
        """The text of the file, UTF-8, with its byte order mark; raise InputError when it cannot be had."""
        self.time.check()
        limit = MAX_BYTES.get(self.suffix, MAX_TEXT_BYTES)
        return read_text(self.path, "a rig file", limit, self.is_packed)

    @property
    def text(self) -> str:
        """The text of the file, UTF-8; raise InputError when it is missing, too large or not text."""
        return self.written.removeprefix(_BOM)

    @cached_property
    def json(self) -> Value:
        """The JSON document; raise InputError with the line for broken JSON, NaN, keys given twice, deep nesting."""
        return self.value(self._parsed(_load_json))

    @cached_property
    def yaml(self) -> Value:
        """The YAML document, plain data only, also as OpenCV writes it; raise InputError with the line."""
        if len(self.text) > MAX_YAML_BYTES:
            raise InputError(f"{self.where}: too large for a rig file (at most {MAX_YAML_BYTES / 1e3:g} kB)")
        text, is_opencv = _OPENCV_HEADER.subn("", self.text, count=1)
        text = _OPENCV_MATRIX.sub(r"\1", _OPENCV_KEY.sub(r"\1: ", text) if is_opencv else text)
        return self.value(plain_value(parse_yaml(text, self.where)))

    @cached_property
    def storage(self) -> Value:
        """The document of OpenCV's FileStorage: YAML, JSON, or XML with the same names as YAML."""
        if self.suffix == ".json":
            return self.json
        return self.value(_opencv_xml(self.xml)) if self.suffix == ".xml" else self.yaml

    @cached_property
    def toml(self) -> Value:
        """The TOML document; raise InputError with the reason."""
        for number, line in enumerate(self.text.split("\n"), 1):
            if line.count(".") > MAX_DOTS:
                raise InputError(f"{self.where}:{number}: too many dots in a line (at most {MAX_DOTS})")
        return self.value(self._parsed(tomllib.loads))

    @cached_property
    def xml(self) -> Element:
        """The root of the XML document; entities and document types are refused."""
        return parse_xml(self.text, self.where)

    def _parsed(self, parse: Callable[[str], Any]) -> Any:
        try:
            return parse(self.text)
        except json.JSONDecodeError as error:
            problem = f"not valid JSON: {error.msg}"
            raise InputError(f"{self.where}:{error.lineno}: {problem}") from error
        except RecursionError as error:
            raise InputError(f"{self.where}: nested too deeply for a rig file") from error
        except ValueError as error:
            raise InputError(f"{self.where}: {shortened(str(error), 160)}") from error


def _opencv_xml(element: Element) -> Any:
    """Return an element of OpenCV's XML as plain data: a mapping or list of its children, numbers, or its text."""
    if element.children:
        found = [(child.tag, _opencv_xml(child)) for child in element.children]
        named = dict(found)
        return named if len(named) == len(found) else [value for _, value in found]
    words = element.text.split()
    numbers = [_number_in(word) for word in words]
    if not words or any(map(math.isnan, numbers)):
        return element.text.strip().strip('"')
    is_data = element.tag == "data" or len(numbers) > 1
    return numbers if is_data else int(numbers[0]) if numbers[0].is_integer() else numbers[0]


def _load_json(text: str) -> Any:
    if sum(map(text.count, ",[{")) > MAX_JSON_VALUES:
        raise ValueError(f"too many values for a rig file (at most {MAX_JSON_VALUES})")
    return json.loads(text, object_pairs_hook=_unique, parse_constant=_refuse_constant)


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    fields: dict[str, Any] = {}
    for key, value in pairs:
        if not is_encodable(key):
            raise ValueError("a key is not UTF-8 text")
        if key in fields:
            raise ValueError(f"key '{shortened(key)}' is given twice in one object")
        fields[key] = value
    return fields


def _refuse_constant(word: str) -> Any:
    raise ValueError(f"numbers must be finite (got {word})")
