"""Line edits that hold a value, not a text: numbers, lists of numbers, names, each with its unit."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from PySide6.QtCore import QEvent, QRect, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFocusEvent,
    QKeyEvent,
    QKeySequence,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QShowEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QLineEdit, QStyle, QStyleOptionFrame, QWidget

from riglens.core.shown_text import visible
from riglens.widgets.panels.controls.style import numbers_font, plain_tip, tones
from riglens.widgets.panels.fields.quantity import (
    NO_UNIT,
    Change,
    Unit,
    fitted_number,
    full_text,
    parse_change,
    parse_quantity,
    short_text,
)

Value = TypeVar("Value")
_SUFFIX_GAP_PX = 3
_TEXT_MARGIN_PX = 2
"""Margin of a line edit on both sides of its text."""
_CUT = "…"
MIXED = "mixed"
"""Text of a field of several sensors whose values differ."""
_Keys = QKeySequence.StandardKey


class ValueEdit(QLineEdit, Generic[Value]):
    """Line edit for a value of any kind.

    It shows a short text, and the full one while it has the keyboard focus. `edited` is emitted only when the
    text was changed and is valid; an invalid text marks the field and keeps the value. Of several things whose values
    differ it says that they do, until a text sets or changes all of them.
    """

    edited = Signal(object)
    """The new value, or a Change of any value."""
    refused = Signal(str)
    unmarked = Signal()
    """The text that was refused is gone."""
    holds_words = False
    """Take any letter, also one that is a shortcut elsewhere."""

    def __init__(
        self,
        parse: Callable[[str], Value | Change],
        short: Callable[[Value], str],
        full: Callable[[Value], str],
        unit: Unit = NO_UNIT,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._parse, self._short, self._full = parse, short, full
        self.path: tuple[str | int, ...] | None = None
        """Return the path of the value in its object; None if it is not a field of a rig file."""
        self._value: Value | None = None
        self._mixed: tuple[Value, ...] = ()
        self._unit = unit
        self.setFont(numbers_font(self.font()))
        self.set_suffix(unit.name)
        self.editingFinished.connect(self._take)
        self.textEdited.connect(lambda _: self.mark(""))

    @property
    def value(self) -> Value | None:
        """The stored value; None when the field is empty because there is nothing to show."""
        return self._value

    def set_value(self, value: Value | None) -> None:
        """Show a value from outside, unless the user is typing."""
        if value == self._value and not self._mixed:
            return
        self._value, self._mixed = value, ()
        self.setPlaceholderText("")
        self._show()

    def set_mixed(self, values: Sequence[Value]) -> None:
        """Show that several things have different values, unless the user is typing."""
        if tuple(values) == self._mixed and (self._is_touched() or self._is_marked()):
            return
        self._value, self._mixed = None, tuple(values)
        self.setPlaceholderText(MIXED)
        self._show()

    def _tip(self) -> str:
        """Return the tooltip of the value, or of the values."""
        return "" if self._value is None else self._full(self._value)

    @property
    def unit(self) -> Unit:
        """The unit shown."""
        return self._unit

    def set_unit(self, unit: Unit) -> None:
        """Show the same value in another unit."""
        self._unit = unit
        self.set_suffix(unit.name)
        self.revert()

    def set_suffix(self, suffix: str) -> None:
        """Set a unit that is always shown at the right end of the field and is not part of the text."""
        self._suffix = suffix
        width = self.fontMetrics().horizontalAdvance(suffix) + _SUFFIX_GAP_PX if suffix else 0
        self.setTextMargins(0, 0, width, 0)

    def mark(self, reason: str) -> None:
        """Show in red that what was typed is not accepted; an empty reason removes the mark."""
        was_marked = self._is_marked()
        if was_marked != bool(reason):
            self.setProperty("invalid", bool(reason))
            self.style().unpolish(self)
            self.style().polish(self)
        self.setToolTip(plain_tip(reason or self._tip()))
        if was_marked and not reason:
            self.unmarked.emit()

    def _is_marked(self) -> bool:
        return bool(self.property("invalid"))

    def _shown(self) -> str:
        if self._value is None:
            return ""
        return self._full(self._value) if self.hasFocus() else self._fitted(self._value)

    def _fitted(self, value: Value) -> str:
        """Return the short text, or a shorter one that fits into the field."""
        return self._short(value)

    def keep_room_for(self, text: str) -> None:
        """Keep at least the width that this text needs."""
        around_px = self.width() - self._room().width()
        self.setMinimumWidth(self.fontMetrics().horizontalAdvance(text) + around_px)

    def _fits(self, text: str) -> bool:
        """Return whether a text has room in the field; before the field is on the screen, any text has."""
        return not self.isVisible() or self.fontMetrics().horizontalAdvance(text) <= self._room().width()

    def _room(self) -> QRect:
        """Return the area of the text."""
        option = QStyleOptionFrame()
        self.initStyleOption(option)
        inside = self.style().subElementRect(QStyle.SubElement.SE_LineEditContents, option, self)
        return inside.marginsRemoved(self.textMargins()).adjusted(_TEXT_MARGIN_PX, 0, -_TEXT_MARGIN_PX, 0)

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
        if self._mixed and not self.text().strip():
            self._show()
            return
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
        """Discard what was typed."""
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
        if self.cut_at is not None:
            self._paint_cut(self.cut_at)

    @property
    def cut_at(self) -> Qt.AlignmentFlag | None:
        """The side at which the text does not fit and is marked as cut off; None for a whole text."""
        if self._fits(self.text()):
            return None
        return Qt.AlignmentFlag.AlignRight if self.cursorPosition() == 0 else Qt.AlignmentFlag.AlignLeft

    def _paint_cut(self, side: Qt.AlignmentFlag) -> None:
        """Put three dots where the text is cut off, so that no number is taken for a smaller one."""
        painter = QPainter(self)
        place, width_px = self._room(), self.fontMetrics().horizontalAdvance(_CUT)
        if side == Qt.AlignmentFlag.AlignRight:
            place.setLeft(place.right() - width_px)
            place.setRight(place.right() + _TEXT_MARGIN_PX)
        else:
            place.setRight(place.left() + width_px)
            place.setLeft(place.left() - _TEXT_MARGIN_PX)
        painter.fillRect(place, self.palette().base())
        painter.setPen(self.palette().text().color())
        painter.drawText(place, Qt.AlignmentFlag.AlignCenter, _CUT)
        painter.end()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Show as much of a value as has room."""
        super().resizeEvent(event)
        self._refit()

    def showEvent(self, event: QShowEvent) -> None:
        """Show as much of a value as has room."""
        super().showEvent(event)
        self._refit()

    def _refit(self) -> None:
        if not (self.hasFocus() or self._is_touched() or self._is_marked()):
            self._show()

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
        self.setCursorPosition(0)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and (self._is_touched() or self._is_marked()):
            self.revert()
            self.selectAll()
            return
        if _is_redo(event):
            self.redo()
            return
        if event.text() == "?" and not self.holds_words:
            event.ignore()
            return
        super().keyPressEvent(event)

    def event(self, event: QEvent) -> bool:
        """Leave undo, redo and Escape to the window unless something is being typed here, and the key of the help
        always: no number has a question mark."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent):
            if event.text() == "?" and not self.holds_words:
                event.ignore()
                return False
            is_own = self._is_touched() or self._is_marked()
            if event.key() == Qt.Key.Key_Escape or _is_redo(event) or event.matches(_Keys.Undo):
                event.setAccepted(is_own)
                return is_own
        return super().event(event)


def _is_redo(event: QKeyEvent) -> bool:
    """Return whether keys mean redo: Ctrl+Y everywhere, not only on systems that use it."""
    is_ctrl_y = event.key() == Qt.Key.Key_Y and event.modifiers() == Qt.KeyboardModifier.ControlModifier
    return is_ctrl_y or event.matches(_Keys.Redo)


WHEEL_NOTCH = 120


class NumberEdit(ValueEdit[float | None]):
    """One double, right aligned, with its unit; arrow keys and, while focused, the wheel change it by `step`.

    An optional one may be left empty. Shift makes steps ten times as large, Ctrl ten times as small. `step` is in the
    stored unit. A text such as "+=0.1" changes the number; of several that differ it changes each, and so do steps.
    """

    def __init__(
        self, step: float, unit: Unit = NO_UNIT, parent: QWidget | None = None, is_optional: bool = False
    ) -> None:
        super().__init__(self._parsed, self._short_text, self._full_text, unit, parent)
        self._step, self._is_optional = step, is_optional
        self._turned = 0
        self.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)

    def _parsed(self, text: str) -> float | Change | None:
        if self._is_optional and not text.strip():
            return None
        change = parse_change(text, self._unit)
        if change is None and self._mixed and text.lstrip().startswith("+"):
            plain = text.strip()[:40]
            raise ValueError(
                f"ambiguous '{plain}': write +={plain[1:]} to add to each, or {plain[1:]} to set all"
            )
        if change is not None and not self._mixed:
            return change.of(self._value)
        return parse_quantity(text, self._unit) if change is None else change

    def _tip(self) -> str:
        if not self._mixed:
            return super()._tip()
        numbers = [value for value in self._mixed if value is not None]
        low, high = self._short_text(min(numbers)), self._short_text(max(numbers))
        span = f"{low} to {high} {self._unit.name}".rstrip()
        return f"{span}\nA number sets all; += or -= with a number changes each."

    def _short_text(self, value: float | None) -> str:
        return "" if value is None else short_text(value, self._unit)

    def _full_text(self, value: float | None) -> str:
        return "" if value is None else full_text(value, self._unit)

    def _fitted(self, value: float | None) -> str:
        return (
            ""
            if value is None
            else fitted_number(value * self._unit.per_base, self._short(value), self._fits)
        )

    def step_by(self, steps: float) -> None:
        """Request the value that many steps further, rounded so that tenths stay tenths."""
        if self._mixed:
            self._take()
            self.edited.emit(Change(plus=steps * self._step * self._unit.step / self._unit.per_base))
            return
        if self._value is None or not math.isfinite(self._value):
            return
        self._take()
        shown = self._value * self._unit.per_base + steps * self._step * self._unit.step
        self.edited.emit(round(shown, 9) / self._unit.per_base)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        steps = {Qt.Key.Key_Up: 1, Qt.Key.Key_Down: -1}.get(Qt.Key(event.key()), 0)
        if steps:
            self.step_by(steps * _pace(event.modifiers()))
            return
        super().keyPressEvent(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Step while focused; otherwise let the surrounding panel scroll."""
        if not self.hasFocus() or self.isReadOnly():
            event.ignore()
            return
        self._turned += event.angleDelta().y() or event.angleDelta().x()  # Alt turns the wheel sideways
        notches = int(self._turned / WHEEL_NOTCH)
        self._turned -= notches * WHEEL_NOTCH
        if notches:
            self.step_by(notches * _pace(event.modifiers()))
        event.accept()


def _pace(modifiers: Qt.KeyboardModifier) -> float:
    if modifiers & Qt.KeyboardModifier.ShiftModifier:
        return 10.0
    return 0.1 if modifiers & Qt.KeyboardModifier.ControlModifier else 1.0


class IntegerEdit(ValueEdit[int | None]):
    """One whole number, right aligned, with its unit; an optional one may be left empty."""

    def __init__(
        self, is_optional: bool = False, unit: Unit = NO_UNIT, parent: QWidget | None = None
    ) -> None:
        def parse(text: str) -> int | None:
            return None if is_optional and not text.strip() else _parse_integer(text)

        super().__init__(parse, str, str, unit, parent)
        self.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)

    def _fitted(self, value: int | None) -> str:
        return "" if value is None else fitted_number(value, str(value), self._fits)


class ListEdit(ValueEdit[tuple[float, ...] | None]):
    """Several doubles, separated by commas or spaces, with their unit; an optional list may be left empty."""

    def __init__(
        self, unit: Unit = NO_UNIT, is_optional: bool = False, parent: QWidget | None = None
    ) -> None:
        self._is_optional = is_optional
        super().__init__(self._parsed, self._joined(short_text), self._joined(full_text), unit, parent)

    def _parsed(self, text: str) -> tuple[float, ...] | None:
        parts = text.replace(",", " ").replace(";", " ").split()
        if not parts and self._is_optional:
            return None
        if not parts:
            raise ValueError("must hold numbers such as -15, 0, 15 (got none)")
        return tuple(parse_quantity(part, self._unit) for part in parts)

    def _joined(self, one: Callable[[float, Unit], str]) -> Callable[[tuple[float, ...] | None], str]:
        return lambda values: ", ".join(one(value, self._unit) for value in values or ())


class TextEdit(ValueEdit[str]):
    """A name: any text that is not empty."""

    holds_words = True

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(_parse_name, visible, str, parent=parent)


class WordsEdit(ValueEdit[tuple[str, ...]]):
    """Words, separated by commas or spaces; may be left empty."""

    holds_words = True

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(
            lambda text: tuple(text.replace(",", " ").split()), ", ".join, ", ".join, parent=parent
        )


def _parse_integer(text: str) -> int:
    try:
        return int(text.strip())
    except ValueError:
        raise ValueError(f"must be an integer such as 16 (got '{text.strip()}')") from None


def _parse_name(text: str) -> str:
    if not text.strip():
        raise ValueError("must not be empty")
    return text.strip()
