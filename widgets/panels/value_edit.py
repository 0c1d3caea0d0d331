"""A line edit that holds a value, not a text: exact until the user changes it, with a unit inside the field."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from PySide6.QtCore import QEvent, QRect, Qt, Signal
from PySide6.QtGui import QColor, QFocusEvent, QKeyEvent, QKeySequence, QPainter, QPaintEvent
from PySide6.QtWidgets import QLineEdit, QWidget

from riglens.widgets.panels.style import numbers_font, tones

Value = TypeVar("Value")
_SUFFIX_GAP_PX = 3


class ValueEdit(QLineEdit, Generic[Value]):
    """A line edit that holds a value, not a text.

    It shows a short text, and the full one while it has the keyboard focus. `edited` is sent only when the
    text was changed and could be read; a text that cannot be read marks the field and keeps the value.
    """

    edited = Signal(object)
    refused = Signal(str)

    def __init__(
        self,
        parse: Callable[[str], Value],
        short: Callable[[Value], str],
        full: Callable[[Value], str],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._parse, self._short, self._full = parse, short, full
        self._value: Value | None = None
        self._suffix = ""
        self.setFont(numbers_font(self.font()))
        self.editingFinished.connect(self._take)

    @property
    def value(self) -> Value | None:
        """The stored value; None when the field is empty because there is nothing to show."""
        return self._value

    def set_value(self, value: Value | None) -> None:
        """Show a value that comes from outside; what the user is just typing is kept."""
        if value == self._value and (self._is_touched() or self._is_marked()):
            return
        self._value = value
        self._show()

    def set_suffix(self, suffix: str) -> None:
        """A unit that always stands at the right end of the field and is no part of the text."""
        self._suffix = suffix
        width = self.fontMetrics().horizontalAdvance(suffix) + _SUFFIX_GAP_PX if suffix else 0
        self.setTextMargins(0, 0, width, 0)

    def mark(self, reason: str) -> None:
        """Show in red that what was typed is not accepted; an empty reason takes the mark away."""
        if self._is_marked() != bool(reason):
            self.setProperty("invalid", bool(reason))
            self.style().unpolish(self)
            self.style().polish(self)
        self.setToolTip(reason or ("" if self._value is None else self._full(self._value)))

    def _is_marked(self) -> bool:
        return bool(self.property("invalid"))

    def _shown(self) -> str:
        if self._value is None:
            return ""
        return self._full(self._value) if self.hasFocus() else self._short(self._value)

    def _is_touched(self) -> bool:
        return self.isModified()

    def _show(self) -> None:
        if self.text() != self._shown():
            self.setText(self._shown())
            self.setCursorPosition(0)
        self.setModified(False)
        self.mark("")

    def _take(self) -> None:
        """Read what was typed, once."""
        if not self._is_touched():
            return
        self.setModified(False)
        if self._value is not None and self.text() in (self._short(self._value), self._full(self._value)):
            self._show()
            return
        try:
            value = self._parse(self.text())
        except ValueError as error:
            self.mark(str(error))
            self.refused.emit(str(error))
            return
        self.mark("")
        self.edited.emit(value)

    def revert(self) -> None:
        """Forget what was typed."""
        self.setModified(False)
        self._show()

    # ------------------------------------------------------------------ Qt events
    def paintEvent(self, event: QPaintEvent) -> None:
        super().paintEvent(event)
        if self._suffix:
            painter = QPainter(self)
            painter.setPen(QColor(tones().muted))
            room = QRect(0, 0, self.width() - 2 * _SUFFIX_GAP_PX, self.height())
            painter.drawText(room, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter, self._suffix)
            painter.end()

    def focusInEvent(self, event: QFocusEvent) -> None:
        super().focusInEvent(event)
        if not self._is_marked():
            self._show()
        if event.reason() != Qt.FocusReason.MouseFocusReason:
            self.selectAll()

    def focusOutEvent(self, event: QFocusEvent) -> None:
        super().focusOutEvent(event)
        if not self._is_marked():
            self._show()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and (self._is_touched() or self._is_marked()):
            self.revert()
            self.selectAll()
            return
        super().keyPressEvent(event)

    def event(self, event: QEvent) -> bool:
        """Leave undo and redo to the document unless something is being typed here."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            is_undo = event.matches(QKeySequence.StandardKey.Undo) or event.matches(
                QKeySequence.StandardKey.Redo
            )
            if is_undo and not self._is_touched():
                event.ignore()
                return False
        return super().event(event)
