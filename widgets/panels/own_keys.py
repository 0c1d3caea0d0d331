"""Keys that a panel takes for itself while it has the focus, before the window's actions of the same keys."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from PySide6.QtCore import QEvent, QObject
from PySide6.QtGui import QKeyEvent, QKeySequence
from PySide6.QtWidgets import QWidget

StandardKey = QKeySequence.StandardKey


class OwnKeys(QObject):
    """Does what is given by key. A QShortcut of the panel would be ambiguous beside an action of the window."""

    def __init__(self, panel: QWidget, slots: Mapping[StandardKey, Callable[[], object]]) -> None:
        super().__init__(panel)
        self._slots = dict(slots)
        panel.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Claim the keys first, then act on them."""
        if isinstance(event, QKeyEvent) and event.type() in (
            QEvent.Type.ShortcutOverride,
            QEvent.Type.KeyPress,
        ):
            for key, slot in self._slots.items():
                if event.matches(key):
                    event.accept()
                    if event.type() == QEvent.Type.KeyPress:
                        slot()
                    return True
        return False
