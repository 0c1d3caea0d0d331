"""Numbers in the panels: short on the screen, exact underneath, with signs that need no colour."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtGui import QFontMetrics
from pytestqt.qtbot import QtBot

from riglens.core.figures.coverage import S_MS, SEEN
from riglens.core.figures.text import change_text, value_text
from riglens.core.figures.values import compared_scores
from riglens.core.metric.scores import ClassScores, KindScore, Scores
from riglens.core.scene.boxes import CLASSES
from riglens.widgets.panels.fields.quantity import (
    METRES,
    NO_UNIT,
    full_number,
    parse_number,
    short_number,
    short_text,
)
from riglens.widgets.panels.scores.table import ScoreTable


@given(st.floats(allow_nan=False))
def test_the_full_text_of_a_number_reads_back_as_the_same_bits(value: float) -> None:
    assert parse_number(full_number(value)).hex() == value.hex()


def test_a_coefficient_is_never_shown_as_nothing() -> None:
    assert [short_text(value, NO_UNIT) for value in (1e-7, -2.5e-6, 0.0, 0.5)] == [
        "1e-7",
        "-2.5e-6",
        "0",
        "0.5",
    ]
    assert short_text(2e-17, METRES) == "0"


@pytest.mark.parametrize(
    ("value", "text"),
    [(2.2, "2.2"), (0.1 + 0.2, "0.3"), (-0.00001, "0"), (1 / 3, "0.3333"), (100.0, "100"), (math.inf, "∞")],
)
def test_the_short_text_has_at_most_four_decimals(value: float, text: str) -> None:
    assert short_number(value) == text


@pytest.mark.parametrize(("text", "value"), [("−2.5", -2.5), (" 1e-3 ", 0.001), ("∞", math.inf)])
def test_numbers_are_read_as_people_write_them(text: str, value: float) -> None:
    assert parse_number(text) == value


@pytest.mark.parametrize("text", ["", "1,5", "nan", "abc", "1 2"])
def test_what_is_no_number_is_refused_with_what_was_found(text: str) -> None:
    with pytest.raises(ValueError, match="must be a number"):
        parse_number(text)


@pytest.mark.parametrize(
    ("nat", "text"), [(-670_712.3, "−670.71"), (0.0, "0.00"), (-0.3, "0.00"), (12.0, "0.01")]
)
def test_entropies_are_in_thousands_of_nat_with_two_decimals(nat: float, text: str) -> None:
    assert value_text(S_MS, nat) == text


@pytest.mark.parametrize(
    ("change", "text"),
    [(0.0, "—"), (14_290.0, "+14.29 ↑"), (-730.0, "−0.73 ↓"), (1e-6, "<0.01"), (-1e-6, "<0.01")],
)
def test_a_change_carries_its_sign_and_never_looks_like_none(change: float, text: str) -> None:
    assert change_text(S_MS, change) == text


def test_shares_are_in_percent_and_their_changes_in_percentage_points() -> None:
    assert value_text(SEEN, 0.76361) == "76.36 %"
    assert change_text(SEEN, -0.0035) == "−0.35 pp"


def test_no_column_of_changes_cuts_its_longest_number(qtbot: QtBot) -> None:
    table = ScoreTable()
    qtbot.addWidget(table)
    table.set_details(True)
    wide = QFontMetrics(table.font()).horizontalAdvance
    for figure in table.shown:
        place = table.place_of(f"{figure.key} change")
        assert table.columnWidth(place) >= wide("+100.00 pp") + 8 and table.columnWidth(place) >= wide(
            "−1000.00 ↓"
        )


def test_titles_have_their_room_where_all_columns_do(qtbot: QtBot) -> None:
    table = ScoreTable()
    qtbot.addWidget(table)
    header = table.horizontalHeader()
    shown = [place for place in range(header.count()) if not table.isColumnHidden(place)]
    table.resize(960, 200)
    table.show()
    titles_px = {place: header.sectionSizeHint(place) for place in shown}
    if sum(titles_px.values()) < 0.9 * table.viewport().width():
        assert all(table.columnWidth(place) >= titles_px[place] for place in shown)
    assert sum(map(table.columnWidth, shown)) <= table.viewport().width()


def test_the_direction_of_s_ms_is_an_arrow_and_only_seen_has_a_colour(qtbot: QtBot) -> None:
    def scores(nat: float, seen: float) -> Scores:
        kind = KindScore(nat, seen)
        found = ClassScores(1000.0, {"camera": kind, "lidar": kind}, seen, 1.1 * nat)
        return Scores(dict.fromkeys(CLASSES, found), {"camera": 1, "lidar": 1, "any": 1})

    table = ScoreTable()
    qtbot.addWidget(table)
    found = compared_scores(scores(-500.0, 0.4), scores(-400.0, 0.5))  # more reached twice, less seen
    table.show_figures("voxels", found)
    change, seen = table.cell("car", "s_ms change"), table.cell("car", "seen change")
    assert change.text == "−0.11 ↓" and seen.text == "−10.00 pp"
    assert (change.tone, seen.tone) == ("text", "less")
    table.set_reading("residual")  # in which it grows with coverage
    table.show_figures("voxels", found)
    assert table.cell("car", "s_ms change").tone == "less"
