"""Colour the car's skin by values at spots on it, each place by the nearest spot."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.rig.model import Vehicle
from riglens.core.view.heatmap_data import HeatmapData, Values
from riglens.widgets.car.layer import mesh_surface
from riglens.widgets.car.parts import Parts, drawn_parts
from riglens.widgets.drawing.actors import Material, hidden, surface_actor
from riglens.widgets.drawing.surface import join, set_normals
from riglens.widgets.heatmap.scale import colour_rows, colours

REACH_M = 0.16
"""A place farther than this from every spot keeps the colour of the car."""
SKIN = ("", "paint", "panel", "trim")
"""Materials that are coloured; a mesh has one without a name."""
_OFF_M = 0.003


class GainLayer:
    """One surface over the car; other values at the same spots change its colours alone."""

    def __init__(self, renderer: vtkRenderer) -> None:
        actor = surface_actor(pv.PolyData(), Material("#ffffff", 0.6, 0.4, 0.0), "gain")
        self._actor = hidden(renderer, actor)
        self._made: tuple[Vehicle, Values] | None = None
        self.mesh = pv.PolyData()
        self._nearest: NDArray[np.int64] = np.zeros(0, np.int64)

    def show(self, vehicle: Vehicle, data: HeatmapData | None) -> None:
        """Show the values of spots, NaN for none; nothing without data, or on a car whose mesh is missing."""
        self._actor.visibility = data is not None and not vehicle.lacks_mesh
        if data is None or vehicle.lacks_mesh:
            return
        if self._made is None or self._made[0] != vehicle or self._made[1] is not data.centres_m:
            self._made = vehicle, data.centres_m
            self.mesh, self._nearest = _near_skin(vehicle, data.centres_m)
        if not self._nearest.size:  # spots of a car of another size
            self._actor.visibility = False
            return
        values = np.nan_to_num(data.values)[self._nearest]
        rows = colour_rows(data.scale, values, values, data.vmax)
        shown = np.empty((len(rows), 4), np.uint8)
        shown[:, :3] = colours(data.scale)[rows]
        shown[:, 3] = np.where(np.isnan(data.values)[self._nearest], 0, 255)
        self.mesh["gain"] = shown
        self._actor.mapper.SetInputData(self.mesh)


def _skin_parts(vehicle: Vehicle) -> Parts:
    """Return the surfaces of a car by material; that of a mesh file has one without a name."""
    if vehicle.body_mesh is not None:
        return {"": mesh_surface(vehicle.body_mesh.placed(vehicle.mesh))}
    return drawn_parts(vehicle)


def _near_skin(vehicle: Vehicle, spots_m: Values) -> tuple[pv.PolyData, NDArray[np.int64]]:
    """Return the skin near spots, a little off the car, and the number of the nearest spot of each of its points."""
    from scipy.spatial import cKDTree  # slow to load

    parts = _skin_parts(vehicle)
    skin = join([mesh for name, mesh in parts.items() if name in SKIN])
    points = np.asarray(skin.points)
    away, nearest = map(np.asarray, cKDTree(spots_m).query(points, distance_upper_bound=REACH_M))
    faces = skin.triangulate().regular_faces
    faces = faces[np.isfinite(away)[faces].all(axis=1)]
    used, corners = np.unique(faces, return_inverse=True)
    if not used.size:
        return pv.PolyData(), np.zeros(0, np.int64)
    normals = np.asarray(skin.point_data["Normals"])[used]
    mesh = pv.PolyData(
        points[used] + np.float32(_OFF_M) * normals, np.insert(corners.reshape(-1, 3), 0, 3, axis=1).ravel()
    )
    set_normals(mesh, normals)
    return mesh, nearest[used].astype(np.int64)
