"""The sensor view: what the selected sensor sees of one frame of the data set."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Qt

from riglens.app.background.pictures import Picture, PictureRequest, Pictures
from riglens.app.evaluation.requests import LoadedScene
from riglens.app.window.feature import Feature
from riglens.app.window.in_sight import InSight
from riglens.core.errors import InputError
from riglens.core.view.camera_picture import CameraPicture
from riglens.widgets.maps.sensor_view import SensorView as SensorViewPanel

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow

NOTHING_SELECTED = "Select a camera or a LiDAR to look through it"
NO_SENSORS = "The rig has no sensors: add one, and look through it here"
LOADING = "Box data are being loaded"
NO_DATA = "No box data are loaded: choose some in the Scene panel"
WAITING = "The picture is being made"
OFF = "Switched off: this sensor does not count in the scores."


class SensorView(Feature):
    """A dock that follows selection, rig and scene; it costs nothing while it is out of sight."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.panel, self.pictures = SensorViewPanel(), Pictures(self)
        self._scene: LoadedScene | None = None
        self._no_scene = LOADING
        self._asked: PictureRequest | None = None
        self._is_answered = True
        self.dock = window.add_dock(
            "Sensor view", self.panel, Qt.DockWidgetArea.RightDockWidgetArea, beside="Inspector"
        )
        self.in_sight = InSight(self.dock)
        self.in_sight.changed.connect(lambda _: self._ask())
        self.panel.frame_chosen.connect(lambda _: self._ask())
        queued = Qt.ConnectionType.QueuedConnection
        self.pictures.made.connect(self._show, queued)
        self.pictures.failed.connect(self._on_failed, queued)
        window.rig_shown.connect(self._ask)
        window.scene_shown.connect(self._on_scene)
        window.recompute.load_ended.connect(self._on_load_ended, queued)
        window.closing.connect(self.pictures.close)

    @property
    def is_current(self) -> bool:
        """Whether the picture shown is the one last asked for."""
        return self._is_answered

    def _on_scene(self, scene: LoadedScene) -> None:
        self._scene = scene
        has_boxes = scene.options.pog is None
        self.panel.set_frames(scene.field.data.frames if has_boxes else 0)
        self._ask()

    def _on_load_ended(self, problem: str) -> None:
        if problem:
            self._no_scene = NO_DATA
            self._ask()

    def _ask(self) -> None:
        """Ask for the picture that belongs to what is selected now, or say why there is none."""
        if not self.in_sight:
            return
        sensor, scene = self.document.selected_sensor(), self._scene
        if sensor is None or scene is None:
            self._asked, self._is_answered = None, True
            has_sensors = bool(self.document.rig.sensors)
            why = self._no_scene if scene is None else NOTHING_SELECTED if has_sensors else NO_SENSORS
            self.panel.show_text(why)
            return
        request = PictureRequest(sensor, self.panel.chosen_frame, scene, self._body())
        if self._asked is None or not request.asks_same(self._asked):
            self._asked, self._is_answered = request, False
            if self.panel.page is self.panel.text:
                self.panel.show_text(WAITING)
            self.pictures.ask(request)

    def _body(self) -> NDArray[np.float32]:
        from riglens.widgets.maps.body_mesh import (
            body_triangles,  # loads VTK, which a window without this view needs not
        )

        try:
            return body_triangles(self.document.rig.vehicle)
        except InputError:  # said already where the car is drawn
            return np.zeros((0, 3, 3), np.float32)

    def _show(self, picture: Picture) -> None:
        """Show a picture of the selected sensor; one of an earlier pose too, until the next is there."""
        request, sensor = picture.request, self.document.selected_sensor()
        if request is self._asked:
            self._is_answered = True
        if sensor is None or sensor.name != request.sensor.name or request.scene is not self._scene:
            return
        self.panel.set_title(sensor.name)
        notes = [picture.note, "" if request.sensor.enabled else OFF]
        self.panel.set_note(" ".join(note for note in notes if note))
        if isinstance(picture.image, CameraPicture):
            self.panel.show_camera(picture.image)
        else:
            grid = request.scene.field.grid
            self.panel.show_ranges(picture.image, math.hypot(grid.roi_m[0], grid.roi_m[1]) / 2)

    def _on_failed(self, problem: str) -> None:
        self._asked, self._is_answered = None, True
        self.panel.show_text(problem)
