"""Every key does one thing, every action says what it does, and the sheet lists them all."""

from __future__ import annotations

from collections import Counter
from html import escape
from pathlib import Path

import pytest
from PySide6.QtCore import SIGNAL, Qt
from PySide6.QtGui import QAction, QShortcut
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QTableView
from pytestqt.qtbot import QtBot

from riglens.app.window.dialogs import Dialogs
from riglens.app.window.features.help import sheet
from riglens.widgets.panels.help.shortcut_sheet import Group, ShortcutSheet, in_columns
from tests.app.window_bench import Bench, open_bench
from tests.waiting import wait_for


@pytest.fixture
def bench(unscored: Bench) -> Bench:
    return unscored


def test_no_two_actions_answer_to_the_same_key(bench: Bench) -> None:
    actions, shortcuts = bench.window.findChildren(QAction), bench.window.findChildren(QShortcut)
    keys = [key.toString() for action in actions for key in action.shortcuts()]
    keys += [shortcut.key().toString() for shortcut in shortcuts]
    assert [key for key, count in Counter(keys).items() if key and count > 1] == []


def test_every_action_has_a_tooltip_and_does_something(bench: Bench) -> None:
    for spec in bench.workbench.actions.specs:
        action = bench.workbench.actions[spec.key]
        assert spec.tip and spec.tip in action.toolTip(), spec.key
        assert action.receivers(SIGNAL("triggered(bool)")) > 0, spec.key  # type: ignore[arg-type]


def test_the_key_of_the_sheet_opens_it(bench: Bench) -> None:
    bench.qtbot.keyClick(bench.window, "?")
    assert len(bench.dialogs.shown) == 1 and "Ctrl+K" in bench.dialogs.shown[0]


def test_the_sheet_lists_every_action_and_gesture_and_nothing_is_cut_off(bench: Bench) -> None:
    groups = sheet(bench.workbench.actions, bench.workbench.gestures)
    Dialogs().show_sheet(bench.window, "Shortcuts and mouse", groups)
    shown = bench.window.findChild(ShortcutSheet)
    columns = shown.findChildren(QLabel)
    assert sum(len(group.rows) for group in groups[:-1]) == len(bench.workbench.actions.specs)
    text = "".join(column.text() for column in columns)
    for group in groups:
        assert all(escape(keys) in text and escape(what) in text for keys, what in group.rows)
    assert all(column.height() >= column.heightForWidth(column.width()) for column in columns)
    assert shown.width() <= 1280 and shown.height() <= 740  # the whole sheet, without a scroll bar
    bench.qtbot.keyClick(shown, Qt.Key.Key_Escape)
    assert not shown.isVisible()


def test_what_is_in_a_submenu_is_named_with_it(bench: Bench) -> None:
    groups = sheet(bench.workbench.actions, bench.workbench.gestures)
    said = {what for group in groups for _, what in group.rows}
    assert {"Align: Left", "Align: Same height", "Handles: Snap", "Fields of view: Frusta"} <= said
    assert not {"Left", "Right", "Front", "Rear"} & said


def test_a_table_with_the_focus_copies_itself_not_the_selected_sensor(bench: Bench) -> None:
    bench.document.select("roof")
    table = bench.panels.scores.findChild(QTableView)
    table.setFocus()
    bench.qtbot.keyClick(table, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    assert bench.clipboard() == bench.panels.scores.table.as_text()


def test_columns_are_as_low_as_can_be() -> None:
    groups = [Group(str(rows), (("A", "does"),) * rows) for rows in (6, 2, 2, 5, 1, 4)]
    columns = in_columns(groups, 3)
    assert [group.title for column in columns for group in column] == ["6", "2", "2", "5", "1", "4"]
    assert [sum(group.height for group in column) for column in columns] == [12, 11, 9]
    assert len(in_columns(groups[:2], 3)) == 2 and in_columns([], 3) == []


@pytest.mark.parametrize("title", ["Map", "Scores"])
def test_the_key_of_a_panel_brings_it_to_the_front_and_never_hides_it(bench: Bench, title: str) -> None:
    dock = bench.workbench.docks[title]
    if title == "Scores":
        bench.workbench.docks["Compare"].raise_()
    key = bench.workbench.actions[f"dock_{title}"].shortcut()[0].key()
    for _ in range(2):
        bench.qtbot.keyClick(bench.window, key, Qt.KeyboardModifier.ControlModifier)
        wait_for(lambda: not dock.widget().visibleRegion().isEmpty())
    dock.close()
    bench.qtbot.keyClick(bench.window, key, Qt.KeyboardModifier.ControlModifier)
    wait_for(lambda: not dock.widget().visibleRegion().isEmpty())


def test_the_view_menu_is_short(bench: Bench) -> None:
    shown = [action for action in bench.workbench.places.menu("view").actions() if not action.isSeparator()]
    assert len(shown) <= 20


def test_the_heatmap_and_its_class_are_chosen_by_keys(bench: Bench) -> None:
    bench.qtbot.keyClick(bench.window, Qt.Key.Key_4, Qt.KeyboardModifier.AltModifier)
    assert bench.session.heat.mode == "unseen" and bench.workbench.actions["heat_unseen"].isChecked()
    bench.qtbot.keyClick(bench.window, Qt.Key.Key_0, Qt.KeyboardModifier.AltModifier)
    assert bench.session.heat.mode == "off"
    for name in ("bicycle", "pedestrian", "car"):
        bench.qtbot.keyClick(bench.window, Qt.Key.Key_T)
        assert bench.session.heat.class_name == name and bench.workbench.actions[f"class_{name}"].isChecked()


OWN_KEYS: set[tuple[str, str]] = {("scores", "copy")}
"""What a panel does itself while it has the focus."""


def test_every_key_reaches_its_action_and_no_other(qtbot: QtBot, tmp_path: Path) -> None:
    """Whatever has the focus: no list takes a letter for a search, no table takes a chord for itself."""
    with open_bench(qtbot, tmp_path, data=False) as bench:
        actions, reached = bench.workbench.actions, []
        keys = [(spec.key, keys) for spec in actions.specs for keys in actions[spec.key].shortcuts()]
        for key, _ in keys:
            actions[key].triggered.disconnect()
            actions[key].setEnabled(True)
            actions[key].triggered.connect(lambda _, key=key: reached.append(key))
        targets = {
            "viewport": bench.viewport,
            "tree": bench.panels.tree,
            "scores": bench.panels.scores.findChild(QTableView),
        }
        for place, target in targets.items():
            target.setFocus()
            for key, chord in keys:
                QTest.keySequence(QApplication.focusWidget() or bench.window, chord)
                if (place, key) in OWN_KEYS:
                    assert reached == [], (place, key)
                else:
                    assert reached == [key], (place, chord.toString())
                reached.clear()
        assert len(keys) > 50
