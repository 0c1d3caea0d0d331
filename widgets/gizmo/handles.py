"""The gizmo that is seen and grasped: three arrows, planes and rings of constant size on the screen.

The hit test works on projected outlines in pixels, not on a pick in the scene: it is quick, forgiving and
the same for every backend. The actors live in a renderer of their own, drawn over everything else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonDataModel import vtkPlane
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.geometry import Pose
from riglens.widgets.drawing.actors import mapper_of
from riglens.widgets.drawing.camera import OrbitCamera, Points, Size
from riglens.widgets.gizmo.drag import (
    MOVE_HANDLES,
    PLANE_HANDLES,
    ROTATE_HANDLES,
    GizmoMode,
    Handle,
    Space,
    gizmo_axes,
    pose_matrix,
)
from riglens.widgets.theme import Palette, mix

SIZE_PX = 96.0
RING_RADIUS = 0.74
_ARROW_FROM, _ARROW_TO = 0.14, 1.0
_PLANE_FROM, _PLANE_TO = 0.24, 0.46
_PLANE_FLAT = 0.12
_GRASP_PX, _PLANE_GRASP_PX = 8.0, 5.0
_BACK_SHARE = 0.05
_SQUARE = (
    (_PLANE_FROM, _PLANE_FROM),
    (_PLANE_TO, _PLANE_FROM),
    (_PLANE_TO, _PLANE_TO),
    (_PLANE_FROM, _PLANE_TO),
    (_PLANE_FROM, _PLANE_FROM),
)


@dataclass(frozen=True)
class GizmoPlace:
    """Place and size of the gizmo: the sensor's pose, axes (3, 3) as columns, an arrow's length (m)."""

    pose: Pose
    axes: NDArray[np.float64]
    size_m: float

    @property
    def ring_radius_m(self) -> float:
        """Radius of the rings, metres."""
        return RING_RADIUS * self.size_m


def place_gizmo(
    pose: Pose, space: Space, camera: OrbitCamera, size: Size, pixel_ratio: float = 1.0
) -> GizmoPlace:
    """Return the gizmo of a sensor, always the same size on the screen."""
    metres = camera.metres_per_pixel(np.array(pose.position_m), size) * SIZE_PX * pixel_ratio
    return GizmoPlace(pose, gizmo_axes(pose, space), metres)


def shown_handles(mode: GizmoMode) -> tuple[Handle, ...]:
    """Return the handles of a gizmo mode."""
    moving = MOVE_HANDLES + PLANE_HANDLES
    return {"move": moving, "rotate": ROTATE_HANDLES, "both": moving + ROTATE_HANDLES}[mode]


def handle_polyline(handle: Handle, place: GizmoPlace, camera: OrbitCamera) -> Points:
    """Return the line (n, 3) in metres by which a handle is grasped; of a ring the half that faces the viewer.

    Of a plane it is the outline of its square; NaN when the plane is seen edge on.
    """
    origin = np.array(place.pose.position_m)
    if handle.kind == "plane":
        if is_flat(handle, place, camera):
            return np.full((5, 3), np.nan)
        axes = facing_axes(place, camera)
        first, second = axes[:, (handle.axis + 1) % 3], axes[:, (handle.axis + 2) % 3]
        corners = np.array(_SQUARE) @ np.stack([first, second])
        return np.asarray(origin + place.size_m * corners)
    if handle.kind == "move":
        ends = np.array([_ARROW_FROM, _ARROW_TO])
        return np.asarray(origin + place.size_m * ends[:, None] * place.axes[:, handle.axis])
    angle = np.linspace(0.0, 2.0 * np.pi, 73)
    first, second = place.axes[:, (handle.axis + 1) % 3], place.axes[:, (handle.axis + 2) % 3]
    ring = place.ring_radius_m * (np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second)
    front = ring @ -_view_direction(place, camera) > -_BACK_SHARE * place.size_m
    return np.asarray(origin + np.where(front[:, None], ring, np.nan))


def is_flat(handle: Handle, place: GizmoPlace, camera: OrbitCamera) -> bool:
    """Return whether a plane handle is seen so nearly edge on that it cannot be dragged."""
    return abs(float(place.axes[:, handle.axis] @ _view_direction(place, camera))) < _PLANE_FLAT


def facing_axes(place: GizmoPlace, camera: OrbitCamera) -> Points:
    """Return the gizmo's axes (3, 3), each reversed if it points away, so that the planes face the viewer."""
    away = _view_direction(place, camera) @ place.axes
    return np.asarray(place.axes * np.where(away > 0.0, -1.0, 1.0))


def _view_direction(place: GizmoPlace, camera: OrbitCamera) -> Points:
    """Return the unit vector from the viewer to the gizmo, (3,)."""
    if camera.parallel:
        return camera.axes()[2]
    offset = np.array(place.pose.position_m) - camera.position_m()
    return np.asarray(offset / max(1e-9, float(np.linalg.norm(offset))))


def hit_handle(
    pixel: tuple[float, float],
    mode: GizmoMode,
    place: GizmoPlace,
    camera: OrbitCamera,
    size: Size,
    pixel_ratio: float = 1.0,
) -> Handle | None:
    """Return the handle under a pixel, or None; the nearest line wins, inside a plane's square the plane."""
    best, best_px = None, _GRASP_PX * pixel_ratio
    for handle in shown_handles(mode):
        line = camera.project(handle_polyline(handle, place, camera), size)
        if np.isnan(line).all() or np.nanmin(line[:, 2]) <= 0.0:
            continue
        if handle.kind == "plane":
            distance = _PLANE_GRASP_PX * pixel_ratio if _is_inside(np.array(pixel), line[:4, :2]) else np.inf
        else:
            distance = _distance_px(np.array(pixel), line[:, :2])
        if distance < best_px:
            best, best_px = handle, distance
    return best


def _distance_px(pixel: Points, line: Points) -> float:
    """Return the distance from a pixel to a polyline (n, 2); parts with NaN do not count."""
    start, edge = line[:-1], np.diff(line, axis=0)
    whole = ~np.isnan(edge).any(axis=1) & ~np.isnan(start).any(axis=1)
    start, edge = start[whole], edge[whole]
    if not len(start):
        return np.inf
    length = np.maximum((edge * edge).sum(axis=1), 1e-12)
    along = np.clip(((pixel - start) * edge).sum(axis=1) / length, 0.0, 1.0)
    return float(np.linalg.norm(pixel - start - along[:, None] * edge, axis=1).min())


def _is_inside(pixel: Points, corners: Points) -> bool:
    """Return whether a pixel lies in a convex polygon (n, 2), corners in either order."""
    edges, offsets = np.roll(corners, -1, axis=0) - corners, pixel - corners
    turn = edges[:, 0] * offsets[:, 1] - edges[:, 1] * offsets[:, 0]
    return bool((turn >= 0.0).all() or (turn <= 0.0).all())


class GizmoActors:
    """Arrows, planes and rings in an overlay renderer; shown, placed and highlighted by the scene.

    They are created when first shown, which is when a sensor is selected.
    """

    def __init__(self, renderer: vtkRenderer, palette: Palette) -> None:
        self._renderer = renderer
        self._palette = palette
        self._plane = vtkPlane()
        self._actors: dict[Handle, pv.Actor] = {}
        self._shown: tuple[object, ...] = ()

    def _make(self) -> None:
        for handle in shown_handles("both"):
            actor = pv.Actor(mapper=mapper_of(_handle_mesh(handle)))
            actor.prop.lighting = handle.kind == "move"
            actor.prop.ambient, actor.prop.diffuse = 0.55, 0.45
            if handle.kind == "plane":
                actor.prop.opacity, actor.prop.show_edges, actor.prop.line_width = 0.6, True, 1.5
            actor.visibility = False
            if handle.kind == "rotate":
                actor.mapper.AddClippingPlane(self._plane)
            self._renderer.AddActor(actor)
            self._actors[handle] = actor

    def arrange(
        self, place: GizmoPlace | None, mode: GizmoMode, camera: OrbitCamera, lit: Handle | None
    ) -> None:
        """Show the handles of a mode at a place, or none; `lit` is under the mouse or being dragged."""
        if place is not None:
            if not self._actors:
                self._make()
            shown = (place.pose, place.axes.tobytes(), place.size_m, mode, camera, lit, self._palette)
            if shown != self._shown:
                self._shown = shown
                self._show(mode, place, camera, lit)
            return
        self._shown = ()
        for actor in self._actors.values():
            actor.visibility = False

    def _show(self, mode: GizmoMode, place: GizmoPlace, camera: OrbitCamera, lit: Handle | None) -> None:
        matrix = pose_matrix(place.pose.position_m, place.axes, place.size_m)
        facing = pose_matrix(place.pose.position_m, facing_axes(place, camera), place.size_m)
        towards = -_view_direction(place, camera)
        self._plane.SetNormal(*towards)
        self._plane.SetOrigin(*(np.array(place.pose.position_m) - towards * _BACK_SHARE * place.size_m))
        shown = shown_handles(mode)
        for handle, actor in self._actors.items():
            is_plane = handle.kind == "plane"
            actor.visibility = handle in shown and not (is_plane and is_flat(handle, place, camera))
            actor.user_matrix = facing if is_plane else matrix
            colour = self._palette.axes[handle.axis]
            colour = mix(self._palette.selected, "#ffffff", 0.25) if handle == lit else colour
            actor.prop.color = actor.prop.edge_color = colour

    def set_palette(self, palette: Palette) -> None:
        """Change the colours; takes effect at the next `arrange`."""
        self._palette = palette


def _handle_mesh(handle: Handle) -> pv.PolyData:
    """Return a handle of unit size about the origin: an arrow with a cone, a small square, or a thin ring."""
    direction = np.eye(3)[handle.axis]
    if handle.kind == "plane":
        first, second = np.eye(3)[(handle.axis + 1) % 3], np.eye(3)[(handle.axis + 2) % 3]
        return pv.PolyData(np.array(_SQUARE)[:4] @ np.stack([first, second]), [4, 0, 1, 2, 3])
    if handle.kind == "rotate":
        angle = np.linspace(0.0, 2.0 * np.pi, 97)
        first, second = np.eye(3)[(handle.axis + 1) % 3], np.eye(3)[(handle.axis + 2) % 3]
        circle = RING_RADIUS * (np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second)
        ring: pv.PolyData = pv.Spline(circle, 97).tube(radius=0.013, n_sides=8)
        return ring
    shaft = pv.Cylinder(
        center=direction * 0.46, direction=direction, radius=0.016, height=0.64, resolution=12
    )
    cone = pv.Cone(center=direction * 0.89, direction=direction, height=0.22, radius=0.062, resolution=24)
    arrow: pv.PolyData = shaft.append_polydata(cone)
    return arrow
