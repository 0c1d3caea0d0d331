"""What the window asks of a viewport, on the screen or offscreen."""

from __future__ import annotations

from typing import Any, Protocol

from riglens.core.rig.model import Vehicle
from riglens.core.vehicle.mesh import BodyMesh
from riglens.widgets.theme import Palette
from riglens.widgets.viewport.camera import OrbitCamera
from riglens.widgets.viewport.scene_state import ShownRig


class ViewportWidget(Protocol):
    """The methods and signals that features may use; the widget itself is a QWidget."""

    sensor_picked: Any
    drag_started: Any
    drag_moved: Any
    drag_finished: Any
    drag_cancelled: Any
    cell_picked: Any
    escaped: Any
    nudged: Any
    placing_changed: Any
    model_dropped: Any
    shown: Any

    def set_rig(self, shown: ShownRig) -> None:
        """Show the sensors of a rig."""

    def set_heatmap(self, data: Any) -> None:
        """Show a heatmap, None for none."""

    def set_heat_look(self, look: Any) -> None:
        """Draw the heatmap in another way."""

    def set_ray_look(self, look: Any) -> None:
        """Draw the rays in another way."""

    def set_picking(self, is_on: bool) -> None:
        """Have every left click pick a cell of the heatmap."""

    def set_marker(self, marker: Any) -> None:
        """Point out a voxel, None for none."""

    def set_grid(self, grid: Any) -> None:
        """Show another region of interest."""

    def set_gizmo(self, mode: Any, space: Any) -> None:
        """Choose the handles and whose axes they follow."""

    def set_view(self, name: str) -> None:
        """Look from a named side."""

    def frame_sensor(self, name: str) -> None:
        """Look at one sensor from near by."""

    def look_at(self, x_m: float, y_m: float) -> None:
        """Bring a spot on the ground into the middle of the view."""

    def set_vehicle(self, vehicle: Vehicle, mesh: BodyMesh | None = None) -> None:
        """Draw another car, from the mesh of its file if it has one; InputError for an unknown body."""

    def set_snap(self, snap: bool) -> None:
        """Have drags end on round numbers."""

    def begin_placing(self) -> bool:
        """Have the selected sensor follow the mouse over the car; False when none is selected and seen."""

    def set_palette(self, palette: Palette) -> None:
        """Follow a light or dark window."""

    def chosen_camera(self) -> OrbitCamera | None:
        """Where somebody looks from; None while it is the first view."""

    def set_camera(self, camera: OrbitCamera) -> None:
        """Look from there."""

    def cancel_drag(self) -> bool:
        """Give up the drag in progress; False when there is none."""

    @property
    def scene_state(self) -> Any:
        """What is shown, to make pictures of it elsewhere."""

    @property
    def picture_size(self) -> tuple[int, int]:
        """Width and height of the view in logical pixels."""

    def close_viewport(self) -> None:
        """Give back what Qt does not: VTK's window and observers."""
