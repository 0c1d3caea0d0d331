"""The rose: a figure by sector and ring around the car, seen from above, with the front upwards."""

from __future__ import annotations

import math
from collections.abc import Sequence

from PySide6.QtCore import QEvent, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QHelpEvent, QPainter, QPainterPath, QPaintEvent, QPen
from PySide6.QtWidgets import QToolTip, QWidget

from riglens.core.figures.figure import ALL, Estimate
from riglens.core.figures.text import tip_text
from riglens.core.figures.values import FigureCells
from riglens.core.scene.sectors import SECTORS, sector_of
from riglens.widgets.panels.controls.style import plain_tip, tones
from riglens.widgets.panels.targets.table import TITLES

SIDE_PX, LEAST_PX, MARGIN_PX = 212, 120, 16
_CAR = (0.5, 0.22)
"""Length and width of the car in the middle, as parts of the first ring."""


class RoseView(QWidget):
    """Chart of a figure of one row: the stronger the colour, the larger the figure; empty without objects."""

    def __init__(self) -> None:
        super().__init__()
        self._shown: FigureCells | None = None
        self._who, self._edges_m = ALL, tuple[float, ...]()
        self._baseline = ""
        self._is_stale = False
        self.setMinimumHeight(LEAST_PX)
        self.setFixedWidth(SIDE_PX)
        self.setAccessibleName("Targets by sector and ring")

    def show_figure(self, cells: FigureCells, who: str, edges_m: Sequence[float], baseline: str) -> None:
        """Show a figure of a row by ring and sector, and in tooltips what it changes against."""
        self._shown, self._who, self._edges_m = cells, who, tuple(edges_m)
        self._baseline, self._is_stale = baseline, False
        self.update()

    def _at(self, ring: int, sector: int) -> tuple[Estimate, Estimate]:
        """Return the figure of a wedge, and its change."""
        assert self._shown is not None
        return self._shown.at(self._who, ring * len(SECTORS) + sector)

    @property
    def _wedges(self) -> list[tuple[int, int]]:
        rings, sectors = range(len(self._edges_m) - 1), range(len(SECTORS))
        return [(ring, sector) for ring in rings for sector in sectors]

    def forget(self) -> None:
        """Show nothing: no figure is known."""
        self._shown = None
        self.update()

    def grey(self) -> None:
        """Show that the numbers are out of date."""
        self._is_stale = True
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw wedges from the middle outwards, the car, and the distances of the rings."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self._shown is None:
            return
        found = {wedge: self._at(*wedge)[0] for wedge in self._wedges}
        largest = max((one.value for one in found.values() if one.exists), default=1.0) or 1.0
        for wedge, value in found.items():
            self._draw_wedge(painter, wedge, value, largest)
        self._draw_car(painter)
        self._draw_distances(painter)

    def _draw_wedge(self, painter: QPainter, wedge: tuple[int, int], value: Estimate, largest: float) -> None:
        painter.setPen(QPen(QColor(tones().border), 1.0))
        if not value.exists:
            painter.setBrush(Qt.BrushStyle.NoBrush)
        else:
            colour = QColor(tones().muted if self._is_stale else tones().accent)
            colour.setAlphaF(0.06 + 0.84 * self._strength(value.value, largest))
            painter.setBrush(colour)
        painter.drawPath(self._wedge(*wedge))

    def _strength(self, value: float, largest: float) -> float:
        """Return the strength of a value's colour, 0 to 1: shares as they are, points and pixels by their logarithm."""
        assert self._shown is not None
        if self._shown.figure.unit == "share":
            return min(1.0, max(0.0, value))
        return math.log1p(value) / math.log1p(largest)

    def _wedge(self, ring: int, sector: int) -> QPainterPath:
        """Return the outline of a wedge; Qt counts degrees from the right, to the left."""
        inner, outer = self._radius(ring), self._radius(ring + 1)
        start, step = 90.0 + (sector - 0.5) * 360.0 / len(SECTORS), 360.0 / len(SECTORS)
        centre, path = QPointF(self._centre()), QPainterPath()
        path.arcMoveTo(_square(centre, outer), start)
        path.arcTo(_square(centre, outer), start, step)
        if inner > 0.0:
            path.arcTo(_square(centre, inner), start + step, -step)
        else:
            path.lineTo(centre)
        path.closeSubpath()
        return path

    def _draw_car(self, painter: QPainter) -> None:
        length, width = (part * self._radius(1) * 1.5 for part in _CAR)
        body = QRectF(0.0, 0.0, width * 1.6, length)
        body.moveCenter(QPointF(self._centre()))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(tones().text))
        painter.drawRoundedRect(body, 2.0, 2.0)

    def _draw_distances(self, painter: QPainter) -> None:
        """Name the outermost ring and the middle one, next to the sector on the right."""
        font = painter.font()
        font.setPointSizeF(font.pointSizeF() * 0.8)
        painter.setFont(font)
        painter.setPen(QColor(tones().muted))
        edges, rings = self._edges_m, len(self._edges_m) - 1
        centre, radius = self._centre(), self._radius(rings)
        room = QRectF(
            centre.x() + 0.55 * radius, centre.y() + 0.86 * radius, 0.5 * radius + MARGIN_PX, MARGIN_PX
        )
        painter.drawText(room, Qt.AlignmentFlag.AlignRight, f"{edges[-1]:g} m")
        front = QRectF(centre.x() - radius, centre.y() - radius - MARGIN_PX, 2 * radius, MARGIN_PX)
        painter.drawText(front, Qt.AlignmentFlag.AlignCenter, "front")

    def event(self, event: QEvent) -> bool:
        """Show the content of a wedge in a tooltip."""
        if isinstance(event, QHelpEvent):
            text = self.text_at(QPointF(event.pos()))
            QToolTip.showText(event.globalPos(), plain_tip(text), self)
            return True
        return bool(super().event(event))

    def text_at(self, place: QPointF) -> str:
        """Describe the wedge at a place of the widget, empty where there is none."""
        if self._shown is None:
            return ""
        away, edges = place - self._centre(), self._edges_m
        distance = math.hypot(away.x(), away.y())
        ring = next((ring for ring in range(len(edges) - 1) if distance < self._radius(ring + 1)), None)
        if ring is None:
            return ""
        sector = int(sector_of(-away.y(), -away.x()))
        where = f"{TITLES[self._who]}, {SECTORS[sector]}, {edges[ring]:g}–{edges[ring + 1]:g} m"
        value, change = self._at(ring, sector)
        return tip_text(self._shown.figure, where, value, change, self._baseline)

    def _centre(self) -> QPointF:
        return QPointF(self.width() / 2.0, self.height() / 2.0 + 2.0)

    def _radius(self, edge: int) -> float:
        """Return the radius of an edge between rings, in proportion to its distance."""
        room = min(self.width(), self.height()) / 2.0 - MARGIN_PX
        return room * self._edges_m[edge] / self._edges_m[-1]


def _square(centre: QPointF, radius: float) -> QRectF:
    return QRectF(centre.x() - radius, centre.y() - radius, 2.0 * radius, 2.0 * radius)
