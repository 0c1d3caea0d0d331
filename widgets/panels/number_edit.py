"""Line edits for numbers, lists of numbers and names; what is stored does not change with the unit shown."""

from __future__ import annotations

import math
from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

from riglens.widgets.panels.expression import NO_UNIT, Unit, parse_quantity
from riglens.widgets.panels.value_edit import ValueEdit

SHOWN_DECIMALS = 4
WHEEL_NOTCH = 120


def short_number(value: float) -> str:
    """At most four decimals, no trailing zeros; what an unfocused field shows."""
    if math.isinf(value):
        return "∞" if value > 0 else "-∞"
    text = f"{value:.{SHOWN_DECIMALS}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def full_number(value: float) -> str:
    """The shortest text that reads back as the same double."""
    return short_number(value) if math.isinf(value) else repr(value).removesuffix(".0")


def short_text(value: float, unit: Unit) -> str:
    """A stored value in a unit, as `short_number`."""
    return short_number(value * unit.per_base)


def full_text(value: float, unit: Unit) -> str:
    """A stored value in a unit: every digit in the stored one, twelve in another."""
    if unit.per_base == 1.0 or math.isinf(value):
        return full_number(value)
    return full_number(float(f"{value * unit.per_base:.12g}"))


class NumberEdit(ValueEdit[float]):
    """One double, right aligned, with its unit; arrow keys and, while focused, the wheel change it by `step`.

    Shift makes steps ten times as large, Ctrl ten times as small. `step` is in the stored unit.
    """

    def __init__(self, step: float, unit: Unit = NO_UNIT, parent: QWidget | None = None) -> None:
        super().__init__(self._parsed, self._short_text, self._full_text, parent)
        self._step = step
        self._unit = unit
        self._turned = 0
        self.set_suffix(unit.name)
        self.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)

    @property
    def unit(self) -> Unit:
        """The unit shown."""
        return self._unit

    def set_unit(self, unit: Unit) -> None:
        """Show the same value in another unit."""
        self._unit = unit
        self.set_suffix(unit.name)
        self.revert()

    def _parsed(self, text: str) -> float:
        return parse_quantity(text, self._unit)

    def _short_text(self, value: float) -> str:
        return short_text(value, self._unit)

    def _full_text(self, value: float) -> str:
        return full_text(value, self._unit)

    def step_by(self, steps: float) -> None:
        """Ask for the value that many steps further, rounded so that tenths stay tenths."""
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
        """Step while focused; otherwise the panel around scrolls."""
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
        parse = _parse_optional_integer if is_optional else _parse_integer
        super().__init__(parse, str, str, parent)
        self.set_suffix(unit.name)
        self.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)


class ListEdit(ValueEdit[tuple[float, ...]]):
    """Several doubles, separated by commas or spaces, with their unit."""

    def __init__(self, unit: Unit = NO_UNIT, parent: QWidget | None = None) -> None:
        super().__init__(self._parsed, self._joined(short_text), self._joined(full_text), parent)
        self._unit = unit
        self.set_suffix(unit.name)

    @property
    def unit(self) -> Unit:
        """The unit shown."""
        return self._unit

    def set_unit(self, unit: Unit) -> None:
        """Show the same values in another unit."""
        self._unit = unit
        self.set_suffix(unit.name)
        self.revert()

    def _parsed(self, text: str) -> tuple[float, ...]:
        parts = text.replace(",", " ").replace(";", " ").split()
        return tuple(parse_quantity(part, self._unit) for part in parts)

    def _joined(self, one: Callable[[float, Unit], str]) -> Callable[[tuple[float, ...]], str]:
        return lambda values: ", ".join(one(value, self._unit) for value in values)


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


def _parse_name(text: str) -> str:
    if not text.strip():
        raise ValueError("found nothing, accepted is any text that no other sensor uses")
    return text.strip()
