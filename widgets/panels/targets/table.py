"""The table of targets: a row per class, a column per ring of distance, each cell with its error and its change."""

from __future__ import annotations

from itertools import pairwise

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QRectF, QSize, Qt
from PySide6.QtGui import QBrush, QColor, QFont, QGuiApplication, QPainter, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableWidget,
    QTableWidgetItem,
)

from riglens.core.targets.quantities import EVERYBODY, WHO, Table
from riglens.widgets.panels.controls.icons import swatch
from riglens.widgets.panels.controls.item_views import OwnKeys, StandardKey
from riglens.widgets.panels.controls.style import numbers_font, plain_tip, tones
from riglens.widgets.panels.targets.text import change_text, error_text, is_better, tip_text, value_text
from riglens.widgets.theme import CLASS_COLOURS

TITLES = {EVERYBODY: "All road users", "car": "Cars", "bicycle": "Bicycles", "pedestrian": "Pedestrians"}
SUB_TEXT = Qt.ItemDataRole.UserRole.value + 1
CHANGE = Qt.ItemDataRole.UserRole.value + 2
CHANGE_COLOUR = Qt.ItemDataRole.UserRole.value + 3
ROW_PX, CLASS_PX, MIN_CELL_PX = 38, 128, 104
LOW_ROW_PX = 30
"""Rows are as low as this where the panel is too low to show all of them otherwise."""
_PAD_PX, _SMALL = 8, 0.86


class _TwoLines(QStyledItemDelegate):
    """Draws the number, and under it in small type its error and its change."""

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionViewItem,
        index: QModelIndex | QPersistentModelIndex,
    ) -> None:
        """Draw the cell's background, then both lines, right-aligned."""
        told = QStyleOptionViewItem(option)
        self.initStyleOption(told, index)
        text, told.text = told.text, ""
        told.state &= ~QStyle.StateFlag.State_HasFocus
        if told.state & QStyle.StateFlag.State_Selected:
            # softer than the style's, so that all lines stay legible
            painter.fillRect(option.rect, QColor(tones().chosen))
            told.state &= ~QStyle.StateFlag.State_Selected
            told.backgroundBrush = QBrush(QColor(tones().chosen))
        told.widget.style().drawControl(
            told.widget.style().ControlElement.CE_ItemViewItem, told, painter, told.widget
        )
        gap_px = 3 if option.rect.height() >= ROW_PX else 1
        room = QRectF(option.rect).adjusted(_PAD_PX, gap_px, -_PAD_PX, -gap_px)
        painter.save()
        painter.setFont(told.font)
        painter.setPen(index.data(Qt.ItemDataRole.ForegroundRole).color())
        right = Qt.AlignmentFlag.AlignRight
        painter.drawText(room, right | Qt.AlignmentFlag.AlignTop, text)
        self._draw_small(painter, room, told.font, index)
        painter.restore()

    def _draw_small(
        self, painter: QPainter, room: QRectF, font: QFont, index: QModelIndex | QPersistentModelIndex
    ) -> None:
        small = QFont(font)
        small.setPointSizeF(font.pointSizeF() * _SMALL)
        small.setBold(False)
        painter.setFont(small)
        bottom = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignBottom
        change, error = index.data(CHANGE) or "", index.data(SUB_TEXT) or ""
        if change:
            painter.setPen(QColor(index.data(CHANGE_COLOUR)))
            painter.drawText(room, bottom, change)
            room = room.adjusted(0, 0, -painter.fontMetrics().horizontalAdvance(change + "  "), 0)
        painter.setPen(QColor(tones().muted))
        painter.drawText(room, bottom, error)

    def sizeHint(self, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex) -> QSize:
        """Room for two lines."""
        return super().sizeHint(option, index).expandedTo(QSize(MIN_CELL_PX, LOW_ROW_PX))


class TargetTable(QTableWidget):
    """Shows one `Table`; the current row says whose rose is wanted."""

    def __init__(self) -> None:
        super().__init__(len(WHO), 0)
        self._table: Table | None = None
        self._names: list[str] = []
        """Titles of the columns."""
        OwnKeys(self, {StandardKey.Copy: self._copy})
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.setTabKeyNavigation(False)
        self.setItemDelegate(_TwoLines(self))
        self.setFont(numbers_font(self.font()))
        self.verticalHeader().setSectionsClickable(True)
        self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        self.verticalHeader().setDefaultSectionSize(ROW_PX)
        self.verticalHeader().setMinimumWidth(CLASS_PX)
        self.verticalHeader().setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        self.horizontalHeader().setMinimumSectionSize(MIN_CELL_PX)
        self.horizontalHeader().setDefaultAlignment(
            Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        )
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        for row, who in enumerate(WHO):
            title = QTableWidgetItem(TITLES[who])
            if who in CLASS_COLOURS:
                title.setIcon(swatch(CLASS_COLOURS[who]))
            self.setVerticalHeaderItem(row, title)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Have every class in sight while there is room for two lines each."""
        super().resizeEvent(event)
        share_px = self.viewport().height() // len(WHO)
        self.verticalHeader().setDefaultSectionSize(max(LOW_ROW_PX, min(share_px, ROW_PX)))

    @property
    def who(self) -> str:
        """The row whose rose is wanted."""
        return WHO[max(self.currentRow(), 0)]

    def show_table(self, table: Table, baseline: str) -> None:
        """Show the numbers, and in tooltips what they change against."""
        self._table = table
        self._show_titles(table)
        for row in range(len(WHO)):
            for column in range(self.columnCount()):
                self._show_cell(table, row, column, baseline)

    def _show_titles(self, table: Table) -> None:
        edges = table.edges_m
        names = [f"0–{edges[-1]:g} m", *(f"{a:g}–{b:g} m" for a, b in pairwise(edges))]
        if names == self._names:
            return
        self._names = names
        self.setColumnCount(len(names))
        self.setHorizontalHeaderLabels(names)
        for row in range(len(WHO)):
            for column in range(len(names)):
                self.setItem(row, column, QTableWidgetItem())

    def _show_cell(self, table: Table, row: int, column: int, baseline: str) -> None:
        item, cells, quantity = self.item(row, column), table.cells, table.quantity
        assert item is not None
        value, change = float(cells.value[row, column]), float(cells.change[row, column])
        item.setText(value_text(quantity, value))
        item.setData(SUB_TEXT, error_text(quantity, float(cells.se[row, column])))
        item.setData(CHANGE, change_text(quantity, change))
        better = tones().more if is_better(quantity, change) else tones().less
        item.setData(CHANGE_COLOUR, better)
        has_any = bool(cells.objects[row, column])
        item.setForeground(QBrush(QColor(tones().text if has_any else tones().muted)))
        font = self.font()
        font.setBold(column == 0)
        item.setFont(font)
        where = f"{TITLES[WHO[row]]}, {self._names[column]}"
        item.setToolTip(plain_tip(tip_text(quantity, where, cells, (row, column), baseline)))

    def grey(self) -> None:
        """Show that the numbers are out of date."""
        muted = QBrush(QColor(tones().muted))
        for row in range(self.rowCount()):
            for column in range(self.columnCount()):
                item = self.item(row, column)
                assert item is not None
                item.setForeground(muted)
                item.setData(CHANGE_COLOUR, tones().muted)

    def as_text(self) -> str:
        """Return titles and exact values with tabs between columns: number, error, change and count of each ring."""
        if self._table is None:
            return ""
        table, titles = self._table, ["class"]
        for column in range(self.columnCount()):
            titles += [
                f"{table.quantity.title} {self._names[column]}",
                "standard error",
                "change",
                "road users",
            ]
        lines = ["\t".join(titles)]
        for row, who in enumerate(WHO):
            values = [who]
            for column in range(self.columnCount()):
                cells = table.cells
                numbers = (cells.value[row, column], cells.se[row, column], cells.change[row, column])
                values += [*(repr(float(number)) for number in numbers), str(cells.objects[row, column])]
            lines.append("\t".join(values))
        return "\n".join(lines) + "\n"

    def _copy(self) -> None:
        QGuiApplication.clipboard().setText(self.as_text())
