"""Context menus of lists and tables: made anew each time, for what is selected then."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QAbstractItemView, QMenu


def give_context_menu(view: QAbstractItemView, make: Callable[[], QMenu]) -> None:
    """Have a right click, or the menu key, open what `make` makes; it goes when it is closed."""

    def open_menu(position: QPoint) -> None:
        menu = make()
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(view.viewport().mapToGlobal(position))

    view.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
    view.customContextMenuRequested.connect(open_menu)
