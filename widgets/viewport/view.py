"""3D view as the window sees it: its content is one frozen state, the user's actions in it are signals."""

from __future__ import annotations

from abc import abstractmethod
from typing import Literal

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.viewport.scene_state import SceneState

Tool = Literal["pick", "measure"]
"""Use of the left button in place of selecting and dragging sensors.

pick: a click picks a cell of the heatmap, as one with Alt always does. measure: clicks choose places to measure
between, and drags still turn the view.
"""


class View(QWidget):
    """A 3D view. Change what it shows with `view.show_state(replace(view.state, heatmap=data))`.

    `state` also holds what people changed in the view itself (the camera, the pose in the middle of a drag), so a
    state made from it by `replace` undoes none of that. The method is not called `show`: that is QWidget's, and
    makes the widget visible.

    This class is abstract although it has no ABCMeta, which Qt's own metaclass rules out.
    """

    sensor_picked = Signal(object)
    """A click chose a sensor: its name, or None for a click on nothing."""
    sensor_toggled = Signal(str)
    """Request by Ctrl- or Shift-click to select one more sensor, or to deselect one: its name."""
    sensors_boxed = Signal(object, bool)
    """A box was drawn around these sensors, a tuple of names: select them too, or (True) no longer."""
    menu_wanted = Signal(object, object)
    """Request for a menu by a right click: the name of the sensor there or None, and the QPoint on screen."""
    drag_started = Signal(object)
    """A handle of these sensors was grasped, or a sensor is being placed: a tuple of names."""
    drag_moved = Signal(object)
    """Sensors were dragged: a dict of their names and Poses, which `state` shows already."""
    drag_finished = Signal()
    """The handle was let go: the sensors stay where they are."""
    drag_cancelled = Signal()
    """The drag was given up: `state` has the sensors where they were before."""
    nudged = Signal(object)
    """Request by a key to move sensors: a dict of their names and new Poses, which are not shown yet."""
    placing_changed = Signal(bool)
    """The selected sensor follows the mouse over the car, or no longer does."""
    model_dropped = Signal(str, object)
    """A model of the sensor library was dropped on the car: its name and the Pose there."""
    cell_picked = Signal(object)
    """The PickedCell of the heatmap that was clicked, None if no cell is drawn."""
    place_picked = Signal(object)
    """The Place that was clicked while measuring, None if nothing can be measured."""
    escaped = Signal()
    """Escape was pressed in the view while nothing was being dragged."""
    drawn = Signal()
    """A frame was drawn."""
    footprints_lacking = Signal()
    """Some footprints in a frame at rest are coarse or left out: request for `update_footprints`."""
    shown = Signal()
    """A picture is on the screen."""

    @property
    @abstractmethod
    def state(self) -> SceneState:
        """Return the state that is shown."""

    @abstractmethod
    def show_state(self, state: SceneState) -> None:
        """Show a state; only differences from the current one are updated, and drawn soon."""

    @abstractmethod
    def update_footprints(self) -> None:
        """Show footprints that have been found since the state was shown."""

    @property
    @abstractmethod
    def picture_size(self) -> tuple[int, int]:
        """Width and height of the view in logical pixels."""

    @abstractmethod
    def show_inset(self, is_on: bool) -> None:
        """Show the picture of a selected camera in a corner, or not."""

    @abstractmethod
    def chosen_camera(self) -> OrbitCamera | None:
        """Return the camera that the user chose; None while the first view is fitted to the size of the widget."""

    @abstractmethod
    def set_view(self, name: str, wide: bool = False) -> None:
        """Look from "iso", "top", "front", "left", "rear" or "right"; `wide` shows the whole ROI in the iso view.

        Raises InputError for another name.
        """

    @abstractmethod
    def frame_sensors(self, names: tuple[str, ...]) -> None:
        """Look at these sensors from close by; without names, at the car with all the sensors shown."""

    @abstractmethod
    def look_at(self, x_m: float, y_m: float) -> None:
        """Turn the view to a point on the ground; keep the distance."""

    @abstractmethod
    def set_tool(self, tool: Tool, is_on: bool) -> None:
        """Take a tool in hand, or put it away if it is: then clicks select sensors again."""

    @abstractmethod
    def begin_placing(self) -> bool:
        """Make the selected sensor follow the mouse over the car until a click; False when none is selected."""

    @abstractmethod
    def cancel_drag(self) -> bool:
        """Give up the drag or the placing in progress; False when there is none."""

    @abstractmethod
    def close_viewport(self) -> None:
        """Stop all timers and release the graphics; the view draws no more."""
