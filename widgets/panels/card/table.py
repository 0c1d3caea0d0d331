"""The table of a card: a row per class, heading and kind of sensor, a column per direction."""

from __future__ import annotations

import math
from typing import NamedTuple

from PySide6.QtCore import Qt
from PySide6.QtGui import QBrush, QColor
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableWidget, QTableWidgetItem

from riglens.core.sensors.registry import AnyKind, kinds
from riglens.core.targets.card import Card, CardRow, Reach
from riglens.core.targets.card_text import HEADINGS, bearing_text, reach_text, stop_text
from riglens.widgets.panels.controls.icons import swatch
from riglens.widgets.panels.controls.style import numbers_font, plain_tip, tones
from riglens.widgets.theme import CLASS_COLOURS

STOPS = "Stops from"
STOPS_TIP = (
    "Speed from which the car stops before a road user straight ahead that it notices at the least distance: the "
    "way is that distance less half the length of the car and of the road user."
)
ROW_PX, TITLE_PX, PAD_PX = 22, 160, 12
WIDEST = "888-888-888"
"""The longest text of a cell: no column of distances is narrower."""


class Line(NamedTuple):
    """A row of the table: a class turned one way, by one kind of sensor."""

    cls: str
    heading_deg: float
    kind: AnyKind

    def reach(self, row: CardRow) -> Reach:
        """Return the reach of its kind of sensor in one direction."""
        return row.reaches[self.kind.name]


def lines_of(card: Card) -> tuple[Line, ...]:
    """Return the rows of a card's table: per class and heading one of each kind of sensor."""
    turned = dict.fromkeys((row.cls, row.heading_deg) for row in card.rows)
    shown = [kind for kind in kinds() if any(kind.name in row.reaches for row in card.rows)]
    return tuple(Line(cls, heading, kind) for cls, heading in turned for kind in shown)


def rows_of(card: Card, line: Line) -> list[CardRow]:
    """Return what a card says of one line, direction by direction."""
    return [row for row in card.rows if (row.cls, row.heading_deg) == (line.cls, line.heading_deg)]


def line_title(card: Card, line: Line) -> str:
    """Return the name of a row; the heading is left out where a class has only one."""
    headings = {row.heading_deg for row in card.rows if row.cls == line.cls}
    turned = f" {HEADINGS[line.heading_deg]}" if len(headings) > 1 else ""
    return f"{line.cls.capitalize()}{turned}, {line.kind.plural}"


def tip_of(card: Card, line: Line, row: CardRow) -> str:
    """Describe one cell in full."""
    reach, plan = line.reach(row), card.plan
    what = f"{plan.enough(line.kind):g} {line.kind.hits.label}"
    where = f"{line_title(card, line)}, {bearing_text(row.bearing_deg)}"
    if reach.most_m == 0.0:
        return f"{where}\nnever {what}, at no distance up to {plan.to_m:g} m"
    lines = [where, f"at least {what} from {reach.from_m:g} m on, fewer than that first at:"]
    if reach.least_m == reach.most_m:
        return "\n".join([*lines, _metres(reach.median_m, plan.to_m)])
    places = ("unluckiest", reach.least_m), ("middle", reach.median_m), ("luckiest", reach.most_m)
    lines += [
        f"{_metres(distance, plan.to_m)} at the {place} place between the beams" for place, distance in places
    ]
    return "\n".join(lines)


def _metres(distance_m: float, to_m: float) -> str:
    return f"beyond {to_m:g} m" if math.isinf(distance_m) else f"{distance_m:g} m"


class CardTable(QTableWidget):
    """Shows one card; the current row says which chart is wanted."""

    def __init__(self) -> None:
        super().__init__(0, 0)
        self._lines: tuple[Line, ...] = ()
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.setTabKeyNavigation(False)
        self.setFont(numbers_font(self.font()))
        self.setHorizontalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
        self.setAccessibleName("Card: first distance with too little, in metres")
        rows, columns = self.verticalHeader(), self.horizontalHeader()
        rows.setSectionsClickable(True)
        rows.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        rows.setDefaultSectionSize(ROW_PX)
        rows.setMinimumWidth(TITLE_PX)
        rows.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        columns.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        columns.setMinimumSectionSize(self.fontMetrics().horizontalAdvance(WIDEST) + PAD_PX)
        columns.setDefaultAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)

    @property
    def line(self) -> Line | None:
        """The line whose chart is wanted: the chosen one, or the first."""
        return self._lines[max(self.currentRow(), 0)] if self._lines else None

    def show_card(self, card: Card) -> None:
        """Show what a card says."""
        bearings = [bearing_text(bearing) for bearing in card.plan.bearings_deg]
        self._lay_out(card, [*bearings, STOPS])
        for number, line in enumerate(self._lines):
            rows = rows_of(card, line)
            stops = [card.stops_from_kmh(row, line.reach(row)) for row in rows]
            ahead = next((stop for stop in stops if stop is not None), None)
            for column, row in enumerate(rows):
                self._show(
                    number,
                    column,
                    reach_text(line.reach(row), card.plan.to_m),
                    tip_of(card, line, row),
                )
            self._show(number, len(rows), stop_text(ahead), STOPS_TIP)

    def _lay_out(self, card: Card, titles: list[str]) -> None:
        lines = lines_of(card)
        if (len(lines), len(titles)) != (self.rowCount(), self.columnCount()):
            self.setRowCount(len(lines))
            self.setColumnCount(len(titles))
            for row in range(len(lines)):
                for column in range(len(titles)):
                    item = QTableWidgetItem()
                    item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
                    self.setItem(row, column, item)
        self._lines = lines
        self.setHorizontalHeaderLabels(titles)
        to_fit = QHeaderView.ResizeMode.ResizeToContents
        self.horizontalHeader().setSectionResizeMode(len(titles) - 1, to_fit)
        for row, line in enumerate(lines):
            title = QTableWidgetItem(line_title(card, line))
            title.setIcon(swatch(CLASS_COLOURS[line.cls]))
            self.setVerticalHeaderItem(row, title)

    def _show(self, row: int, column: int, text: str, tip: str) -> None:
        item = self.item(row, column)
        assert item is not None
        item.setText(text)
        item.setToolTip(plain_tip(tip))
        item.setForeground(QBrush(QColor(tones().muted if text == "never" else tones().text)))

    def grey(self) -> None:
        """Show that the figures are out of date."""
        muted = QBrush(QColor(tones().muted))
        for row in range(self.rowCount()):
            for column in range(self.columnCount()):
                item = self.item(row, column)
                assert item is not None
                item.setForeground(muted)

    def text_of(self, title: str, column: str) -> str:
        """Return what a cell shows: of the row of that name, in the column of that title."""
        rows = [self._text(self.verticalHeaderItem(row)) for row in range(self.rowCount())]
        columns = [self._text(self.horizontalHeaderItem(number)) for number in range(self.columnCount())]
        return self._text(self.item(rows.index(title), columns.index(column)))

    @staticmethod
    def _text(item: QTableWidgetItem | None) -> str:
        return "" if item is None else item.text()
