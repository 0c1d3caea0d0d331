"""The sensors of a rig in the scene: their bodies, and the rays of those that are switched on."""

from __future__ import annotations

from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.geometry import Pose
from riglens.core.rig.model import Camera, Lidar
from riglens.widgets.gizmo.drag import Handle
from riglens.widgets.sensors.bodies import Mark, SensorLayer
from riglens.widgets.sensors.rays import RaysLayer
from riglens.widgets.theme import Palette
from riglens.widgets.viewport.scene_state import SceneState


class RigLayer:
    """Bodies and fans of all sensors that are not hidden; the selected one has the dense fan."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._sensors, self._rays = SensorLayer(renderer), RaysLayer(renderer)

    def set_line_width(self, width_px: float) -> None:
        """Width of the rays, for pictures of higher resolution."""
        self._rays.set_line_width(width_px)

    def show_bodies(self, state: SceneState, hovered: str | Handle | None) -> None:
        """Draw exactly the sensors of a state; the one under the mouse stands out."""
        marks: dict[str, Mark] = {hovered: "hovered"} if isinstance(hovered, str) else {}
        marks.update({sensor.name: "selected" for sensor in state.shown if state.is_selected(sensor.name)})
        self._sensors.set_sensors(state.shown, marks, state.palette)

    def show_fans(self, state: SceneState, quick: bool, others: bool = True) -> None:
        """Rebuild the rays, fewer while something moves; those of sensors that are not selected only with `others`."""
        casting, look = state.casting, state.ray_look
        selected = next((sensor for sensor in casting if sensor.name == state.selected), None)
        self._rays.set_selected(selected, state.grid, state.palette, look.of_selected(quick))
        if others:
            rest = [sensor for sensor in casting if sensor is not selected]
            self._rays.set_others(rest, state.grid, state.palette, look.of_others(len(rest), quick))

    def set_pose(self, name: str, pose: Pose) -> None:
        """Move the body of a shown sensor."""
        self._sensors.set_pose(name, pose)

    def set_ghost(self, sensor: Lidar | Camera | None, palette: Palette) -> None:
        """Show where a sensor that is not in the rig would be placed, or None."""
        self._sensors.set_ghost(sensor, palette)
