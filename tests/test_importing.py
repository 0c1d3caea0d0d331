"""Importing RigLens does nothing but import: no file, no folder, no setting of another package; and no circles."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.waiting import TIMEOUT_S

REPOSITORY = Path(__file__).resolve().parents[1]
EVERY_MODULE = """
import importlib, pathlib, sys
import numba
settings = lambda: {name: repr(value) for name, value in vars(numba.config).items() if name.isupper()}
before = settings()
for room in ("core", "widgets", "riglens", "app"):
    folder = pathlib.Path(sys.argv[1]) / room
    for path in sorted(folder.rglob("*.py")):
        parts = path.relative_to(folder.parent).with_suffix("").parts
        name = ".".join(parts if room == "riglens" else ("riglens", *parts))
        if not name.endswith("__main__"):
            importlib.import_module(name)
changed = {name: value for name, value in settings().items() if value != before[name]}
assert not changed, changed
"""
KERNEL_OF_A_USER = """
import numba, numba.core.caching
import riglens.core.engine.engine

@numba.njit(cache=True)
def twice(x):
    return 2 * x

assert twice(2) == 4
print(twice.stats.cache_path)
"""


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """A home folder in which nothing is."""
    home = tmp_path / "home"
    home.mkdir()
    return home


def run(home: Path, *arguments: str | Path) -> str:
    """Standard output of Python with that home; it must end well."""
    names = ("PATH", "LANG", "DISPLAY", "QT_QPA_PLATFORM", "LIBGL_ALWAYS_SOFTWARE")
    environment = {name: os.environ[name] for name in names if name in os.environ}
    environment |= {"HOME": str(home), "PYTHONPATH": str(REPOSITORY), "PYTHONDONTWRITEBYTECODE": "1"}
    environment["MPLCONFIGDIR"] = str(home.parent / "matplotlib")  # it makes folders when it is imported
    command = [sys.executable, *arguments]
    done = subprocess.run(
        command, env=environment, cwd=home.parent, capture_output=True, encoding="utf-8", timeout=TIMEOUT_S
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_every_module_is_imported_without_a_file_or_a_setting(home: Path) -> None:
    run(home, "-c", EVERY_MODULE, REPOSITORY)
    assert [str(path.relative_to(home)) for path in home.rglob("*")] == []


def test_engine_window_and_commands_are_imported_where_no_home_can_be_written(home: Path) -> None:
    home.rmdir()
    home.write_text("a file: not even root can make folders in it", encoding="utf-8")
    run(
        home,
        "-c",
        "import riglens.core.engine.engine, riglens.app.window.start, riglens.app.commands.parsing",
    )


def test_a_kernel_of_the_user_is_cached_where_numba_would_put_it(home: Path) -> None:
    script = home.parent / "users_kernel.py"
    script.write_text(KERNEL_OF_A_USER, encoding="utf-8")
    assert Path(run(home, script).strip()) == home.parent / "__pycache__"
    assert list((home.parent / "__pycache__").glob("users_kernel.twice-*.nbc"))
    assert not list(home.rglob("*"))


def imported() -> dict[str, set[str]]:
    """The modules that each module imports: at its top, in functions, and for types alone."""
    files = {}
    for floor in ("core", "widgets", "riglens", "app"):
        for path in (REPOSITORY / floor).rglob("*.py"):
            parts = path.relative_to(REPOSITORY).with_suffix("").parts
            named = parts if floor == "riglens" else ("riglens", *parts)
            files[".".join(named).removesuffix(".__init__")] = path
    found = {}
    for module, path in files.items():
        names = set()
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                names |= {name.name for name in node.names}
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{path}: relative imports are not followed here"
                whole = {f"{node.module}.{name.name}" for name in node.names}
                names |= whole if whole & files.keys() else {str(node.module)}
        found[module] = (names & files.keys()) - {module}
    return found


def reached(start: str, imports: dict[str, set[str]]) -> set[str]:
    found: set[str] = set()
    waiting = [start]
    while waiting:
        new = imports[waiting.pop()] - found
        found |= new
        waiting += new
    return found


def test_no_modules_import_each_other_in_a_circle() -> None:
    imports = imported()
    reach = {module: reached(module, imports) for module in imports}
    assert len(imports) > 500 and max(map(len, reach.values())) > 300
    circles = {
        frozenset(other for other in found if module in reach[other])
        for module, found in reach.items()
        if module in found
    }
    assert circles == set()
