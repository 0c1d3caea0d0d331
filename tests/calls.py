"""Note which functions of the product each test calls, for `mutation.py`: pytest -p tests.calls.

RIGLENS_CALLS names the folder that gets a JSON file per process: the seconds of each test, and by function those
tests that call the fewest others, one case of each before the next. A test that fails notices nothing. Compiled kernels
show no calls, unless they run as plain Python.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from collections import Counter
from collections.abc import Generator, Iterable, Mapping
from pathlib import Path
from types import CodeType, FrameType

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
ROOMS = tuple(f"{REPOSITORY / room}{os.sep}" for room in ("app", "core", "riglens", "widgets"))
MOST_TESTS = 24
"""Kept for one function."""


class Calls:
    """The functions that the test which runs now has called, and those of all tests before."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._now: dict[int, CodeType] = {}
        self.tests: dict[str, tuple[int, float]] = {}
        """By test: the number of functions that it calls, and its seconds."""
        self.callers: dict[str, list[str]] = {}
        self._failed = set[str]()

    def trace(self, frame: FrameType, _event: str, _arg: object) -> None:
        """Note a call; lines within it are not followed."""
        self._now[id(frame.f_code)] = frame.f_code

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Follow one test, its fixtures included."""
        self._now = {}
        sys.settrace(self.trace)
        threading.settrace(self.trace)
        try:
            return (yield)
        finally:
            sys.settrace(None)
            threading.settrace(None)
            # threads of the product may still be at work
            names = {name for name in map(function_of, list(self._now.values())) if name}
            self.tests[item.nodeid] = (len(names), self.tests.get(item.nodeid, (0, 0.0))[1])
            for name in names:
                self.callers.setdefault(name, []).append(item.nodeid)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Add up the seconds of a test, and note whether it failed."""
        if report.failed:
            self._failed.add(report.nodeid)
        count, seconds = self.tests.get(report.nodeid, (0, 0.0))
        self.tests[report.nodeid] = (count, seconds + report.duration)

    def pytest_sessionfinish(self) -> None:
        """Write what was noted."""
        self._folder.mkdir(parents=True, exist_ok=True)
        passed = {name: set(tests) - self._failed for name, tests in self.callers.items()}
        kept = {name: nearest(tests, self.tests) for name, tests in passed.items() if tests}
        text = json.dumps({"tests": self.tests, "callers": kept})
        (self._folder / f"{os.getpid()}.json").write_text(text, encoding="utf-8")


def nearest(tests: Iterable[str], noted: Mapping[str, tuple[int, float]]) -> list[str]:
    """Return the tests that call few functions; a second case of one comes after the first of all others."""
    cases = Counter[str]()
    turns = list[tuple[int, tuple[int, float], str]]()
    for noted_of, test in sorted((noted[test], test) for test in set(tests)):
        name = test.partition("[")[0]
        cases[name] += 1
        turns.append((cases[name], noted_of, test))
    return [test for *_, test in sorted(turns)[:MOST_TESTS]]


def function_of(code: CodeType) -> str | None:
    """Return "core/geometry.py:Pose.apply", None for functions of others."""
    path = os.path.realpath(code.co_filename)
    if not path.startswith(ROOMS):
        return None
    parts = [part for part in code.co_qualname.split(".") if not part.startswith("<")]
    return f"{Path(path).relative_to(REPOSITORY).as_posix()}:{'.'.join(parts)}"


def pytest_configure(config: pytest.Config) -> None:
    """Follow the tests of this process; with workers, each follows its own."""
    if hasattr(config, "workerinput") or not config.getoption("numprocesses", None):
        config.pluginmanager.register(Calls(Path(os.environ["RIGLENS_CALLS"]).resolve()))
