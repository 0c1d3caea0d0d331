"""Mouse and keys of the 3D view: Qt's events go to the controller, never to VTK's own interaction styles."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QHelpEvent, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QWheelEvent
from PySide6.QtWidgets import QToolTip, QWidget

from riglens.widgets.drawing.camera import Pixel
from riglens.widgets.gizmo.nudge import NudgeKey
from riglens.widgets.panels.controls.style import plain_tip
from riglens.widgets.theme import SELECTED_COLOUR
from riglens.widgets.viewport.controller import Button, ViewController

_BUTTONS: dict[Qt.MouseButton, Button] = {
    Qt.MouseButton.LeftButton: "left",
    Qt.MouseButton.MiddleButton: "middle",
    Qt.MouseButton.RightButton: "right",
}
_ADDING = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier


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
        """Stop listening."""
        self._canvas.removeEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Pass events of mouse and keys to the controller; all others go on to the canvas."""
        if isinstance(event, QMouseEvent | QWheelEvent | QKeyEvent):
            self.used.emit()
        if isinstance(event, QMouseEvent):
            return self._on_mouse(event)
        if isinstance(event, QWheelEvent):
            self._controller.wheel(self.pixel(event.position()), event.angleDelta().y() / 120.0)
            return True
        if isinstance(event, QKeyEvent) and event.type() == QEvent.Type.ShortcutOverride:
            event.setAccepted(is_own_key(event, self._controller))
            return True
        if isinstance(event, QKeyEvent):
            event.setAccepted(handle_key(self._controller, event))
            return True
        if isinstance(event, QHelpEvent) and event.type() == QEvent.Type.ToolTip:
            words = self._controller.words(self.pixel(QPointF(event.pos())))
            QToolTip.showText(event.globalPos(), plain_tip(words), self._canvas)
            return True
        if event.type() == QEvent.Type.Leave:
            self._controller.leave()
        if event.type() == QEvent.Type.Resize:
            self.resized.emit()
        return super().eventFilter(watched, event)

    def _on_mouse(self, event: QMouseEvent) -> bool:
        pixel = self.pixel(event.position())
        button = _BUTTONS.get(event.button(), "none")
        if event.type() == QEvent.Type.MouseMove:
            keys = event.modifiers()
            is_ctrl = bool(keys & Qt.KeyboardModifier.ControlModifier)
            self._controller.move(pixel, is_ctrl, bool(keys & Qt.KeyboardModifier.AltModifier))
        elif event.type() == QEvent.Type.MouseButtonPress:
            self._canvas.setFocus(Qt.FocusReason.MouseFocusReason)
            shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
            alt = bool(event.modifiers() & Qt.KeyboardModifier.AltModifier)
            self._controller.press(pixel, button, shift, alt)
        elif event.type() == QEvent.Type.MouseButtonRelease:
            is_adding = bool(event.modifiers() & _ADDING)
            is_removing = bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
            self._controller.release(pixel, button, is_adding, is_removing)
        elif event.type() == QEvent.Type.MouseButtonDblClick and button == "left":
            self._controller.double_click(pixel)
        elif event.type() == QEvent.Type.MouseButtonDblClick:
            self._controller.press(pixel, button)
        event.accept()
        return True

    def pixel(self, position: QPointF) -> Pixel:
        """Return the pixel of the screen at a place of the canvas."""
        ratio = self._canvas.devicePixelRatioF()
        return position.x() * ratio, position.y() * ratio


_NUDGES: dict[int, NudgeKey] = {
    Qt.Key.Key_Left: "left",
    Qt.Key.Key_Right: "right",
    Qt.Key.Key_Up: "forward",
    Qt.Key.Key_Down: "back",
    Qt.Key.Key_PageUp: "up",
    Qt.Key.Key_PageDown: "down",
}


def handle_key(controller: ViewController, event: QKeyEvent) -> bool:
    """Escape cancels, arrow keys nudge (with Ctrl or Alt they turn), Ctrl inverts the snapping of a drag, digits say
    how far it goes.

    Every other key is left to the window. Returns whether this one was used.
    """
    is_press = event.type() == QEvent.Type.KeyPress
    if event.key() == Qt.Key.Key_Control:
        controller.invert(is_press)
        return False
    if is_press and event.key() == Qt.Key.Key_Escape:
        return controller.escape()
    if is_press and controller.type_key(_letter(event)):
        return True
    if not is_press or event.key() not in _NUDGES:
        return False
    keys = event.modifiers()
    turn = bool(keys & (Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier))
    return controller.nudge(_NUDGES[event.key()], turn, bool(keys & Qt.KeyboardModifier.ShiftModifier))


def is_own_key(event: QKeyEvent, controller: ViewController) -> bool:
    """Return whether a key nudges, ends a drag or says how far it goes: the view takes it even if the window has a
    shortcut for it."""
    return event.key() in _NUDGES or event.key() == Qt.Key.Key_Escape or controller.takes(_letter(event))


def _letter(event: QKeyEvent) -> str:
    """Return what a key types; a comma is a point."""
    return event.text().replace(",", ".")


_BOX_FILL = 40


class BoxFrame(QWidget):
    """The box that is drawn around sensors: over the canvas, so that the scene need not be drawn for it."""

    def __init__(self, canvas: QWidget) -> None:
        super().__init__(canvas)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.hide()

    def show_between(self, corners: tuple[Pixel, Pixel] | None) -> None:
        """Show the box between two pixels of the canvas, or none."""
        self.setVisible(corners is not None)
        if corners is not None:
            ratio = self.devicePixelRatioF()
            (x, y), (other_x, other_y) = corners
            box = QRectF(QPointF(x, y) / ratio, QPointF(other_x, other_y) / ratio).normalized()
            self.setGeometry(box.toAlignedRect().adjusted(0, 0, 1, 1))

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw a thin frame, filled lightly."""
        painter = QPainter(self)
        colour = QColor(SELECTED_COLOUR)
        painter.setPen(colour)
        colour.setAlpha(_BOX_FILL)
        painter.setBrush(colour)
        painter.drawRect(self.rect().adjusted(0, 0, -1, -1))
        painter.end()
