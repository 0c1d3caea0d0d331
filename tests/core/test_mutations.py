"""Small mistakes in every room of core are caught by its tests; those of the kernels have a list of their own.

Every mutation of `mutations.py` is made in a copy of the sources, and the tests of that file run there: at least one
must fail.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from tests.conftest import KERNELS
from tests.core.kernels.mutations import MUTATIONS as OF_KERNELS
from tests.core.mutations import MUTATIONS, SURVIVORS, TESTS, Mutation

REPOSITORY = Path(__file__).resolve().parents[2]
FOLDERS = ("core", "riglens", "assets", "app", "widgets", "docs", "tests/core")
FILES = ("pyproject.toml", "tests/conftest.py", "tests/waiting.py", "tests/hand_clock.py")
SETTINGS = "[pytest]\naddopts = --import-mode=importlib -m 'not slow'\npythonpath = .\nmarkers = slow\n"
PYTEST = (sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "-x")
LONGEST_S = 600.0
PASSED, FAILED = 0, 1
ROOMS = ("engine", "formats", "kernels", "metric", "rig", "scene", "sensing", "view")


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of what the tests need, in which they have passed."""
    root = tmp_path_factory.mktemp("sources")
    for folder in FOLDERS:
        shutil.copytree(REPOSITORY / folder, root / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for path in FILES:
        shutil.copy(REPOSITORY / path, root / path)
    (root / "pytest.ini").write_text(SETTINGS, encoding="utf-8")
    every = tuple(sorted({name for names in TESTS.values() for name in names}))
    code, output = run(root, every, keeps_bytecode=True)
    assert code == PASSED, f"the tests fail without any mutation:\n{output[-4000:]}"
    return root


def run(root: Path, tests: tuple[str, ...], keeps_bytecode: bool = False) -> tuple[int, str]:
    """Run tests of core in a copy of the sources; returns pytest's exit code and what it printed."""
    environment = {
        **os.environ,
        "NUMBA_CACHE_DIR": os.environ.get("NUMBA_CACHE_DIR", str(KERNELS)),
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
        "PYTHONDONTWRITEBYTECODE": "" if keeps_bytecode else "1",
    }
    for name in ("PYTHONPATH", "PYTEST_ADDOPTS"):
        environment.pop(name, None)
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-p",
            "no:cacheprovider",
            "-q",
            "-x",
            *(f"tests/core/{name}" for name in tests),
        ],
        cwd=root,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=LONGEST_S,
        check=False,
    )
    return done.returncode, done.stdout


def test_the_list_follows_the_sources() -> None:
    survivors = [mutation for mutation, _ in SURVIVORS]
    for mutation in (*MUTATIONS, *survivors):
        found = (REPOSITORY / mutation.file).read_text(encoding="utf-8").count(mutation.right)
        assert found == 1, f"{mutation.file} holds {mutation.right!r} {found} times"
        assert mutation.right != mutation.wrong
    assert max(Counter(MUTATIONS).values()) == 1
    assert {mutation.file for mutation in MUTATIONS} == set(TESTS)
    assert not set(survivors) & set(MUTATIONS)
    assert len(survivors) < 0.05 * (len(MUTATIONS) + len(survivors))
    rooms = {mutation.file.split("/")[1] for mutation in (*MUTATIONS, *OF_KERNELS)}
    assert rooms >= set(ROOMS) and len(MUTATIONS) + len(OF_KERNELS) >= 200


@pytest.mark.slow
@pytest.mark.parametrize(
    "mutation", MUTATIONS, ids=lambda mutation: f"{Path(mutation.file).stem}: {mutation.right}"
)
def test_a_mutation_is_caught(copy: Path, mutation: Mutation) -> None:
    source = copy / mutation.file
    right, stat = source.read_text(encoding="utf-8"), source.stat()
    source.write_text(right.replace(mutation.right, mutation.wrong), encoding="utf-8")
    try:
        code, output = run(copy, TESTS[mutation.file])
    finally:
        source.write_text(right, encoding="utf-8")
        os.utime(source, ns=(stat.st_atime_ns, stat.st_mtime_ns))  # its bytecode is valid again
    assert code == FAILED, f"with {mutation.wrong!r} the tests say:\n{output[-2000:]}"
