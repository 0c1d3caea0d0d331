"""Chart of detection ranges: distance by direction, seen from above, with the stopping distances ahead."""

from __future__ import annotations

import math

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QPainter, QPainterPath, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from riglens.core.sensors.registry import AnyKind, kinds
from riglens.core.targets.detection_range import DetectionRange, RangeRow
from riglens.widgets.panels.controls.style import tones
from riglens.widgets.panels.detection_range.table import Line, rows_of
from riglens.widgets.sensors.appearance import colour_of

WIDTH_PX, LEAST_PX, MARGIN_PX = 214, 96, 6
RINGS_M = (10.0, 20.0, 50.0, 100.0, 200.0, 500.0)
"""Distances between rings; the first with which there are five at most."""
STOP_ARC_DEG = 20.0
_SMALL = 0.8
_BEYOND = 1.08
"""The edge of the chart is so much farther out than the farthest distance that there is."""


def ring_step_m(edge_m: float) -> float:
    """Return the distance between the rings of a chart that reaches so far."""
    return next((step for step in RINGS_M if edge_m / step <= 5.0), RINGS_M[-1])


def edge_m(ranges: DetectionRange) -> float:
    """Return the edge of the charts, the same for all classes."""
    reaches = [reach.most_m for row in ranges.rows for reach in row.reaches.values()]
    return min(_BEYOND * max(reaches, default=0.0), ranges.plan.to_m) or ranges.plan.to_m


class RangeChart(QWidget):
    """Chart of one class turned one way: for each kind of sensor a line, and a band where luck decides; ahead is up."""

    def __init__(self) -> None:
        super().__init__()
        self._ranges: DetectionRange | None = None
        self._edge_m = 1.0
        self._rows: list[RangeRow] = []
        self._is_stale = False
        self.setMinimumHeight(LEAST_PX)
        self.setFixedWidth(WIDTH_PX)
        self.setAccessibleName("Detection range by direction")

    def show_line(self, ranges: DetectionRange, line: Line) -> None:
        """Show the class and heading of a line, all kinds of sensors."""
        self._ranges, self._rows, self._is_stale = ranges, rows_of(ranges, line), False
        self._edge_m = edge_m(ranges)
        self.update()

    def grey(self) -> None:
        """Show that the figures are out of date."""
        self._is_stale = True
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw rings, each kind of sensor, and the ways to stop in."""
        if self._ranges is None:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self._draw_rings(painter)
        for line in self._kinds:
            self._draw_kind(painter, line)
        self._draw_stops(painter)
        self._draw_words(painter)

    # ------------------------------------------------------------------ where things are
    def _centre(self) -> QPointF:
        return QPointF(self.width() / 2.0, self.height() / 2.0)

    def _radius(self, distance_m: float) -> float:
        room = min(self.width(), self.height()) / 2.0 - MARGIN_PX
        return room * min(distance_m / self._edge_m, 1.0)

    def _at(self, bearing_deg: float, distance_m: float) -> QPointF:
        turn, radius = math.radians(bearing_deg), self._radius(distance_m)
        return self._centre() + QPointF(-math.sin(turn) * radius, -math.cos(turn) * radius)

    def _outline(self, kind: AnyKind, edge: str) -> QPolygonF:
        ordered = sorted(self._rows, key=lambda row: row.bearing_deg % 360.0)
        return QPolygonF(
            [self._at(row.bearing_deg, getattr(row.reaches[kind.name], edge)) for row in ordered]
        )

    @property
    def _kinds(self) -> list[AnyKind]:
        """The kinds of sensors that have ranges."""
        return [kind for kind in kinds() if all(kind.name in row.reaches for row in self._rows)]

    def _colour(self, kind: AnyKind) -> QColor:
        return QColor(tones().muted if self._is_stale else colour_of(kind.name))

    # ------------------------------------------------------------------ what is drawn
    def _draw_rings(self, painter: QPainter) -> None:
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(QColor(tones().border), 1.0))
        step_m = ring_step_m(self._edge_m)
        for number in range(1, math.floor(self._edge_m / step_m) + 1):
            radius = self._radius(number * step_m)
            painter.drawEllipse(self._centre(), radius, radius)
        for row in self._rows:
            painter.drawLine(self._centre(), self._at(row.bearing_deg, self._edge_m))

    def _draw_kind(self, painter: QPainter, kind: AnyKind) -> None:
        reaches = [row.reaches[kind.name] for row in self._rows]
        if not any(reach.most_m for reach in reaches):
            return
        if any(reach.least_m < reach.most_m for reach in reaches):
            band = QPainterPath()
            for edge in ("most_m", "least_m"):
                band.addPolygon(self._outline(kind, edge))
                band.closeSubpath()
            fill = self._colour(kind)
            fill.setAlphaF(0.22)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(fill)
            painter.drawPath(band)
        if any(reach.median_m for reach in reaches):
            painter.setPen(QPen(self._colour(kind), 1.8))
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.drawPolygon(self._outline(kind, "median_m"))

    def _draw_stops(self, painter: QPainter) -> None:
        """Draw arcs ahead at the distances at which the car can just stop for an object, by speed."""
        assert self._ranges is not None
        plan, gap_m, room_px = self._ranges.plan, self._rows[0].gap_m, math.inf
        painter.setFont(self._small_font())
        painter.setPen(QPen(QColor(tones().text), 1.3))
        for speed in sorted(plan.speeds_kmh, reverse=True):
            distance_m = plan.stopping_m(speed) - gap_m
            if distance_m > self._edge_m:
                continue
            radius = self._radius(distance_m)
            room = QRectF(0.0, 0.0, 2.0 * radius, 2.0 * radius)
            room.moveCenter(self._centre())
            painter.drawArc(room, round(16.0 * (90.0 - STOP_ARC_DEG / 2.0)), round(16.0 * STOP_ARC_DEG))
            beside = self._at(-STOP_ARC_DEG / 2.0, distance_m) + QPointF(3.0, 4.0)
            if room_px - radius >= painter.fontMetrics().ascent():  # never one number on another
                painter.drawText(beside, f"{speed:g}")
                room_px = radius

    def _draw_words(self, painter: QPainter) -> None:
        """Name the kinds by their colours, and the distance of the rings."""
        painter.setFont(self._small_font())
        room = QRectF(self.rect()).adjusted(4.0, 2.0, -4.0, -2.0)
        up, down = Qt.AlignmentFlag.AlignTop, Qt.AlignmentFlag.AlignBottom
        left, right = Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignRight
        painter.setPen(QColor(tones().muted))
        painter.drawText(room, down | right, f"rings\n{ring_step_m(self._edge_m):g} m")
        painter.drawText(room, up | right, "stops\nfrom\nkm/h")
        for number, kind in enumerate(self._kinds):
            raised = max(0, number - 1) * painter.fontMetrics().lineSpacing()
            painter.setPen(self._colour(kind))
            painter.drawText(room.translated(0.0, -raised), (down if number else up) | left, kind.plural)

    def _small_font(self) -> QFont:
        font = QFont(self.font())
        font.setPointSizeF(font.pointSizeF() * _SMALL)
        return font
