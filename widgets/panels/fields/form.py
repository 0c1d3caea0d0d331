"""Rows of labelled fields that edit one frozen object: a change gives a validated copy or a reason in red."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError
from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QPaintEvent, QWheelEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QStyle,
    QStyleOptionComboBox,
    QStylePainter,
    QVBoxLayout,
    QWidget,
)

from riglens.core.errors import InputError
from riglens.core.rig.edits import replaced
from riglens.widgets.panels.controls.building import filled, plain_label
from riglens.widgets.panels.controls.scrolled import breakable
from riglens.widgets.panels.controls.style import MARGIN, SPACING, as_panel
from riglens.widgets.panels.fields.edits import MIXED, ListEdit, NumberEdit, ValueEdit
from riglens.widgets.panels.fields.quantity import Change, Unit

TEXT_MARGIN_PX = 4


class ChoiceBox(QComboBox):
    """A list of choices that the wheel does not change: a scrolled panel must not edit the rig."""

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Leave the wheel to the surrounding panel."""
        event.ignore()

    def sizeHint(self) -> QSize:
        """Return room for the longest choice with the margin that painting leaves."""
        return super().sizeHint() + QSize(TEXT_MARGIN_PX, 0)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the choice, with an ellipsis where it is too long: Qt cuts it off within a letter."""
        painter, option = QStylePainter(self), QStyleOptionComboBox()
        self.initStyleOption(option)
        painter.drawComplexControl(QStyle.ComplexControl.CC_ComboBox, option)
        field = self.style().subControlRect(
            QStyle.ComplexControl.CC_ComboBox, option, QStyle.SubControl.SC_ComboBoxEditField, self
        )
        if self.currentIndex() < 0:
            option.currentText = self.placeholderText()
        elide, room_px = Qt.TextElideMode.ElideRight, field.width() - TEXT_MARGIN_PX
        option.currentText = self.fontMetrics().elidedText(option.currentText, elide, room_px)
        painter.drawControl(QStyle.ControlElement.CE_ComboBoxLabel, option)


Read = Callable[[Any], Any]
Write = Callable[[Any, Any], Any]


@dataclass(frozen=True)
class _Binding:
    """A widget, how its value is read from the object shown, and how it shows one value or several."""

    widget: QWidget
    read: Read
    show: Callable[[Any], None]
    show_mixed: Callable[[Sequence[Any]], None]


class Form(QWidget):
    """A grid of labels and fields over one frozen object (`subject`).

    `changed` carries the changed copy. A value that the object refuses marks its field, and the reason is shown under
    the field as long as the value; the object itself stays as it is.

    Other objects may stand beside the subject: fields then show what all of them share, or that they differ, and a
    change is one of all of them. Fields in `shared` mean all, the others those of the subject's own class.
    """

    changed = Signal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self._subject: Any = None
        self._beside: tuple[Any, ...] = ()
        self._shared: set[QWidget] = set()
        self._bindings: list[_Binding] = []
        self._captions: dict[QWidget, QLabel] = {}
        self._reasons: dict[QWidget, str] = {}
        self._reason_labels: dict[QWidget, QLabel] = {}
        self._other_problem = ""
        self.words: dict[str, str] = {}
        """Names that the form shows for the fields of a rig file, for reasons that mention them."""
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(MARGIN, MARGIN, MARGIN, MARGIN)
        self._grid.setHorizontalSpacing(SPACING)
        self._grid.setVerticalSpacing(SPACING - 1)
        self._grid.setColumnMinimumWidth(0, 70)
        self._grid.setColumnStretch(1, 1)
        self._problem = _problem_label()

    # ------------------------------------------------------------------ building
    def add_heading(self, text: str) -> QLabel:
        """Add a line that names the group of fields under it."""
        label = plain_label(text, "heading", wraps=True)
        label.setIndent(0)
        self._grid.addWidget(label, self._grid.rowCount(), 0, 1, 2)
        return label

    def add_row(self, label: str, fields: Sequence[QWidget], tip: str = "") -> QWidget:
        """Add a label with its fields side by side, and return the widget that holds the fields."""
        box, line = QWidget(), filled(QHBoxLayout(), spacing=4)
        filled(QVBoxLayout(box), line, spacing=2)
        for field in fields:
            line.addWidget(field, 0 if isinstance(field, QLabel) else 1)
        caption = QLabel(label)
        caption.setToolTip(tip)
        box.setToolTip(tip)
        row = self._grid.rowCount()
        self._grid.addWidget(caption, row, 0)
        self._grid.addWidget(box, row, 1)
        self._captions[box] = caption
        return box

    def show_row(self, row: QWidget, shown: bool) -> None:
        """Show or hide a row that `add_row` returned, with its label."""
        row.setVisible(shown)
        self._captions[row].setVisible(shown)

    def add_wide(self, widget: QWidget) -> None:
        """Add a widget over the whole width."""
        self._grid.addWidget(widget, self._grid.rowCount(), 0, 1, 2)

    def add_problem_line(self) -> None:
        """Add the place for problems that belong to no row."""
        self.add_wide(self._problem)

    def set_fields_enabled(self, enabled: bool) -> None:
        """Make every bound field editable, or read-only."""
        for binding in self._bindings:
            binding.widget.setEnabled(enabled)

    def close_form(self) -> None:
        """Keep the rows at the top; problems without a row go under the last one unless they have a place already."""
        if self._problem.parentWidget() is None:
            self.add_problem_line()
        self._grid.setRowStretch(self._grid.rowCount(), 1)

    def bind_edit(
        self, edit: ValueEdit[Any], read: Read, write: Write, name: str, path: Path | None = None
    ) -> None:
        """Connect a line edit with one value of the subject, at a path if it is a field; `name` is the object name that
        finds it."""
        edit.setObjectName(name)
        edit.path = path
        self._bindings.append(_Binding(edit, read, edit.set_value, edit.set_mixed))
        edit.edited.connect(lambda value: self._try(edit, write, value))
        edit.refused.connect(lambda reason: self._refuse(edit, reason))
        edit.unmarked.connect(lambda: self._forget(edit))

    def bind_check(self, check: QCheckBox, read: Read, write: Write, name: str) -> None:
        """Connect a check box with a bool of the subject."""
        check.setObjectName(name)
        self._bindings.append(_Binding(check, read, *_check_shows(check)))
        check.clicked.connect(lambda value: self._try(check, write, value))

    def bind_choice(self, combo: QComboBox, read: Read, write: Write, name: str) -> None:
        """Connect a list of choices with the data of the item that is chosen."""
        combo.setObjectName(name)
        self._bindings.append(
            _Binding(combo, read, lambda value: _choose(combo, value), lambda _: _choose_none(combo))
        )
        combo.activated.connect(lambda index: self._try(combo, write, combo.itemData(index)))

    def set_units(self, *units: Unit) -> None:
        """Show every length and angle in these units; stored values stay in metres and degrees."""
        for binding in self._bindings:
            edit = binding.widget
            if isinstance(edit, NumberEdit | ListEdit):
                fitting = next((unit for unit in units if unit.quantity == edit.unit.quantity), None)
                if fitting is not None and fitting != edit.unit:
                    edit.set_unit(fitting)

    # ------------------------------------------------------------------ showing and changing
    def show_subject(self, subject: Any) -> None:
        """Show an object; fields with invalid text keep it until the value under them changes."""
        self._subject = subject
        for binding in self._bindings:
            self._show_binding(binding)
        self.show_problem("")

    def show_several(self, subjects: Sequence[Any]) -> None:
        """Show several objects, the last of which is the subject."""
        self._beside = tuple(subjects[:-1])
        self.show_subject(subjects[-1])

    def share(self, *widgets: QWidget) -> None:
        """Have these fields mean objects of every class, not of the subject's alone."""
        self._shared.update(widgets)

    @property
    def beside(self) -> tuple[Any, ...]:
        """Return what is shown besides the subject."""
        return self._beside

    def _meant(self, widget: QWidget) -> list[Any]:
        """Return the objects that a field is about, the subject last."""
        own = type(self._subject)
        others = [other for other in self._beside if widget in self._shared or isinstance(other, own)]
        return [*others, self._subject]

    def _show_binding(self, binding: _Binding) -> None:
        values = [binding.read(subject) for subject in self._meant(binding.widget)]
        if all(value == values[-1] for value in values):
            binding.show(values[-1])
        else:
            binding.show_mixed(values)

    def forget_input(self) -> None:
        """Discard what was typed and refused."""
        for widget in tuple(self._reasons):
            if isinstance(widget, ValueEdit):
                widget.revert()
        self.show_problem("")

    def _try(self, widget: QWidget, write: Write, value: Any) -> None:
        if self._subject is None:  # nothing has been shown yet
            return
        before, after = self._meant(widget), []
        for subject in before:
            try:
                after.append(write(subject, self._value_for(widget, subject, value)))
            except (ValidationError, InputError, ValueError) as error:
                reason = reason_of(error)
                self._refuse(widget, f"{subject.name}: {reason}" if self._beside else reason)
                return
        self._forget(widget)
        self.deliver(before, after)
        self.show_subject(self._subject)

    def _value_for(self, widget: QWidget, subject: Any, value: Any) -> Any:
        """Return the value that an object takes: the one given, or its own after a change."""
        if not isinstance(value, Change):
            return value
        return value.of(next(b for b in self._bindings if b.widget is widget).read(subject))

    def deliver(self, before: Sequence[Any], after: Sequence[Any]) -> None:
        """Emit the changed copies of some objects."""
        self.changed.emit(after[-1])

    def _refuse(self, widget: QWidget, reason: str) -> None:
        reason = self._in_words(reason)
        if isinstance(widget, ValueEdit):
            widget.mark(reason)
            self._reasons[widget] = reason
            self._show_reasons()
            return
        for binding in self._bindings:
            if binding.widget is widget:
                self._show_binding(binding)
        self.show_problem(_line(widget, reason))

    def _in_words(self, reason: str) -> str:
        """Return a reason with the names of the form in place of those of a rig file."""
        for name, word in self.words.items():
            reason = re.sub(rf"\b{name}\b", word, reason)
        return reason

    def _forget(self, widget: QWidget) -> None:
        """Clear the reason for rejecting a value that is gone."""
        if self._reasons.pop(widget, None) is not None:
            self._show_reasons()

    def _show_reasons(self) -> None:
        """Show every reason under the row of its field."""
        lines: dict[QWidget, list[str]] = {}
        for widget, reason in self._reasons.items():
            box = widget.parentWidget()
            if box is not None:
                lines.setdefault(box, []).append(_line(widget, reason))
        for box in lines.keys() - self._reason_labels.keys():
            label = self._reason_labels[box] = _problem_label()
            column = box.layout()
            assert column is not None
            column.addWidget(label)
        for box, label in self._reason_labels.items():
            label.setText(breakable("\n".join(lines.get(box, []))))
            label.setVisible(box in lines)

    @property
    def subject(self) -> Any:
        """The object that is shown."""
        return self._subject

    def show_problem(self, text: str) -> None:
        """Report a problem that is not bound to a field; the next change removes it."""
        self._other_problem = text
        self._problem.setText(breakable(text))
        self._problem.setVisible(bool(text))

    @property
    def problem(self) -> str:
        """Every reason shown in the form, empty when all is well."""
        lines = [_line(widget, reason) for widget, reason in self._reasons.items()]
        return "\n".join([*lines, self._other_problem] if self._other_problem else lines)


def _problem_label() -> QLabel:
    label = plain_label(style="problem", wraps=True)
    label.hide()
    return label


def _line(widget: QWidget, reason: str) -> str:
    """Return a reason with the name of its field."""
    name = widget.accessibleName()
    return f"{name}: {reason}" if name else reason


Path = tuple[str | int, ...]
"""From an object to a value in it: names of fields and places in tuples."""


def read(path: Path) -> Read:
    """Return a function that reads the value at a path; None if there is no such field or place."""

    def found(subject: Any) -> Any:
        for part in path:
            if isinstance(part, int):
                subject = subject[part] if subject is not None and part < len(subject) else None
            else:
                subject = getattr(subject, part, None)
        return subject

    return found


def write(path: Path) -> Write:
    """Return a function that replaces what lies at a path; all else stays the very same objects."""
    return lambda subject, value: replaced(subject, path, value)


def reason_of(error: Exception) -> str:
    """Return one line, without the words meant for programmers."""
    if isinstance(error, ValidationError):
        first = error.errors()[0]
        said = str(first["msg"])
        if said.startswith("Input should be "):
            return f"must be {said.removeprefix('Input should be ')} (got {first['input']})"
        return said.removeprefix("Value error, ")
    return error.message if isinstance(error, InputError) else str(error)


def _check_shows(check: QCheckBox) -> tuple[Callable[[Any], None], Callable[[Sequence[Any]], None]]:
    """Return how a check box shows one value, and several that differ; a click on the latter ticks it."""

    def show(value: Any) -> None:
        check.setTristate(False)
        check.setChecked(value)

    return show, lambda _: check.setCheckState(Qt.CheckState.PartiallyChecked)


def _choose_none(combo: QComboBox) -> None:
    combo.setPlaceholderText(MIXED)
    combo.setCurrentIndex(-1)


def _choose(combo: QComboBox, value: Any) -> None:
    """Select the item that carries `value`; add an item for a value that has none, except for no value."""
    index = combo.findData(value)
    if index < 0 and value is not None:
        combo.addItem(str(value), value)
        index = combo.count() - 1
    combo.setCurrentIndex(index)
