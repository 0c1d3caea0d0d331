"""The package is laid out for static tools as a wheel holds it, in links or, where those are not allowed, in copies."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]


@pytest.fixture
def static_tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The tool on a small checkout of its own."""
    for name in ("riglens/__init__.py", "app/__init__.py", "assets/a.csv", "core/grid.py", "widgets/x.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(name)
    spec = importlib.util.spec_from_file_location("static_tree", REPOSITORY / "tools" / "static_tree.py")
    assert spec is not None and spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    monkeypatch.setattr(tool, "ROOT", tmp_path)
    monkeypatch.setattr(tool, "STATIC", tmp_path / "build" / "static")
    return tool


def content(tool: ModuleType) -> dict[str, str]:
    package = tool.STATIC / "riglens"
    files = (path for name in tool.ROOMS for path in (package / name).iterdir())
    return {str(path.relative_to(package)): path.read_text() for path in (package / "__init__.py", *files)}


@pytest.mark.parametrize("may_link", [True, False])
def test_it_shows_the_checkout_as_it_is_each_time(
    may_link: bool, static_tree: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not may_link:
        monkeypatch.setattr(Path, "symlink_to", refuse)
    static_tree.lay_out()
    assert (static_tree.STATIC / "riglens" / "core").is_symlink() == may_link
    names = {"app/__init__.py", "assets/a.csv", "core/grid.py", "widgets/x.py"}
    assert content(static_tree) == {"__init__.py": "riglens/__init__.py"} | {name: name for name in names}
    (static_tree.ROOT / "core" / "grid.py").rename(static_tree.ROOT / "core" / "cube.py")
    (static_tree.STATIC / "riglens" / "stray.py").touch()
    static_tree.lay_out()
    assert "core/cube.py" in content(static_tree) and "core/grid.py" not in content(static_tree)
    assert not (static_tree.STATIC / "riglens" / "stray.py").exists()


def refuse(*_: object, **__: object) -> None:
    raise OSError("A required privilege is not held by the client")
