"""A table of figures described by data: text, exact values, error and change, colour and tooltip of each cell."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from PySide6.QtCore import (
    QAbstractTableModel,
    QModelIndex,
    QPersistentModelIndex,
    QRectF,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QBrush, QColor, QFont, QFontMetrics, QGuiApplication, QPainter, QPaintEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from riglens.core.shown_values import NONE
from riglens.widgets.panels.controls.icons import swatch
from riglens.widgets.panels.controls.item_views import (
    BAR_COLOUR,
    BAR_SHARE,
    BarDelegate,
    OwnKeys,
    StandardKey,
)
from riglens.widgets.panels.controls.style import numbers_font, plain_tip, tones

Tone = Literal["text", "muted", "more", "less"]
Index = QModelIndex | QPersistentModelIndex
FIGURE = Qt.ItemDataRole.UserRole.value
SORT = Qt.ItemDataRole.UserRole.value + 3
_ROLE = Qt.ItemDataRole
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter


@dataclass(frozen=True)
class Cell:
    """A cell; tones name colours of the theme.

    values: exact numbers that are copied, one for each of its column's `copied`; the first is sorted by. error, change:
    small, in a second line. bar: length of a bar under the number, 0 to 1 of the cell.
    """

    text: str = NONE
    values: tuple[float | int | None, ...] = ()
    tip: str = ""
    tone: Tone = "text"
    error: str = ""
    change: str = ""
    change_tone: Tone = "text"
    is_bold: bool = False
    is_italic: bool = False
    bar: float | None = None
    bar_colour: str | None = None


NOTHING = Cell(tone="muted")


@dataclass(frozen=True)
class Heading:
    """Title of a row or a column.

    copied: titles of the exact numbers of a column, with none its texts are copied; or the name of a row where it is
    copied. unit: at the end of the texts of a column, which its title may name in their place. is_left: whether the
    texts of a column without numbers are left-aligned.
    """

    title: str
    tip: str = ""
    short: str = ""
    colour: str = ""
    copied: tuple[str, ...] = ()
    unit: str = ""
    is_left: bool = False
    is_muted: bool = False


class FigureModel(QAbstractTableModel):
    """Cells under headings. All of them, or some columns, may be greyed as out of date."""

    def __init__(self) -> None:
        super().__init__()
        self._rows: tuple[Heading, ...] = ()
        self._columns: tuple[Heading, ...] = ()
        self._figures: list[tuple[Cell, ...]] = []
        self._grey: frozenset[int] = frozenset()
        self._is_narrow = False
        self._names_units = False

    def show(
        self,
        rows: Sequence[Heading],
        columns: Sequence[Heading],
        figures: Sequence[Sequence[Cell]],
        anew: bool = False,
    ) -> None:
        """Show cells, none of them grey; selection and scroll position stay, unless `anew` or of another size."""
        is_resized = anew or (len(rows), len(columns)) != (len(self._rows), len(self._columns))
        if is_resized:
            self.beginResetModel()
            self._rows, self._columns = tuple(rows), tuple(columns)
            self._figures, self._grey = [tuple(row) for row in figures], frozenset()
            self.endResetModel()
        else:
            self.set_row_titles(rows)
            if self._columns != tuple(columns):
                self._columns = tuple(columns)
                self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, len(columns) - 1)
            self._exchange([tuple(row) for row in figures], frozenset())

    def show_columns(self, columns: Mapping[int, Sequence[Cell]]) -> None:
        """Show other cells in some columns, row by row; they are not grey any more."""
        whole = [list(row) for row in self._figures]
        for place, cells in columns.items():
            for row, cell in zip(whole, cells, strict=True):
                row[place] = cell
        self._exchange([tuple(row) for row in whole], self._grey - set(columns))

    def set_row_titles(self, rows: Sequence[Heading]) -> None:
        """Show other titles of the rows."""
        if self._rows != tuple(rows):
            self._rows = tuple(rows)
            self.headerDataChanged.emit(Qt.Orientation.Vertical, 0, len(rows) - 1)

    def grey(self, columns: Iterable[int] | None = None) -> None:
        """Show in the muted colour that all columns, or some, are out of date."""
        grey = self._grey | frozenset(range(len(self._columns)) if columns is None else columns)
        self._exchange(self._figures, grey)

    def forget(self) -> None:
        """Show a dash in every cell: no figure is known."""
        self._exchange([(NOTHING,) * len(self._columns)] * len(self._figures), frozenset())

    def _exchange(self, figures: list[tuple[Cell, ...]], grey: frozenset[int]) -> None:
        """Show cells of as many rows and columns; columns that look the same are not painted again."""
        before, self._figures = self._figures, figures
        turned, self._grey = self._grey ^ grey, grey
        others = [
            column
            for column, (old, new) in enumerate(
                zip(zip(*before, strict=True), zip(*figures, strict=True), strict=True)
            )
            if old != new or column in turned
        ]
        if others:
            self.dataChanged.emit(self.index(0, others[0]), self.index(len(figures) - 1, others[-1]))

    def set_narrow(self, is_narrow: bool) -> None:
        """Give columns short titles where they have one."""
        if is_narrow != self._is_narrow and self._columns:
            self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, len(self._columns) - 1)
        self._is_narrow = is_narrow

    def name_units(self, in_titles: bool) -> None:
        """Name the units of columns that have one in their titles, once, or else in each cell."""
        if in_titles == self._names_units:
            return
        self._names_units = in_titles
        if self._columns:
            last = len(self._columns) - 1
            self.headerDataChanged.emit(Qt.Orientation.Horizontal, 0, last)
            self.dataChanged.emit(self.index(0, 0), self.index(len(self._figures) - 1, last))

    @property
    def row_titles(self) -> tuple[str, ...]:
        """Titles of the rows."""
        return tuple(heading.title for heading in self._rows)

    @property
    def column_titles(self) -> tuple[str, ...]:
        """Titles of the columns, in full."""
        return tuple(heading.title for heading in self._columns)

    def cell(self, row: int, column: int) -> Cell:
        """Return a cell."""
        return self._figures[row][column]

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008 Qt's signature
        return 0 if parent.isValid() else len(self._figures)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008 Qt's signature
        return 0 if parent.isValid() else len(self._columns)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = _ROLE.DisplayRole) -> Any:
        is_column = orientation == Qt.Orientation.Horizontal
        heading = (self._columns if is_column else self._rows)[section]
        if role == _ROLE.DisplayRole:
            title = heading.short if self._is_narrow and heading.short else heading.title
            return f"{title}, {heading.unit}" if self._names_units and heading.unit else title
        if role == _ROLE.ToolTipRole:
            return heading.tip
        if role == _ROLE.DecorationRole and heading.colour:
            return swatch(heading.colour)
        if role == _ROLE.TextAlignmentRole:
            return _RIGHT if is_column and not heading.is_left else _LEFT
        if role == _ROLE.ForegroundRole and heading.is_muted:
            return QBrush(QColor(tones().muted))
        return None

    def data(self, index: Index, role: int = _ROLE.DisplayRole) -> Any:
        figure = self._figures[index.row()][index.column()]
        if role == FIGURE:
            return figure
        if role == _ROLE.DisplayRole:
            unit = self._columns[index.column()].unit if self._names_units else ""
            return figure.text.removesuffix(f" {unit}") if unit else figure.text
        if role == _ROLE.ToolTipRole:
            return plain_tip(figure.tip)
        if role == _ROLE.TextAlignmentRole:
            return _LEFT if self._columns[index.column()].is_left else _RIGHT
        if role == _ROLE.ForegroundRole:
            return QBrush(self.colour(index.column(), figure.tone))
        if role == SORT:
            return float("-inf") if figure.values[:1] == (None,) else (*figure.values, figure.text)[0]
        if role == _ROLE.FontRole and (figure.is_bold or figure.is_italic):
            font = numbers_font(QFont())
            font.setBold(figure.is_bold)
            font.setItalic(figure.is_italic)
            return font
        return {BAR_SHARE: figure.bar, BAR_COLOUR: figure.bar_colour}.get(role)

    def colour(self, column: int, tone: Tone) -> QColor:
        """Return the colour of a tone, which is muted where a column is grey."""
        return QColor(getattr(tones(), "muted" if column in self._grey else tone))

    def as_text(self, corner: str, delimiter: str = "\t") -> str:
        """Return titles and exact numbers, `corner` above the titles of the rows."""
        titles = [corner, *(name for heading in self._columns for name in heading.copied or (heading.title,))]
        lines: list[list[str]] = []
        for heading, figures in zip(self._rows, self._figures, strict=True):
            cells = [*(heading.copied or (heading.title,))]
            for column, figure in zip(self._columns, figures, strict=True):
                cells += (
                    [exact(value) for value in figure.values or (None,) * len(column.copied)]
                    if column.copied
                    else [figure.text]
                )
            lines.append(cells)
        return delimited([titles, *lines], delimiter)


def exact(value: float | int | None) -> str:
    """Return a number in full precision; nothing where there is none."""
    return "" if value is None else repr(value)


def delimited(lines: Iterable[Iterable[object]], delimiter: str) -> str:
    """Return lines of cells for spreadsheets."""
    stream = io.StringIO()
    csv.writer(stream, delimiter=delimiter, lineterminator="\n").writerows(lines)
    return stream.getvalue()


class FigureTable(QTableView):
    """Table of a FigureModel; Ctrl+C copies it. The current row selects the chart next to it."""

    row_chosen = Signal()

    def __init__(self, name: str, model: FigureModel | None = None, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.figures = FigureModel() if model is None else model
        self.setModel(self.figures)
        self._reason = ""
        self.setAccessibleName(name)
        self.setItemDelegate(BarDelegate(self))
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.setTabKeyNavigation(False)
        self.setFont(numbers_font(self.font()))
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.horizontalHeader().setHighlightSections(False)
        self.selectionModel().currentRowChanged.connect(lambda *_: self.row_chosen.emit())

    def dataChanged(self, first: Index, last: Index, roles: Sequence[int] = ()) -> None:
        """Paint the cells that have changed; Qt paints the whole table where they are several."""
        if first == last or self.isColumnHidden(first.column()) or self.isColumnHidden(last.column()):
            super().dataChanged(first, last, roles)
        else:
            self.viewport().update(self.visualRect(first).united(self.visualRect(last)))

    def explain(self, reason: str) -> None:
        """Set what stands in the table while it has no rows: why it has none."""
        self._reason = reason
        self.viewport().update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the table, or why it is empty."""
        super().paintEvent(event)
        if self._reason and not self.figures.rowCount():
            painter, room = QPainter(self.viewport()), self.viewport().rect()
            painter.setPen(QColor(tones().muted))
            painter.drawText(room, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, self._reason)
            painter.end()

    def give_titles(self, least_px: int, row_px: int, cell_px: int) -> None:
        """Have a title for each row, which a click chooses, and columns that share the width."""
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        OwnKeys(self, {StandardKey.Copy: self.copy})
        rows, columns = self.verticalHeader(), self.horizontalHeader()
        rows.setSectionsClickable(True)
        rows.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        rows.setDefaultSectionSize(row_px)
        rows.setMinimumWidth(least_px)
        rows.setDefaultAlignment(_LEFT)
        columns.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        columns.setMinimumSectionSize(cell_px)

    @property
    def current_row(self) -> int:
        """The row that is chosen, or else the first."""
        return max(self.currentIndex().row(), 0)

    def text_of(self, name: str, title: str) -> str:
        """Return the text of a cell: of the row of that name, in the column of that title."""
        row, place = self.figures.row_titles.index(name), self.figures.column_titles.index(title)
        return self.figures.cell(row, place).text

    def as_text(self) -> str:
        """Return titles and exact values with tabs between columns; nothing while there are no figures."""
        return self.figures.as_text("class") if self.figures.rowCount() else ""

    def copy(self) -> None:
        """Copy all of the table."""
        QGuiApplication.clipboard().setText(self.as_text())


_PAD_PX, _LEAST_PAD_PX, _SMALL = 8, 2, 0.86
_BETWEEN = (" · ", ", ")
"""Between parts of a second line, the last of which are left out where there is no room."""


def fitting(text: str, wide: QFontMetrics, room_px: int) -> str:
    """Return a second line without the last parts that have no room; empty where not even its first part has it."""
    while text and wide.horizontalAdvance(text) > room_px:
        text = text[: max(0, *(text.rfind(between) for between in _BETWEEN))]
    return text


class TwoLines(QStyledItemDelegate):
    """Delegate that draws the number, and under it in small type its error and its change; cells are at least
    `least` in size."""

    def __init__(self, least: QSize, high_px: int, parent: QWidget) -> None:
        super().__init__(parent)
        self._least, self._high_px = least, high_px

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        """Draw the cell's background, then both lines, right-aligned; in a row too low for two the first alone."""
        if option.rect.height() < self._least.height():
            super().paint(painter, option, index)
            return
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
        gap_px = 3 if option.rect.height() >= self._high_px else 1
        room = QRectF(option.rect).adjusted(_LEAST_PAD_PX, gap_px, -_PAD_PX, -gap_px)
        painter.save()
        painter.setFont(told.font)
        painter.setPen(index.data(_ROLE.ForegroundRole).color())
        painter.drawText(room, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignTop, text)
        self._draw_small(painter, room, told.font, index)
        painter.restore()

    def _draw_small(self, painter: QPainter, room: QRectF, font: QFont, index: Index) -> None:
        figure, model = index.data(FIGURE), index.model()
        assert isinstance(model, FigureModel)
        small = QFont(font)
        small.setPointSizeF(font.pointSizeF() * _SMALL)
        small.setBold(False)
        painter.setFont(small)
        bottom = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignBottom
        if figure.change:
            painter.setPen(model.colour(index.column(), figure.change_tone))
            painter.drawText(room, bottom, figure.change)
            room = room.adjusted(0, 0, -painter.fontMetrics().horizontalAdvance(figure.change + "  "), 0)
        painter.setPen(QColor(tones().muted))
        painter.drawText(room, bottom, fitting(figure.error, painter.fontMetrics(), int(room.width()) + 1))

    def sizeHint(self, option: QStyleOptionViewItem, index: Index) -> QSize:
        """Return room for two lines."""
        return super().sizeHint(option, index).expandedTo(self._least)
