"""Handle mouse and keys in the 3D view: pixels in, camera moves, picks, drags and poses out.

Left on a handle drags all that is selected, left elsewhere orbits, a left click selects, one sensor more with Ctrl or
Shift; with Alt it picks a cell of the heatmap. Shift+left draws a box around sensors to select. Middle pans, right
zooms, a right click asks for a menu. The wheel zooms towards the cursor, a double-click shows a sensor from close by,
arrow keys nudge, Escape cancels. Digits typed while an arrow or a ring is dragged say how far it goes. While a sensor
is being placed it follows the mouse over the car, and a click leaves it there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from riglens.core.geometry import Pose
from riglens.core.rig.groups import Poses, carried
from riglens.widgets.drawing.camera import Pixel
from riglens.widgets.gizmo.drag import Drag, begin_drag
from riglens.widgets.gizmo.echo import amount_of, drag_echo, typed_echo
from riglens.widgets.gizmo.nudge import NudgeKey, nudge_turned, nudged
from riglens.widgets.viewport.drawn_scene import DrawnScene
from riglens.widgets.viewport.view import Tool, View

Button = Literal["left", "middle", "right", "none"]
Gesture = Literal["orbit", "pan", "zoom", "box", "pick", "none"]
"""Action of a drag that grasped no handle."""


_CLICK_PX = 4.0
_BACK, _DONE = "\b", "\r"
_TYPED = frozenset("0123456789.-" + _BACK + _DONE)
_LONGEST_TYPED = 9
_ZOOM_PER_STEP = 0.86
_ZOOM_PER_HEIGHT = 12.0
"""So much further away is the car after a drag with the right button over the whole height, downwards."""


@dataclass(frozen=True)
class _Held:
    """Sensors that follow the mouse, with their poses before: by a handle, or over the car without a `drag`.

    `frame` is the pose of the gizmo at the start; that of a single sensor is its own. `typed` are the keys that say how
    far a handle goes; without any the mouse does.
    """

    poses: Poses
    frame: Pose
    drag: Drag | None = None
    typed: str = ""

    @property
    def name(self) -> str:
        """The current sensor."""
        return list(self.poses)[-1]


class ViewController:
    """Controller that turns mouse and keys into changes of a scene and signals of the view; pixels count from the upper
    left.

    `changed` draws the scene again, `boxing` shows the box drawn between two pixels, or none, `ask_menu` opens a menu
    for the sensor at a pixel.
    """

    def __init__(
        self,
        scene: DrawnScene,
        view: View,
        changed: Callable[[], None],
        boxing: Callable[[tuple[Pixel, Pixel] | None], None],
        ask_menu: Callable[[str | None, Pixel], None],
    ) -> None:
        self._scene, self._view = scene, view
        self._changed, self._boxing, self._ask_menu = changed, boxing, ask_menu
        self._held: _Held | None = None
        self._inverted = self._other_way = False
        self._button: Button = "none"
        self._pressed: Pixel = (0.0, 0.0)
        self._last: Pixel = (0.0, 0.0)
        self._gesture: Gesture = "none"
        self._moved = False
        self.tool: Tool | None = None
        """The tool in hand, None for none."""

    @property
    def dragging(self) -> str | None:
        """Name of the sensor that follows the mouse."""
        return self._held.name if self._held else None

    @property
    def is_placing(self) -> bool:
        """Return whether a sensor follows the mouse over the car."""
        return self._held is not None and self._held.drag is None

    @property
    def busy(self) -> bool:
        """Return whether a mouse button is held in the view."""
        return self._button != "none"

    @property
    def snaps(self) -> bool:
        """Return whether a drag or a placing ends on round numbers now."""
        return self._scene.state.snap != self._inverted

    def takes(self, key: str) -> bool:
        """Return whether a key says how far the arrow or ring goes that is being dragged."""
        drag = self._held.drag if self._held else None
        return key in _TYPED and drag is not None and drag.handle.kind != "plane"

    def set_tool(self, tool: Tool, is_on: bool) -> None:
        """Take a tool in hand, or put it away if it is the one in hand."""
        if is_on or self.tool == tool:
            self.tool = tool if is_on else None

    def press(self, pixel: Pixel, button: Button, shift: bool = False, alt: bool = False) -> None:
        """Handle a press of a mouse button; with Alt the left one picks a cell."""
        if self.busy:
            return
        self._button, self._pressed, self._last, self._moved = button, pixel, pixel, False
        with_shift: Gesture = "box" if shift else "orbit"
        gestures: dict[Button, Gesture] = {"left": with_shift, "middle": "pan", "right": "zoom"}
        self._gesture = gestures.get(button, "none")
        if button == "left" and (alt or self.tool == "pick") and self._held is None:
            self._gesture = "pick"
        if self._gesture != "orbit" or self.is_placing or self.tool == "measure":
            return
        self._grasp(pixel)

    def move(self, pixel: Pixel, inverted: bool = False, other_way: bool = False) -> None:
        """Handle a move of the mouse, with or without a button; `inverted` is Ctrl, `other_way` Alt."""
        dx, dy = pixel[0] - self._last[0], pixel[1] - self._last[1]
        self._last, self._inverted, self._other_way = pixel, inverted, other_way
        if self._held is not None and (self._held.drag is not None or not self.busy):
            self._drag_to(pixel)
        elif not self.busy:
            self._hover(pixel)
        elif self._is_drag(pixel) and self._gesture == "box":
            self._boxing((self._pressed, pixel))
        elif self._moved:
            self._move_camera(dx, dy)

    def invert(self, inverted: bool) -> None:
        """Continue a drag with or without snapping when Ctrl is pressed or released, even while the mouse rests."""
        if self._held is not None and inverted != self._inverted:
            self._inverted = inverted
            self._drag_to(self._last)

    def release(self, pixel: Pixel, button: Button, adding: bool = False, removing: bool = False) -> None:
        """Handle the release of a mouse button.

        With `adding` a click leaves the other sensors selected; with `removing` a box takes out what is in it.
        """
        if button != self._button:
            return
        self._button, is_click = "none", not self._moved
        gesture, self._gesture = self._gesture, "none"
        if self._held is not None and (self._held.drag is not None or (is_click and button == "left")):
            self._let_go(pixel)
        elif gesture == "pick":
            if is_click:
                self._view.cell_picked.emit(self._scene.under_mouse.cell(pixel))
        elif is_click and button == "left":
            self._click(pixel, adding)
        elif is_click and gesture == "zoom" and self._held is None:
            self._ask_menu(self._scene.under_mouse.sensor(pixel), pixel)
        elif gesture == "box":
            self._boxing(None)
            self._view.sensors_boxed.emit(self._scene.under_mouse.inside(self._pressed, pixel), removing)
        self._changed()

    def _click(self, pixel: Pixel, adding: bool) -> None:
        """Select the sensor under the mouse; a click on nothing while `adding` is ignored."""
        if self.tool == "measure":
            self._view.place_picked.emit(self._scene.place_at(pixel))
            return
        name = self._scene.under_mouse.sensor(pixel)
        if not adding:
            self._view.sensor_picked.emit(name)
        elif name is not None:
            self._view.sensor_toggled.emit(name)

    def double_click(self, pixel: Pixel) -> None:
        """Look at the sensor under the mouse from close by."""
        name = self._scene.under_mouse.sensor(pixel)
        if name is not None and self._held is None and self.tool != "measure":
            self._scene.frame((name,))
            self._changed()

    def wheel(self, pixel: Pixel, steps: float) -> None:
        """Zoom towards the cursor; one step is one notch, positive is closer."""
        camera = self._scene.state.camera
        self._scene.set_camera(camera.zoomed(_ZOOM_PER_STEP**steps, pixel, self._scene.size))
        self._scene.set_quick(True)
        self._changed()

    def words(self, pixel: Pixel) -> str:
        """Return the tooltip at a pixel, nothing during a drag."""
        return "" if self.busy or self._held is not None else self._scene.under_mouse.words(pixel)

    def leave(self) -> None:
        """Handle the mouse leaving the view."""
        if not self.busy and (self._scene.set_hovered(None) | self._scene.aim_at(None)):
            self._changed()

    def escape(self) -> bool:
        """Handle Escape: the view says so unless a sensor follows the mouse, and what is in progress is given up."""
        if self._held is None:
            self._view.escaped.emit()
        return self.cancel()

    def cancel(self) -> bool:
        """Give up a drag, a placing or a box and restore what was before it. False when there was none."""
        if self._gesture == "box":
            self._button = self._gesture = "none"
            self._boxing(None)
            return True
        held = self._held
        if held is None:
            return False
        self._button = self._gesture = "none"
        self._release_held()
        self._scene.preview({name: pose for name, pose in held.poses.items() if self._has(name)})
        self._view.drag_cancelled.emit()
        self._changed()
        return True

    def type_key(self, key: str) -> bool:
        """Handle a key of a typed distance: digit, sign or point; Backspace deletes, Return ends the drag. Return
        whether the key was used.
        """
        held = self._held
        if held is None or not self.takes(key):
            return False
        if key == _DONE:
            self._button = self._gesture = "none"
            self._let_go(self._last)
            self._changed()
            return True
        typed = held.typed[:-1] if key == _BACK else (held.typed + key)[:_LONGEST_TYPED]
        self._held = replace(held, typed=typed)
        self._drag_to(self._last)
        return True

    def begin_placing(self) -> bool:
        """Make the selected sensor follow the mouse over the car; False when none is selected and visible."""
        self.cancel()
        sensor = self._scene.state.selected_sensor
        if sensor is None:
            return False
        self._held = _Held({sensor.name: sensor.pose}, sensor.pose)
        self._scene.set_hovered(None)
        self._view.drag_started.emit((sensor.name,))
        self._view.placing_changed.emit(True)
        self._drag_to(self._last)
        return True

    def nudge(self, key: NudgeKey, turn: bool = False, coarse: bool = False) -> bool:
        """Move the selection by 1 cm or turn it by 1 degree, ten times as far when coarse."""
        state = self._scene.state
        poses, frame = state.held_poses, state.frame_pose
        if frame is None or self._held is not None:
            return False
        pose = (
            nudge_turned(frame, key, state.gizmo_space, coarse)
            if turn
            else nudged(frame, key, state.gizmo_space, state.camera, coarse)
        )
        self._view.nudged.emit(carried(poses, frame, pose))
        return True

    def _grasp(self, pixel: Pixel) -> None:
        """Begin a gizmo drag when a handle is under the mouse and can be dragged from here."""
        scene = self._scene
        handle, place = scene.under_mouse.handle(pixel), scene.under_mouse.gizmo()
        if handle is None or place is None:
            return
        poses, ray = scene.state.held_poses, scene.state.camera.ray(pixel, scene.size)
        drag = begin_drag(handle, scene.state.gizmo_space, place.pose, ray, place.ring_radius_m)
        if drag is None:
            return
        self._held = _Held(poses, place.pose, replace(drag, by_steps=len(poses) > 1))
        scene.set_hovered(handle)
        scene.set_quick(True)
        scene.set_echo(drag_echo(place.pose, place.pose, len(poses)), pixel)
        self._view.drag_started.emit(tuple(poses))
        self._changed()

    def _drag_to(self, pixel: Pixel) -> None:
        held, scene = self._held, self._scene
        if held is None or not all(self._has(name) for name in held.poses):
            return
        if held.drag is None:
            pose = scene.pose_on_body(pixel, scene.state.rig.sensor(held.name), self.snaps, self._other_way)
        elif (amount := amount_of(held.typed)) is not None:
            pose = held.drag.pose_after(amount)
        else:
            pose = held.drag.pose(scene.state.camera.ray(pixel, scene.size), self.snaps)
        if pose is None:
            return
        poses = carried(held.poses, held.frame, pose)
        echo = drag_echo(held.frame, pose, len(poses))
        if held.drag is not None and held.typed:
            echo += "\n" + typed_echo(held.typed, held.drag.handle.kind == "rotate")
        scene.set_echo(echo, pixel)
        scene.preview(poses)
        scene.set_quick(True)
        self._view.drag_moved.emit(poses)
        self._changed()

    def _let_go(self, pixel: Pixel) -> None:
        """Drop the held sensor where it is; a click off the car places nothing."""
        held = self._held
        assert held is not None
        if held.drag is None and self._has(held.name):
            if self._scene.pose_on_body(pixel, self._scene.state.rig.sensor(held.name)) is None:
                return
            self._drag_to(pixel)
        self._release_held()
        self._view.drag_finished.emit()

    def _release_held(self) -> None:
        was_placing, self._held = self.is_placing, None
        self._scene.set_echo("")
        if was_placing:
            self._view.placing_changed.emit(False)

    def _has(self, name: str) -> bool:
        return any(sensor.name == name for sensor in self._scene.state.rig.sensors)

    def _hover(self, pixel: Pixel) -> None:
        sensor = self._scene.under_mouse.sensor(pixel)
        handle = None if self.tool == "measure" else self._scene.under_mouse.handle(pixel)
        is_changed = self._scene.set_hovered(handle or sensor)
        if self.tool == "measure" and self._scene.aim_at(pixel):
            self._scene.set_quick(True)
            is_changed = True
        if is_changed:
            self._changed()

    def _is_drag(self, pixel: Pixel) -> bool:
        """Return whether the mouse has left the place of a click."""
        far = max(abs(pixel[0] - self._pressed[0]), abs(pixel[1] - self._pressed[1]))
        self._moved = self._moved or far > _CLICK_PX * self._scene.pixel_ratio
        return self._moved

    def _move_camera(self, dx: float, dy: float) -> None:
        camera, size = self._scene.state.camera, self._scene.size
        if self._gesture == "pan":
            camera = camera.panned(dx, dy, size)
        elif self._gesture == "orbit":
            camera = camera.orbited(dx, dy, size)
        elif self._gesture == "zoom":
            camera = camera.zoomed(_ZOOM_PER_HEIGHT ** (dy / max(1, size[1])), self._pressed, size)
        else:
            return
        self._scene.set_camera(camera)
        self._scene.set_quick(True)
        self._changed()
