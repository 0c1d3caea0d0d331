"""A bar above the 3D view that says what went wrong, without stopping the work."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFrame, QHBoxLayout, QLabel, QSizePolicy, QToolButton, QWidget

from widgets.panels.icons import icon


class MessageBar(QFrame):
    """One message at a time; hidden until `show_message`, closed by its button."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("messageBar")
        self._label = QLabel()
        self._label.setWordWrap(True)
        self._label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._label.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        close = QToolButton()
        close.setIcon(icon("close"))
        close.setAutoRaise(True)
        close.setToolTip("Close this message")
        close.clicked.connect(self.clear)
        row = QHBoxLayout(self)
        row.setContentsMargins(12, 6, 6, 6)
        row.addWidget(self._label)
        row.addWidget(close)
        self.hide()

    @property
    def message(self) -> str:
        """The text that is shown, empty when the bar is closed."""
        return self._label.text()

    def show_message(self, text: str) -> None:
        """Show a message in place of the last one."""
        self._label.setText(text)
        self.show()

    def clear(self) -> None:
        """Close the bar."""
        self._label.clear()
        self.hide()
