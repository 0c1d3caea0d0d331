"""The curve of one field as a small chart beside it; a click on a point sets the value."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from PySide6.QtCore import QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QWidget

from riglens.core.scene.boxes import CLASSES
from riglens.widgets.panels.controls.building import room_around
from riglens.widgets.panels.controls.style import tones
from riglens.widgets.panels.fields.quantity import Unit, short_text
from riglens.widgets.theme import CLASS_COLOURS

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.sweep.curve import CurvePoint

SIZE_PX = (380, 230)
_LEFT, _TOP, _RIGHT, _BOTTOM = 40.0, 54.0, 12.0, 22.0
_LEAST = 1e-4
"""Least change that the chart shows in full height."""


class FieldCurve(QWidget):
    """A popup: change of a figure by class over the values of a field, with a band of its noise."""

    chosen = Signal(float)
    """The value of the point that was clicked."""
    closed = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent, Qt.WindowType.Popup)
        self.setFixedSize(*SIZE_PX)
        self.setMouseTracking(True)
        self.setAccessibleName("Sweep of the field")
        self._points: Sequence[CurvePoint] = ()
        self._title, self._note, self._now, self._unit = "", "", 0.0, Unit("", "")
        self._at: int | None = None

    def open_at(self, place: QWidget, title: str, now: float, unit: Unit) -> None:
        """Open under a field with this value, still without a curve."""
        self._points, self._title, self._now, self._unit, self._at = (), title, now, unit, None
        self._note = "computing"
        room, corner = room_around(place), place.mapToGlobal(place.rect().bottomLeft())
        self.move(
            max(room.left(), min(corner.x(), room.right() - self.width())),
            min(corner.y() + 2, room.bottom() - self.height()),
        )
        self.show()

    def show_points(self, points: Sequence[CurvePoint], note: str) -> None:
        """Show the points that are known, and a note under the title."""
        self._points, self._note = points, note
        self.update()

    @property
    def note(self) -> str:
        """Return the line under the title: the point under the mouse, or the note."""
        if self._at is None or self._at >= len(self._points):
            return self._note
        value, changes = self._points[self._at]
        said = ", ".join(f"{name} {_signed(changes[name][0])}" for name in CLASSES)
        return f"{self._value_text(value)}: {said} pp"

    def place_of(self, index: int) -> QPointF:
        """Return where a point of the first class is drawn."""
        value, changes = self._points[index]
        return QPointF(self._x(value), self._y(changes[CLASSES[0]][0]))

    # ------------------------------------------------------------------ Qt events
    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Mark the point nearest to the mouse."""
        distances = [abs(self._x(point.value) - event.position().x()) for point in self._points]
        self._at = distances.index(min(distances)) if distances else None
        self.update()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Choose the point nearest to the mouse; outside of the chart, close it."""
        if self.rect().contains(event.position().toPoint()):
            self.mouseMoveEvent(event)
            self._choose()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Move along the curve by arrows, choose by Enter, close by Escape."""
        step = {Qt.Key.Key_Left: -1, Qt.Key.Key_Right: 1}.get(Qt.Key(event.key()))
        if step is not None and self._points:
            start = self._nearest(self._now) if self._at is None else self._at
            self._at = min(max(start + step, 0), len(self._points) - 1)
            self.update()
        elif event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self._choose()
        elif event.key() == Qt.Key.Key_Escape:
            self.hide()

    def hideEvent(self, event: object) -> None:
        """Report that the curve is no longer needed."""
        self.closed.emit()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), self.palette().base())
        painter.setPen(QColor(tones().border))
        painter.drawRect(self.rect().adjusted(0, 0, -1, -1))
        painter.setPen(QColor(tones().text))
        painter.drawText(QRectF(8.0, 4.0, self.width() - 16.0, 18.0), self._title)
        right = self.width() - 8.0
        for name in reversed(CLASSES):
            painter.setPen(QColor(CLASS_COLOURS[name]))
            right -= painter.fontMetrics().horizontalAdvance(name) + 8.0
            painter.drawText(QPointF(right, 4.0 + painter.fontMetrics().ascent()), name)
        painter.setPen(QColor(tones().muted))
        painter.drawText(QRectF(8.0, 22.0, self.width() - 16.0, 18.0), self.note)
        if len(self._points) > 1:
            self._draw_axes(painter)
            for name in CLASSES:
                self._draw_class(painter, name)

    # ------------------------------------------------------------------ drawing
    def _choose(self) -> None:
        if self._at is not None and self._at < len(self._points):
            value = self._points[self._at].value
            self.hide()
            self.chosen.emit(value)

    def _nearest(self, value: float) -> int:
        return min(range(len(self._points)), key=lambda index: abs(self._points[index].value - value))

    def _bounds(self) -> tuple[float, float]:
        edges = [
            c + sign * noise
            for point in self._points
            for c, noise in point.changes.values()
            for sign in (-1, 1)
        ]
        return min(edges, default=-_LEAST), max(edges, default=_LEAST)

    def _x(self, value: float) -> float:
        low, high = self._points[0].value, self._points[-1].value
        room = self.width() - _LEFT - _RIGHT
        return _LEFT + room * (value - low) / ((high - low) or 1.0)

    def _y(self, change: float) -> float:
        low, high = self._bounds()
        room = self.height() - _TOP - _BOTTOM
        return _TOP + room * (high - change) / max(high - low, _LEAST)

    def _draw_axes(self, painter: QPainter) -> None:
        (low, high), right = self._bounds(), self.width() - _RIGHT
        painter.setPen(QPen(QColor(tones().border), 1.0))
        painter.drawLine(QPointF(_LEFT, self._y(0.0)), QPointF(right, self._y(0.0)))
        for value in (self._now, *([] if self._at is None else [self._points[self._at].value])):
            if self._points[0].value <= value <= self._points[-1].value:
                painter.drawLine(
                    QPointF(self._x(value), _TOP), QPointF(self._x(value), self.height() - _BOTTOM)
                )
        painter.setPen(QColor(tones().muted))
        end = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        for change in (low, high):
            painter.drawText(QRectF(0.0, self._y(change) - 8.0, _LEFT - 4.0, 16.0), end, _signed(change))
        line = QRectF(_LEFT, self.height() - _BOTTOM + 2.0, right - _LEFT, _BOTTOM - 4.0)
        painter.drawText(line, self._value_text(self._points[0].value))
        painter.drawText(line, Qt.AlignmentFlag.AlignRight, self._value_text(self._points[-1].value))

    def _draw_class(self, painter: QPainter, name: str) -> None:
        known = [(self._x(point.value), *point.changes[name]) for point in self._points]
        colour = QColor(CLASS_COLOURS[name])
        band = QColor(colour)
        band.setAlphaF(0.18)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(band)
        upper = [QPointF(x, self._y(change + noise)) for x, change, noise in known]
        painter.drawPolygon(
            QPolygonF([*upper, *(QPointF(x, self._y(c - noise)) for x, c, noise in reversed(known))])
        )
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(colour, 1.6))
        painter.drawPolyline(QPolygonF([QPointF(x, self._y(change)) for x, change, _ in known]))
        painter.setBrush(colour)
        for index, (x, change, _) in enumerate(known):
            painter.drawEllipse(
                QPointF(x, self._y(change)), *((4.0, 4.0) if index == self._at else (1.8, 1.8))
            )

    def _value_text(self, value: float) -> str:
        return f"{short_text(value, self._unit)} {self._unit.name}".rstrip()


def _signed(change: float) -> str:
    """Return a change in percentage points with its sign."""
    text = f"{100.0 * change:+.1f}".replace("-", "−")
    return "0.0" if text.strip("+−") == "0.0" else text
