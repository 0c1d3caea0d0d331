"""Surfaces as VTK draws them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from riglens.core.vehicle.surface import Surface

Points = NDArray[np.float64]


def drawn(surface: Surface) -> pv.PolyData:
    """Return a surface with its normals, ready to be drawn."""
    faces = np.insert(surface.triangles, 0, 3, axis=1).ravel()
    mesh = pv.PolyData(surface.points.astype(np.float32), faces)
    set_normals(mesh, surface.normals)
    return mesh


def set_normals(mesh: pv.PolyData, normals: Points) -> None:
    """Give a mesh its point normals; always float32 and under one name, or joining meshes would drop them."""
    mesh.point_data["Normals"] = np.asarray(normals, dtype=np.float32)
    mesh.point_data.active_normals_name = "Normals"


def appended(meshes: Sequence[pv.PolyData]) -> pv.PolyData:
    """Return meshes as one, with the arrays that all of them have."""
    return meshes[0].append_polydata(*meshes[1:]) if len(meshes) > 1 else meshes[0]


def join(meshes: Sequence[pv.PolyData]) -> pv.PolyData:
    """Return all meshes as one, with their normals."""
    joined = appended([mesh for mesh in meshes if mesh.n_cells])
    joined.point_data.active_normals_name = "Normals"
    return joined
