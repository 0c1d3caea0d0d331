"""The ego car in the scene: its surfaces with their materials, its soft shadow, and where a view ray meets it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.vtkCommonCore import mutable
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.rig.body_mesh import BodyMesh
from riglens.core.rig.model import Vehicle
from riglens.widgets.car.materials import Painted, car_materials, painted
from riglens.widgets.car.parts import drawn_parts
from riglens.widgets.car.stand_in import stand_in_parts
from riglens.widgets.drawing.actors import exchange, rgba_actor, surface_actor
from riglens.widgets.drawing.camera import OrbitCamera, Points, ViewRay
from riglens.widgets.drawing.surface import join, set_normals
from riglens.widgets.theme import Palette

_REACH_M = 500.0
_QUICK_TRIANGLES, _QUICK_CELLS = 25_000, 110


class BodyLayer:
    """The car; rebuilt when the vehicle or the palette changes."""

    def __init__(self, renderer: vtkRenderer, ground_renderer: vtkRenderer) -> None:
        self._renderer, self._ground_renderer = renderer, ground_renderer
        self._actors: list[pv.Actor] = []
        self._quick_actors: list[pv.Actor] = []
        self._shadows: list[pv.Actor] = []
        self._quick = False
        self._painted: list[Painted] = []
        self._mirrored: object = None
        self._is_dark = True
        self._solid = pv.PolyData()
        self._locator: vtkStaticCellLocator | None = None

    def set_vehicle(self, vehicle: Vehicle, palette: Palette) -> None:
        """Draw a vehicle, with the mesh of its file; where that is missing, a plain box replaces it."""
        body_mesh = vehicle.body_mesh
        if body_mesh is None:
            parts = stand_in_parts(vehicle) if vehicle.lacks_mesh else drawn_parts(vehicle)
            self._painted = painted(parts, vehicle, palette)
            actors = quick = [part.actor for part in self._painted]
            solid = join(list(parts.values()))
        else:
            self._painted = []
            placed = body_mesh.placed(vehicle.mesh)
            solid = mesh_surface(placed)
            actors = quick = [_mesh_actor(solid, palette)]
            if len(body_mesh.triangles) > _QUICK_TRIANGLES:
                quick = [_mesh_actor(mesh_surface(placed.coarse(_QUICK_CELLS)), palette)]
        self._exchange(actors, quick, rgba_actor(shadow_mesh(vehicle), "rgba"))
        self._solid, self._locator = solid, None
        self._mirrored, self._is_dark = None, palette.is_dark

    def _exchange(self, actors: list[pv.Actor], quick: list[pv.Actor], shadow: pv.Actor) -> None:
        exchange(
            self._renderer,
            dict.fromkeys([*self._actors, *self._quick_actors]),
            dict.fromkeys([*actors, *quick]),
        )
        exchange(self._ground_renderer, self._shadows, [shadow])
        self._actors, self._quick_actors, self._shadows = actors, quick, [shadow]
        self.set_quick(self._quick)

    def set_quick(self, quick: bool) -> None:
        """Show a car that is faster to draw while something moves: its light painted on, or fewer triangles."""
        self._quick = quick
        hidden, shown = (self._actors, self._quick_actors) if quick else (self._quick_actors, self._actors)
        for actor in hidden:
            actor.visibility = False
        for actor in shown:
            actor.visibility = True

    def arrange(self, camera: OrbitCamera) -> None:
        """Paint on what the car mirrors towards the viewer, unless something moves."""
        if self._quick or self._mirrored == camera:
            return
        self._mirrored = camera
        for part in self._painted:
            part.mirror(camera.position_m(), self._is_dark)

    def hit(self, ray: ViewRay) -> tuple[Points, Points] | None:
        """Return where a view ray first meets the car: point (3,) in metres and unit normal (3,) towards the viewer."""
        found = self._first(ray)
        if found is None:
            return None
        point, cell = found
        normal = _normal_at(self._solid, cell, point)
        return point, normal if float(normal @ ray.direction) <= 0.0 else -normal

    def point(self, ray: ViewRay) -> Points | None:
        """Return where a view ray first meets the car, (3,) metres."""
        found = self._first(ray)
        return None if found is None else found[0]

    def _first(self, ray: ViewRay) -> tuple[Points, int] | None:
        if self._locator is None:
            self._locator = vtkStaticCellLocator()
            self._locator.SetDataSet(self._solid)
            self._locator.BuildLocator()
        share: Any = mutable(0.0)
        sub: Any = mutable(0)
        cell: Any = mutable(0)
        point, inside = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
        start, end = ray.origin_m.tolist(), (ray.origin_m + _REACH_M * ray.direction).tolist()
        if not self._locator.IntersectWithLine(start, end, 1e-6, share, point, inside, sub, cell):
            return None
        return np.array(point), int(cell)


def _normal_at(mesh: pv.PolyData, cell: int, point: Points) -> Points:
    """Return the smooth normal of a cell at a point: those of its corners, nearer corners counting more."""
    corners = mesh.get_cell(cell)
    distance = np.linalg.norm(np.asarray(corners.points) - point, axis=1)
    weight = 1.0 / np.maximum(distance, 1e-9)
    normal = weight @ np.asarray(mesh.point_data["Normals"], dtype=np.float64)[corners.point_ids]
    length = float(np.linalg.norm(normal))
    if length < 1e-9 * float(weight.sum()):
        first, second, third = np.asarray(corners.points)[:3]
        normal = np.cross(second - first, third - first)
        length = max(1e-12, float(np.linalg.norm(normal)))
    return np.asarray(normal / length)


def mesh_surface(mesh: BodyMesh) -> pv.PolyData:
    """Return a mesh as a surface with normals and, where the file has colours, an `rgb` array."""
    faces = np.insert(mesh.triangles.astype(np.int64), 0, 3, axis=1).ravel()
    surface = pv.PolyData(mesh.points, faces)
    set_normals(surface, mesh.normals.astype(np.float64))
    if mesh.colours is not None:
        surface["rgb"] = mesh.colours
    return surface


def _mesh_actor(surface: pv.PolyData, palette: Palette) -> pv.Actor:
    return surface_actor(
        surface, car_materials(palette)["paint"], "rgb" if "rgb" in surface.point_data else ""
    )


def shadow_mesh(vehicle: Vehicle) -> pv.PolyData:
    """Return a dark patch under the car that fades outwards, with an `rgba` point array."""
    x, y = np.meshgrid(np.linspace(-1.25, 1.25, 41), np.linspace(-1.45, 1.45, 33), indexing="ij")
    points = np.stack([x * vehicle.length / 2, y * vehicle.width / 2, np.full_like(x, 0.004)], axis=-1)
    outside = np.hypot(np.maximum(np.abs(x) - 0.82, 0.0) / 0.40, np.maximum(np.abs(y) - 0.72, 0.0) / 0.62)
    alpha = 0.62 * np.clip(1.0 - outside, 0.0, 1.0) ** 1.6
    index = np.arange(x.size).reshape(x.shape)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    mesh = pv.PolyData(points.reshape(-1, 3), np.insert(quads, 0, 4, axis=1).ravel())
    rgba = np.zeros((x.size, 4), dtype=np.uint8)
    rgba[:, 3] = (255 * alpha).ravel()
    mesh["rgba"] = rgba
    return mesh
