"""Small mistakes made in copies of the sources, one at a time, and what the tests that stand guard say to each.

`python -m tests.core.mutants --jobs 2` goes through both lists and writes a line per mistake into out/mutants.txt. What
is there already is not run again unless the source or its tests have changed, so a run may be stopped and gone on with.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import NamedTuple

REPOSITORY = Path(__file__).resolve().parents[2]
PASSED, FAILED = 0, 1
LONGEST_S = 600.0
"""Of one run; a mistake whose tests do not come to an end in it counts as caught, for they passed without it."""


class Mutation(NamedTuple):
    """A mistake: the text of a file that is replaced, and by what."""

    file: str
    right: str
    wrong: str


def mutations_of(file: str, *pairs: tuple[str, str]) -> list[Mutation]:
    """Return the mistakes in one file, each said as (right, wrong)."""
    return [Mutation(file, right, wrong) for right, wrong in pairs]


Explained = tuple[Mutation, str]
"""A mistake that changes no result, and why."""


@dataclass(frozen=True)
class Guard:
    """Mistakes, the tests that stand guard over each file, and what those tests need of the checkout."""

    name: str
    mutations: tuple[Mutation, ...]
    harmless: tuple[Explained, ...]
    tests: Mapping[str, tuple[str, ...]]
    """Test files of a source file, in `place`."""
    place: str
    needed: tuple[str, ...]
    pythonpath: str = "."
    options: tuple[str, ...] = ()
    environment: tuple[tuple[str, str], ...] = ()

    def copy(self, root: Path) -> None:
        """Copy what the tests need into an empty folder."""
        for name in self.needed:
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            if (REPOSITORY / name).is_dir():
                shutil.copytree(REPOSITORY / name, root / name, ignore=shutil.ignore_patterns("__pycache__"))
            else:
                shutil.copy(REPOSITORY / name, root / name)
        settings = f"addopts = --import-mode=importlib -m 'not slow'\npythonpath = {self.pythonpath}\n"
        (root / "pytest.ini").write_text(f"[pytest]\n{settings}markers = slow\n", encoding="utf-8")

    def run(self, root: Path, tests: Iterable[str], keeps_bytecode: bool = False) -> tuple[int, str]:
        """Run tests in a copy; return pytest's exit code and what it printed."""
        environment = {
            **os.environ,
            **dict(self.environment),
            "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
            "PYTHONDONTWRITEBYTECODE": "" if keeps_bytecode else "1",
        }
        for name in ("PYTHONPATH", "PYTEST_ADDOPTS"):
            environment.pop(name, None)
        pytest = [sys.executable, "-m", "pytest", *self.options, "-p", "no:cacheprovider", "-q", "-x"]
        done = subprocess.run(
            [*pytest, *(f"{self.place}/{name}" for name in tests)],
            cwd=root,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=LONGEST_S,
            check=False,
        )
        return done.returncode, done.stdout

    def with_mistake(self, root: Path, mutation: Mutation) -> tuple[int, str]:
        """Make a mistake in a copy, run the tests that stand guard, and put the copy in order again."""
        source = root / mutation.file
        right, stat = source.read_text(encoding="utf-8"), source.stat()
        source.write_text(right.replace(mutation.right, mutation.wrong), encoding="utf-8")
        try:
            return self.run(root, self.tests[mutation.file])
        except subprocess.TimeoutExpired:
            return FAILED, "took too long"
        finally:
            source.write_text(right, encoding="utf-8")
            os.utime(source, ns=(stat.st_atime_ns, stat.st_mtime_ns))  # its bytecode is valid again

    def every_test(self) -> tuple[str, ...]:
        """Return all tests that stand guard."""
        return tuple(sorted({name for names in self.tests.values() for name in names}))

    def check(self) -> None:
        """Assert that the list follows the sources."""
        harmless = [mutation for mutation, _ in self.harmless]
        for mutation in (*self.mutations, *harmless):
            found = (REPOSITORY / mutation.file).read_text(encoding="utf-8").count(mutation.right)
            assert found == 1, f"{mutation.file} holds {mutation.right!r} {found} times"
            assert mutation.right != mutation.wrong
        assert max(Counter((*self.mutations, *harmless)).values()) == 1
        assert {mutation.file for mutation in self.mutations} == set(self.tests)
        assert all(why for _, why in self.harmless)


# ---------------------------------------------------------------- both lists at once


def _key(guard: Guard, mutation: Mutation, root: Path = REPOSITORY) -> str:
    """What the outcome of a mistake depends on: itself, its source file and the tests that stand guard."""
    digest = hashlib.sha256(repr(mutation).encode())
    for name in (mutation.file, *(f"{guard.place}/{test}" for test in guard.tests[mutation.file])):
        digest.update((root / name).read_bytes())
    return digest.hexdigest()[:16]


class _Log:
    """Outcomes by key, one line each in a file."""

    def __init__(self, path: Path) -> None:
        self._path, self._lock = path, Lock()
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        self.outcomes = {line.split("\t")[0]: line.split("\t")[1] for line in lines}

    def add(self, key: str, outcome: str, *more: str) -> None:
        """Keep an outcome."""
        with self._lock:
            self.outcomes[key] = outcome
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("a", encoding="utf-8") as stream:
                stream.write("\t".join((key, outcome, *more)) + "\n")


def _go_through(guard: Guard, mutations: list[Mutation], log: _Log) -> None:
    """Try mistakes in a copy of one's own; the tests of a file have to pass there without any mistake."""
    with tempfile.TemporaryDirectory(prefix="riglens-mutants-") as folder:
        root = Path(folder)
        guard.copy(root)
        passed: set[tuple[str, ...]] = set()
        for mutation in mutations:
            tests = guard.tests[mutation.file]
            if tests not in passed:
                code, output = guard.run(root, tests, keeps_bytecode=True)
                assert code == PASSED, f"{tests} fail without any mistake:\n{output[-4000:]}"
                passed.add(tests)
            code, output = guard.with_mistake(root, mutation)
            failed = [line for line in output.splitlines() if line.startswith(("FAILED", "ERROR"))]
            outcome = {PASSED: "not caught", FAILED: "caught"}.get(code, f"pytest's exit code {code}")
            log.add(
                _key(guard, mutation, root),
                outcome,
                f"{mutation.file}: {mutation.right!r} -> {mutation.wrong!r}",
                *failed[:1],
            )


def main() -> int:
    """Go through both lists; exit code 1 when a mistake is not caught."""
    from tests.core.kernels.mutations import GUARD as OF_KERNELS
    from tests.core.mutations import GUARD as OF_ROOMS

    words = argparse.ArgumentParser(prog="python -m tests.core.mutants", description=__doc__)
    words.add_argument("--jobs", type=int, default=1, help="processes at a time")
    words.add_argument("--log", type=Path, default=REPOSITORY / "out" / "mutants.txt")
    words.add_argument("--only", default="", help="files whose names hold this text")
    said = words.parse_args()
    log, waiting = _Log(said.log), []
    for guard in (OF_ROOMS, OF_KERNELS):
        chosen = [mutation for mutation in guard.mutations if said.only in mutation.file]
        left = sorted(mutation for mutation in chosen if _key(guard, mutation) not in log.outcomes)
        waiting += [(guard, left[start :: said.jobs]) for start in range(said.jobs)]
    with ThreadPoolExecutor(said.jobs) as pool:
        for done in [pool.submit(_go_through, guard, left, log) for guard, left in waiting if left]:
            done.result()
    outcomes = Counter(
        log.outcomes.get(_key(guard, mutation), "changed while it was tried")
        for guard in (OF_ROOMS, OF_KERNELS)
        for mutation in guard.mutations
        if said.only in mutation.file
    )
    harmless = len(OF_ROOMS.harmless) + len(OF_KERNELS.harmless)
    print(f"{dict(outcomes)}; {harmless} more change no result")
    return 0 if set(outcomes) <= {"caught"} else 1


if __name__ == "__main__":
    sys.exit(main())
