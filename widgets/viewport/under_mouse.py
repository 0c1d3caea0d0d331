"""Find what is under a pixel of a scene: a handle of the gizmo, a sensor, a cell. No Qt, no VTK."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from riglens.core.rig.edits import partner_of
from riglens.widgets.drawing.camera import Pixel, Size
from riglens.widgets.gizmo.drag import Handle
from riglens.widgets.gizmo.handles import GizmoPlace, hit_handle, place_gizmo
from riglens.widgets.heatmap.pick import PickedCell, cell_at
from riglens.widgets.sensors.bodies import PICK_RADIUS_M
from riglens.widgets.viewport.scene_state import SceneState

_PICK_PX = 9.0


@dataclass(frozen=True)
class UnderMouse:
    """State as drawn in a picture of a size, to find what is under a pixel."""

    state: SceneState
    size: Size
    pixel_ratio: float

    def gizmo(self) -> GizmoPlace | None:
        """Return the place of the gizmo; None when no visible sensor is selected, or one that cannot be dragged."""
        state, pose = self.state, self.state.gizmo_pose
        if pose is None:
            return None
        return place_gizmo(pose, state.gizmo_space, state.camera, self.size, self.pixel_ratio)

    def handle(self, pixel: Pixel) -> Handle | None:
        """Return the gizmo handle under a pixel."""
        place, state = self.gizmo(), self.state
        if place is None:
            return None
        return hit_handle(pixel, state.gizmo_mode, place, state.camera, self.size, self.pixel_ratio)

    def sensor(self, pixel: Pixel) -> str | None:
        """Return the sensor under a pixel, the nearest to the viewer if there are several."""
        sensors, camera = self.state.shown, self.state.camera
        if not sensors:
            return None
        places = np.array([sensor.position for sensor in sensors])
        seen = camera.project(places, self.size)
        radius = [PICK_RADIUS_M / camera.metres_per_pixel(place, self.size) for place in places]
        reach = np.maximum(_PICK_PX * self.pixel_ratio, radius)
        hit = np.flatnonzero((np.linalg.norm(seen[:, :2] - pixel, axis=1) <= reach) & (seen[:, 2] > 0.0))
        return sensors[hit[np.argmin(seen[hit, 2])]].name if len(hit) else None

    def words(self, pixel: Pixel) -> str:
        """Describe the sensor under a pixel: its name, and the one it is linked to; empty off all sensors."""
        name = self.sensor(pixel)
        if name is None:
            return ""
        other = partner_of(self.state.rig, name)
        return name if other is None else f"{name}\nMirror pair with {other}: both move together"

    def inside(self, corner: Pixel, other: Pixel) -> tuple[str, ...]:
        """Return the sensors whose middle is drawn inside the box between two pixels, in the order of the rig."""
        sensors = self.state.shown
        if not sensors:
            return ()
        low, high = np.minimum(corner, other), np.maximum(corner, other)
        seen = self.state.camera.project(np.array([sensor.position for sensor in sensors]), self.size)
        is_in = ((seen[:, :2] >= low) & (seen[:, :2] <= high)).all(axis=1) & (seen[:, 2] > 0.0)
        return tuple(sensor.name for sensor, found in zip(sensors, is_in, strict=True) if found)

    def cell(self, pixel: Pixel) -> PickedCell | None:
        """Return the cell of the heatmap under a pixel, the nearest of those that are drawn."""
        state = self.state
        if state.heatmap is None:
            return None
        return cell_at(state.heatmap, state.heat_look, state.camera, self.size, pixel)
