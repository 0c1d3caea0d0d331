"""Objects from the entry points of installed packages, and what is told about those that cannot be used."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import pytest

from riglens.core.extensions import extended, extensions, first_fitting

_NUMBERS = count()
Install = Callable[..., str]


@dataclass(frozen=True)
class Tool:
    name: str
    size: int = 0


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Put packages on the path, each with one module that has THING; return their group, which no other test has."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def install(**modules: str) -> str:
        group = f"riglens.tests{next(_NUMBERS)}"
        for name, source in modules.items():
            unique = f"{name}_{group.partition('.')[2]}"
            (tmp_path / f"{unique}.py").write_text(
                f"from {__name__} import Tool\n{source}\n", encoding="utf-8"
            )
            folder = tmp_path / f"{name}-1.5.dist-info"
            folder.mkdir()
            (folder / "METADATA").write_text(
                f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.5\n", encoding="utf-8"
            )
            (folder / "entry_points.txt").write_text(
                f"[{group}]\n{name} = {unique}:THING\n", encoding="utf-8"
            )
        return group

    return install


def test_objects_come_after_the_built_in_ones_in_the_order_of_their_packages(install: Install) -> None:
    group = install(zeta="THING = Tool('a')", alpha="THING = Tool('z')")
    assert list(extended(group, {"own": Tool("own")}, Tool)) == ["own", "z", "a"]


def test_names_may_come_from_elsewhere(install: Install) -> None:
    group = install(alpha="THING = Tool('x', 3)")
    assert extended(group, {}, Tool, name_of=lambda tool: str(tool.size)) == {"3": Tool("x", 3)}


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("import no_such_module", "no_such_module"),
        ("raise SystemExit('bye')", "bye"),
        ("raise ValueError('two\\nlines')", "two lines"),
        ("1 +", "SyntaxError"),
        ("OTHER = 3", "THING"),
        ("THING = 'a text'", "str"),
        ("THING = Tool('own')", "own"),
    ],
)
def test_a_package_that_cannot_be_used_is_named_once(
    install: Install, caplog: pytest.LogCaptureFixture, source: str, said: str
) -> None:
    group = install(broken=source, fine="THING = Tool('fine')")
    for _ in range(2):
        assert list(extended(group, {"own": Tool("own")}, Tool)) == ["own", "fine"]
    (message,) = caplog.messages
    assert "broken 1.5" in message and said in message and "\n" not in message


def test_objects_for_another_registry_are_left_to_it(
    install: Install, caplog: pytest.LogCaptureFixture
) -> None:
    group = install(numbers="THING = 3", tools="THING = Tool('x')")
    assert list(extended(group, {}, Tool, beside=(int,))) == ["x"]
    assert caplog.messages == []


def test_one_that_fails_when_it_is_asked_is_passed_over(
    install: Install, caplog: pytest.LogCaptureFixture
) -> None:
    group = install(a="THING = Tool('a', 0)", b="THING = Tool('b', 5)")
    tools = [thing for _, thing in extensions(group)]
    found = first_fitting(group, tools, lambda tool: 10 // tool.size == 2)
    assert found == Tool("b", 5)
    (message,) = caplog.messages
    assert "a 1.5" in message and "ZeroDivisionError" in message
    assert first_fitting(group, tools[1:], lambda tool: False) is None
