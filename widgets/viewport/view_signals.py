"""How what the controller of a view says becomes signals of the view."""

from __future__ import annotations

from PySide6.QtCore import Qt

from riglens.core.geometry import Pose
from riglens.widgets.viewport.drop_target import DropTarget


class ViewSignals(DropTarget):
    """Listens to the controller of a view (`listener.Listener`) and tells the window."""

    def on_picked(self, name: str | None) -> None:
        """A click chose a sensor, or nothing."""
        self.sensor_picked.emit(name)

    def on_drag_started(self, name: str) -> None:
        """A handle was grasped."""
        self.drag_started.emit(name)

    def on_drag_moved(self, name: str, pose: Pose) -> None:
        """The sensor was dragged."""
        self.drag_moved.emit(name, pose)

    def on_drag_finished(self, name: str) -> None:
        """The handle was let go."""
        self.drag_finished.emit(name)

    def on_drag_cancelled(self, name: str) -> None:
        """The drag was given up."""
        self.drag_cancelled.emit(name)

    def on_nudged(self, name: str, pose: Pose) -> None:
        """A key moved the sensor."""
        self.nudged.emit(name, pose)

    def on_placing(self, active: bool) -> None:
        """A sensor follows the mouse, or no longer."""
        self._canvas.setCursor(Qt.CursorShape.CrossCursor if active else Qt.CursorShape.ArrowCursor)
        self.placing_changed.emit(active)

    def on_changed(self) -> None:
        """The scene changed by the mouse."""
        self.request_render()
