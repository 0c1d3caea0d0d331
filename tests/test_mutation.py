"""Mistakes are made in code and nowhere else, and the tests of core notice most of them."""

import json
from pathlib import Path

import pytest

from tests.calls import Calls, nearest
from tests.mutation import REPOSITORY, Callers, mutations_of, note_calls, sample, score

SOURCE = '''"""A module."""
from __future__ import annotations

TABLE = (1, 2, 3)


def first(a: int | None, b: float = 2.0) -> bool:
    """Return 1."""
    if a is None or not b:
        raise ValueError(f"a is {1 + 1}, " + "b")
    b += a * 3
    return b < 4
'''
MISTAKES = {
    "constant": ["(3.0)", "(4)", "(5)"],
    "condition": ["(not (a is None or not b))"],
    "and or": ["(a is None and (not b))"],
    "compare": ["(a is not None)", "(b <= 4)"],
    "sign": ["(b)"],
    "arithmetic": ["(a / 3)", "b -= a * 3"],
    "statement": ["pass", "pass"],
    "return": ["return False"],
}
LEAST_SHARE = 0.6
"""Of a sample that tests must notice; the rest are mistakes that change no result or only one of the paths."""


def mistakes_in(folder: Path, source: str) -> dict[str, list[str]]:
    (folder / "module.py").write_text(source, encoding="utf-8")
    found: dict[str, list[str]] = {}
    for mutation in mutations_of(folder, "module.py", seed=1):
        found.setdefault(mutation.operator, []).append(mutation.wrong)
    return {operator: sorted(wrong) for operator, wrong in found.items()}


def test_mistakes_are_made_in_code_and_leave_words_types_and_tables_alone(tmp_path: Path) -> None:
    assert mistakes_in(tmp_path, SOURCE) == MISTAKES


def test_every_mistake_is_a_program(tmp_path: Path) -> None:
    (tmp_path / "module.py").write_text(SOURCE, encoding="utf-8")
    for mutation in mutations_of(tmp_path, "module.py", seed=1):
        compile(SOURCE[: mutation.start] + mutation.wrong + SOURCE[mutation.end :], str(mutation), "exec")


def test_a_change_of_one_function_leaves_the_sample_elsewhere(tmp_path: Path) -> None:
    (tmp_path / "module.py").write_text(SOURCE, encoding="utf-8")
    before = {mutation.rank for mutation in sample(tmp_path, ["module.py"], 99, seed=1)}
    (tmp_path / "moved.py").write_text("def new(a):\n    return a + 1\n\n\n" + SOURCE, encoding="utf-8")
    after = sample(tmp_path, ["moved.py"], 99, seed=1)
    assert {mutation.rank for mutation in after if mutation.function != "new"} == before
    assert before.isdisjoint(mutation.rank for mutation in sample(tmp_path, ["module.py"], 99, seed=2))


def test_those_tests_run_that_call_the_function_and_few_others(tmp_path: Path) -> None:
    (tmp_path / "module.py").write_text(SOURCE + "\n\nclass Other:\n    wide: int = 2\n", encoding="utf-8")
    by_file = [
        {"tests": {"a": (9, 1.0), "b": (2, 30.0)}, "callers": {"module.py:first": ["a", "b"]}},
        {
            "tests": {"c": (5, 30.0), "d": (1, 1.0)},
            "callers": {"module.py:first": ["c"], "module.py:Other.of": ["d"]},
        },
    ]
    for number, noted in enumerate(by_file):
        (tmp_path / f"{number}.json").write_text(json.dumps(noted), encoding="utf-8")
    chosen = {
        mutation.function: Callers(tmp_path).of(mutation)
        for mutation in sample(tmp_path, ["module.py"], 99, 1)
    }
    assert chosen == {"first": ["b"], "Other": ["d"]}, "and no more than fit into the time"


def test_of_a_test_with_many_cases_the_first_runs_before_other_tests_and_the_second_after_them() -> None:
    noted = {f"refused[{case}]": (1, 0.1) for case in range(9)} | {"whole": (9, 2.0)}
    assert nearest(noted, noted)[:3] == ["refused[0]", "whole", "refused[1]"]


def test_a_test_that_fails_is_no_test_of_what_it_calls(tmp_path: Path) -> None:
    calls = Calls(tmp_path)
    calls.tests = {"fails": (1, 0.0), "passes": (2, 0.0)}
    calls.callers = {"module.py:first": ["fails", "passes"], "module.py:other": ["fails"]}
    for name, outcome in (("fails", "failed"), ("passes", "passed")):
        calls.pytest_runtest_logreport(pytest.TestReport(name, ("", 0, ""), {}, outcome, None, "call"))
    calls.pytest_sessionfinish()
    (noted,) = tmp_path.glob("*.json")
    assert json.loads(noted.read_text(encoding="utf-8"))["callers"] == {"module.py:first": ["passes"]}


def test_the_same_mistake_in_two_files_has_an_outcome_for_each(tmp_path: Path) -> None:
    for name in ("one.py", "other.py"):
        (tmp_path / name).write_text("def first(a):\n    return a + 1\n", encoding="utf-8")
    mistakes = sample(tmp_path, ["one.py", "other.py"], 99, seed=1)
    outcomes = {mistake: mistake.file == "one.py" for mistake in mistakes}
    assert len({mistake.rank for mistake in mistakes}) == len(mistakes) / 2
    rows = [
        {"file": mistake.file, "rank": mistake.rank, "by": "a test" if noticed else None}
        for mistake, noticed in outcomes.items()
    ]
    log = tmp_path / "log.jsonl"
    log.write_text("\n".join(map(json.dumps, rows)), encoding="utf-8")
    assert score(REPOSITORY, mistakes, log, tmp_path) == outcomes


@pytest.mark.slow
def test_tests_notice_most_small_mistakes(tmp_path: Path) -> None:
    note_calls(REPOSITORY, tmp_path / "calls", "tests/core/test_geometry.py")
    mistakes = sample(REPOSITORY, ["core/geometry.py"], 30, seed=1)
    outcomes = score(REPOSITORY, mistakes, tmp_path / "log.jsonl", tmp_path / "calls")
    survivors = [str(mutation) for mutation, noticed in outcomes.items() if not noticed]
    assert len(survivors) <= (1.0 - LEAST_SHARE) * len(outcomes), survivors
