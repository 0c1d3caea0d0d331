"""Line edits for numbers, lists of numbers and names; a value stays exact until the user changes it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Generic, TypeVar

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QKeySequence
from PySide6.QtWidgets import QLineEdit, QWidget

from widgets.panels.style import numbers_font

Value = TypeVar("Value")
SHOWN_DECIMALS = 4


def short_number(value: float) -> str:
    """At most four decimals, no trailing zeros; what an unfocused field shows."""
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    text = f"{value:.{SHOWN_DECIMALS}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def full_number(value: float) -> str:
    """The shortest text that reads back as the same double."""
    return short_number(value) if math.isinf(value) else repr(value).removesuffix(".0")


def thousands(count: int) -> str:
    """A count with thin spaces between groups of three digits."""
    return f"{count:,}".replace(",", "\u2009")


def parse_number(text: str) -> float:
    """A double from text; ValueError with a reason. Infinity may be written ∞ or inf."""
    cleaned = text.strip().replace("∞", "inf").replace("−", "-")
    try:
        value = float(cleaned)
    except ValueError:
        raise ValueError(f"found '{text.strip()}', accepted is a number such as 1.25") from None
    if math.isnan(value):
        raise ValueError("found nan, accepted is a number such as 1.25")
    return value


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


class NumberEdit(ValueEdit[float]):
    """One double, right aligned; the up and down keys change it by `step`."""

    def __init__(self, step: float, parent: QWidget | None = None) -> None:
        super().__init__(parse_number, short_number, full_number, parent)
        self._step = step
        self.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        steps = {Qt.Key.Key_Up: 1, Qt.Key.Key_Down: -1}.get(Qt.Key(event.key()), 0)
        if steps and self._value is not None and math.isfinite(self._value):
            self._take()
            factor = 10 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1
            self.edited.emit(round(self._value + steps * factor * self._step, 9))
            return
        super().keyPressEvent(event)


class IntegerEdit(ValueEdit[int | None]):
    """One whole number, right aligned; an optional one may be left empty."""

    def __init__(self, is_optional: bool = False, parent: QWidget | None = None) -> None:
        parse = _parse_optional_integer if is_optional else _parse_integer
        super().__init__(parse, str, str, parent)
        self.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)


class ListEdit(ValueEdit[tuple[float, ...]]):
    """Several doubles, separated by commas or spaces."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(_parse_list, _join(short_number), _join(full_number), parent)


class TextEdit(ValueEdit[str]):
    """A name: any text that is not empty."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(_parse_name, str, str, parent)


def _parse_integer(text: str) -> int:
    try:
        return int(text.strip())
    except ValueError:
        raise ValueError(f"found '{text.strip()}', accepted is a whole number such as 16") from None


def _parse_optional_integer(text: str) -> int | None:
    return _parse_integer(text) if text.strip() else None


def _parse_list(text: str) -> tuple[float, ...]:
    return tuple(parse_number(part) for part in text.replace(",", " ").replace(";", " ").split())


def _parse_name(text: str) -> str:
    if not text.strip():
        raise ValueError("found nothing, accepted is any text that no other sensor uses")
    return text.strip()


def _join(one: Callable[[float], str]) -> Callable[[tuple[float, ...]], str]:
    return lambda values: ", ".join(one(value) for value in values)
