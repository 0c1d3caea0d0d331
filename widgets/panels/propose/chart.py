"""Small charts side by side: lines, and dots that stand for rigs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from riglens.widgets.heatmap.scale import number_text, tick_values
from riglens.widgets.panels.compare.chart import side_by_side
from riglens.widgets.panels.controls.style import plain_tip, small_font, tones

_EDGE_PX, _GAP_PX, _LINE_PX, _DOT_PX, _NEAR_PX = 8.0, 22.0, 15.0, 4.5, 10.0
_TICK_PX, _BETWEEN_PX, _PAD = 42.0, 8.0, 0.08
PlotTone = Literal["accent", "muted", "less"]


@dataclass(frozen=True)
class Dot:
    """A point with its tooltip; `key` names the rig that it stands for."""

    x: float
    y: float
    tip: str
    key: str = ""


@dataclass(frozen=True)
class Line:
    """Points in order, joined by straight lines."""

    points: tuple[tuple[float, float], ...]
    tone: PlotTone = "accent"


@dataclass(frozen=True)
class Plot:
    """One chart; where it has neither lines nor dots it says why."""

    title: str
    x_title: str
    lines: tuple[Line, ...] = ()
    dots: tuple[Dot, ...] = ()
    empty: str = ""

    @property
    def points(self) -> list[tuple[float, float]]:
        """All points."""
        return [
            *((dot.x, dot.y) for dot in self.dots),
            *(point for line in self.lines for point in line.points),
        ]


@dataclass(frozen=True)
class _Frame:
    """Place of a chart in the widget, and the ranges of its axes."""

    area: QRectF
    x: tuple[float, float]
    y: tuple[float, float]

    def at(self, x: float, y: float) -> QPointF:
        (x0, x1), (y0, y1) = self.x, self.y
        across, up = (x - x0) / (x1 - x0), (y - y0) / (y1 - y0)
        return QPointF(
            self.area.left() + across * self.area.width(), self.area.bottom() - up * self.area.height()
        )


def _range(values: Sequence[float]) -> tuple[float, float]:
    """Return an axis that holds all values, with a margin."""
    low, high = min(values), max(values)
    pad = _PAD * (high - low) or 0.1 * max(abs(high), 1e-3)
    return low - pad, high + pad


def apart(ticks: list[float], of: tuple[float, float], length_px: float, least_px: float) -> list[float]:
    """Return every tick of an axis, or every second or third, so that they are some pixels apart."""
    if len(ticks) < 2:
        return ticks
    between_px = (ticks[1] - ticks[0]) / (of[1] - of[0]) * max(1.0, length_px)
    return ticks[:: math.ceil(least_px / between_px)]


class Plots(QWidget):
    """Row of charts of equal width."""

    hovered = Signal(str)
    """Key of the rig under the mouse, empty for none."""
    chosen = Signal(str)
    """Key of the rig whose dot was clicked."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMouseTracking(True)
        self.setMinimumSize(180, 96)
        self.setAccessibleName("Charts of proposed rigs")
        self.plots: tuple[Plot, ...] = ()
        self.key = ""
        """Key of the rig that is highlighted."""

    def show_plots(self, plots: Sequence[Plot]) -> None:
        """Show these charts."""
        self.plots = tuple(plots)
        self.update()

    def highlight(self, key: str) -> None:
        """Highlight the dots of a rig, or of none."""
        if key != self.key:
            self.key = key
            self.update()

    # ------------------------------------------------------------------ where things are
    def _frames(self) -> list[tuple[Plot, _Frame | None, QRectF]]:
        """Return each chart with its axes, None while it is empty, and its whole place."""
        room = QRectF(self.rect()).adjusted(_EDGE_PX, _EDGE_PX / 2, -_EDGE_PX, -_EDGE_PX / 2)
        found = []
        for plot, place in zip(self.plots, side_by_side(room, len(self.plots), _GAP_PX), strict=True):
            area = place.adjusted(_TICK_PX, _LINE_PX + 6.0, -4.0, -2.0 * _LINE_PX)
            points = [point for point in plot.points if all(map(math.isfinite, point))]
            frame = None
            if points and area.height() > 0.0:
                across, up = zip(*points, strict=True)
                frame = _Frame(area, _range(across), _range(up))
            found.append((plot, frame, place))
        return found

    def place_of(self, plot: int, dot: int) -> QPointF:
        """Return where a dot is drawn."""
        shown, frame, _ = self._frames()[plot]
        assert frame is not None
        return frame.at(shown.dots[dot].x, shown.dots[dot].y)

    def dot_at(self, at: QPointF) -> Dot | None:
        """Return the nearest dot under the mouse."""
        near = [
            (math.hypot(*(frame.at(dot.x, dot.y) - at).toTuple()), dot)
            for plot, frame, _ in self._frames()
            if frame is not None
            for dot in plot.dots
        ]
        distance, dot = min(near, key=lambda pair: pair[0], default=(math.inf, None))
        return dot if distance <= _NEAR_PX else None

    # ------------------------------------------------------------------ painting
    def paintEvent(self, event: QPaintEvent) -> None:
        painter, look = QPainter(self), tones()
        painter.fillRect(self.rect(), QColor(look.field))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(small_font(self.font()))
        for plot, frame, place in self._frames():
            painter.setPen(QColor(look.text))
            title = painter.fontMetrics().elidedText(
                plot.title, Qt.TextElideMode.ElideRight, int(place.width())
            )
            painter.drawText(QRectF(place.topLeft(), place.size()), Qt.AlignmentFlag.AlignTop, title)
            painter.setPen(QColor(look.muted))
            if frame is None:
                flags = Qt.AlignmentFlag.AlignCenter.value | Qt.TextFlag.TextWordWrap.value
                painter.drawText(place, flags, plot.empty)
                continue
            bottom = Qt.AlignmentFlag.AlignBottom | Qt.AlignmentFlag.AlignHCenter
            painter.drawText(place.adjusted(_TICK_PX, 0.0, 0.0, 0.0), bottom, plot.x_title)
            self._draw_ticks(painter, frame)
            for line in plot.lines:
                self._draw_line(painter, frame, line)
            for dot in plot.dots:
                self._draw_dot(painter, frame.at(dot.x, dot.y), dot)
        painter.end()

    def _draw_ticks(self, painter: QPainter, frame: _Frame) -> None:
        """Draw a labelled line for each round value, as many as fit without their numbers touching."""
        look, area, metrics = tones(), frame.area, painter.fontMetrics()
        for value in apart(tick_values(*frame.y, log=False), frame.y, area.height(), _LINE_PX):
            y = frame.at(frame.x[0], value).y()
            painter.setPen(QPen(QColor(look.border), 1.0))
            painter.drawLine(QPointF(area.left(), y), QPointF(area.right(), y))
            painter.setPen(QColor(look.muted))
            room = QRectF(area.left() - _TICK_PX, y - _LINE_PX / 2, _TICK_PX - 5.0, _LINE_PX)
            right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
            painter.drawText(room, right, number_text(value))
        ticks = tick_values(*frame.x, log=False)
        widest = max((metrics.horizontalAdvance(number_text(value)) for value in ticks), default=0)
        for value in apart(ticks, frame.x, area.width(), widest + _BETWEEN_PX):
            x = frame.at(value, frame.y[0]).x()
            room = QRectF(x - _TICK_PX / 2, area.bottom() + 2.0, _TICK_PX, _LINE_PX)
            painter.drawText(room, Qt.AlignmentFlag.AlignCenter, number_text(value))

    def _draw_line(self, painter: QPainter, frame: _Frame, line: Line) -> None:
        places = [frame.at(x, y) for x, y in line.points]
        painter.setPen(QPen(QColor(getattr(tones(), line.tone)), 1.6))
        painter.drawPolyline(QPolygonF(places))

    def _draw_dot(self, painter: QPainter, at: QPointF, dot: Dot) -> None:
        look, is_lit = tones(), bool(dot.key) and dot.key == self.key
        painter.setPen(QPen(QColor(look.field), 1.2))
        painter.setBrush(QColor(look.accent if dot.key else look.muted))
        radius = _DOT_PX * (1.5 if is_lit else 1.0)
        painter.drawEllipse(at, radius, radius)

    # ------------------------------------------------------------------ mouse
    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        dot = self.dot_at(event.position())
        self.setToolTip("" if dot is None else plain_tip(dot.tip))
        self._hover("" if dot is None else dot.key)

    def leaveEvent(self, event: QEvent) -> None:
        self._hover("")

    def _hover(self, key: str) -> None:
        if key != self.key:
            self.highlight(key)
            self.hovered.emit(key)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        dot = self.dot_at(event.position())
        if dot is not None and dot.key and event.button() == Qt.MouseButton.LeftButton:
            self.chosen.emit(dot.key)

    def sizeHint(self) -> QSize:
        return QSize(520, 170)
