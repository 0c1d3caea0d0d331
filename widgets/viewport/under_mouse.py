"""What is under a pixel of a scene: a handle of the gizmo, a sensor, a cell. No Qt, no VTK."""

from __future__ import annotations

import numpy as np

from widgets.gizmo.drag import Handle
from widgets.gizmo.handles import GizmoPlace, hit_handle, place_gizmo
from widgets.viewport.camera import Size
from widgets.viewport.heat_pick import PickedCell, cell_at
from widgets.viewport.listener import Pixel
from widgets.viewport.scene_state import SceneState
from widgets.viewport.sensor_shapes import PICK_RADIUS_M

_PICK_PX = 9.0


def gizmo_of(state: SceneState, size: Size, pixel_ratio: float) -> GizmoPlace | None:
    """Where the gizmo is; None when no visible sensor is selected, or one that cannot be dragged."""
    sensor = state.selected_sensor
    if not state.show_gizmo or sensor is None or sensor.name in state.fixed:
        return None
    return place_gizmo(sensor.pose, state.gizmo_space, state.camera, size, pixel_ratio)


def handle_under(pixel: Pixel, state: SceneState, size: Size, pixel_ratio: float) -> Handle | None:
    """The gizmo handle under a pixel."""
    place = gizmo_of(state, size, pixel_ratio)
    if place is None:
        return None
    return hit_handle(pixel, state.gizmo_mode, place, state.camera, size, pixel_ratio)


def sensor_under(pixel: Pixel, state: SceneState, size: Size, pixel_ratio: float) -> str | None:
    """The sensor under a pixel; of several the one nearest to the viewer."""
    sensors, camera = state.shown, state.camera
    if not sensors:
        return None
    places = np.array([sensor.position for sensor in sensors])
    seen = camera.project(places, size)
    radius = [PICK_RADIUS_M / camera.metres_per_pixel(place, size) for place in places]
    reach = np.maximum(_PICK_PX * pixel_ratio, radius)
    hit = np.flatnonzero((np.linalg.norm(seen[:, :2] - pixel, axis=1) <= reach) & (seen[:, 2] > 0.0))
    return sensors[hit[np.argmin(seen[hit, 2])]].name if len(hit) else None


def cell_under(pixel: Pixel, state: SceneState, size: Size) -> PickedCell | None:
    """The cell of the heatmap under a pixel, the nearest of those that are drawn."""
    if state.heatmap is None:
        return None
    return cell_at(state.heatmap, state.heat_look, state.camera, size, pixel)
