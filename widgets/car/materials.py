"""Materials of the car, and the same with the light painted on, used while something moves.

One painted surface costs a third of the shaded ones. The lights do not move, so everything but the highlights is worked
out once. Faces that look away are left out.
"""

from __future__ import annotations

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from riglens.widgets.car.parts import Parts
from riglens.widgets.drawing.actors import Material, rgba_actor, surface_colours
from riglens.widgets.drawing.lights import light_on
from riglens.widgets.drawing.surface import appended
from riglens.widgets.theme import Palette, mix


def car_materials(palette: Palette) -> dict[str, Material]:
    """Return the materials of a car body by name, with the palette's paint."""
    return {
        "paint": Material(palette.paint, 0.26, 0.74, 0.35, 45.0),
        "panel": Material(mix(palette.paint, "#ffffff", 0.5), 0.30, 0.70, 0.15, 25.0),
        "glass": Material("#10161d", 0.45, 0.55, 0.6, 60.0, sky="#415669"),
        "trim": Material("#1d2126", 0.25, 0.75, 0.15, 15.0),
        "gap": Material("#2a2f36", 0.4, 0.6, 0.0),
        "lamp": Material("#f4f8ff", 0.6, 0.4, 0.8, 50.0),
        "tail": Material("#c4122b", 0.45, 0.55, 0.5, 40.0),
        "plate": Material("#eceee9", 0.45, 0.55),
        "tyre": Material("#1b1c1f", 0.25, 0.75, 0.08, 8.0),
        "rim": Material("#b7bec6", 0.25, 0.75, 0.5, 20.0),
        "dark": Material("#0c0d0f", 0.3, 0.7, 0.0),
    }


_SEEN_INSIDE = "dark"
"""The wheel housings, which are open: they are drawn from both sides."""


def baked_actors(parts: Parts, palette: Palette) -> list[pv.Actor]:
    """Return unlit actors that show the parts as the lights would, without highlights."""
    materials = car_materials(palette)
    baked = {name: baked_mesh(mesh, materials[name]) for name, mesh in parts.items()}
    inside = baked.pop(_SEEN_INSIDE, None)
    outside = rgba_actor(appended(list(baked.values())), "rgb")
    outside.prop.culling = "back"
    return [outside] if inside is None else [outside, rgba_actor(inside, "rgb")]


def baked_mesh(mesh: pv.PolyData, material: Material) -> pv.PolyData:
    """Return the surface as triangles that face along its normals, with an `rgb` point array of colour times light."""
    normals = np.asarray(mesh.point_data["Normals"])
    triangles = _outward(mesh.points, normals, mesh.triangulate().regular_faces)
    baked = pv.PolyData(mesh.points, np.insert(triangles, 0, 3, axis=1).ravel())
    light = material.ambient + material.diffuse * light_on(normals)
    colours = surface_colours(mesh, material) * light[:, None]
    baked["rgb"] = np.asarray(255.0 * np.clip(colours, 0.0, 1.0), dtype=np.uint8)
    return baked


def _outward(
    points: NDArray[np.float32], normals: NDArray[np.float32], triangles: NDArray[np.int_]
) -> NDArray[np.int_]:
    """Return the triangles (m, 3), reversed where their corners run the wrong way about their normals."""
    a, b, c = (np.asarray(points, dtype=np.float64)[triangles[:, corner]] for corner in range(3))
    wrong = (np.cross(b - a, c - a) * normals[triangles].sum(axis=1)).sum(axis=1) < 0.0
    turned = np.array(triangles)
    turned[wrong] = turned[wrong][:, ::-1]
    return turned
