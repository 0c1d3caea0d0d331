"""Share code between both viewports: the interface to the window, and the frames they draw."""

from __future__ import annotations

import math
from dataclasses import replace

from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtWidgets import QVBoxLayout, QWidget

from riglens.core.geometry import Vec3
from riglens.core.rig.groups import Poses
from riglens.widgets.drawing.camera import OrbitCamera, Pixel
from riglens.widgets.timers import Timers, single_shot
from riglens.widgets.viewport.canvas_input import BoxFrame, CanvasInput, CellPicker
from riglens.widgets.viewport.controller import ViewController
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.drop_target import DropTarget
from riglens.widgets.viewport.measured import Place
from riglens.widgets.viewport.redraw import Parts, Redraw
from riglens.widgets.viewport.scene_state import SceneState

OVER_TRAFFIC_DEG = 35.0
"""Over a car 1.5 m high, the ground is seen from 2.1 m behind it on."""


class ViewportBase(DropTarget):
    """3D view as the window sees it; a subclass supplies the canvas and draws on it.

    A drag moves sensor, fan and gizmo at once and emits `drag_moved`; the document answers with a state that says
    the same.
    """

    def __init__(self, parent: QWidget | None = None, timers: Timers = single_shot) -> None:
        super().__init__(parent)
        self._closed = False
        self._redraw = Redraw(self, self._draw_now, self._draw_rested, self._in_parts, timers)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)

    def _start(self, canvas: QWidget, scene: DrawnScene) -> None:
        """Put the canvas into the widget and listen to its mouse."""
        self._canvas, self._scene = canvas, scene
        self._controller = ViewController(scene, self)
        self._home = scene.state.camera
        self._input = CanvasInput(canvas, self._controller)
        self._input.used.connect(self._redraw.postpone_rest)
        self._input.resized.connect(self._on_resized)
        self._box = BoxFrame(canvas)
        self._picker = CellPicker(canvas, scene, lambda: self._controller.dragging is not None)
        self._picker.picked.connect(self.cell_picked)
        self._picker.escaped.connect(self.escaped)
        layout = self.layout()
        assert layout is not None
        layout.addWidget(canvas)
        self.request_render()

    # ---- what the window calls

    @property
    def state(self) -> SceneState:
        """Return the state that is shown, with changes made in the view itself."""
        return self._scene.state

    def show_state(self, state: SceneState) -> None:
        """Show a state; only differences from the current one are updated."""
        before = self.state
        if (before.rig, before.heat_look, before.ray_look) != (state.rig, state.heat_look, state.ray_look):
            self._expect_more()
        self._scene.show(state)
        self.request_render()

    @property
    def picture_size(self) -> tuple[int, int]:
        """Width and height of the view in logical pixels."""
        return self._canvas.width(), self._canvas.height()

    # ---- actions that are not state

    def set_picking(self, is_on: bool) -> None:
        """Make every left click pick a cell of the heatmap; otherwise only clicks with Alt do."""
        self._picker.set_on(is_on)

    def set_measuring(self, is_on: bool) -> None:
        """Make clicks choose places to measure between; drags still turn the view."""
        self._canvas.setCursor(Qt.CursorShape.CrossCursor if is_on else Qt.CursorShape.ArrowCursor)
        self._controller.set_measuring(is_on)
        if is_on:
            self._canvas.setFocus(Qt.FocusReason.OtherFocusReason)  # Escape ends it

    def set_painting(self, is_on: bool) -> None:
        """Set whether the left button paints on the car; off the car drags still orbit the view."""
        self._canvas.setCursor(Qt.CursorShape.CrossCursor if is_on else Qt.CursorShape.ArrowCursor)
        self._controller.set_painting(is_on)
        if is_on:
            self._canvas.setFocus(Qt.FocusReason.OtherFocusReason)  # Escape ends it

    def set_view(self, name: str, wide: bool = False) -> None:
        """Look from "iso", "top", "front", "left", "rear" or "right"; `wide` shows the whole ROI in the iso view."""
        self._scene.set_view(name, wide)
        self.request_render()

    def chosen_camera(self) -> OrbitCamera | None:
        """The camera that somebody chose; None while the first view is fitted to the size of the widget."""
        camera = self._scene.state.camera
        return None if camera is self._home else camera

    def frame_sensors(self, names: tuple[str, ...]) -> None:
        """Look at these sensors from close by; without names, at the car with all the sensors shown."""
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

    def set_snap(self, snap: bool) -> None:
        """Make drags end on round numbers: 0.05 m and 5 degrees."""
        self._controller.set_snap(snap)

    @property
    def snaps(self) -> bool:
        """Return whether sensors put on the car snap to round places."""
        return self._controller.snaps

    def set_placing(self, upright: bool, below_rails: bool) -> None:
        """Say how sensors are put on the car: level, and through narrow things on the roof."""
        self._scene.set_placing(upright, below_rails)

    def cancel_drag(self) -> bool:
        """Give up the drag or the placing in progress; False when there is none."""
        return self._controller.cancel()

    def begin_placing(self) -> bool:
        """Make the selected sensor follow the mouse over the car until a click; False when none is selected."""
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
        """Stop all timers and release the graphics; the widget draws nothing from then on."""
        if self._closed:
            return
        self._closed = True
        self._redraw.stop()
        self._input.stop()
        self._picker.stop()
        self._release()

    # ---- what the controller reports (`controller.Listener`)

    def on_picked(self, name: str | None) -> None:
        """A click chose a sensor, or nothing."""
        self.sensor_picked.emit(name)

    def on_place(self, place: Place | None) -> None:
        """A click chose a place to measure from or to."""
        self.place_picked.emit(place)

    def on_brushed(self, point_m: Vec3, begins: bool) -> None:
        """The brush touches the car."""
        self.brushed.emit(point_m, begins)

    def on_brush_ended(self, kept: bool) -> None:
        """The brush was lifted, or the stroke given up."""
        self.brush_ended.emit(kept)

    def on_toggled(self, name: str) -> None:
        """A click with Ctrl or Shift chose one more sensor."""
        self.sensor_toggled.emit(name)

    def on_boxing(self, corners: tuple[Pixel, Pixel] | None) -> None:
        """A box is being drawn between two pixels, or no longer."""
        self._box.show_between(corners)

    def on_boxed(self, names: tuple[str, ...], removing: bool) -> None:
        """A box was drawn around sensors."""
        self.sensors_boxed.emit(names, removing)

    def on_menu_wanted(self, name: str | None, pixel: Pixel) -> None:
        """Emit a request for a menu."""
        ratio = self._canvas.devicePixelRatioF()
        place = QPointF(pixel[0] / ratio, pixel[1] / ratio).toPoint()
        self.menu_wanted.emit(name, self._canvas.mapToGlobal(place))

    def on_drag_started(self, names: tuple[str, ...]) -> None:
        """A handle was grasped."""
        self.drag_started.emit(names)

    def on_drag_moved(self, poses: Poses) -> None:
        """Sensors were dragged."""
        self.drag_moved.emit(poses)

    def on_drag_finished(self) -> None:
        """The handle was let go."""
        self.drag_finished.emit()

    def on_drag_cancelled(self) -> None:
        """The drag was given up."""
        self.drag_cancelled.emit()

    def on_nudged(self, poses: Poses) -> None:
        """A key moved sensors."""
        self.nudged.emit(poses)

    def on_placing(self, active: bool) -> None:
        """A sensor follows the mouse, or no longer does."""
        self._canvas.setCursor(Qt.CursorShape.CrossCursor if active else Qt.CursorShape.ArrowCursor)
        self.placing_changed.emit(active)

    def on_changed(self) -> None:
        """The mouse changed the scene."""
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
        self.request_render()

    def _in_parts(self) -> bool:
        """Return whether a full picture takes so long that the event loop should get turns in between."""
        return False

    def _draw_now(self) -> None:
        if not self._closed:
            self._adapt(smooth=False)
            self._draw()
            self.drawn.emit()

    def _draw_rested(self) -> Parts:
        """Nothing has changed for a while: one more frame, of everything and with smooth edges."""
        if self._closed:
            return
        if self._controller.busy:
            self._held_still()
            return
        self._scene.set_quick(False)
        self._adapt(smooth=True)
        yield from self._draw_whole()
        self.drawn.emit()

    def _held_still(self) -> None:
        """The mouse holds something, but has not moved for a while."""

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
        """Until somebody looks elsewhere, keep the first view fitted to the size of the widget."""
        if self._scene.state.camera is self._home:
            self._scene.set_view("iso")
            self._home = self._scene.state.camera
