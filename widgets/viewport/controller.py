"""What the mouse does in the 3D view, without Qt: pixels in, camera moves, picks and gizmo drags out.

Left on a handle drags it, left elsewhere orbits, a left click selects, middle or Shift+left pans, the wheel
zooms towards the cursor, a double click looks at a sensor from near by, Escape cancels a drag.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from core.geometry import Pose
from widgets.gizmo.drag import Drag, begin_drag
from widgets.viewport.scene import Scene

Pixel = tuple[float, float]
Button = Literal["left", "middle", "right", "none"]
_CLICK_PX = 4.0
_ZOOM_PER_STEP = 0.86


class Listener(Protocol):
    """Who hears what the mouse did."""

    def on_picked(self, name: str | None) -> None:
        """A click chose a sensor, or nothing."""

    def on_drag_started(self, name: str) -> None:
        """A handle of the sensor was grasped."""

    def on_drag_moved(self, name: str, pose: Pose) -> None:
        """The sensor was dragged here; the scene shows it already."""

    def on_drag_finished(self, name: str) -> None:
        """The handle was let go."""

    def on_drag_cancelled(self, name: str) -> None:
        """The drag was given up; the scene shows the start pose again."""

    def on_changed(self) -> None:
        """The scene needs to be drawn again."""


@dataclass(frozen=True)
class _GizmoDrag:
    name: str
    drag: Drag


class ViewController:
    """Turns mouse input into changes of a scene and tells the listener; pixels count from the upper left."""

    def __init__(self, scene: Scene, listener: Listener) -> None:
        self._scene = scene
        self._listener = listener
        self._gizmo: _GizmoDrag | None = None
        self._button: Button = "none"
        self._pressed: Pixel = (0.0, 0.0)
        self._last: Pixel = (0.0, 0.0)
        self._panning = False
        self._moved = False

    @property
    def dragging(self) -> str | None:
        """Name of the sensor whose handle is held."""
        return self._gizmo.name if self._gizmo else None

    @property
    def busy(self) -> bool:
        """Whether a mouse button is held in the view."""
        return self._button != "none"

    def press(self, pixel: Pixel, button: Button, shift: bool = False) -> None:
        """A mouse button went down."""
        if self.busy:
            return
        self._button, self._pressed, self._last, self._moved = button, pixel, pixel, False
        self._panning = button == "middle" or (button == "left" and shift)
        if button == "left" and not shift:
            self._grasp(pixel)

    def move(self, pixel: Pixel) -> None:
        """The mouse moved, with or without a button."""
        dx, dy = pixel[0] - self._last[0], pixel[1] - self._last[1]
        self._last = pixel
        if not self.busy:
            self._hover(pixel)
        elif self._gizmo is not None:
            self._drag_to(pixel)
        elif self._is_drag(pixel):
            self._move_camera(dx, dy)

    def release(self, pixel: Pixel, button: Button) -> None:
        """A mouse button went up."""
        if button != self._button:
            return
        self._button = "none"
        gizmo, self._gizmo = self._gizmo, None
        self._scene.set_quick(False)
        if gizmo is not None:
            self._listener.on_drag_finished(gizmo.name)
        elif button == "left" and not self._moved:
            self._listener.on_picked(self._scene.sensor_at(pixel))
        self._listener.on_changed()

    def double_click(self, pixel: Pixel) -> None:
        """Look at the sensor under the mouse from near by."""
        name = self._scene.sensor_at(pixel)
        if name is not None:
            self._scene.frame(name)
            self._listener.on_changed()

    def wheel(self, pixel: Pixel, steps: float) -> None:
        """Zoom towards the cursor; one step is one notch, positive is closer."""
        camera = self._scene.state.camera
        self._scene.set_camera(camera.zoomed(_ZOOM_PER_STEP**steps, pixel, self._scene.size))
        self._scene.set_quick(True)
        self._listener.on_changed()

    def rest(self) -> None:
        """Nothing moved for a while: show full quality again."""
        if not self.busy:
            self._scene.set_quick(False)
            self._listener.on_changed()

    def leave(self) -> None:
        """The mouse left the view."""
        if not self.busy and self._scene.set_hovered(None):
            self._listener.on_changed()

    def cancel(self) -> bool:
        """Give up a gizmo drag: everything is as before it. False when there was none."""
        gizmo, self._gizmo = self._gizmo, None
        if gizmo is None:
            return False
        self._button = "none"
        self._scene.set_quick(False)
        if self._has(gizmo.name):
            self._scene.preview(gizmo.name, gizmo.drag.start)
        self._listener.on_drag_cancelled(gizmo.name)
        self._listener.on_changed()
        return True

    def _grasp(self, pixel: Pixel) -> None:
        """Begin a gizmo drag when a handle is under the mouse and can be dragged from here."""
        scene = self._scene
        handle, place, name = scene.handle_at(pixel), scene.gizmo_place(), scene.state.selected
        if handle is None or place is None or name is None:
            return
        ray = scene.state.camera.ray(pixel, scene.size)
        drag = begin_drag(handle, scene.state.gizmo_space, place.pose, ray, place.ring_radius_m)
        if drag is None:
            return
        self._gizmo = _GizmoDrag(name, drag)
        scene.set_hovered(handle)
        scene.set_quick(True)
        self._listener.on_drag_started(name)
        self._listener.on_changed()

    def _drag_to(self, pixel: Pixel) -> None:
        assert self._gizmo is not None
        name = self._gizmo.name
        pose = self._gizmo.drag.pose(self._scene.state.camera.ray(pixel, self._scene.size))
        if pose is None or not self._has(name):
            return
        self._scene.preview(name, pose)
        self._listener.on_drag_moved(name, pose)
        self._listener.on_changed()

    def _has(self, name: str) -> bool:
        return any(sensor.name == name for sensor in self._scene.state.rig.sensors)

    def _hover(self, pixel: Pixel) -> None:
        if self._scene.set_hovered(self._scene.handle_at(pixel) or self._scene.sensor_at(pixel)):
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
