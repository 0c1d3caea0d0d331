"""Small valid files, changed bit by bit, and a few numbers that stand for all that is read then.

A line, or a key of JSON, is left out, or a number is replaced. `python -m tests.core.test_small_inputs` and `python -m
tests.core.formats.test_small_files` keep the numbers anew after a wanted change.
"""

from __future__ import annotations

import json
import math
import re
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel

from riglens.core.errors import InputError

Outcome = list[float] | None
"""Sums over the values read, or None if the input was rejected."""
Files = Mapping[str, str]
NUMBER = re.compile(r"(?<![\w.#-])-?\d+\.?\d*(?:e-?\d+)?(?![\w.])")
INSTEAD = ("0", "-1", "1e9", "7.5")
MOST = 30
"""Changes of a kind in one file."""


def changes(name: str, text: str) -> Iterator[str]:
    """Yield the text without each of its lines, or keys of JSON, and with another number in place of each."""
    yield from some(without_keys(text) if name.endswith(".json") else without_lines(text))
    yield from some(other_numbers(text))


def some(found: Iterator[str]) -> list[str]:
    """Return MOST of the texts at most, evenly from all."""
    texts = list(found)
    return texts[:: max(1, math.ceil(len(texts) / MOST))]


def without_lines(text: str) -> Iterator[str]:
    lines = text.splitlines(keepends=True)
    for n in range(len(lines)):
        yield "".join(lines[:n] + lines[n + 1 :])


def without_keys(text: str) -> Iterator[str]:
    root = json.loads(text)
    for place in places(root):
        for key in [*place]:
            value = place.pop(key)
            yield json.dumps(root)
            place[key] = value


def places(value: Any) -> Iterator[dict[str, Any]]:
    if isinstance(value, dict):
        yield value
    if isinstance(value, dict | list):
        for inner in [*(value.values() if isinstance(value, dict) else value)]:
            yield from places(inner)


def other_numbers(text: str) -> Iterator[str]:
    for n, found in enumerate(NUMBER.finditer(text)):
        yield text[: found.start()] + INSTEAD[n % len(INSTEAD)] + text[found.end() :]


def outcomes(files: Files, read: Callable[[Files], Iterable[object]]) -> list[Outcome]:
    """Return what is read from files as they are, and with each change; `read` yields what is added up."""

    def outcome(changed: Files) -> Outcome:
        try:
            return [weighed(one) for one in read(changed)]
        except InputError:
            return None

    every = ({**files, name: text} for name in files for text in changes(name, files[name]))
    return [outcome(files), *map(outcome, every)]


def weighed(value: object) -> float:
    """Return a sum over all numbers and words in something, each with a weight of its own."""
    return sum(one * math.sqrt(n + 2) for n, one in enumerate(numbers(value)))


def numbers(value: Any) -> Iterator[float]:
    match value:
        case BaseModel():
            yield from numbers(value.model_dump())
        case np.ndarray():
            yield from numbers(value.tolist())
        case dict():
            yield from numbers(sorted(value.items(), key=str))
        case set() | frozenset():
            yield from numbers(sorted(value))
        case list() | tuple():
            yield len(value)
            for inner in value:
                yield from numbers(inner)
        case float() | int():
            yield value if math.isfinite(value) else 0.25
        case _ if is_dataclass(value):
            for one in fields(value):
                yield from numbers(getattr(value, one.name))
        case _:
            yield zlib.crc32(str(value).encode()) / 2**32


def keep(kept: Path, every: Mapping[str, list[Outcome]]) -> None:
    """Write what comparisons rest on."""
    lines = (f"  {json.dumps(case)}: {json.dumps(found)}" for case, found in every.items())
    kept.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def compare(kept: Path, case: str, found: list[Outcome]) -> None:
    expected = json.loads(kept.read_text(encoding="utf-8"))[case]
    assert [one is None for one in found] == [one is None for one in expected]
    for mine, theirs in zip(found, expected, strict=True):
        assert mine == (theirs and pytest.approx(theirs, rel=1e-9, abs=1e-9))
