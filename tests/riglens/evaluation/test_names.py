"""Fields of messages: core knows them by their names in Python alone, and each is an option of some command."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from riglens.app.commands.parsing import app
from riglens.evaluation.names import label_of, option_of

ROOT = Path(__file__).resolve().parents[3]
NOT_OPTIONS = {"bearings_deg", "speeds_kmh", "name", "field", "key", "traffic", "width_m"}
"""Arguments of Python alone, variables, and what a command calls otherwise (`--blind-width`)."""


def nodes(floor: str, containing: str) -> Iterator[tuple[Path, ast.AST]]:
    """Yield the syntax of the files of a floor that contain a text."""
    for path in (ROOT / floor).rglob("*.py"):
        if containing in (source := path.read_text(encoding="utf-8")):
            yield from ((path, node) for node in ast.walk(ast.parse(source)))


def test_core_names_no_option_of_the_command_line() -> None:
    named = [
        f"{path.relative_to(ROOT)}:{node.lineno}: {word[0]}"
        for path, node in nodes("core", "--")
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        for word in [re.search(r"(?<![\w-])--[a-z][\w-]*", node.value)]
        if word and word[0] not in ("--index-url", "--fans-first")  # of pip, and of our own child process
    ]
    assert named == []


def fields() -> Iterator[str]:
    """Yield the field of every InputError in the sources that names one."""
    for floor in ("core", "app", "riglens"):
        for _, node in nodes(floor, "InputError("):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "InputError":
                yield from (one.value for one in node.args[1:] if isinstance(one, ast.Constant))


def options(of: object = app) -> Iterator[str]:
    """Yield every option of every command."""
    if of.default_command is not None:  # type: ignore[attr-defined]
        for argument in of.assemble_argument_collection():  # type: ignore[attr-defined]
            yield from argument.names
    for name in of:  # type: ignore[attr-defined]
        if not name.startswith("-"):
            yield from options(of[name])  # type: ignore[index]


def test_every_field_of_a_message_is_an_option() -> None:
    known, named = set(options()), set(fields()) - NOT_OPTIONS
    assert len(named) > 30
    assert {field for field in named if option_of(field) not in known} == set()


def test_fields_have_names_of_each_front_end() -> None:
    assert [option_of(field) for field in ("voxel_m", "camera_weight", "find_ground", "min_points")] == [
        "--voxel", "--lambda", "--ground", "--min-points",
    ]  # fmt: skip
    assert [label_of(field) for field in ("voxel_m", "min_height_px")] == ["Voxel", "Min height"]
