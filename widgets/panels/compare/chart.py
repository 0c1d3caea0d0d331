"""Rigs as bars: one small chart per figure with its own scale, with the same figures as the table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFontMetricsF, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from riglens.core.figures.figure import Estimate
from riglens.core.shown_values import NONE
from riglens.widgets.panels.compare.model import CompareModel, CompareRow, FigureColumn
from riglens.widgets.panels.controls.style import plain_tip, small_font, tones
from riglens.widgets.theme import RIG_COLOURS, Tones

WIDEST_PX, FILLED = 64.0, 0.78


@dataclass(frozen=True)
class Bar:
    """One figure as drawn: `area` reaches from zero to the figure, `column` is the chart's full height at the bar."""

    row: CompareRow
    shown: FigureColumn
    value: Estimate
    area: QRectF
    column: QRectF


@dataclass(frozen=True)
class Chart:
    """The bars of one figure; `zero_px` is the height of zero."""

    shown: FigureColumn
    area: QRectF
    zero_px: float
    bars: tuple[Bar, ...]


def side_by_side(area: QRectF, count: int, gap_px: float) -> list[QRectF]:
    """Return an area divided into charts of equal width."""
    wide = max(1.0, (area.width() - (count - 1) * gap_px) / max(1, count))
    return [
        QRectF(area.left() + place * (wide + gap_px), area.top(), wide, area.height())
        for place in range(count)
    ]


def chart_of(
    shown: FigureColumn, rows: Sequence[tuple[CompareRow, Estimate | None]], area: QRectF, words_px: float
) -> Chart:
    """Return bars for rigs with their figures, none for those without; `words_px` stay free beyond the longest ones."""
    known = [one.value for _, one in rows if one is not None]
    low, high = min([0.0, *known]), max([0.0, *known])
    inner = area.adjusted(0.0, words_px * (high > 0.0), 0.0, -words_px * (low < 0.0))
    scale = inner.height() / (high - low) if high > low else 0.0
    zero_px = inner.top() + high * scale
    step = min(area.width() / max(1, len(rows)), WIDEST_PX)
    bars = []
    for place, (row, one) in enumerate(rows):
        if one is not None:
            column = QRectF(area.left() + place * step, area.top(), step, area.height())
            end = zero_px - one.value * scale
            wide = FILLED * step
            left = column.center().x() - wide / 2
            bar = QRectF(left, min(zero_px, end), wide, max(1.0, abs(zero_px - end)))
            bars.append(Bar(row, shown, one, bar, column))
    return Chart(shown, area, zero_px, tuple(bars))


_EDGE_PX, _GAP_PX, _LINE_PX, _SWATCH_PX = 10.0, 12.0, 16.0, 9.0
_LEGEND_LINES = 2
_WAITING = "Scores follow"
_NARROWEST_PX = 100.0
"""Of a chart and the gap beside it: a short title fits; what does not fit into the panel is scrolled to."""
_ONE_LINE_PX = 150.0
"""From this width on a chart's title and its scale stand in one line."""


def _title_lines(area: QRectF) -> int:
    return 1 if area.width() >= _ONE_LINE_PX else 2


class CompareChart(QWidget):
    """Chart of the given rigs, in that order, by the columns of a model."""

    open_wanted = Signal(str)
    """Key of the rig that was double clicked."""
    chosen = Signal(str)
    """Key of the rig that was clicked."""

    def __init__(self, model: CompareModel, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMouseTracking(True)
        self.setMinimumSize(240, 80)
        self._model = model
        self._rows: tuple[CompareRow, ...] = ()
        self._selected: tuple[str, ...] = ()
        self._hover: str | None = None

    def show_rows(self, rows: Sequence[CompareRow], selected: tuple[str, ...]) -> None:
        """Show these rigs; when some are selected, the others are faint."""
        self._rows, self._selected = tuple(rows), selected
        self.setMinimumWidth(int(len(self._model.columns) * _NARROWEST_PX))
        self.update()

    # ------------------------------------------------------------------ where things are
    def charts(self) -> list[Chart]:
        """Return the charts that are drawn below the legend, from left to right."""
        columns = self._model.columns
        top = self._legend_lines() * _LINE_PX + 8.0
        room = QRectF(self.rect()).adjusted(_EDGE_PX, top, -_EDGE_PX, -_EDGE_PX)
        found = []
        for shown, place in zip(columns, side_by_side(room, len(columns), _GAP_PX), strict=True):
            known = ((row, self._model.estimate(row, shown)) for row in self._rows)
            values = [(row, one if one and one.exists else None) for row, one in known]
            area = place.adjusted(0.0, _title_lines(place) * _LINE_PX, 0.0, 0.0)
            words = _LINE_PX if self._has_room_for_numbers(area) else 0.0
            found.append(chart_of(shown, values, area, words))
        return found

    def _has_room_for_numbers(self, area: QRectF) -> bool:
        step = area.width() / max(1, len(self._rows))
        return area.height() > 4 * _LINE_PX and step > QFontMetricsF(
            small_font(self.font())
        ).horizontalAdvance("−888.88 %")

    def legend(self) -> list[tuple[QRectF, str, str]]:
        """Return the entries that fit into a few lines: place, key, name."""
        metrics = QFontMetricsF(small_font(self.font()))
        entries: list[tuple[QRectF, str, str]] = []
        x, line = _EDGE_PX, 0
        for row in self._rows:
            name = metrics.elidedText(row.title, Qt.TextElideMode.ElideMiddle, 160.0)
            wide = _SWATCH_PX + 5.0 + metrics.horizontalAdvance(name)
            if x + wide > self.width() - _EDGE_PX and x > _EDGE_PX:
                x, line = _EDGE_PX, line + 1
            if line == _LEGEND_LINES:
                break
            entries.append((QRectF(x, 4.0 + line * _LINE_PX, wide, _LINE_PX), row.key, name))
            x += wide + 16.0
        return entries

    def _legend_lines(self) -> float:
        places = [place for place, _, _ in self.legend()]
        return (places[-1].top() - 4.0) / _LINE_PX + 1.0 if places else 0.0

    def colour_of(self, key: str) -> QColor:
        """Return the colour of a rig by its place in the list, not the order shown; faint when others are selected."""
        keys = [row.key for row in self._model.rows]
        colour = QColor(RIG_COLOURS[keys.index(key) % len(RIG_COLOURS)] if key in keys else tones().muted)
        lit = (*self._selected, self._hover)
        if (self._selected or self._hover) and key not in lit:
            colour.setAlphaF(0.35)
        return colour

    # ------------------------------------------------------------------ painting
    def paintEvent(self, event: QPaintEvent) -> None:
        painter, look = QPainter(self), tones()
        painter.fillRect(self.rect(), QColor(look.field))
        painter.setFont(small_font(self.font()))
        self._draw_legend(painter, look)
        for chart in self.charts():
            self._draw_chart(painter, chart, look)
        painter.end()

    def _draw_legend(self, painter: QPainter, look: Tones) -> None:
        for place, key, name in self.legend():
            top = place.center().y() - _SWATCH_PX / 2
            painter.fillRect(QRectF(place.left(), top, _SWATCH_PX, _SWATCH_PX), self.colour_of(key))
            painter.setPen(QColor(look.text if key not in self._selected else look.accent))
            painter.drawText(
                place.adjusted(_SWATCH_PX + 5.0, 0.0, 2.0, 0.0), Qt.AlignmentFlag.AlignVCenter, name
            )

    def _draw_chart(self, painter: QPainter, chart: Chart, look: Tones) -> None:
        area = chart.area
        self._draw_title(painter, chart, look)
        for bar in chart.bars:
            painter.fillRect(bar.area, self.colour_of(bar.row.key))
        if self._has_room_for_numbers(area):
            painter.setPen(QColor(look.text))
            for bar in chart.bars:
                self._draw_number(painter, bar)
        painter.setPen(QPen(QColor(look.muted), 1.0))
        painter.drawLine(QPointF(area.left(), chart.zero_px), QPointF(area.right(), chart.zero_px))
        if not chart.bars and self._rows:
            known = [self._model.estimate(row, chart.shown) for row in self._rows]
            painter.drawText(area, Qt.AlignmentFlag.AlignCenter, _WAITING if None in known else NONE)

    def _draw_title(self, painter: QPainter, chart: Chart, look: Tones) -> None:
        """Draw the title on the left and the number of the longest bar, which gives the scale, on the right, or below
        the title where both would not fit."""
        area = chart.area
        line = QRectF(area.left(), area.top() - _LINE_PX - 2.0, area.width(), _LINE_PX)
        longest = max(chart.bars, key=lambda bar: abs(bar.value.value), default=None)
        scale = self._model.text(chart.shown, longest.value) if longest is not None else ""
        painter.setPen(QColor(look.muted))
        painter.drawText(line, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter, scale)
        if _title_lines(area) > 1:
            line.translate(0.0, -_LINE_PX)
        else:
            line.setWidth(area.width() - painter.fontMetrics().horizontalAdvance(scale) - 6.0)
        title = chart.shown.title if line.width() > 100.0 else chart.shown.short
        title = painter.fontMetrics().elidedText(title, Qt.TextElideMode.ElideRight, int(line.width()))
        painter.setPen(QColor(look.text))
        painter.drawText(line, Qt.AlignmentFlag.AlignVCenter, title)

    def _draw_number(self, painter: QPainter, bar: Bar) -> None:
        """Draw the figure at the end of its bar."""
        box = QRectF(bar.column.left(), bar.area.bottom(), bar.column.width(), _LINE_PX)
        if bar.value.value >= 0.0:
            box.moveBottom(bar.area.top())
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, self._model.text(bar.shown, bar.value))

    # ------------------------------------------------------------------ mouse
    def bar_at(self, at: QPointF) -> Bar | None:
        """Return the bar above, on or below which a place is."""
        found = (bar for chart in self.charts() for bar in chart.bars if bar.column.contains(at))
        return next(found, None)

    def _key_at(self, at: QPointF) -> str | None:
        """Return the rig whose bar or name is at a place."""
        bar = self.bar_at(at)
        named = next((key for place, key, _ in self.legend() if place.contains(at)), None)
        return bar.row.key if bar is not None else named

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        at = event.position()
        bar, key = self.bar_at(at), self._key_at(at)
        tip = ""
        if bar is not None:
            tip = f"{bar.row.title}: {bar.shown.title} {self._model.text(bar.shown, bar.value)}"
        self.setToolTip(plain_tip(tip) if tip else "")
        if key != self._hover:
            self._hover = key
            self.update()

    def leaveEvent(self, event: QEvent) -> None:
        self._hover = None
        self.update()

    def mousePressEvent(self, event: QMouseEvent) -> None:
        key = self._key_at(event.position())
        if key is not None and event.button() == Qt.MouseButton.LeftButton:
            self.chosen.emit(key)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        key = self._key_at(event.position())
        if key is not None:
            self.open_wanted.emit(key)

    def sizeHint(self) -> QSize:
        return QSize(640, 180)
