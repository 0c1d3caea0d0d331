"""Paint keep-out zones on the car: whole materials, parts of the car in boxes, and spots of a brush."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonDataModel import vtkBox, vtkImplicitFunction, vtkSphere
from vtkmodules.vtkFiltersCore import vtkClipPolyData
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.rig.model import Spot, Vehicle
from riglens.widgets.car.keep_out import KeepOut, Zone
from riglens.widgets.car.layer import mesh_surface
from riglens.widgets.car.parts import Parts, drawn_parts
from riglens.widgets.drawing.actors import Material, hidden, surface_actor
from riglens.widgets.drawing.surface import join, set_normals

ZONE_COLOUR, SPOT_COLOUR = "#f5a524", "#f43f5e"
_OPACITY, _OFF_M = 0.62, 0.004


def skin_parts(vehicle: Vehicle) -> Parts:
    """Return the surfaces of a car by material; that of a mesh file has one without a name."""
    if vehicle.body_mesh is not None:
        return {"": mesh_surface(vehicle.body_mesh.placed(vehicle.mesh))}
    return drawn_parts(vehicle)


class _Skin:
    """The surfaces of a car, by material where it has any, and pieces cut out of them."""

    def __init__(self, vehicle: Vehicle) -> None:
        self.parts = skin_parts(vehicle)
        self.whole = join(list(self.parts.values()))
        self._faces = self.whole.triangulate().regular_faces
        corners = np.asarray(self.whole.points)[self._faces]
        self._low, self._high = corners.min(axis=1), corners.max(axis=1)

    def of(self, zone: Zone) -> list[pv.PolyData]:
        """Return the pieces of a zone; none of a material that the car does not have."""
        if not zone.boxes_m:
            return [mesh for name, mesh in self.parts.items() if name == zone.material]
        pieces = []
        for low, high in zone.boxes_m:
            box = vtkBox()
            box.SetBounds(low[0], high[0], low[1], high[1], low[2], high[2])
            whole = None if zone.material is None else self.parts.get(zone.material, pv.PolyData())
            pieces.append(
                _clipped(self._near(np.array(low), np.array(high)) if whole is None else whole, box)
            )
        return pieces

    def within(self, spot: Spot) -> pv.PolyData:
        """Return the part of the skin in the ball of a spot."""
        middle, radius_m = np.array(spot[:3]), spot[3]
        ball = vtkSphere()
        ball.SetCenter(*middle.tolist())
        ball.SetRadius(radius_m)
        return _clipped(self._near(middle - radius_m, middle + radius_m), ball)

    def _near(self, low: NDArray[np.float64], high: NDArray[np.float64]) -> pv.PolyData:
        """Return the triangles that may reach into a box."""
        near = ((self._low <= high) & (self._high >= low)).all(axis=1)
        if not near.any():
            return pv.PolyData()
        used, faces = np.unique(self._faces[near], return_inverse=True)
        mesh = pv.PolyData(
            np.asarray(self.whole.points)[used], np.insert(faces.reshape(-1, 3), 0, 3, axis=1).ravel()
        )
        set_normals(mesh, np.asarray(self.whole.point_data["Normals"])[used])
        return mesh


def _clipped(mesh: pv.PolyData, inside: vtkImplicitFunction) -> pv.PolyData:
    """Return the part of a surface inside of something, cut exactly."""
    if not mesh.n_cells:
        return pv.PolyData()
    cut = vtkClipPolyData()
    cut.SetInputData(mesh)
    cut.SetClipFunction(inside)
    cut.InsideOutOn()
    cut.Update()
    return pv.wrap(cut.GetOutput())


def _lifted(pieces: list[pv.PolyData]) -> pv.PolyData | None:
    """Return pieces as one surface slightly above the skin, so that they are visible; None if there are none."""
    full = [piece for piece in pieces if piece.n_cells]
    if not full:
        return None
    mesh = join(full).copy()
    normals = np.asarray(mesh.point_data["Normals"])
    mesh.points = np.asarray(mesh.points) + np.float32(_OFF_M) * normals
    return mesh


class KeepOutLayer:
    """Two tones over the car; only differences from the previous zones are cut, so that a brush costs one spot."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._actors = []
        for colour in (ZONE_COLOUR, SPOT_COLOUR):
            actor = surface_actor(pv.PolyData(), Material(colour, ambient=0.55, diffuse=0.45, specular=0.0))
            actor.prop.opacity = _OPACITY
            self._actors.append(hidden(renderer, actor))
        self._of: Vehicle | None = None
        self._skin: _Skin | None = None
        self._zones: tuple[Zone, ...] | None = None
        self._pieces: dict[Spot, pv.PolyData] = {}

    def show(self, vehicle: Vehicle, shown: KeepOut | None) -> None:
        """Paint zones on a car, or none; none on a car whose mesh is missing."""
        if shown is None or vehicle.lacks_mesh:
            for actor in self._actors:
                actor.visibility = False
            return
        if self._skin is None or self._of != vehicle:
            self._of, self._skin = vehicle, _Skin(vehicle)
            self._zones, self._pieces = None, {}
        if shown.zones != self._zones:
            self._zones = shown.zones
            self._show(0, [piece for zone in shown.zones for piece in self._skin.of(zone)])
        known, skin = self._pieces, self._skin
        self._pieces = {spot: known[spot] if spot in known else skin.within(spot) for spot in shown.spots}
        self._show(1, list(self._pieces.values()))
        self._actors[0].visibility = self._actors[0].mapper.GetInput().GetNumberOfCells() > 0

    def _show(self, place: int, pieces: list[pv.PolyData]) -> None:
        mesh = _lifted(pieces)
        self._actors[place].mapper.SetInputData(pv.PolyData() if mesh is None else mesh)
        self._actors[place].visibility = mesh is not None
