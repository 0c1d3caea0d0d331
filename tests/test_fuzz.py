"""Every target of the fuzzer reads or refuses broken input; `make fuzz` hands in far more of it."""

import pytest

from tests.fuzz import Target, outcome, run


@pytest.mark.parametrize(
    ("count", "seed", "only"),
    [
        (1320, 1, "rig "),
        (600, 1, "boxes "),
        (240, 1, ""),
        pytest.param(20_000, 2, "", marks=pytest.mark.slow),
    ],
)
def test_broken_input_is_read_or_refused_in_one_line(count: int, seed: int, only: str) -> None:
    found, crashes = run(count, seed, only=only)
    assert [(crash.target, crash.number, crash.what, crash.inputs) for crash in crashes] == []
    assert found.total() == count
    names = {line.rpartition(":")[0] for line in found}
    wanted = {"POG", "autosave", "command line", "clipboard: sensors", "mesh glb", "rig xacro"}
    assert wanted <= names if not only else len(names) >= 10
    assert sum(times for line, times in found.items() if line.endswith("refused")) > count // 4
    if only:  # broken and handed in often enough
        assert all(f"{name}: refused" in found for name in names)
        assert sum(f"{name}: read" in found for name in names) > 0.75 * len(names)


def test_the_fuzzer_notices_what_crashes() -> None:
    def crash(_: object) -> None:
        raise ZeroDivisionError("here")

    assert "ZeroDivisionError: here" in outcome(Target("x", crash), None)  # type: ignore[arg-type]
