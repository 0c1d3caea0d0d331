"""A small line in a table cell: S-MS after each of the last edits."""

from __future__ import annotations

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QStyledItemDelegate, QStyleOptionViewItem

from riglens.widgets.panels.score_text import kilo_text
from riglens.widgets.panels.style import tones

MAX_TRAIL = 40
TRAIL_VALUES = Qt.ItemDataRole.UserRole.value + 1
TRAIL_COLOUR = Qt.ItemDataRole.UserRole.value + 2
_MARGIN_PX, _DOT_PX = 6, 2.0


def trail_points(values: list[float], room: QRectF) -> QPolygonF:
    """The values from left to right in a rectangle, the largest at the top; equal ones in the middle."""
    low, high = min(values), max(values)
    step = room.width() / max(len(values) - 1, 1)
    points = []
    for place, value in enumerate(values):
        height = 0.5 if high == low else (value - low) / (high - low)
        points.append(QPointF(room.left() + place * step, room.bottom() - height * room.height()))
    return QPolygonF(points)


def trail_tip(class_name: str, values: list[float]) -> str:
    """How many edits the line shows and between which values."""
    if not values:
        return ""
    low, high = kilo_text(min(values)), kilo_text(max(values))
    return f"S-MS of {class_name} after the last {len(values)} edits, between {low} and {high} · 10³ nat"


class Sparkline(QStyledItemDelegate):
    """Draws the line with a dot on its latest value."""

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionViewItem,
        index: QModelIndex | QPersistentModelIndex,
    ) -> None:
        """Draw the cell's background, then the line."""
        super().paint(painter, option, index)
        values = index.data(TRAIL_VALUES)
        if not values:
            return
        rect = QRectF(option.rect)  # type: ignore[attr-defined]
        points = trail_points(values, rect.adjusted(_MARGIN_PX, _MARGIN_PX, -_MARGIN_PX, -_MARGIN_PX))
        colour = QColor(index.data(TRAIL_COLOUR) or tones().accent)
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(colour, 1.4))
        painter.drawPolyline(points)
        painter.setBrush(colour)
        painter.drawEllipse(points.last(), _DOT_PX, _DOT_PX)
        painter.restore()
