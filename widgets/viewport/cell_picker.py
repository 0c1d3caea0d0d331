"""Picking a cell of the heatmap with the mouse: Alt and a left click, or a left click while the tool is on."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, QPointF, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent
from PySide6.QtWidgets import QWidget

from riglens.widgets.viewport.scene import Scene

_CLICK_PX = 4.0


class CellPicker(QObject):
    """Listens to a canvas before anything else does, and keeps to itself the clicks that pick a cell."""

    picked = Signal(object)
    """A PickedCell; None when no cell is drawn there."""
    escaped = Signal()
    """Escape was pressed on the canvas, and no drag was going on."""

    def __init__(self, canvas: QWidget, scene: Scene, is_dragging: Callable[[], bool]) -> None:
        super().__init__(canvas)
        self._canvas, self._scene, self._is_dragging = canvas, scene, is_dragging
        self._is_on = False
        self._pressed: QPointF | None = None
        canvas.installEventFilter(self)

    def set_on(self, is_on: bool) -> None:
        """Pick with every left click, or with Alt only."""
        self._is_on = is_on
        self._canvas.setCursor(Qt.CursorShape.CrossCursor if is_on else Qt.CursorShape.ArrowCursor)

    def stop(self) -> None:
        """Listen no more."""
        self._canvas.removeEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Take the clicks that pick; everything else goes on to the view."""
        if isinstance(event, QMouseEvent):
            return self._on_mouse(event)
        is_press = isinstance(event, QKeyEvent) and event.type() == QEvent.Type.KeyPress
        if is_press and event.key() == Qt.Key.Key_Escape and not self._is_dragging():  # type: ignore[attr-defined]
            self.escaped.emit()
        return False

    def _on_mouse(self, event: QMouseEvent) -> bool:
        is_left = event.button() == Qt.MouseButton.LeftButton
        if event.type() == QEvent.Type.MouseButtonPress and is_left and not self._is_dragging():
            with_alt = bool(event.modifiers() & Qt.KeyboardModifier.AltModifier)
            if self._is_on or with_alt:
                self._pressed = event.position()
                self._canvas.setFocus(Qt.FocusReason.MouseFocusReason)
                return True
        if self._pressed is None:
            return False
        if event.type() == QEvent.Type.MouseButtonRelease and is_left:
            moved, self._pressed = event.position() - self._pressed, None
            if max(abs(moved.x()), abs(moved.y())) <= _CLICK_PX:
                ratio = self._canvas.devicePixelRatioF()
                place = event.position()
                self.picked.emit(self._scene.under_mouse.cell((place.x() * ratio, place.y() * ratio)))
        return True
