"""Every key does one thing, every action says what it does, and the sheet lists them all."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from html import escape
from pathlib import Path

import pytest
from PySide6.QtCore import SIGNAL, Qt
from PySide6.QtGui import QAction, QShortcut
from PySide6.QtWidgets import QLabel, QTableWidget
from pytestqt.qtbot import QtBot

from app.dialogs import Dialogs
from app.window.features.help import sheet
from tests.app.window_bench import Bench, open_bench
from widgets.panels.shortcut_sheet import Group, ShortcutSheet, in_two


@pytest.fixture
def bench(qtbot: QtBot, tmp_path: Path) -> Iterator[Bench]:
    with open_bench(qtbot, tmp_path, wait=False) as opened:
        yield opened


def test_no_two_actions_answer_to_the_same_key(bench: Bench) -> None:
    actions, shortcuts = bench.window.findChildren(QAction), bench.window.findChildren(QShortcut)
    keys = [key.toString() for action in actions for key in action.shortcuts()]
    keys += [shortcut.key().toString() for shortcut in shortcuts]
    assert [key for key, count in Counter(keys).items() if key and count > 1] == []


def test_every_action_has_a_tooltip_and_does_something(bench: Bench) -> None:
    for spec in bench.window.actions_.specs:
        action = bench.window.actions_[spec.key]
        assert spec.tip and spec.tip in action.toolTip(), spec.key
        assert action.receivers(SIGNAL("triggered(bool)")) > 0, spec.key  # type: ignore[arg-type]


def test_the_key_of_the_sheet_opens_it(bench: Bench) -> None:
    bench.qtbot.keyClick(bench.window, "?")
    bench.qtbot.keyClick(bench.window, Qt.Key.Key_F1)
    assert len(bench.dialogs.shown) == 2
    assert bench.dialogs.shown[0] == bench.dialogs.shown[1]


def test_the_sheet_shows_all_groups_in_two_columns_and_nothing_is_cut_off(bench: Bench) -> None:
    groups = sheet(bench.window)
    Dialogs().show_sheet(bench.window, "Shortcuts and mouse", groups)
    shown = bench.window.findChild(ShortcutSheet)
    columns = shown.findChildren(QLabel)
    assert len(columns) == 2
    text = "".join(column.text() for column in columns)
    for group in groups:
        assert all(escape(keys) in text and escape(what) in text for keys, what in group.rows)
    assert all(column.height() >= column.heightForWidth(column.width()) for column in columns)
    assert shown.width() <= 1280 and shown.height() <= 800
    bench.qtbot.keyClick(shown, Qt.Key.Key_Escape)
    assert not shown.isVisible()


def test_a_table_with_the_focus_copies_itself_not_the_selected_sensor(qtbot: QtBot, tmp_path: Path) -> None:
    with open_bench(qtbot, tmp_path) as bench:
        bench.document.select("roof")
        table = bench.window.scores.findChild(QTableWidget)
        table.setFocus()
        qtbot.keyClick(table, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
        assert bench.clipboard() == bench.window.scores.as_text()


def test_columns_are_alike_in_height() -> None:
    groups = [Group(str(rows), (("A", "does"),) * rows) for rows in (6, 2, 2, 5, 1)]
    left, right = in_two(groups)
    assert [group.title for group in left + right] == ["6", "2", "2", "5", "1"]
    assert abs(sum(g.height for g in left) - sum(g.height for g in right)) <= 4
