"""Scores per class with the change since the last save, in 10^3 nat; every digit in tooltip and copy.

Estimates can be shown in their place for a moment: marked ≈, in italics, without changes and without a copy.
"""

from __future__ import annotations

import math

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QBrush, QColor, QGuiApplication, QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from core.metric.scores import READINGS, MetricSettings, Scores
from core.scene.boxes import CLASSES
from widgets.panels.form import ChoiceBox
from widgets.panels.icons import swatch
from widgets.panels.number_edit import NumberEdit
from widgets.panels.score_text import (
    COLUMNS,
    NONE,
    SIGN_NOTE,
    Column,
    change_text,
    exact_text,
    kilo_text,
    rough_text,
    share_text,
)
from widgets.panels.style import MARGIN, SPACING, numbers_font, tones
from widgets.theme import CLASS_COLOURS

ABOUT, FOLLOWS = "≈ ", "…"
CLASS_PX, MIN_VALUE_PX, CHANGE_PX = 120, 90, 96

ESTIMATE_NOTE = "Estimated on larger voxels; the exact number follows as soon as the mouse rests"
READING_NOTES = {
    "covered": "S-MIG = −entropy of the set of voxels reached: the paper's equations",
    "residual": "S-MIG = −entropy of the voxels not reached: grows with coverage",
    "hits": "S-MIG counts a voxel once per ray: what the published code adds up",
}


class ScoresPanel(QWidget):
    """Shows one evaluation beside that of the saved rig. A number that is out of date is greyed."""

    settings_changed = Signal(object)
    """MetricSettings as the user wants them."""

    def __init__(self, settings: MetricSettings, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("panel")
        self._settings = settings
        self._is_stale = True
        self._is_estimate = False
        self._table = _ScoreTable()
        self._weight = NumberEdit(0.05)
        self._reading = ChoiceBox()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self._table, 1)
        layout.addLayout(self._controls())

    @property
    def settings(self) -> MetricSettings:
        """Method, reading and camera weight that are chosen."""
        return self._settings

    def _controls(self) -> QHBoxLayout:
        self._weight.setObjectName("camera_weight")
        self._weight.setFixedWidth(64)
        self._weight.set_value(self._settings.camera_weight)
        self._weight.edited.connect(self._on_weight)
        self._reading.setObjectName("reading")
        for reading in READINGS:
            self._reading.addItem(reading, reading)
            self._reading.setItemData(
                self._reading.count() - 1, READING_NOTES[reading], Qt.ItemDataRole.ToolTipRole
            )
        self._reading.setCurrentText(self._settings.reading)
        self._reading.activated.connect(self._on_reading)
        self._note = QLabel()
        self._note.setObjectName("hint")
        row = QHBoxLayout()
        row.setContentsMargins(MARGIN, 5, MARGIN, 6)
        row.setSpacing(SPACING)
        for widget in (QLabel("λ"), self._weight, QLabel("Reading"), self._reading):
            row.addWidget(widget)
        row.addSpacing(2 * SPACING)
        row.addWidget(self._note, 1)
        self._weight.setToolTip("Weight of the cameras in S-MS, 0.1 in the paper")
        self._show_note()
        return row

    # ------------------------------------------------------------------ what is shown
    def show_scores(self, scores: Scores, saved: Scores) -> None:
        """Show up-to-date scores and their change since `saved`."""
        self._is_stale = self._is_estimate = False
        self._table.show_scores(scores, saved, self._settings)

    def show_estimate(self, scores: Scores) -> None:
        """Show rough scores until the exact ones are there; there is nothing to copy until then."""
        self._is_stale = self._is_estimate = True
        self._table.show_estimate(scores)

    def set_stale(self) -> None:
        """Grey the numbers: they belong to an earlier state."""
        if not self._is_stale:
            self._is_stale = True
            self._table.grey()

    @property
    def is_stale(self) -> bool:
        """Whether the numbers are greyed."""
        return self._is_stale

    @property
    def is_estimate(self) -> bool:
        """Whether the numbers are rough ones."""
        return self._is_estimate

    def text_of(self, class_name: str, column: str) -> str:
        """What a cell shows; `column` is a key of COLUMNS, or the key with " change" behind it."""
        return self._table.cell(class_name, column).text()

    def as_text(self) -> str:
        """The table with every digit, columns separated by tabs."""
        return self._table.as_text()

    # ------------------------------------------------------------------ what the user does
    def _on_weight(self, value: float) -> None:
        if not (math.isfinite(value) and value >= 0.0):
            self._weight.mark(f"λ: found {value:g}, accepted is a number from 0 up")
            return
        self._change(MetricSettings(self._settings.method, self._settings.reading, value))

    def _on_reading(self, index: int) -> None:
        self._change(MetricSettings(self._settings.method, READINGS[index], self._settings.camera_weight))

    def _change(self, settings: MetricSettings) -> None:
        self._settings = settings
        self._weight.set_value(settings.camera_weight)
        self._show_note()
        self.settings_changed.emit(settings)

    def _show_note(self) -> None:
        falls = self._settings.reading != "residual"
        way = "S-MS falls as coverage grows" if falls else "S-MS rises as coverage grows"
        self._note.setText(f"10³ nat · change since last saved · {way}")
        self._note.setToolTip(SIGN_NOTE)


class _ScoreTable(QTableWidget):
    """Class, then value and change for every column."""

    def __init__(self) -> None:
        super().__init__(len(CLASSES), 1 + 2 * len(COLUMNS))
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ContiguousSelection)
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.setFont(numbers_font(self.font()))
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(26)
        self._set_header()
        for row, name in enumerate(CLASSES):
            self._fill_row(row, name)

    def _set_header(self) -> None:
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setMinimumSectionSize(MIN_VALUE_PX)
        for place in range(self.columnCount()):
            is_value = place % 2 == 1
            mode = QHeaderView.ResizeMode.Stretch if is_value else QHeaderView.ResizeMode.Fixed
            header.setSectionResizeMode(place, mode)
            header.resizeSection(place, CLASS_PX if place == 0 else CHANGE_PX)
        titles: list[tuple[str, str]] = [("Class", "")]
        for column in COLUMNS:
            titles += [
                (column.title, column.tip),
                ("change", "Change since the rig was last saved or opened"),
            ]
        for place, (title, tip) in enumerate(titles):
            item = QTableWidgetItem(title)
            item.setToolTip(tip)
            side = Qt.AlignmentFlag.AlignRight if place else Qt.AlignmentFlag.AlignLeft
            item.setTextAlignment(side | Qt.AlignmentFlag.AlignVCenter)
            self.setHorizontalHeaderItem(place, item)

    def _fill_row(self, row: int, name: str) -> None:
        title = QTableWidgetItem(swatch(CLASS_COLOURS[name]), name)
        title.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
        self.setItem(row, 0, title)
        for place in range(1, self.columnCount()):
            item = QTableWidgetItem(NONE)
            item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            item.setForeground(QBrush(QColor(tones().muted)))
            self.setItem(row, place, item)

    def cell(self, class_name: str, column: str) -> QTableWidgetItem:
        """The item of a class and a column key, with " change" behind it for its change."""
        key, _, is_change = column.partition(" ")
        place = 1 + 2 * [c.key for c in COLUMNS].index(key) + (1 if is_change else 0)
        item = self.item(CLASSES.index(class_name), place)
        assert item is not None
        return item

    def show_scores(self, scores: Scores, saved: Scores, settings: MetricSettings) -> None:
        for name in CLASSES:
            now, before = scores.classes[name], saved.classes[name]
            for column in COLUMNS:
                value, change = column.value(now), column.value(now) - column.value(before)
                self._show_value(self.cell(name, column.key), column, value)
                self._show_change(self.cell(name, f"{column.key} change"), column, change, settings)

    def show_estimate(self, scores: Scores) -> None:
        """Rough values without changes, of which no digit can be copied."""
        for name in CLASSES:
            for column in COLUMNS:
                value = column.value(scores.classes[name])
                self._show_rough(self.cell(name, column.key), ABOUT + rough_text(column, value))
                self._show_rough(self.cell(name, f"{column.key} change"), FOLLOWS)

    def _show_rough(self, item: QTableWidgetItem, text: str) -> None:
        item.setText(text)
        item.setToolTip(ESTIMATE_NOTE)
        item.setData(Qt.ItemDataRole.UserRole, None)
        item.setForeground(QBrush(QColor(tones().muted)))
        _set_italic(item, True)

    def _show_value(self, item: QTableWidgetItem, column: Column, value: float) -> None:
        item.setText(share_text(value) if column.is_share else kilo_text(value))
        _set_italic(item, False)
        item.setToolTip(exact_text(column, value))
        item.setData(Qt.ItemDataRole.UserRole, value)
        item.setForeground(QBrush(QColor(tones().text)))

    def _show_change(
        self, item: QTableWidgetItem, column: Column, change: float, settings: MetricSettings
    ) -> None:
        item.setText(change_text(change, column))
        _set_italic(item, False)
        item.setData(Qt.ItemDataRole.UserRole, change)
        looks_at_more = (change > 0) == (column.is_share or settings.reading == "residual")
        colour = tones().muted if change == 0 else tones().more if looks_at_more else tones().less
        item.setForeground(QBrush(QColor(colour)))
        meaning = "no change" if change == 0 else "looks at more" if looks_at_more else "looks at less"
        item.setToolTip(f"{exact_text(column, change)}: {meaning} since the rig was last saved")

    def grey(self) -> None:
        """Every number in the muted colour."""
        muted = QBrush(QColor(tones().muted))
        for row in range(self.rowCount()):
            for place in range(1, self.columnCount()):
                item = self.item(row, place)
                if item is not None:
                    item.setForeground(muted)

    def as_text(self) -> str:
        """Titles and exact values, tabs between columns."""
        titles = ["class"]
        for column in COLUMNS:
            unit = "fraction" if column.is_share else "nat"
            titles += [f"{column.title} ({unit})", f"change ({unit})"]
        lines = ["\t".join(titles)]
        for row, name in enumerate(CLASSES):
            values = [
                self.model().index(row, place).data(Qt.ItemDataRole.UserRole)
                for place in range(1, self.columnCount())
            ]
            lines.append("\t".join([name, *("" if value is None else repr(value) for value in values)]))
        return "\n".join(lines) + "\n"

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.matches(QKeySequence.StandardKey.Copy):
            QGuiApplication.clipboard().setText(self.as_text())
            return
        super().keyPressEvent(event)


def _set_italic(item: QTableWidgetItem, italic: bool) -> None:
    font = item.font()
    if font.italic() != italic:
        font.setItalic(italic)
        item.setFont(font)
