"""The map under the mouse: the wheel zooms, a drag shifts, a click selects a sensor or looks there."""

from __future__ import annotations

import math

from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

from riglens.widgets.maps.map_picture import MapPicture

_CLICK_PX = 4.0
_WHEEL = 1.2
HINT = "Wheel: zoom · drag: shift · click: select, or look there · double click: fit"


class MapView(MapPicture):
    """A MapPicture that can be moved, and says by signals what was clicked."""

    sensor_clicked = Signal(str)
    place_clicked = Signal(float, float)
    """x and y in metres of a spot without a sensor."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setMouseTracking(True)
        self.setToolTip(HINT)
        self._pressed: QPointF | None = None
        self._last: QPointF | None = None

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self._pressed = self._last = event.position()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        at = event.position()
        if self._last is not None and event.buttons() and self._is_drag(at):
            self._view = self.plane.shifted(at - self._last)
            self._last, self._pressed = at, None
        self._hover = at
        self.update()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        pressed, self._pressed, self._last = self._pressed, None, None
        if pressed is None or event.button() != Qt.MouseButton.LeftButton:
            return
        sensor = self._sensor_at(event.position())
        if sensor is not None:
            self.sensor_clicked.emit(sensor.name)
        elif self.plane.area.contains(event.position()):
            self.place_clicked.emit(*self.plane.to_m(event.position()))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self._pressed = self._last = None
        if self._sensor_at(event.position()) is None:
            self.fit()

    def wheelEvent(self, event: QWheelEvent) -> None:
        factor = _WHEEL ** (event.angleDelta().y() / 120.0)
        self._view = self.plane.zoomed(factor, event.position())
        event.accept()
        self.update()

    def leaveEvent(self, event: QEvent) -> None:
        self._hover = None
        self.update()

    def _is_drag(self, at: QPointF) -> bool:
        if self._pressed is None:
            return True
        moved = at - self._pressed
        return math.hypot(moved.x(), moved.y()) > _CLICK_PX
