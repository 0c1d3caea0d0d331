"""What mouse and keys do in the 3D view, without Qt: pixels in, camera moves, picks, drags and poses out.

Left on a handle drags it, left elsewhere orbits, a left click selects, one sensor more with Ctrl or Shift, middle or
Shift+left pans, the wheel zooms towards the cursor, a double click looks at a sensor from close by, arrow keys nudge,
Escape cancels a drag. While a sensor is being placed it follows the mouse over the car, and a click leaves it there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from riglens.core.geometry import Pose
from riglens.core.rig.model import Camera, Lidar
from riglens.widgets.drawing.camera import Pixel
from riglens.widgets.gizmo.drag import Drag, begin_drag
from riglens.widgets.gizmo.echo import drag_echo
from riglens.widgets.gizmo.nudge import NudgeKey, nudge_turned, nudged
from riglens.widgets.viewport.drawn_scene import DrawnScene

Button = Literal["left", "middle", "right", "none"]


class Listener(Protocol):
    """What the controller tells: what mouse and keys did."""

    def on_picked(self, name: str | None) -> None:
        """A click chose a sensor, or nothing."""

    def on_toggled(self, name: str) -> None:
        """A click with Ctrl or Shift chose one sensor more, or one less."""

    def on_drag_started(self, name: str) -> None:
        """A handle of the sensor was grasped, or the sensor is being placed."""

    def on_drag_moved(self, name: str, pose: Pose) -> None:
        """The sensor was dragged here; the scene shows it already."""

    def on_drag_finished(self, name: str) -> None:
        """The handle was let go."""

    def on_drag_cancelled(self, name: str) -> None:
        """The drag was given up; the scene shows the start pose again."""

    def on_nudged(self, name: str, pose: Pose) -> None:
        """A key moved the sensor here."""

    def on_placing(self, active: bool) -> None:
        """A sensor follows the mouse over the car, or no longer."""

    def on_changed(self) -> None:
        """The scene needs to be drawn again."""


_CLICK_PX = 4.0
_ZOOM_PER_STEP = 0.86


@dataclass(frozen=True)
class _HeldSensor:
    """The sensor that follows the mouse: by a handle, or over the car when there is no `drag`."""

    name: str
    start: Pose
    drag: Drag | None = None


class ViewController:
    """Turns mouse and keys into changes of a scene and tells the listener; pixels count from the upper left."""

    def __init__(self, scene: DrawnScene, listener: Listener) -> None:
        self._scene = scene
        self._listener = listener
        self._held: _HeldSensor | None = None
        self._snap = False
        self._inverted = False
        self._button: Button = "none"
        self._pressed: Pixel = (0.0, 0.0)
        self._last: Pixel = (0.0, 0.0)
        self._panning = False
        self._moved = False

    @property
    def dragging(self) -> str | None:
        """Name of the sensor that follows the mouse."""
        return self._held.name if self._held else None

    @property
    def is_placing(self) -> bool:
        """Whether a sensor follows the mouse over the car."""
        return self._held is not None and self._held.drag is None

    @property
    def busy(self) -> bool:
        """Whether a mouse button is held in the view."""
        return self._button != "none"

    def set_snap(self, snap: bool) -> None:
        """Drags end on round numbers; Ctrl does the opposite of this while it is held."""
        self._snap = snap

    def press(self, pixel: Pixel, button: Button, shift: bool = False) -> None:
        """A mouse button went down."""
        if self.busy:
            return
        self._button, self._pressed, self._last, self._moved = button, pixel, pixel, False
        self._panning = button == "middle" or (button == "left" and shift)
        if button == "left" and not shift and not self.is_placing:
            self._grasp(pixel)

    def move(self, pixel: Pixel, inverted: bool = False) -> None:
        """The mouse moved, with or without a button; `inverted` is Ctrl."""
        dx, dy = pixel[0] - self._last[0], pixel[1] - self._last[1]
        self._last, self._inverted = pixel, inverted
        if self._held is not None and (self._held.drag is not None or not self.busy):
            self._drag_to(pixel)
        elif not self.busy:
            self._hover(pixel)
        elif self._is_drag(pixel):
            self._move_camera(dx, dy)

    def invert(self, inverted: bool) -> None:
        """Ctrl went down or up: a drag continues with or without snapping, even while the mouse rests."""
        if self._held is not None and self._held.drag is not None and inverted != self._inverted:
            self._inverted = inverted
            self._drag_to(self._last)

    def release(self, pixel: Pixel, button: Button, adding: bool = False) -> None:
        """A mouse button went up; with `adding` a click leaves the other sensors selected."""
        if button != self._button:
            return
        self._button = "none"
        is_click = button == "left" and not self._moved
        if self._held is not None and (self._held.drag is not None or is_click):
            self._let_go(pixel)
        elif is_click:
            self._click(pixel, adding)
        self._listener.on_changed()

    def _click(self, pixel: Pixel, adding: bool) -> None:
        """Select what is under the mouse; a click on nothing beside `adding` is a slip."""
        name = self._scene.under_mouse.sensor(pixel)
        if not adding:
            self._listener.on_picked(name)
        elif name is not None:
            self._listener.on_toggled(name)

    def double_click(self, pixel: Pixel) -> None:
        """Look at the sensor under the mouse from close by."""
        name = self._scene.under_mouse.sensor(pixel)
        if name is not None and self._held is None:
            self._scene.frame((name,))
            self._listener.on_changed()

    def wheel(self, pixel: Pixel, steps: float) -> None:
        """Zoom towards the cursor; one step is one notch, positive is closer."""
        camera = self._scene.state.camera
        self._scene.set_camera(camera.zoomed(_ZOOM_PER_STEP**steps, pixel, self._scene.size))
        self._scene.set_quick(True)
        self._listener.on_changed()

    def leave(self) -> None:
        """The mouse left the view."""
        if not self.busy and self._scene.set_hovered(None):
            self._listener.on_changed()

    def cancel(self) -> bool:
        """Give up a drag or a placing and restore what was before it. False when there was none."""
        held = self._held
        if held is None:
            return False
        self._button = "none"
        self._release_held()
        if self._has(held.name):
            self._scene.preview(held.name, held.start)
        self._listener.on_drag_cancelled(held.name)
        self._listener.on_changed()
        return True

    def begin_placing(self) -> bool:
        """Make the selected sensor follow the mouse over the car; False when none is selected and visible."""
        self.cancel()
        sensor = self._selected()
        if sensor is None:
            return False
        self._held = _HeldSensor(sensor.name, sensor.pose)
        self._scene.set_hovered(None)
        self._listener.on_drag_started(sensor.name)
        self._listener.on_placing(True)
        self._drag_to(self._last)
        return True

    def nudge(self, key: NudgeKey, turn: bool = False, coarse: bool = False) -> bool:
        """Move the selected sensor by 1 cm or turn it by 1 degree, ten times as far when coarse."""
        sensor, state = self._selected(), self._scene.state
        if sensor is None or self._held is not None:
            return False
        pose = (
            nudge_turned(sensor.pose, key, state.gizmo_space, coarse)
            if turn
            else nudged(sensor.pose, key, state.gizmo_space, state.camera, coarse)
        )
        self._listener.on_nudged(sensor.name, pose)
        return True

    def _selected(self) -> Lidar | Camera | None:
        state = self._scene.state
        seen = (s for s in state.rig.sensors if s.name == state.selected and s.name not in state.hidden)
        return next(seen, None)

    def _grasp(self, pixel: Pixel) -> None:
        """Begin a gizmo drag when a handle is under the mouse and can be dragged from here."""
        scene = self._scene
        under, name = scene.under_mouse, scene.state.selected
        handle, place = under.handle(pixel), under.gizmo()
        if handle is None or place is None or name is None:
            return
        ray = scene.state.camera.ray(pixel, scene.size)
        drag = begin_drag(handle, scene.state.gizmo_space, place.pose, ray, place.ring_radius_m)
        if drag is None:
            return
        self._held = _HeldSensor(name, place.pose, drag)
        scene.set_hovered(handle)
        scene.set_quick(True)
        scene.set_echo(drag_echo(place.pose, place.pose), pixel)
        self._listener.on_drag_started(name)
        self._listener.on_changed()

    def _drag_to(self, pixel: Pixel) -> None:
        held, scene = self._held, self._scene
        if held is None or not self._has(held.name):
            return
        if held.drag is None:
            pose = scene.pose_on_body(pixel, scene.state.rig.sensor(held.name))
        else:
            pose = held.drag.pose(scene.state.camera.ray(pixel, scene.size), self._snap != self._inverted)
        if pose is None:
            return
        scene.set_echo(drag_echo(held.start, pose), pixel)
        scene.preview(held.name, pose)
        scene.set_quick(True)
        self._listener.on_drag_moved(held.name, pose)
        self._listener.on_changed()

    def _let_go(self, pixel: Pixel) -> None:
        """The held sensor stays where it is; a click beside the car places nothing."""
        held = self._held
        assert held is not None
        if held.drag is None and self._has(held.name):
            if self._scene.pose_on_body(pixel, self._scene.state.rig.sensor(held.name)) is None:
                return
            self._drag_to(pixel)
        self._release_held()
        self._listener.on_drag_finished(held.name)

    def _release_held(self) -> None:
        was_placing, self._held = self.is_placing, None
        self._scene.set_echo("")
        if was_placing:
            self._listener.on_placing(False)

    def _has(self, name: str) -> bool:
        return any(sensor.name == name for sensor in self._scene.state.rig.sensors)

    def _hover(self, pixel: Pixel) -> None:
        if self._scene.set_hovered(
            self._scene.under_mouse.handle(pixel) or self._scene.under_mouse.sensor(pixel)
        ):
            self._listener.on_changed()

    def _is_drag(self, pixel: Pixel) -> bool:
        """Whether the mouse has left the place of a click."""
        far = max(abs(pixel[0] - self._pressed[0]), abs(pixel[1] - self._pressed[1]))
        self._moved = self._moved or far > _CLICK_PX * self._scene.pixel_ratio
        return self._moved

    def _move_camera(self, dx: float, dy: float) -> None:
        camera, size = self._scene.state.camera, self._scene.size
        if self._panning:
            camera = camera.panned(dx, dy, size)
        elif self._button == "left":
            camera = camera.orbited(dx, dy, size)
        else:
            return
        self._scene.set_camera(camera)
        self._scene.set_quick(True)
        self._listener.on_changed()
