"""Models of the sensor library dragged onto the car: a ghost under the mouse, and a signal where they were dropped."""

from __future__ import annotations

from PySide6.QtCore import QMimeData, QPointF
from PySide6.QtGui import QDragEnterEvent, QDragLeaveEvent, QDragMoveEvent, QDropEvent
from PySide6.QtWidgets import QWidget

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Sensor
from riglens.widgets.drawing.camera import Pixel
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.view import View

MODEL_MIME = "application/x-riglens-model"
"""MIME type of a model dragged from the library: the name of a sensor model, UTF-8."""
_MAX_NAME_BYTES = 200


class DropTarget(View):
    """A view of a scene that takes models of the sensor library; everything else is left to the window."""

    _scene: DrawnScene
    _canvas: QWidget

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._dropped: Sensor | None = None
        self.setAcceptDrops(True)

    def request_render(self) -> None:
        """Draw once, soon."""
        raise NotImplementedError

    @property
    def snaps(self) -> bool:
        """Return whether sensors put on the car snap to round places."""
        raise NotImplementedError

    def place_at(self, pixel: Pixel, model: str) -> Pose | None:
        """Return the pose of a sensor of a library model on the car under a pixel; None off the car.

        Pixels are those of the screen, from the upper left of the view. InputError for an unknown model.
        """
        return self._scene.pose_on_body(pixel, sensor_from_model(model, model, Pose()), self.snaps)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """A model of the library may be dropped here; files are left to the window."""
        self._dropped = dragged_sensor(event.mimeData())
        event.setAccepted(self._dropped is not None)

    def dragMoveEvent(self, event: QDragMoveEvent) -> None:
        """Show where the sensor would be placed."""
        pose = self._pose_of_drop(event.position())
        self._show_drop(pose)
        event.setAccepted(pose is not None)

    def dragLeaveEvent(self, event: QDragLeaveEvent) -> None:
        """The drag went elsewhere."""
        self._show_drop(None)

    def dropEvent(self, event: QDropEvent) -> None:
        """Emit the dropped model and its place."""
        pose, sensor = self._pose_of_drop(event.position()), self._dropped
        self._show_drop(None)
        if pose is not None and sensor is not None:
            event.acceptProposedAction()
            self.model_dropped.emit(sensor.name, pose)

    def _pose_of_drop(self, position: QPointF) -> Pose | None:
        if self._dropped is None:
            return None
        return self._scene.pose_on_body(self._pixel(position), self._dropped, self.snaps)

    def _show_drop(self, pose: Pose | None) -> None:
        sensor = self._dropped
        self._scene.set_ghost(None if pose is None or sensor is None else sensor.with_pose(pose))
        self.request_render()

    def _pixel(self, position: QPointF) -> Pixel:
        ratio = self._canvas.devicePixelRatioF()
        return position.x() * ratio, position.y() * ratio


def dragged_sensor(data: QMimeData) -> Sensor | None:
    """The sensor of the library that is being dragged, at the origin; None for anything else."""
    if not data.hasFormat(MODEL_MIME):
        return None
    name = bytes(data.data(MODEL_MIME).data())[:_MAX_NAME_BYTES].decode("utf-8", "replace")
    try:
        return sensor_from_model(name, name, Pose())
    except InputError:
        return None
