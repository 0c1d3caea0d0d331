"""A foreign file or folder as plain data, read within limits: size, depth, no aliases, no entities, no duplicates."""

from __future__ import annotations

import gzip
import json
import os
import tomllib
import zlib
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any

from riglens.core.errors import InputError
from riglens.core.rig.formats.values import Value, is_encodable
from riglens.core.rig.formats.xml_tree import Element, parse_xml
from riglens.core.rig.text_file import shown_path
from riglens.core.rig.yaml_nodes import parse_yaml, plain_value, shortened

MAX_JSON_BYTES = 16_000_000
MAX_TEXT_BYTES = 1_000_000
MAX_YAML_BYTES = 200_000
_BOM = "\ufeff"


class Source:
    """What the user named: a file, read at most once, or a folder with files of known names."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.where = shown_path(self.path)
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
        """The first file of those names in the folder, None when there is none."""
        for name in names:
            if (self.folder / name).is_file():
                return Source(self.folder / name)
        return None

    def siblings(self, pattern: str, most: int = 64) -> list[Source]:
        """The files of the folder that match a pattern, by name; refused when they are very many."""
        paths = sorted(path for path in self.folder.glob(pattern) if path.is_file())
        if len(paths) > most:
            raise InputError(f"{self.where}: {len(paths)} files {pattern}; accepted are at most {most}")
        return [Source(path) for path in paths]

    @cached_property
    def text(self) -> str:
        """The text of the file, UTF-8; InputError when it is missing, too large or not text."""
        limit = {".json": MAX_JSON_BYTES, ".yaml": MAX_YAML_BYTES, ".yml": MAX_YAML_BYTES}
        content = _content(self.path, self.where, self.is_packed, limit.get(self.suffix, MAX_TEXT_BYTES))
        if b"\0" in content:
            raise InputError(f"{self.where}: not a text file; accepted is text in UTF-8")
        try:
            return content.decode("utf-8").removeprefix(_BOM)
        except UnicodeDecodeError as error:
            line = content.count(b"\n", 0, error.start) + 1
            found = f"found byte 0x{content[error.start]:02x}"
            raise InputError(f"{self.where}:{line}: not UTF-8 text, {found}; accepted is UTF-8") from error

    @cached_property
    def json(self) -> Value:
        """The JSON document; InputError with the line for broken JSON, NaN, keys given twice, deep nesting."""
        return Value(self._parsed(_load_json), self.where)

    @cached_property
    def yaml(self) -> Value:
        """The YAML document, plain data only; InputError with the line."""
        if len(self.text) > MAX_YAML_BYTES:
            raise InputError(f"{self.where}: larger than {MAX_YAML_BYTES / 1e3:g} kB; accepted is a rig file")
        return Value(plain_value(parse_yaml(self.text, self.where)), self.where)

    @cached_property
    def toml(self) -> Value:
        """The TOML document; InputError with what is wrong."""
        return Value(self._parsed(tomllib.loads), self.where)

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
            raise InputError(f"{self.where}: nested too deeply; accepted is a rig file") from error
        except ValueError as error:
            raise InputError(f"{self.where}: {shortened(str(error), 160)}") from error


def _content(path: Path, where: str, is_packed: bool, limit: int) -> bytes:
    try:
        with gzip.open(path) if is_packed else path.open("rb") as stream:
            content: bytes = stream.read(limit + 1)
    except FileNotFoundError as error:
        raise InputError(f"{where}: no such file") from error
    except IsADirectoryError as error:
        raise InputError(f"{where}: this is a folder; accepted is a file") from error
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise InputError(f"{where}: not a complete gzip file") from error
    except OSError as error:
        raise InputError(f"{where}: cannot be read: {error.strerror or error}") from error
    if len(content) > limit:
        raise InputError(f"{where}: larger than {limit / 1e6:g} MB; accepted is a rig file")
    return content


def _load_json(text: str) -> Any:
    return json.loads(text, object_pairs_hook=_unique, parse_constant=_refuse_constant)


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    fields: dict[str, Any] = {}
    for key, value in pairs:
        if not is_encodable(key):
            raise ValueError("a key is no text in UTF-8")
        if key in fields:
            raise ValueError(f"key '{shortened(key)}' is given twice in one object")
        fields[key] = value
    return fields


def _refuse_constant(word: str) -> Any:
    raise ValueError(f"found {word}; accepted are finite numbers")
