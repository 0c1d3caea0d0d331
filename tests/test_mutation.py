"""Mistakes are made in code and nowhere else, and the tests of core notice most of them."""

from pathlib import Path

import pytest

from tests.mutation import REPOSITORY, Neighbours, mutations_of, sample, score

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
    (folder / "module.py").write_text(source)
    found: dict[str, list[str]] = {}
    for mutation in mutations_of(folder, "module.py", seed=1):
        found.setdefault(mutation.operator, []).append(mutation.wrong)
    return {operator: sorted(wrong) for operator, wrong in found.items()}


def test_mistakes_are_made_in_code_and_leave_words_types_and_tables_alone(tmp_path: Path) -> None:
    assert mistakes_in(tmp_path, SOURCE) == MISTAKES


def test_every_mistake_is_a_program(tmp_path: Path) -> None:
    (tmp_path / "module.py").write_text(SOURCE)
    for mutation in mutations_of(tmp_path, "module.py", seed=1):
        compile(SOURCE[: mutation.start] + mutation.wrong + SOURCE[mutation.end :], str(mutation), "exec")


def test_a_change_of_one_function_leaves_the_sample_elsewhere(tmp_path: Path) -> None:
    (tmp_path / "module.py").write_text(SOURCE)
    before = {mutation.rank for mutation in sample(tmp_path, ["module.py"], 99, seed=1)}
    (tmp_path / "moved.py").write_text("def new(a):\n    return a + 1\n\n\n" + SOURCE)
    after = sample(tmp_path, ["moved.py"], 99, seed=1)
    assert {mutation.rank for mutation in after if mutation.function != "new"} == before
    assert before.isdisjoint(mutation.rank for mutation in sample(tmp_path, ["module.py"], 99, seed=2))


def test_the_tests_of_a_module_come_first_and_strangers_never(tmp_path: Path) -> None:
    files = {
        "core/boxes.py": "def turned(a):\n    return a + 1\n",
        "core/pog.py": "from riglens.core.boxes import turned\n",
        "tests/core/test_boxes.py": "from riglens.core import boxes\n",
        "tests/core/test_turns.py": "from riglens.core.boxes import turned\n" + 9 * "# long\n",
        "tests/core/test_pog.py": "import riglens.core.pog\n",
        "tests/core/test_other.py": "import riglens\n",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "riglens").mkdir()
    (tmp_path / "riglens" / "core").symlink_to(tmp_path / "core")
    mutation = sample(tmp_path, ["core"], 1, seed=1)[0]
    near = [Path(test).stem for test in Neighbours(tmp_path).of(mutation)]
    assert near == ["test_boxes", "test_turns", "test_pog"]


@pytest.mark.slow
def test_tests_notice_most_small_mistakes(tmp_path: Path) -> None:
    outcomes = score(REPOSITORY, sample(REPOSITORY, ["core"], 30, seed=1), tmp_path / "log.jsonl")
    survivors = [str(mutation) for mutation, noticed in outcomes.items() if not noticed]
    assert len(survivors) <= (1.0 - LEAST_SHARE) * len(outcomes), survivors
