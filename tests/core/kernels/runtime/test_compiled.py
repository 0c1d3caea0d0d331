"""Compiled kernels are named by all sources that they are made of, so that none of them can be out of date."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numba
import pytest

from riglens.core.cache_folder import tell_damaged
from riglens.core.kernels.runtime.compiled import OLD_S, PREFIX, SOURCES, KernelCache, KernelFolder, Sources
from tests.waiting import TIMEOUT_S

INNER = """
from riglens.core.kernels.runtime.jit import inlined


@inlined
def step(x: int) -> int:
    return x + {}
"""
OUTER = """
from riglens.core.kernels.rays.inner import step
from riglens.core.kernels.runtime.jit import kernel


@kernel
def twice(x: int) -> int:
    return step(step(x))
"""
CALL = (
    "from riglens.core.kernels.rays.outer import twice; print(twice(0), sum(twice.stats.cache_hits.values()))"
)
LINK = """
import numba
from riglens.core.kernels.rays.inner import step
{}
thrice = numba.njit(lambda x: step(step(step(x))))
print(thrice(0), sum(step.stats.cache_hits.values()))
"""


@pytest.fixture
def user_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's cache folder, while Numba has been given none."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setenv("RIGLENS_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_a_change_of_a_source_changes_the_code_of_what_imports_it_and_nothing_else(tmp_path: Path) -> None:
    copy = tmp_path / "kernels"
    shutil.copytree(SOURCES, copy, ignore=shutil.ignore_patterns("__pycache__"))
    modules = [".".join(path.relative_to(copy).with_suffix("").parts) for path in sorted(copy.rglob("*.py"))]
    before = Sources(copy)
    assert before.digest == Sources().digest
    for changed in modules[::12]:
        source = copy / f"{changed.replace('.', '/')}.py"
        text = source.read_text(encoding="utf-8")
        source.write_text(text + "\n", encoding="utf-8")
        after = Sources(copy)
        source.write_text(text, encoding="utf-8")
        assert after.digest != before.digest
        for module in modules:
            is_made_of_it = changed in before.needed_by(module)
            assert (after.digest_of(module) != before.digest_of(module)) == is_made_of_it, (changed, module)


def test_what_a_source_imports_is_seen_however_far_it_is(tmp_path: Path) -> None:
    line = "from riglens.core.kernels.{} import thing\n"
    for name, imported in (("a", "b"), ("b", "c"), ("c", "a"), ("d", "a")):
        (tmp_path / f"{name}.py").write_text(
            '"""A file."""\n\nimport numpy as np\n\n' + line.format(imported), encoding="utf-8"
        )
    sources = Sources(tmp_path)
    assert sources.needed_by("a") == ("a", "b", "c")
    assert sources.needed_by("d") == ("a", "b", "c", "d")


@pytest.mark.parametrize("path", sorted(SOURCES.glob("*/*.py")), ids=lambda path: path.stem)
def test_kernels_take_from_one_another_in_the_one_way_that_is_looked_for(path: Path) -> None:
    """Python's own parser finds the same imports, and nothing of RigLens but kernels, apart from the cache's own."""
    own = f"{path.parent.name}.{path.stem}"
    imported, others = {own}, set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        assert not isinstance(node, ast.Import) or "riglens" not in ast.unparse(node)
        if isinstance(node, ast.ImportFrom) and "riglens" in (module := node.module or ""):
            name = module.removeprefix("riglens.core.kernels.")
            (others if name == module else imported).add(name)
        assert not isinstance(node, ast.ImportFrom) or not node.level
    sources = Sources()
    assert set(sources.needed_by(own)) == imported.union(*map(sources.needed_by, imported - {own}))
    assert not others or own == "runtime.compiled"


def test_a_kernel_follows_a_function_of_another_file_that_it_inlines(tmp_path: Path) -> None:
    kernels, package = tmp_path / "riglens" / "core" / "kernels", SOURCES.parent
    for room in ("rays", "runtime"):
        (kernels / room).mkdir(parents=True)
        (kernels / room / "__init__.py").touch()
    for name in (
        "__init__.py",
        "cache_folder.py",
        "errors.py",
        "files.py",
        "user_folders.py",
        "kernels/__init__.py",
        "kernels/runtime/jit.py",
        "kernels/runtime/compiled.py",
        "kernels/runtime/linked.py",
    ):
        shutil.copy(package / name, tmp_path / "riglens" / "core" / name)
    (tmp_path / "riglens" / "__init__.py").touch()
    (kernels / "rays" / "outer.py").write_text(OUTER, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "RIGLENS_CACHE_DIR": str(tmp_path / "cache")}
    environment.pop("NUMBA_CACHE_DIR", None)

    def call(step: int, program: str = CALL) -> list[str]:
        (kernels / "rays" / "inner.py").write_text(INNER.format(step), encoding="utf-8")
        command = [sys.executable, "-c", program]
        done = subprocess.run(
            command, env=environment, cwd=tmp_path, capture_output=True, encoding="utf-8", timeout=TIMEOUT_S
        )
        assert done.stderr == ""
        return done.stdout.split()

    assert [call(step) for step in (1, 1, 10)] == [["2", "0"], ["2", "1"], ["20", "0"]]
    assert call(10, LINK.format("")) == [
        "30",
        "1",
    ]  # a kernel from disk, inlined into one that is compiled now
    # the same, of one that Python calls too
    assert [call(10, LINK.format("step(0)")) for _ in range(2)] == [["30", "0"], ["30", "1"]]


def test_they_are_kept_in_the_users_cache_folder(user_cache: Path) -> None:
    path = KernelFolder().path
    assert path == user_cache / (PREFIX + f"numba-{numba.__version__}")
    assert path.is_dir()


def test_a_folder_that_the_user_gave_to_numba_holds_them(
    user_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "given"))
    path = KernelFolder().path
    assert path is not None and path.parent == tmp_path / "given"
    assert not user_cache.exists()


def test_without_a_cache_folder_they_are_kept_beside_their_sources_or_not_at_all(
    user_cache: Path, tmp_path: Path
) -> None:
    user_cache.write_text("a file where the folder should be", encoding="utf-8")
    sources = tmp_path / "kernels"
    path = KernelFolder(sources).path
    assert path is not None and path.parent == sources / "__pycache__"
    shutil.rmtree(sources)
    sources.write_text("a file here too", encoding="utf-8")
    nowhere = KernelFolder(sources)
    nowhere.write("kernel.nbc", b"machine code")
    assert nowhere.path is None and nowhere.read("kernel.nbc") is None


def test_nothing_is_made_before_a_kernel_is_needed(user_cache: Path) -> None:
    folder = KernelFolder()
    assert not user_cache.exists()
    assert folder.read("kernel.nbc") is None


def test_a_damaged_file_is_compiled_anew(user_cache: Path, caplog: pytest.LogCaptureFixture) -> None:
    tell_damaged.cache_clear()
    folder = KernelFolder()
    assert folder.read("absent.nbc") is None
    folder.write("kernel.nbc", b"machine code")
    assert folder.read("kernel.nbc") == b"machine code"
    assert folder.path is not None
    file = folder.path / "kernel.nbc"
    whole = file.read_bytes()
    for damaged in (b"", whole[:-1], whole[:10], whole[:-1] + b"x", b"x" + whole[1:]):
        file.write_bytes(damaged)
        assert folder.read("kernel.nbc") is None
    folder.write("kernel.nbc", b"machine code")
    assert folder.read("kernel.nbc") == b"machine code"
    assert caplog.messages == [f"note: damaged compiled kernels in {folder.path} are made again"]


def test_code_of_other_sources_and_versions_goes_when_nobody_has_used_it_for_long(user_cache: Path) -> None:
    used = KernelFolder()
    assert used.path is not None
    other, recent, foreign = (user_cache / name for name in (PREFIX + "old", PREFIX + "recent", "numba"))
    for folder in (other, recent, foreign, used.path):
        folder.mkdir(parents=True, exist_ok=True)
        for name in ("old.nbc", "read.nbc"):
            (folder / name).write_bytes(b"machine code")
    long_ago = (time.time() - 2 * OLD_S,) * 2
    for path in (other, foreign, used.path / "old.nbc", used.path / "read.nbc"):
        os.utime(path, long_ago)
    used.read("read.nbc")
    assert other.exists()
    used.write("kernel.nbc", b"machine code")
    assert (other.exists(), recent.exists(), foreign.exists()) == (False, True, True)
    assert sorted(path.name for path in used.path.iterdir()) == ["kernel.nbc", "read.nbc"]


@pytest.mark.usefixtures("user_cache")
def test_the_code_of_each_tuple_of_argument_types_is_kept(tmp_path: Path) -> None:
    (tmp_path / f"{__name__}.py").touch()
    folder = KernelFolder(tmp_path)

    def compiled_now() -> Any:
        dispatcher = numba.njit(_twice)
        dispatcher._cache = KernelCache(folder, _twice)
        return dispatcher

    first = compiled_now()
    assert [first(2), first(2.5)] == [4, 5.0]
    again = compiled_now()
    assert [again(2), again(2.5)] == [4, 5.0]
    assert (sum(again.stats.cache_hits.values()), sum(again.stats.cache_misses.values())) == (2, 0)
    assert again.stats.cache_path == str(folder.path)


def _twice(x: float) -> float:
    return 2 * x
