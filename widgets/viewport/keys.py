"""Keys of the 3D view: Qt's events in the words of the controller."""

from __future__ import annotations

from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QKeyEvent

from riglens.widgets.gizmo.nudge import NudgeKey
from riglens.widgets.viewport.controller import ViewController

_NUDGES: dict[int, NudgeKey] = {
    Qt.Key.Key_Left: "left",
    Qt.Key.Key_Right: "right",
    Qt.Key.Key_Up: "forward",
    Qt.Key.Key_Down: "back",
    Qt.Key.Key_PageUp: "up",
    Qt.Key.Key_PageDown: "down",
}


def handle_key(controller: ViewController, event: QKeyEvent) -> bool:
    """Escape cancels, arrow keys nudge (with Ctrl or Alt they turn), Ctrl inverts the snapping of a drag.

    Every other key is the window's; returns whether this one was used.
    """
    is_press = event.type() == QEvent.Type.KeyPress
    if event.key() == Qt.Key.Key_Control:
        controller.invert(is_press)
        return False
    if is_press and event.key() == Qt.Key.Key_Escape:
        return controller.cancel()
    if not is_press or event.key() not in _NUDGES:
        return False
    keys = event.modifiers()
    turn = bool(keys & (Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier))
    return controller.nudge(_NUDGES[event.key()], turn, bool(keys & Qt.KeyboardModifier.ShiftModifier))


def is_nudge(event: QKeyEvent) -> bool:
    """Whether a key nudges: then it is the view's even where the window has a shortcut for it."""
    return event.key() in _NUDGES
