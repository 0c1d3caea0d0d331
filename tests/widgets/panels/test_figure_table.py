"""The one table of figures: what it shows, copies, greys, and keeps chosen."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QEvent, QObject
from PySide6.QtGui import QFontMetrics, QPaintEvent, QRegion
from pytestqt.qtbot import QtBot

from riglens.widgets.panels.figures.table import NOTHING, Cell, FigureTable, Heading, fitting

ROWS = [Heading("Cars", copied=("car",)), Heading("Bicycles", copied=("bicycle",))]
COLUMNS = [Heading("Seen by any", short="Seen", copied=("seen", "standard error")), Heading("Note")]
CELLS = [[Cell("33.3 %", (1 / 3, None)), Cell("near")], [NOTHING, Cell("far")]]


@pytest.fixture
def table(qtbot: QtBot) -> FigureTable:
    made = FigureTable("figures")
    qtbot.addWidget(made)
    made.give_titles(50, 20, 50)
    made.figures.show(ROWS, COLUMNS, CELLS)
    return made


def test_it_copies_exact_numbers_and_leaves_out_what_there_is_not(table: FigureTable) -> None:
    lines = [line.split("\t") for line in table.as_text().splitlines()]
    assert lines == [
        ["class", "seen", "standard error", "Note"],
        ["car", repr(1 / 3), "", "near"],
        ["bicycle", "", "", "far"],
    ]
    assert table.text_of("Cars", "Seen by any") == "33.3 %"


def test_new_figures_keep_the_chosen_row_and_take_the_grey_away(table: FigureTable) -> None:
    table.selectRow(1)
    table.figures.grey([0])
    assert (0 in table.figures._grey, 1 in table.figures._grey) == (True, False)
    table.figures.show(ROWS, [Heading("Other"), Heading("Note")], CELLS)
    assert table.current_row == 1 and 0 not in table.figures._grey
    table.figures.show(ROWS[:1], COLUMNS, CELLS[:1])
    assert table.current_row == 0


def test_an_empty_table_says_why_it_is_empty_and_no_other_does(table: FigureTable) -> None:
    table.resize(300, 120)
    full = table.grab().toImage()
    table.explain("Counting objects…")
    assert table.grab().toImage() == full
    table.figures.show([], [], [], anew=True)
    why = table.grab().toImage()
    table.explain("")
    assert table.grab().toImage() != why


def test_one_column_is_shown_anew_alone(table: FigureTable) -> None:
    table.figures.grey()
    table.figures.show_columns({1: [Cell("a"), Cell("b")]})
    assert [table.figures.cell(row, 1).text for row in (0, 1)] == ["a", "b"]
    assert table.figures.cell(0, 0) is CELLS[0][0]
    assert (0 in table.figures._grey, 1 in table.figures._grey) == (True, False)


class _Painted(QObject):
    """Collects where a widget is painted."""

    def __init__(self) -> None:
        super().__init__()
        self.region = QRegion()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if isinstance(event, QPaintEvent):
            self.region += event.region()
        return False


def test_only_columns_that_look_different_are_painted_again(table: FigureTable, qtbot: QtBot) -> None:
    with qtbot.waitExposed(table):
        table.show()
    qtbot.wait(50)
    painted = _Painted()
    table.viewport().installEventFilter(painted)
    table.figures.show(list(ROWS), list(COLUMNS), [list(row) for row in CELLS])
    table.figures.grey(())
    qtbot.wait(50)
    assert painted.region.isEmpty()
    table.figures.grey([1])
    note = table.visualRect(table.figures.index(0, 1)).united(table.visualRect(table.figures.index(1, 1)))
    qtbot.waitUntil(lambda: painted.region.boundingRect() == note)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("= LiDARs 28.5 + 12.4 · < ½ from 20 m", ["= LiDARs 28.5 + 12.4", ""]),
        (
            "worst: pedestrian, rear-left · > ½ from 30 m",
            ["worst: pedestrian, rear-left", "worst: pedestrian", ""],
        ),
    ],
)
def test_a_second_line_is_cut_between_its_parts_alone(
    table: FigureTable, text: str, shown: list[str]
) -> None:
    wide, found = QFontMetrics(table.font()), text
    for expected in shown:
        assert fitting(text, wide, wide.horizontalAdvance(found)) == found
        found = fitting(text, wide, wide.horizontalAdvance(found) - 1)
        assert found == expected
