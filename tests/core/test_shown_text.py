"""Words from outside steer neither a terminal nor a spreadsheet."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from riglens.core.shown_text import remark_text, spreadsheet_cell, visible, visible_lines


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("W+T", "W+T"),
        ("Zoë’s car 車 👩‍🚗", "Zoë’s car 車 👩‍🚗"),
        ("\x1b[31mred", r"\x1b[31mred"),
        ("\x9b31m", r"\x9b31m"),
        ("two\nlines\r", r"two\x0alines\x0d"),
        ("\u202ekcab", r"\u202ekcab"),
        ("half \ud800", r"half \ud800"),
    ],
)
def test_what_would_steer_a_terminal_is_written_out(text: str, shown: str) -> None:
    assert visible(text) == shown


@given(st.text(st.characters(max_codepoint=0x2100)))
def test_no_control_character_is_left(text: str) -> None:
    assert not any(ord(character) < 32 or 127 <= ord(character) < 160 for character in visible(text))
    assert visible(visible(text)) == visible(text)


def test_a_remark_has_at_most_a_few_hundred_letters() -> None:
    assert remark_text("short\n") == "short\\x0a"
    cut = remark_text("\x00" * 500)
    assert 300 < len(cut) < 500 and cut.endswith("…")


def test_lines_stay_lines_where_they_may() -> None:
    assert visible_lines("one\ntwo\x07") == "one\ntwo\\x07"


@pytest.mark.parametrize(
    "formula", ['=HYPERLINK("http://x")', "+1+cmd|' /C calc'!A0", "-2+3", "@SUM(A1)", "\t=1", "＝1"]
)
def test_a_formula_becomes_text(formula: str) -> None:
    assert spreadsheet_cell(formula) == "'" + formula


@pytest.mark.parametrize("value", ["W+T", "", "-1.25", "-inf", "+1e-9", -3, None, 0.5])
def test_names_and_numbers_stay(value: object) -> None:
    assert spreadsheet_cell(value) == value


@pytest.mark.parametrize("unseen", ["\ufeff", "\u200b", "\xad", "\u2060", "\u200f"])
def test_what_has_no_width_is_written_out(unseen: str) -> None:
    """A library with such a mark in a field's name was refused in a line that seemed to name the right field."""
    shown = visible(f"r{unseen}ange_m")
    assert shown.isprintable() and shown.isascii()
