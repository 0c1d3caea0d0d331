"""Tables keep every number whole in any terminal; words are broken where a table is too wide for it."""

import pytest

from riglens.app.terminal.console import note, results
from riglens.app.terminal.tables import table
from riglens.studies.files import csv_text

NUMBERS = ("-123,456.78", "45.67 %", "0.57 × 1.70")


@pytest.mark.parametrize("width", [20, 60, 80, 140])
def test_no_number_of_a_table_is_cut_however_narrow_the_terminal(
    width: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("riglens.app.terminal.console.PIPE_WIDTH", width)
    made = table("rig", "seen by LiDARs", "median\nsize", "share", "note", words={0, 4}, wraps={1, 4})
    made.add_row("a rig of some name", *NUMBERS, "said of it in many words")
    results().print(made)
    out = capsys.readouterr().out
    lines = [line.rstrip() for line in out.splitlines()]
    (row,) = (line for line in lines if NUMBERS[0] in line)
    assert all(number in row for number in NUMBERS) and "…" not in out
    assert {"rig", "name", "said", "words"} <= set(out.split())
    assert max(map(len, lines)) <= max(width, 72)


def test_a_remark_with_names_without_end_is_cut(capsys: pytest.CaptureFixture[str]) -> None:
    note(f"columns not used: {'x' * 100_000}")
    assert len(capsys.readouterr().err) < 500


def test_a_csv_has_the_columns_of_all_lines() -> None:
    assert csv_text([{"rig": "a"}, {"rig": "b", "radar": 1}]) == "rig,radar\na,\nb,1\n"
