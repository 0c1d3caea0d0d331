"""Make small mistakes in a copy of core, one at a time, and see whether a test fails.

    python -m tests.mutation --count 100 --seed 1 --rooms core/kernels core/engine

The mistakes are operators over the syntax tree (a comparison swapped, a constant off by one, a statement left out) at
places drawn by a seed. Each place has a hash of its own, so a change of one function leaves the rest of the sample as
it is. For each mistake those tests run that call the function and few others, kernels as plain Python
(`plain_kernels.py`): `calls.py` notes them in one run of all tests, the first of a checkout. Each outcome is a line of
the log, and a run that was stopped goes on after the last one.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from tests.calls import nearest

REPOSITORY = Path(__file__).resolve().parents[1]
COPIED = (
    "README.md",
    "app",
    "assets",
    "core",
    "docs",
    "riglens",
    "tests",
    "tools",
    "widgets",
    "pyproject.toml",
)
MOST_S = 40.0
"""That the tests which run for one mistake may take without it."""
LONGEST_S = 90.0
"""A run that takes longer hangs: the mistake is noticed."""
KERNEL_TESTS = (
    "tests/core/kernels",
    "tests/core/targets/test_brute_force.py",
    "tests/core/targets/test_clearance.py",
    "tests/core/test_blocked.py",
    "tests/core/test_body_blocking.py",
    "tests/core/optimise/test_bounds.py",
    "tests/core/optimise/test_run.py",
)
"""Run as plain Python, too; most others would take minutes."""
PLAIN = {"NUMBA_DISABLE_JIT": "1", "PYTEST_ADDOPTS": "-p tests.core.kernels.plain_kernels -W ignore"}

# ---------------------------------------------------------------- operators over the syntax tree

_SWAPS = """Lt LtE, LtE Lt, Gt GtE, GtE Gt, Eq NotEq, NotEq Eq, In NotIn, NotIn In, Is IsNot, IsNot Is, And Or, Or And,
Add Sub, Sub Add, Mult Div, Div Mult, FloorDiv Mult, Mod FloorDiv, Pow Mult, LShift RShift, RShift LShift,
BitAnd BitOr, BitOr BitAnd, BitXor BitOr"""
SWAPPED = {getattr(ast, right): getattr(ast, wrong) for right, wrong in map(str.split, _SWAPS.split(","))}
DEFAULTS = {"bool": "False", "int": "0", "float": "0.0", "str": "''"}
"""Returned instead of the result, by the type that a function declares."""


class Mutation(NamedTuple):
    """One mistake: the bytes from `start` to `end` of a file are replaced."""

    rank: str
    """A sample holds the mistakes of the lowest rank; the same one in a function of that name elsewhere shares it."""
    file: str
    line: int
    function: str
    operator: str
    wrong: str
    start: int
    end: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line} {self.function}: {self.operator}: {self.wrong}"


class Place(NamedTuple):
    """A node of a syntax tree, the function that it is in, and what that returns."""

    node: ast.AST
    function: str
    returned: str
    is_condition: bool


def mistakes(node: Any, returned: str) -> Iterator[tuple[str, str]]:
    """Yield the operators that fit a node, each with the code that it puts in its place."""
    swapped = SWAPPED.get(type(getattr(node, "op", None)))
    match node:
        case ast.Compare(left, ops, rest):
            for n, op in enumerate(ops):
                others = [*ops[:n], SWAPPED[type(op)](), *ops[n + 1 :]]
                yield "compare", ast.unparse(ast.Compare(left, others, rest))
        case ast.BinOp(left, _, right) if swapped and not (is_text_or_type(left) or is_text_or_type(right)):
            yield "arithmetic", ast.unparse(ast.BinOp(left, swapped(), right))
        case ast.AugAssign(target, _, value) if swapped:
            yield "arithmetic", ast.unparse(ast.AugAssign(target, swapped(), value))
            yield "statement", "pass"
        case ast.BoolOp(_, values) if swapped:
            yield "and or", ast.unparse(ast.BoolOp(swapped(), values))
        case ast.UnaryOp(ast.Not() | ast.USub(), operand) if not isinstance(operand, ast.Constant):
            yield "sign", ast.unparse(operand)
        case ast.Constant(bool(value)):
            yield "constant", str(not value)
        case ast.Constant(int(value) | float(value)):
            yield "constant", repr(value + 1)
        case ast.Return(ast.expr() as value) if ast.unparse(value) != DEFAULTS.get(returned, "None"):
            yield "return", f"return {DEFAULTS.get(returned, 'None')}"
        case (
            ast.Expr(ast.Call())
            | ast.Raise()
            | ast.Continue()
            | ast.Assign([ast.Attribute() | ast.Subscript()])
        ):
            yield "statement", "pass"


def is_text_or_type(node: ast.AST) -> bool:
    """Return whether a side of an operator is text or a type, whose `+` and `|` are no arithmetic."""
    match node:
        case ast.JoinedStr() | ast.Constant(None | str()):
            return True
        case ast.Name(name):
            return (name[0].isupper() and not name.isupper()) or name in ("bool", "int", "float", "str")
        case ast.BinOp(left, ast.Add() | ast.BitOr(), right):
            return is_text_or_type(left) or is_text_or_type(right)
    return False


def places(node: ast.AST, function: str = "", returned: str = "") -> Iterator[Place]:
    """Yield the places below a node, without annotations, decorators, imports and the words of messages."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "bases"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST) or isinstance(
                child, ast.JoinedStr | ast.Import | ast.ImportFrom
            ):
                continue
            where, gives = function, returned
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                where = f"{function}.{child.name}".lstrip(".")
                gives = (
                    ast.unparse(child.returns) if isinstance(child, ast.FunctionDef) and child.returns else ""
                )
            yield Place(child, where, gives, isinstance(node, ast.If | ast.IfExp) and name == "test")
            if not isinstance(child, ast.Raise):
                yield from places(child, where, gives)


def mutations_of(root: Path, file: str, seed: int) -> Iterator[Mutation]:
    """Yield all mistakes that can be made in a file, but none in its tables of constants."""
    text = (root / file).read_bytes()
    begins = [0]
    for line in text.splitlines(keepends=True):
        begins.append(begins[-1] + len(line))
    seen: Counter[tuple[str, ...]] = Counter()
    for place in places(ast.parse(text)):
        node = place.node
        if (
            not isinstance(node, ast.expr | ast.stmt)
            or node.end_lineno is None
            or node.end_col_offset is None
        ):
            continue
        if (right := ast.unparse(node)) == "TYPE_CHECKING":
            continue
        start, end = (
            begins[node.lineno - 1] + node.col_offset,
            begins[node.end_lineno - 1] + node.end_col_offset,
        )
        negated = [("condition", f"not ({right})")] if place.is_condition else []
        for operator, wrong in [*mistakes(node, place.returned), *negated]:
            if operator == "constant" and not place.function:
                continue
            key = (str(seed), place.function, operator, right, wrong)
            seen[key] += 1
            rank = hashlib.sha256(repr((key, seen[key])).encode()).hexdigest()
            put = f"({wrong})" if isinstance(node, ast.expr) else wrong
            yield Mutation(rank, file, node.lineno, place.function, operator, put, start, end)


def sample(root: Path, rooms: Iterable[str], count: int, seed: int) -> list[Mutation]:
    """Draw mistakes in files and folders of a checkout; a smaller sample is the beginning of a larger one."""
    chosen = [root / room for room in rooms]
    files = {path for room in chosen for path in ([room] if room.is_file() else room.rglob("*.py"))}
    return sorted(m for path in files for m in mutations_of(root, path.relative_to(root).as_posix(), seed))[
        :count
    ]


# ---------------------------------------------------------------- tests near a module


def is_kernel(file: str) -> bool:
    """Return whether a module is compiled, which takes minutes for every mistake."""
    return file.startswith("core/kernels/") and not file.startswith("core/kernels/runtime/")


class Callers:
    """Tests by the functions that they call, as `calls.py` has noted them."""

    def __init__(self, folder: Path) -> None:
        self._tests: dict[str, tuple[int, float]] = {}
        self._callers: dict[str, list[str]] = {}
        for path in sorted(folder.glob("*.json")):
            noted = json.loads(path.read_text(encoding="utf-8"))
            self._tests |= noted["tests"]
            for function, tests in noted["callers"].items():
                self._callers.setdefault(function, []).extend(tests)

    def of(self, mutation: Mutation) -> list[str]:
        """Return tests of a function, nearest first; of a class or module, tests of all in it."""
        name = f"{mutation.file}:{mutation.function}"
        inside = f"{name}." if mutation.function else name
        tests = self._callers.get(name) or {
            test for other, tests in self._callers.items() if other.startswith(inside) for test in tests
        }
        chosen, left_s = list[str](), MOST_S
        for test in nearest(tests, self._tests):
            left_s -= self._tests[test][1]
            if chosen and left_s < 0:
                break
            chosen.append(test)
        return chosen


def note_calls(copy: Path, folder: Path, *chosen: str) -> None:
    """Run tests of a copy once and note what they call: `chosen`, or all, and those of kernels as plain Python."""
    environment = {**os.environ, "PYTHONPATH": str(copy), "RIGLENS_CALLS": str(folder)}
    runs = [(chosen, {})] if chosen else [(("tests",), {}), (KERNEL_TESTS, PLAIN)]
    for tests, options in runs:
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-m",
            "not slow",
            "-p",
            "tests.calls",
            "-n",
            "logical",
            *tests,
        ]
        subprocess.run(command, cwd=copy, env=environment | options, check=False)


# ---------------------------------------------------------------- running tests with and without a mistake


@dataclass(frozen=True)
class Copy:
    """A copy of a checkout in which mistakes are made."""

    root: Path
    failing: dict[tuple[str, ...], bool] = field(default_factory=dict)
    """Tests that ran without a mistake, and whether they failed or took too long."""

    @classmethod
    def of(cls, checkout: Path, root: Path) -> Copy:
        """Copy a checkout into an empty folder."""
        for name in COPIED:
            if (checkout / name).is_dir():
                ignored = shutil.ignore_patterns("__pycache__", "images")
                shutil.copytree(checkout / name, root / name, symlinks=True, ignore=ignored)
            else:
                shutil.copy(checkout / name, root / name)
        return cls(root)

    def run(self, tests: Iterable[str], plain: bool) -> tuple[bool, str]:
        """Run tests until one fails; return whether one did, and its name if it is known."""
        environment = {**os.environ, "PYTHONPATH": str(self.root), **(PLAIN if plain else {})}
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-x",
            "-m",
            "not slow",
            "-p",
            "no:cacheprovider",
            *tests,
        ]
        options: dict[str, Any] = {"cwd": self.root, "env": environment, "capture_output": True}
        try:
            done = subprocess.run(command, timeout=LONGEST_S, check=False, **options)
        except subprocess.TimeoutExpired:
            return True, ""
        failed = re.search(rb"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", done.stdout, re.MULTILINE)
        return done.returncode != 0, failed[1].decode() if failed else ""

    def fails_anyway(self, tests: list[str], plain: bool) -> bool:
        """Return whether tests fail without a mistake."""
        key = (str(plain), *tests)
        if key not in self.failing:
            self.failing[key] = self.run(tests, plain)[0]
        return self.failing[key]

    def noticed_by(self, mutation: Mutation, tests: list[str]) -> str | None:
        """Make a mistake and run tests; return the one that fails (no name: they hang), or None."""
        source, plain = self.root / mutation.file, is_kernel(mutation.file)
        right = source.read_bytes()
        while tests:
            source.write_bytes(right[: mutation.start] + mutation.wrong.encode() + right[mutation.end :])
            failed, test = self.run(tests, plain)
            source.write_bytes(right)
            if not failed:
                return None
            suspects = [test] if test else tests
            if not self.fails_anyway(suspects, plain):
                return test
            tests = [other for other in tests if other != test] if test else tests[: len(tests) // 2]
        return None


def score(checkout: Path, mutations: Iterable[Mutation], log: Path, calls: Path) -> dict[Mutation, bool]:
    """Return for each mistake whether a test noticed it; what the log holds already does not run again."""
    log.parent.mkdir(parents=True, exist_ok=True)
    rows = map(json.loads, log.read_text(encoding="utf-8").splitlines()) if log.exists() else []
    known = {(row.get("file"), row["rank"]): row["by"] is not None for row in rows}
    with tempfile.TemporaryDirectory(prefix="riglens-mutation-") as folder:
        copy = Copy.of(checkout, Path(folder).resolve())
        if not calls.is_dir():
            note_calls(copy.root, calls)
        callers = Callers(calls)
        for mutation in (one for one in mutations if (one.file, one.rank) not in known):
            by = copy.noticed_by(mutation, callers.of(mutation))
            known[mutation.file, mutation.rank] = by is not None
            row = {"file": mutation.file, "rank": mutation.rank, "mutation": str(mutation), "by": by}
            with log.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(row) + "\n")
            print("survived" if by is None else "noticed ", mutation, by or "", flush=True)
    return {one: known[one.file, one.rank] for one in mutations}


def main() -> int:
    """Draw mistakes, score them and print how many the tests notice."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.mutation", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("--count", type=int, default=100, help="mistakes to draw (100)")
    parser.add_argument("--seed", type=int, default=1, help="which ones (1)")
    parser.add_argument(
        "--rooms", nargs="+", default=["core"], help="folders or files to make them in (core)"
    )
    parser.add_argument(
        "--log", type=Path, default=REPOSITORY / "out" / "mutations.jsonl", help="kept outcomes"
    )
    parser.add_argument(
        "--calls", type=Path, default=REPOSITORY / "out" / "calls", help="which functions each test calls"
    )
    parser.add_argument(
        "--checkout", type=Path, default=REPOSITORY, help="sources and tests to score (these)"
    )
    asked = parser.parse_args()
    checkout = asked.checkout.resolve()
    outcomes = score(checkout, sample(checkout, asked.rooms, asked.count, asked.seed), asked.log, asked.calls)
    print(f"{sum(outcomes.values())} of {len(outcomes)} mistakes are noticed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
