"""Entries of menus."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu


def add_entry(menu: QMenu, text: str, slot: Callable[[], object]) -> QAction:
    """Append an entry that calls `slot` without arguments, and return its action.

    `QMenu.addAction(text, slot)` is not used: it looks its new action up by address, and PySide now and then finds the
    wrapper of a dead object that lay there before ("QSurface has no attribute connect").
    """
    action = QAction(text, menu)
    action.triggered.connect(lambda _checked=False: slot())
    menu.addAction(action)
    return action
