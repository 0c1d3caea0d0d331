"""Mouse and keys of the 3D view: Qt's events go to the controller, never to VTK's own interaction styles."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QPointF, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

from riglens.widgets.viewport.controller import ViewController
from riglens.widgets.viewport.keys import handle_key, is_nudge
from riglens.widgets.viewport.listener import Button, Pixel

_BUTTONS: dict[Qt.MouseButton, Button] = {
    Qt.MouseButton.LeftButton: "left",
    Qt.MouseButton.MiddleButton: "middle",
    Qt.MouseButton.RightButton: "right",
}


class CanvasInput(QObject):
    """Listens to a canvas for a controller."""

    used = Signal()
    """The mouse moved over the canvas, or something was pressed."""
    resized = Signal()

    def __init__(self, canvas: QWidget, controller: ViewController) -> None:
        super().__init__(canvas)
        self._canvas, self._controller = canvas, controller
        canvas.setMouseTracking(True)
        canvas.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        canvas.installEventFilter(self)

    def stop(self) -> None:
        """Listen no more."""
        self._canvas.removeEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Take what the controller knows; everything else goes on to the canvas."""
        if isinstance(event, QMouseEvent | QWheelEvent | QKeyEvent):
            self.used.emit()
        if isinstance(event, QMouseEvent):
            return self._on_mouse(event)
        if isinstance(event, QWheelEvent):
            self._controller.wheel(self._pixel(event.position()), event.angleDelta().y() / 120.0)
            return True
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.ShortcutOverride:
            event.setAccepted(is_nudge(event))
            return True
        if isinstance(event, QKeyEvent):
            event.setAccepted(handle_key(self._controller, event))
            return True
        if event.type() == QEvent.Type.Leave:
            self._controller.leave()
        if event.type() == QEvent.Type.Resize:
            self.resized.emit()
        return super().eventFilter(watched, event)

    def _on_mouse(self, event: QMouseEvent) -> bool:
        pixel = self._pixel(event.position())
        button = _BUTTONS.get(event.button(), "none")
        if event.type() == QEvent.Type.MouseMove:
            self._controller.move(pixel, bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier))
        elif event.type() == QEvent.Type.MouseButtonPress:
            self._canvas.setFocus(Qt.FocusReason.MouseFocusReason)
            shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
            self._controller.press(pixel, button, shift)
        elif event.type() == QEvent.Type.MouseButtonRelease:
            self._controller.release(pixel, button)
        elif event.type() == QEvent.Type.MouseButtonDblClick:
            self._controller.double_click(pixel)
        event.accept()
        return True

    def _pixel(self, position: QPointF) -> Pixel:
        ratio = self._canvas.devicePixelRatioF()
        return position.x() * ratio, position.y() * ratio
