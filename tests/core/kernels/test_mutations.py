"""Small mistakes in kernels, engine and metric are caught by the direct tests, each within a second or two.

Every mutation of `mutations.py` is made in a copy of the sources, and the direct tests of that file run there as plain
Python, without the compiler (see `plain_kernels.py`): at least one must fail.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from tests.core.kernels.mutations import MUTATIONS, TESTS, Mutation

REPOSITORY = Path(__file__).resolve().parents[3]
HERE = "tests/core/kernels"
SETTINGS = f"[pytest]\naddopts = --import-mode=importlib\npythonpath = . {HERE}\nmarkers = slow\n"
LONGEST_S = 120.0
PASSED, FAILED = 0, 1


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of what the direct tests need, in which they have passed."""
    root = tmp_path_factory.mktemp("sources")
    for folder in ("core", "riglens", "assets", HERE):
        shutil.copytree(REPOSITORY / folder, root / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for path in ("tests/core/builders.py", "tests/core/oracle.py", "docs/engine.md"):
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(REPOSITORY / path, root / path)
    (root / "pytest.ini").write_text(SETTINGS, encoding="utf-8")
    every = tuple(sorted({name for names in TESTS.values() for name in names}))
    code, output = run(root, every, keeps_bytecode=True)
    assert code == PASSED, f"the direct tests fail without any mutation:\n{output}"
    return root


def run(root: Path, tests: tuple[str, ...], keeps_bytecode: bool = False) -> tuple[int, str]:
    """Run direct tests in a copy of the sources; returns pytest's exit code and what it printed."""
    command = [sys.executable, "-m", "pytest", "-p", "plain_kernels", "-p", "no:cacheprovider", "-q", "-x"]
    environment = {
        **os.environ,
        "NUMBA_DISABLE_JIT": "1",
        "NUMBA_CACHE_DIR": str(root / "cache"),
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
        "PYTHONDONTWRITEBYTECODE": "" if keeps_bytecode else "1",
    }
    for name in ("PYTHONPATH", "PYTEST_ADDOPTS"):
        environment.pop(name, None)
    done = subprocess.run(
        [*command, *(f"{HERE}/{name}.py" for name in tests)],
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
    for mutation in MUTATIONS:
        found = (REPOSITORY / mutation.file).read_text(encoding="utf-8").count(mutation.right)
        assert found == 1, f"{mutation.file} holds {mutation.right!r} {found} times"
        assert mutation.right != mutation.wrong
    assert max(Counter(MUTATIONS).values()) == 1
    assert {mutation.file for mutation in MUTATIONS} == set(TESTS)


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
