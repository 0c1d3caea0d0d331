"""Share code between both viewports: the interface to the window, and the frames they draw."""

from __future__ import annotations

import math
from dataclasses import replace

from PySide6.QtCore import QEvent, QMimeData, QPointF, Qt
from PySide6.QtGui import QDragEnterEvent, QDragLeaveEvent, QDragMoveEvent, QDropEvent
from PySide6.QtWidgets import QVBoxLayout, QWidget

from riglens.core.errors import InputError
from riglens.core.geometry import Pose
from riglens.core.rig.library import sensor_from_model
from riglens.core.rig.model import Sensor
from riglens.widgets.drawing.camera import OrbitCamera, Pixel
from riglens.widgets.panels.sensors.library import MODEL_MIME
from riglens.widgets.timers import Timers, single_shot
from riglens.widgets.viewport.canvas_input import BoxFrame, CanvasInput
from riglens.widgets.viewport.controller import ViewController
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.inset import CameraInset
from riglens.widgets.viewport.redraw import Parts, Redraw
from riglens.widgets.viewport.scene_state import SceneState
from riglens.widgets.viewport.view import Tool, View

_MAX_NAME_BYTES = 200
_TILTING = Qt.KeyboardModifier.AltModifier
OVER_TRAFFIC_DEG = 35.0
"""Over a car 1.5 m high, the ground is seen from 2.1 m behind it on."""


class ViewportBase(View):
    """3D view as the window sees it; a subclass supplies the canvas and draws on it.

    A drag moves sensor, fan and gizmo at once and emits `drag_moved`; the document answers with a state that says
    the same.
    """

    def __init__(self, parent: QWidget | None = None, timers: Timers = single_shot) -> None:
        super().__init__(parent)
        self._closed, self._timers = False, timers
        self._dropped: Sensor | None = None
        self.setAcceptDrops(True)
        self._redraw = Redraw(self, self._draw_now, self._draw_rested, self._in_parts, timers)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)

    def _start(self, canvas: QWidget, scene: DrawnScene) -> None:
        """Put the canvas into the widget and connect its mouse events."""
        self._canvas, self._scene = canvas, scene
        self._box = BoxFrame(canvas)
        self._controller = ViewController(
            scene, self, self.request_render, self._box.show_between, self._ask_menu
        )
        self._home = scene.state.camera
        self._input = CanvasInput(canvas, self._controller)
        self._input.used.connect(self._redraw.postpone_rest)
        self._input.resized.connect(self._on_resized)
        self.placing_changed.connect(self._show_cross)
        layout = self.layout()
        assert layout is not None
        layout.addWidget(canvas)
        self._inset = CameraInset(self, self._timers)
        self.request_render()

    # ---- what the window calls

    @property
    def state(self) -> SceneState:
        return self._scene.state

    def show_state(self, state: SceneState) -> None:
        before = self.state
        if (before.rig, before.heat_look, before.ray_look) != (state.rig, state.heat_look, state.ray_look):
            self._expect_more()
        self._scene.show(state)
        self._follow_inset()
        self.request_render()

    def update_footprints(self) -> None:
        if self._scene.update_footprints():
            self.request_render()
        self._inset.update_footprints()

    @property
    def picture_size(self) -> tuple[int, int]:
        return self._canvas.width(), self._canvas.height()

    def show_inset(self, is_on: bool) -> None:
        self._inset.set_wanted(is_on)
        self._follow_inset()
        self.request_render()

    def _follow_inset(self) -> None:
        """Show the picture of the selected camera, and keep labels off it."""
        self._inset.follow(self.state)
        self._scene.set_covered(self._inset.box)

    # ---- actions that are not state

    def set_tool(self, tool: Tool, is_on: bool) -> None:
        self._controller.set_tool(tool, is_on)
        self._show_cross(self._controller.tool is not None)
        if is_on and tool != "pick":
            self._canvas.setFocus(Qt.FocusReason.OtherFocusReason)  # Escape ends it

    def set_view(self, name: str, wide: bool = False) -> None:
        self._scene.set_view(name, wide)
        self.request_render()

    def chosen_camera(self) -> OrbitCamera | None:
        camera = self._scene.state.camera
        return None if camera is self._home else camera

    def frame_sensors(self, names: tuple[str, ...]) -> None:
        self._scene.frame(names)
        self.request_render()

    def look_at(self, x_m: float, y_m: float) -> None:
        """Look over the car at a point of the ground plan, so steeply that what stands before it does not hide it."""
        camera = self._scene.state.camera
        self._scene.set_camera(
            replace(
                camera,
                focal_m=(x_m, y_m, camera.focal_m[2]),
                azimuth_deg=math.degrees(math.atan2(-y_m, -x_m)),
                elevation_deg=max(camera.elevation_deg, OVER_TRAFFIC_DEG),
            )
        )
        self.request_render()

    @property
    def snaps(self) -> bool:
        """Return whether sensors put on the car snap to round places."""
        return self._controller.snaps

    def cancel_drag(self) -> bool:
        return self._controller.cancel()

    def begin_placing(self) -> bool:
        self._canvas.setFocus(Qt.FocusReason.OtherFocusReason)
        return self._controller.begin_placing()

    @property
    def is_at_rest(self) -> bool:
        """Return whether the picture is in full quality and nothing waits to be drawn."""
        return self._redraw.is_at_rest

    def request_render(self) -> None:
        """Draw once, soon; any number of changes until then make one frame."""
        self._redraw.request()

    def close_viewport(self) -> None:
        if self._closed:
            return
        self._closed = True
        self._redraw.stop()
        self._input.stop()
        self._inset.release()
        self._release()

    def _ask_menu(self, name: str | None, pixel: Pixel) -> None:
        ratio = self._canvas.devicePixelRatioF()
        place = QPointF(pixel[0] / ratio, pixel[1] / ratio).toPoint()
        self.menu_wanted.emit(name, self._canvas.mapToGlobal(place))

    def _show_cross(self, is_on: bool) -> None:
        """Show a cross for what the next click chooses."""
        self._canvas.setCursor(Qt.CursorShape.CrossCursor if is_on else Qt.CursorShape.ArrowCursor)

    # ---- models of the library dragged onto the car; everything else is left to the window

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """Accept a model dragged from the library; leave files to the window."""
        self._dropped = dragged_sensor(event.mimeData())
        event.setAccepted(self._dropped is not None)

    def dragMoveEvent(self, event: QDragMoveEvent) -> None:
        """Show where the sensor would be placed."""
        pose = self._pose_of_drop(event)
        self._show_drop(pose)
        event.setAccepted(pose is not None)

    def dragLeaveEvent(self, event: QDragLeaveEvent) -> None:
        """Remove the preview when the drag leaves."""
        self._show_drop(None)

    def dropEvent(self, event: QDropEvent) -> None:
        """Emit the dropped model and its place."""
        pose, sensor = self._pose_of_drop(event), self._dropped
        self._show_drop(None)
        if pose is not None and sensor is not None:
            event.acceptProposedAction()
            self.model_dropped.emit(sensor.name, pose)

    def _pose_of_drop(self, event: QDropEvent) -> Pose | None:
        if self._dropped is None:
            return None
        pixel, other_way = self._input.pixel(event.position()), bool(event.modifiers() & _TILTING)
        return self._scene.pose_on_body(pixel, self._dropped, self.snaps, other_way)

    def _show_drop(self, pose: Pose | None) -> None:
        sensor = self._dropped
        self._scene.set_ghost(None if pose is None or sensor is None else sensor.with_pose(pose))
        self.request_render()

    # ---- what a subclass supplies

    def _draw(self) -> None:
        raise NotImplementedError

    def _release(self) -> None:
        raise NotImplementedError

    # ---- Qt

    def closeEvent(self, event: QEvent) -> None:
        """Release the graphics before the widget goes."""
        self.close_viewport()
        super().closeEvent(event)  # type: ignore[arg-type]

    def _expect_more(self) -> None:
        """Draw changes that follow one another closely, from a slider or a held key, like those of a drag."""
        if self._redraw.is_busy:
            self._scene.set_quick(True)

    def _on_resized(self) -> None:
        self._expect_more()
        self._follow_inset()
        self.request_render()

    def _in_parts(self) -> bool:
        """Return whether a full picture takes so long that the event loop should get turns in between."""
        return False

    def _draw_now(self) -> None:
        if not self._closed:
            self._adapt(smooth=False)
            self._draw()
            self._emit_drawn()

    def _draw_rested(self) -> Parts:
        """Draw one more frame when nothing has changed for a while, of everything and with smooth edges."""
        if self._closed:
            return
        if self._controller.busy:
            self._held_still()
            return
        self._scene.set_quick(False)
        self._adapt(smooth=True)
        yield from self._draw_whole()
        self._emit_drawn()

    def _emit_drawn(self) -> None:
        self.drawn.emit()
        if self._scene.lacks_footprints and not self._scene.is_quick:
            self.footprints_lacking.emit()

    def _held_still(self) -> None:
        """Handle a mouse that holds something but has not moved for a while."""

    def _draw_whole(self) -> Parts:
        """Draw everything; each yield gives the event loop a turn."""
        self._draw()
        yield from ()

    def _adapt(self, smooth: bool) -> None:
        """Fit the scene to the screen and the size of the widget."""
        self._scene.set_pixel_ratio(self._canvas.devicePixelRatioF())
        self._scene.set_smooth(smooth)
        self._fit_home()

    def _fit_home(self) -> None:
        """Keep the first view fitted to the size of the widget until the user moves the camera."""
        if self._scene.state.camera is self._home:
            self._scene.set_view("iso")
            self._home = self._scene.state.camera


def dragged_sensor(data: QMimeData) -> Sensor | None:
    """Return the sensor of the library that is being dragged, at the origin; None for anything else."""
    if not data.hasFormat(MODEL_MIME):
        return None
    name = bytes(data.data(MODEL_MIME).data())[:_MAX_NAME_BYTES].decode("utf-8", "replace")
    try:
        return sensor_from_model(name, name, Pose())
    except InputError:
        return None
