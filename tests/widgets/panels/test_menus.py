"""Entries of menus call what they were made for, and nothing else."""

from __future__ import annotations

from PySide6.QtWidgets import QMenu
from pytestqt.qtbot import QtBot

from riglens.widgets.panels.controls.menus import add_entry


def test_an_entry_stands_last_in_its_menu_and_calls_its_slot_without_arguments(qtbot: QtBot) -> None:
    menu, calls = QMenu(), list[tuple[object, ...]]()
    qtbot.addWidget(menu)
    add_entry(menu, "First", lambda *args: calls.append(("first", *args)))
    last = add_entry(menu, "Last", lambda *args: calls.append(("last", *args)))
    last.trigger()
    assert [action.text() for action in menu.actions()] == ["First", "Last"]
    assert calls == [("last",)]
