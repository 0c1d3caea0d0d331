"""What camera image and range image have in common: the frame around them, the hovering mouse, the words below."""

from __future__ import annotations

from abc import abstractmethod

from PySide6.QtCore import QEvent, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget

from riglens.widgets.maps.paint import small_font
from riglens.widgets.panels.style import tones
from riglens.widgets.theme import Tones

READOUT_PX = 34.0
"""Two lines of words at the foot of a view."""
_WORDS = int(Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignTop | Qt.TextFlag.TextWordWrap)


class ImageView(QWidget):
    """A widget that draws an image, when it has one, and says what is under the mouse."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMouseTracking(True)
        self._hover: QPointF | None = None

    @property
    @abstractmethod
    def image_area(self) -> QRectF:
        """Where the image lies on the widget; empty without an image."""

    @property
    @abstractmethod
    def readout_area(self) -> QRectF:
        """Where the words about it stand."""

    @abstractmethod
    def readout(self) -> str:
        """What is under the mouse, or what the image holds."""

    @abstractmethod
    def draw(self, painter: QPainter, look: Tones) -> None:
        """Draw the image with what belongs to it; called only when there is room for one."""

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        look = tones()
        painter.fillRect(self.rect(), QColor(look.panel))
        if not self.image_area.isEmpty():
            painter.setFont(small_font(painter))
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
