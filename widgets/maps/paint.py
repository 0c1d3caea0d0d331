"""Painting that the flat pictures share: colours, legends, labels, and the frame around an image."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from functools import lru_cache

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QImage, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from riglens.widgets.panels.controls.style import small_font, tones
from riglens.widgets.theme import Tones

SHARE_MAP, RANGE_MAP = "viridis", "turbo"
BAR_PX = 8.0
LEGEND_PX = 34.0
"""Room for a colour bar with its marks, or for two rows of swatches."""
_ROW_PX = 16.0


@lru_cache(maxsize=4)
def colours(name: str) -> NDArray[np.uint32]:
    """Return a colour map as 256 values 0xAARRGGBB."""
    table = np.rint(matplotlib.colormaps[name](np.linspace(0.0, 1.0, 256))[:, :3] * 255).astype(np.uint32)
    return np.asarray(0xFF000000 | table[:, 0] << 16 | table[:, 1] << 8 | table[:, 2], np.uint32)


def argb(colour: str | QColor) -> int:
    """Return a colour as 0xAARRGGBB."""
    return int(QColor(colour).rgba())


def image_of(pixels: NDArray[np.uint32]) -> QImage:
    """Return pixels (rows, columns) 0xAARRGGBB as an image that owns its memory."""
    data = np.ascontiguousarray(pixels, np.uint32)
    rows, columns = data.shape
    return QImage(data.data, columns, rows, 4 * columns, QImage.Format.Format_ARGB32).copy()


def draw_tag(painter: QPainter, at: QPointF, text: str, ink: QColor, paper: QColor) -> None:
    """Draw a short text centred on a point, on a patch that keeps it readable over anything."""
    metrics = QFontMetricsF(painter.font())
    box = metrics.boundingRect(text).adjusted(-3.0, -1.0, 3.0, 1.0)
    box.moveCenter(at)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(paper)
    painter.drawRoundedRect(box, 3.0, 3.0)
    painter.setPen(ink)
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)


def draw_message(painter: QPainter, area: QRectF, text: str, tones: Tones) -> None:
    """Draw a sentence at the bottom of an area, on a patch."""
    font = QFont(painter.font())
    painter.setFont(font)
    room = area.adjusted(16.0, 8.0, -16.0, -8.0)
    room.adjust(0.0, 0.0, 0.0, -10.0)
    flags = int(Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignBottom | Qt.TextFlag.TextWordWrap)
    box = QFontMetricsF(font).boundingRect(room, flags, text).adjusted(-10.0, -6.0, 10.0, 6.0)
    paper = QColor(tones.panel)
    paper.setAlphaF(0.92)
    painter.setPen(QPen(QColor(tones.border), 1.0))
    painter.setBrush(paper)
    painter.drawRoundedRect(box, 5.0, 5.0)
    painter.setPen(QColor(tones.text))
    painter.drawText(room, flags, text)


def draw_bar(
    painter: QPainter, area: QRectF, name: str, marks: list[tuple[float, str]], tones: Tones
) -> None:
    """Draw a colour bar along the top of an area with marks (share of its length, text) below it."""
    strip = QRectF(area.left(), area.top(), area.width(), BAR_PX)
    painter.drawImage(strip, image_of(colours(name)[None, :]))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QPen(QColor(tones.border), 1.0))
    painter.drawRect(strip)
    painter.setPen(QColor(tones.text))
    metrics = QFontMetricsF(painter.font())
    for share, text in marks:
        width = metrics.horizontalAdvance(text) + 2.0
        left = strip.left() + share * (strip.width() - width)
        box = QRectF(left, strip.bottom() + 1.0, width, metrics.height())
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)


def draw_swatches(painter: QPainter, area: QRectF, entries: Mapping[str, str], tones: Tones) -> None:
    """Draw a key of colours: a small square next to each name, in as many rows as needed."""
    metrics = QFontMetricsF(painter.font())
    x, y = area.left(), area.top() + 3.0
    for name, colour in entries.items():
        width = BAR_PX + 4.0 + metrics.horizontalAdvance(name)
        if x + width > area.right() and x > area.left():
            x, y = area.left(), y + _ROW_PX
        painter.fillRect(QRectF(x, y, BAR_PX, BAR_PX), QColor(colour))
        painter.setPen(QColor(tones.text))
        painter.drawText(QPointF(x + BAR_PX + 4.0, y + BAR_PX), name)
        x += width + 12.0


READOUT_PX = 34.0
"""Two lines of words at the foot of a view."""
_WORDS = int(Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignTop | Qt.TextFlag.TextWordWrap)


class ImageView(QWidget):
    """Widget that draws an image, when it has one, and describes the place under the mouse."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMouseTracking(True)
        self._hover: QPointF | None = None

    @property
    @abstractmethod
    def image_area(self) -> QRectF:
        """Return the area of the image on the widget; empty without an image."""

    @property
    @abstractmethod
    def readout_area(self) -> QRectF:
        """Return the area of the text about the image."""

    @abstractmethod
    def readout(self) -> str:
        """Describe the place under the mouse, or the content of the image."""

    @abstractmethod
    def draw(self, painter: QPainter, look: Tones) -> None:
        """Draw the image with what belongs to it; called only when there is room for one."""

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        look = tones()
        painter.fillRect(self.rect(), QColor(look.panel))
        if not self.image_area.isEmpty():
            painter.setFont(small_font(painter.font()))
            painter.save()
            self.draw(painter, look)
            painter.restore()
            painter.setPen(QColor(look.text))
            painter.drawText(self.readout_area, _WORDS, self.readout())
        painter.end()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self._hover = event.position()
        self.update()

    def leaveEvent(self, event: QEvent) -> None:
        self._hover = None
        self.update()
