"""A table with a row for each sensor of a rig; a click selects the sensor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QBrush, QColor
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableWidget, QTableWidgetItem

from riglens.core.shown_text import visible
from riglens.widgets.panels.controls.style import numbers_font, plain_tip, tones

_ROW_PX = 24


class SensorTable(QTableWidget):
    """Titles with tooltips over the values of each sensor."""

    chosen = Signal(str)
    """The row of this sensor was clicked."""

    def __init__(self, columns: Mapping[str, str]) -> None:
        super().__init__(0, 1 + len(columns))
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.setTabKeyNavigation(False)
        self.setFont(numbers_font(self.font()))
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(_ROW_PX)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        for place, (title, tip) in enumerate([("Sensor", ""), *columns.items()]):
            item = QTableWidgetItem(title)
            item.setToolTip(tip)
            item.setTextAlignment(_side(place))
            self.setHorizontalHeaderItem(place, item)
        self._names: list[str] = []
        self.cellClicked.connect(lambda row, _: self.chosen.emit(self._names[row]))

    def grey(self) -> None:
        """Show every value in the muted colour."""
        for row in range(self.rowCount()):
            for place in range(self.columnCount()):
                item = self.item(row, place)
                if item is not None:
                    item.setForeground(QBrush(QColor(tones().muted)))

    def show_rows(self, rows: Mapping[str, Sequence[tuple[str, str]]], is_current: bool = True) -> None:
        """Show text and tooltip of every value by sensor, greyed unless current."""
        if list(rows) != self._names:
            self._names = list(rows)
            self.setRowCount(0)
            self.setRowCount(len(rows))
        brush = QBrush(QColor(tones().text if is_current else tones().muted))
        for row, (name, values) in enumerate(rows.items()):
            for place, (text, tip) in enumerate([(visible(name), ""), *values]):
                item = self.item(row, place)
                if item is None:
                    item = QTableWidgetItem()
                    item.setTextAlignment(_side(place))
                    self.setItem(row, place, item)
                item.setText(text)
                item.setToolTip(plain_tip(tip))
                item.setForeground(brush)

    def texts_of(self, name: str) -> list[str]:
        """Return the values of a sensor as shown."""
        row = self._names.index(name)
        items = (self.item(row, place) for place in range(1, self.columnCount()))
        return ["" if item is None else item.text() for item in items]


def _side(place: int) -> Qt.AlignmentFlag:
    return (
        Qt.AlignmentFlag.AlignRight if place else Qt.AlignmentFlag.AlignLeft
    ) | Qt.AlignmentFlag.AlignVCenter
