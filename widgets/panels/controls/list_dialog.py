"""A dialog that tells when nobody looks at it any more."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtGui import QHideEvent
from PySide6.QtWidgets import QDialog


class ListDialog(QDialog):
    """Says when it is hidden, so that what it shows need not be kept up to date."""

    put_away = Signal()

    def hideEvent(self, event: QHideEvent) -> None:
        """Nobody looks any more."""
        super().hideEvent(event)
        self.put_away.emit()
