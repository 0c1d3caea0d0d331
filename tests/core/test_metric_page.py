"""The table of docs/metric.md that leads from the paper's equations to the code names what there is."""

from __future__ import annotations

import importlib
import re
from functools import reduce
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
PAGE = (REPOSITORY / "docs" / "metric.md").read_text(encoding="utf-8")
ROW = re.compile(r"^\| ([0-9][^|]*) \| [^|\\]*(?:\\\|[^|\\]*)* \| ([^|]+) \| ([^|]+) \|$", re.MULTILINE)
CODE = re.compile(r"`([^`]+)`")
ROWS = [(equation, CODE.findall(names), CODE.findall(files)) for equation, names, files in ROW.findall(PAGE)]


def test_all_equations_are_in_the_table() -> None:
    told: set[int] = set()
    for equation, _, _ in ROWS:
        for part in equation.split(","):
            first, *last = (int(number) for number in part.split("–"))
            told |= set(range(first, (last or [first])[0] + 1))
    assert told == set(range(1, 18))


@pytest.mark.parametrize(("equation", "names", "files"), ROWS, ids=[row[0] for row in ROWS])
def test_the_functions_of_an_equation_are_where_the_table_says(
    equation: str, names: list[str], files: list[str]
) -> None:
    modules = [
        importlib.import_module("riglens." + path.removesuffix(".py").replace("/", ".")) for path in files
    ]
    for name in names:
        assert any(_has(module, name.split(".")) for module in modules), f"equation {equation}: {name}"


def _has(place: object, names: list[str]) -> bool:
    return reduce(lambda found, name: getattr(found, name, None), names, place) is not None
