"""Compiled kernels are kept in a folder named by all of their sources, so that none of them can be out of date."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numba
import pytest

from riglens.core.kernels import compiled
from riglens.core.kernels.compiled import OLD_S, PREFIX, SOURCES, digest_of, use_own_folder

INNER = """
from riglens.core.kernels.jit import inlined


@inlined
def step(x: int) -> int:
    return x + {}
"""
OUTER = """
from riglens.core.kernels.inner import step
from riglens.core.kernels.jit import kernel


@kernel
def twice(x: int) -> int:
    return step(step(x))
"""
CALL = "from riglens.core.kernels.outer import twice; print(twice(0), sum(twice.stats.cache_hits.values()))"


@pytest.fixture
def user_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's cache folder, while Numba has been given none."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setenv("RIGLENS_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_a_change_of_any_source_changes_the_folder(tmp_path: Path) -> None:
    copy = tmp_path / "kernels"
    shutil.copytree(SOURCES, copy, ignore=shutil.ignore_patterns("__pycache__"))
    names = {digest_of(copy)}
    assert names == {digest_of(SOURCES)}
    for source in sorted(copy.glob("*.py")):
        source.write_text(source.read_text() + "\n")
        names.add(digest_of(copy))
    assert len(names) == 1 + len(list(copy.glob("*.py")))


def test_a_kernel_follows_a_function_of_another_file_that_it_inlines(tmp_path: Path) -> None:
    kernels, package = tmp_path / "riglens" / "core" / "kernels", SOURCES.parent
    kernels.mkdir(parents=True)
    for name in (
        "__init__.py",
        "cache_folder.py",
        "kernels/__init__.py",
        "kernels/jit.py",
        "kernels/compiled.py",
    ):
        shutil.copy(package / name, tmp_path / "riglens" / "core" / name)
    (tmp_path / "riglens" / "__init__.py").touch()
    (kernels / "outer.py").write_text(OUTER)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "RIGLENS_CACHE_DIR": str(tmp_path / "cache")}
    del environment["NUMBA_CACHE_DIR"]

    def call(step: int) -> list[str]:
        (kernels / "inner.py").write_text(INNER.format(step))
        command = [sys.executable, "-c", CALL]
        done = subprocess.run(
            command, env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=120
        )
        assert done.stderr == ""
        return done.stdout.split()

    assert [call(step) for step in (1, 1, 10)] == [["2", "0"], ["2", "1"], ["20", "0"]]


def test_they_are_kept_in_the_users_cache_folder(user_cache: Path) -> None:
    assert use_own_folder()
    assert Path(numba.config.CACHE_DIR) == user_cache / (PREFIX + digest_of(SOURCES))
    assert Path(numba.config.CACHE_DIR).is_dir()


def test_a_folder_that_the_user_gave_to_numba_holds_them(
    user_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "given"))
    assert use_own_folder()
    assert Path(numba.config.CACHE_DIR).parent == tmp_path / "given"
    assert not user_cache.exists()


def test_without_a_cache_folder_they_are_kept_beside_their_sources_or_not_at_all(
    user_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    user_cache.write_text("a file where the folder should be")
    monkeypatch.setattr(compiled, "SOURCES", tmp_path / "kernels")
    assert use_own_folder()
    assert Path(numba.config.CACHE_DIR).parent == tmp_path / "kernels" / "__pycache__"
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    shutil.rmtree(tmp_path / "kernels")
    (tmp_path / "kernels").write_text("a file here too")
    assert not use_own_folder()
    assert numba.config.CACHE_DIR == ""


def test_folders_of_other_sources_go_when_nobody_has_used_them_for_long(user_cache: Path) -> None:
    old, recent, foreign = (user_cache / name for name in (PREFIX + "old", PREFIX + "recent", "numba"))
    for folder in (old, recent, foreign):
        folder.mkdir(parents=True)
        (folder / "kernel.nbc").write_bytes(b"machine code")
    for folder in (old, foreign):
        os.utime(folder, (time.time() - 2 * OLD_S,) * 2)
    assert use_own_folder()
    assert (old.exists(), recent.exists(), foreign.exists()) == (False, True, True)
