"""Number fields: sums may be typed, the unit shown can change, and only a focused field follows the wheel."""

import math
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QKeyEvent, QWheelEvent
from PySide6.QtWidgets import QApplication, QLineEdit, QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from riglens.widgets.panels.controls.style import MARGIN, tones
from riglens.widgets.panels.fields.edits import IntegerEdit, NumberEdit, TextEdit, ValueEdit
from riglens.widgets.panels.fields.form import Form
from riglens.widgets.panels.fields.quantity import (
    DEGREES,
    METRES,
    MILLIMETRES,
    RADIANS,
    Unit,
    fitted_number,
    parse_number,
    parse_quantity,
    short_number,
)
from tests.waiting import TIMEOUT_MS
from tests.widgets.marks import colour, marks, texts

SHIFT, CTRL = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1.2+0.05", 1.2 + 0.05),
        ("2 * (0.5 − 0.2)", 2 * (0.5 - 0.2)),
        ("4.6/2 - 0.35", 4.6 / 2 - 0.35),
        ("-(1)", -1.0),
        ("1e-3*2", 0.002),
        ("pi/2", math.pi / 2),
        ("3 × 2 ÷ 4", 1.5),
    ],
)
def test_a_sum_is_worked_out(text: str, value: float) -> None:
    assert parse_number(text) == value


@pytest.mark.parametrize(
    "text",
    [
        "1+",
        "(1",
        "1,2+3",
        "2**9",
        "9//2",
        "__import__('os')",
        "x+1",
        "1 if 1 else 2",
        "True+1",
        "(" * 199,
        "1+" * 200,
    ],
)
def test_anything_but_a_sum_of_numbers_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"must .*a number"):
        parse_number(text)


def test_a_division_by_zero_says_so() -> None:
    with pytest.raises(ValueError, match="divide by zero"):
        parse_number("1/0")


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("1.25", METRES, 1.25),
        ("1250", MILLIMETRES, 1.25),
        ("1250 mm", METRES, 1.25),
        ("1.2 m", MILLIMETRES, 1.2),
        ("12cm", METRES, 0.12),
        ("(1+1)mm", METRES, 0.002),
        ("90 deg", RADIANS, 90.0),
        ("90°", DEGREES, 90.0),
    ],
)
def test_a_unit_behind_the_number_wins_over_the_one_shown(text: str, unit: Unit, value: float) -> None:
    assert parse_quantity(text, unit) == value


def test_radians_become_degrees() -> None:
    assert parse_quantity("pi/4", RADIANS) == pytest.approx(45.0, abs=1e-12)


@pytest.mark.parametrize("text", ["5 deg", "5 px", "5 furlongs"])
def test_a_length_in_another_kind_of_unit_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"must .*a number"):
        parse_quantity(text, METRES)


class Field:
    """A number field above another one that can have the focus, with a model that takes what was typed."""

    def __init__(self, qtbot: QtBot) -> None:
        self._qtbot = qtbot
        self.page = QWidget()
        qtbot.addWidget(self.page)
        self.edit, self.other = NumberEdit(0.05, METRES), QLineEdit()
        column = QVBoxLayout(self.page)
        column.addWidget(self.edit)
        column.addWidget(self.other)
        self.edit.set_value(1.2)
        self.edit.edited.connect(self.edit.set_value)
        self.page.show()
        self.page.activateWindow()
        qtbot.waitUntil(self.page.isActiveWindow, timeout=TIMEOUT_MS)
        self.other.setFocus()

    def wheel(self, delta: int, modifiers: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier) -> bool:
        """Turn the wheel over the field; whether the field took it."""
        middle = QPointF(self.edit.rect().center())
        event = QWheelEvent(
            middle, self.edit.mapToGlobal(middle), QPoint(), QPoint(0, delta), Qt.MouseButton.NoButton,
            modifiers, Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QApplication.sendEvent(self.edit, event)
        return event.isAccepted()

    def ask(self, text: str) -> bool:
        """Return whether the field takes a key for itself that the window may have a shortcut for."""
        event = QKeyEvent(QEvent.Type.ShortcutOverride, Qt.Key.Key_A, Qt.KeyboardModifier.NoModifier, text)
        event.ignore()
        QApplication.sendEvent(self.edit, event)
        return event.isAccepted()

    def type(self, text: str) -> None:
        self.edit.setFocus()
        self.edit.selectAll()
        self._qtbot.keyClicks(self.edit, text)
        self._qtbot.keyClick(self.edit, Qt.Key.Key_Return)


@pytest.fixture
def field(qtbot: QtBot) -> Iterator[Field]:
    yield Field(qtbot)


def test_the_wheel_leaves_a_field_alone_that_is_not_being_edited(field: Field) -> None:
    assert not field.wheel(120)
    assert field.edit.value == 1.2


def test_the_wheel_steps_the_field_that_is_being_edited(field: Field) -> None:
    field.edit.setFocus()
    assert field.wheel(120)
    assert field.edit.value == 1.25
    field.wheel(-120, SHIFT)
    assert field.edit.value == 0.75
    field.wheel(120, CTRL)
    assert field.edit.value == 0.755


def test_small_turns_of_the_wheel_add_up_to_one_step(field: Field) -> None:
    field.edit.setFocus()
    for _ in range(3):
        field.wheel(30)
    assert field.edit.value == 1.2
    field.wheel(30)
    assert field.edit.value == 1.25


def test_another_unit_shows_the_same_value(field: Field) -> None:
    field.edit.set_unit(MILLIMETRES)
    assert field.edit.text() == "1200"
    assert field.edit.value == 1.2
    field.type("1200+55")
    assert field.edit.value == 1.255


def test_looking_at_a_value_in_another_unit_does_not_change_a_bit_of_it(field: Field) -> None:
    odd = 0.1 + 0.2
    field.edit.set_value(odd)
    for unit in (MILLIMETRES, METRES):
        field.edit.set_unit(unit)
        field.edit.setFocus()
        field.other.setFocus()
    assert field.edit.value == odd
    assert field.edit.text() == "0.3"


def test_steps_are_round_in_the_unit_shown(field: Field) -> None:
    field.edit.set_unit(MILLIMETRES)
    field.edit.setFocus()
    field.wheel(120)
    assert field.edit.text() == "1250"


# ---------------------------------------------------------------------- numbers longer than their field
@pytest.mark.parametrize(
    ("value", "characters", "text"),
    [
        (10_000_000, 8, "10000000"), (10_000_000, 7, "1e7"), (12_345_678, 7, "1.235e7"), (-12_345_678, 5, "-1e7"),
        (123.45678, 7, "123.457"), (123.45678, 5, "123.5"), (0.000123, 6, "0.0001"), (math.inf, 0, "∞"),
        (-180.0, 3, "-180"), (99_999.4, 3, "99999"), (0.1234, 3, "0.1234"),
    ],
)  # fmt: skip
def test_a_number_is_shortened_to_its_room_but_never_cut_off(
    value: float, characters: int, text: str
) -> None:
    assert fitted_number(value, short_number(value), lambda found: len(found) <= characters) == text


@pytest.mark.parametrize("make", [IntegerEdit, lambda: NumberEdit(0.05, METRES)])
def test_a_narrow_field_shows_ten_million_as_such(qtbot: QtBot, make: Callable[[], ValueEdit[Any]]) -> None:
    edit = make()
    qtbot.addWidget(edit)
    edit.setFixedWidth(edit.fontMetrics().horizontalAdvance("0000000") + 8)
    edit.set_value(10_000_000)
    edit.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    edit.show()
    assert edit.text() == "1e7" and edit.cut_at is None
    edit.setFixedWidth(300)
    qtbot.waitUntil(lambda: edit.text() == "10000000", timeout=TIMEOUT_MS)


def test_a_text_that_is_cut_off_says_so_at_the_side_where_it_goes_on(qtbot: QtBot) -> None:
    edit = TextEdit()
    qtbot.addWidget(edit)
    edit.resize(80, 24)
    edit.set_value("a name that no field of eighty pixels has room for")
    edit.show()
    edit.setCursorPosition(0)
    assert edit.cut_at == Qt.AlignmentFlag.AlignRight
    edit.end(False)
    assert edit.cut_at == Qt.AlignmentFlag.AlignLeft
    edit.set_value("short")
    assert edit.cut_at is None


def test_a_field_paints_its_unit_at_the_right_end_and_dots_where_its_text_goes_on(qtbot: QtBot) -> None:
    number, name = NumberEdit(0.05, METRES), TextEdit()
    for edit, value in ((number, 1.5), (name, "a name that no field of eighty pixels has room for")):
        qtbot.addWidget(edit)
        edit.resize(80, 24)
        edit.set_value(value)
        edit.show()
    (unit,) = (mark for mark in marks(number) if mark.text == "m")
    wide_px = number.fontMetrics().horizontalAdvance("m")
    assert 60.0 < unit.at[0] + wide_px < 80.0 and 12.0 < unit.at[1] < 22.0
    assert unit.fill == colour(tones().muted)
    assert not [mark for mark in marks(name) if mark.text == "m"]
    for place, is_right in ((0, True), (len(name.text()), False)):
        name.setCursorPosition(place)
        (dots,) = (mark for mark in marks(name) if mark.text == "…")
        assert (dots.at[0] > 50.0) == is_right and (dots.at[0] < 20.0) != is_right
    number.set_value(2.5)
    assert "…" not in texts(marks(number))


def test_a_field_of_several_values_shows_their_span_and_changes_each(field: Field) -> None:
    found: list[Any] = []
    field.edit.edited.disconnect()
    field.edit.edited.connect(found.append)
    field.edit.set_mixed((2.0, None, -1.0, 0.5))
    assert field.edit.text() == "" and "-1 to 2 m" in field.edit.toolTip().replace("−", "-")
    for typed in ("+=0.5", "-=1", "3"):
        field.type(typed)
    field.type("+5")
    assert "ambiguous" in field.edit.toolTip()
    plus, minus, all_of_them = found
    assert (plus.of(2.0), minus.of(-0.5), all_of_them) == (2.5, -1.5, 3.0)


def test_a_question_mark_is_left_to_the_help_and_digits_are_the_field_s(field: Field) -> None:
    assert field.ask("7") and not field.ask("?")


def test_the_fields_of_forms_with_short_captions_stand_below_one_another(qtbot: QtBot) -> None:
    """Captions of one form are shorter than those of the next, and the fields line up all the same."""
    begins = []
    for captions in (("z",), ("Roll", "x")):
        form = Form()
        qtbot.addWidget(form)
        form.resize(300, 200)
        boxes = [form.add_row(caption, [QLineEdit()]) for caption in captions]
        form.show()
        begins.append({box.x() for box in boxes})
        assert {box.geometry().right() for box in boxes} == {form.contentsRect().right() - MARGIN}
    assert begins[0] == begins[1] and len(begins[0]) == 1
