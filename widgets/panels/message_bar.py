"""A bar above the 3D view that says what happened and what to do, without stopping the work."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QPlainTextEdit,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from riglens.widgets.panels.icons import icon

DETAILS_PX = 150
Choices = dict[str, Callable[[], object]]


class MessageBar(QFrame):
    """One message at a time; hidden until `show_message`, closed by its button or by one of its choices."""

    def __init__(self, parent: QWidget | None = None, is_error: bool = True) -> None:
        super().__init__(parent)
        self.setObjectName("messageBar" if is_error else "noteBar")
        self._label = QLabel()
        self._label.setWordWrap(True)
        self._label.setTextFormat(Qt.TextFormat.PlainText)
        self._label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._label.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self._choices = QHBoxLayout()
        self._details = QPlainTextEdit()
        self._details.setReadOnly(True)
        self._details.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        self._details.setFixedHeight(DETAILS_PX)
        self._toggle, self._copy, close = QPushButton("Details"), QPushButton("Copy"), QToolButton()
        self._toggle.setObjectName("details")
        self._toggle.setCheckable(True)
        self._toggle.toggled.connect(self._show_details)
        self._copy.setObjectName("copy_details")
        self._copy.setToolTip("Copy message and details, for a report of the problem")
        self._copy.clicked.connect(self._copy_all)
        close.setIcon(icon("close"))
        close.setAutoRaise(True)
        close.setToolTip("Close this message")
        close.clicked.connect(self.clear)
        self._build(close)
        self.hide()

    def _build(self, close: QToolButton) -> None:
        row = QHBoxLayout()
        row.addWidget(self._label, 1)
        row.addLayout(self._choices)
        for widget in (self._copy, self._toggle, close):
            row.addWidget(widget, 0, Qt.AlignmentFlag.AlignTop)
        column = QVBoxLayout(self)
        column.setContentsMargins(12, 6, 6, 6)
        column.addLayout(row)
        column.addWidget(self._details)

    @property
    def message(self) -> str:
        """The text that is shown, empty when the bar is closed."""
        return self._label.text()

    @property
    def details(self) -> str:
        """What Details shows, empty when there is nothing more to say."""
        return self._details.toPlainText()

    def show_message(self, text: str, details: str = "", choices: Choices | None = None) -> None:
        """Show a message in place of the last one; `choices` are buttons, each closes the bar."""
        self.clear()
        self._label.setText(text)
        self._details.setPlainText(details)
        for widget in (self._toggle, self._copy):
            widget.setVisible(bool(details))
        for title, chosen in (choices or {}).items():
            button = QPushButton(title)
            button.setObjectName(title)
            button.clicked.connect(self.clear)
            button.clicked.connect(lambda _=False, chosen=chosen: chosen())
            self._choices.addWidget(button)
        self.show()

    def clear(self) -> None:
        """Close the bar."""
        self._label.clear()
        self._details.clear()
        self._toggle.setChecked(False)
        self._details.hide()
        while (item := self._choices.takeAt(0)) is not None:
            widget = item.widget()
            if widget is not None:
                widget.hide()
                widget.deleteLater()
        self.hide()

    def _show_details(self, shown: bool) -> None:
        self._details.setVisible(shown)

    def _copy_all(self) -> None:
        QGuiApplication.clipboard().setText(f"{self.message}\n\n{self.details}")
