"""Materials of the car with light and reflections painted on: a frame costs one unlit surface, with any driver.

The lights do not move, so what a surface scatters is worked out once. What it mirrors - a sky, the floor, soft boxes
above and beside - depends on the eye and is painted on again when the view comes to rest. Faces that look away are left
out, but for glass and for what is seen through it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from riglens.core.rig.model import Vehicle
from riglens.widgets.car.parts import Parts
from riglens.widgets.drawing.actors import Material, numpy_of, rgba_actor
from riglens.widgets.drawing.lights import light_on
from riglens.widgets.drawing.surface import appended
from riglens.widgets.theme import Palette, mix, rgb

Points = NDArray[np.float64]


def car_materials(palette: Palette) -> dict[str, Material]:
    """Return the materials of a car body by name, with the palette's paint."""
    return {
        "paint": Material(palette.paint, 0.34, 0.66),
        "panel": Material(mix(palette.paint, "#ffffff", 0.5), 0.30, 0.70),
        "glass": Material("#0b1014", 0.45, 0.55),
        "trim": Material("#1d2126", 0.25, 0.75),
        "gap": Material("#2a2f36", 0.4, 0.6),
        "lamp": Material("#f4f8ff", 0.55, 0.4),
        "tail": Material("#b80f27", 0.45, 0.5),
        "plate": Material("#eceee9", 0.45, 0.55),
        "tyre": Material("#1b1c1f", 0.25, 0.75),
        "rim": Material("#8d949c", 0.25, 0.6),
        "dark": Material("#0c0d0f", 0.3, 0.7),
    }


_GLOSS = {
    "paint": (0.09, 0.95), "panel": (0.03, 0.5), "glass": (0.07, 1.0), "trim": (0.03, 0.25), "lamp": (0.10, 1.0),
    "tail": (0.06, 0.9), "rim": (0.45, 0.6), "plate": (0.03, 0.2),
}  # fmt: skip
"""Share of the light from ahead that a material mirrors, and how much of that at a glancing angle is left; others are
dull."""
_CLEAR, _INSIDE = "glass", "dark"
"""The windows, and the wheel housings, which are open: both are seen from both sides."""
_CLEARNESS = 0.66
"""Opacity of glass that mirrors nothing."""
_SEATS = "#24282e"


@dataclass(eq=False)
class Painted:
    """A surface with its dull colour (n, 3), what it mirrors ahead and at a glance (n, 2), and whether it is clear."""

    mesh: pv.PolyData
    points: Points
    normals: Points
    dull: Points
    gloss: Points
    is_clear: bool
    actor: pv.Actor

    def mirror(self, eye_m: Points | None, is_dark: bool) -> None:
        """Paint on what is mirrored towards an eye at a place (3,), or nothing."""
        if not self.gloss.any():
            return
        shown, clear = self.dull, np.full((len(self.dull), 1), _CLEARNESS)
        if eye_m is not None:
            sight = self.points - eye_m
            sight /= np.linalg.norm(sight, axis=1, keepdims=True)
            facing = (sight * self.normals).sum(axis=1, keepdims=True)
            light = surroundings(sight - 2.0 * facing * self.normals, is_dark)
            ahead, glancing = self.gloss[:, :1], self.gloss[:, 1:]
            share = ahead + (glancing - ahead) * (1.0 - np.abs(facing)) ** 5
            if self.is_clear:
                share = np.where(facing < 0.0, share, 0.0)
                clear = np.clip(_CLEARNESS + 0.8 * share * light.mean(axis=1, keepdims=True), 0.0, 0.97)
            shown = shown * (1.0 - share) + share * light
        rgba = numpy_of(self.mesh.GetPointData().GetArray("rgb"))
        rgba[:, :3] = 255.0 * np.clip(shown, 0.0, 1.0)
        if self.is_clear:
            rgba[:, 3:] = 255.0 * clear
        self.mesh.GetPointData().GetArray("rgb").Modified()
        self.mesh.Modified()


def painted(parts: Parts, vehicle: Vehicle, palette: Palette) -> list[Painted]:
    """Return a car's surfaces: what is solid, what is open or inside, and last the glass."""
    materials = car_materials(palette)
    solid = [name for name in parts if name not in (_CLEAR, _INSIDE)]
    made = [_painted([(parts[name], materials[name], name) for name in solid], culls=True)]
    inside = [(parts[_INSIDE], materials[_INSIDE], _INSIDE)] if _INSIDE in parts else []
    if _CLEAR in parts:
        seats = Material(_SEATS, 0.35, 0.6)
        inside.append((_seats(vehicle), seats, ""))
    if inside:
        made.append(_painted(inside, culls=False))
    if _CLEAR in parts:
        made.append(_painted([(parts[_CLEAR], materials[_CLEAR], _CLEAR)], culls=False, is_clear=True))
    return made


def _painted(parts: list[tuple[pv.PolyData, Material, str]], culls: bool, is_clear: bool = False) -> Painted:
    mesh = appended([baked_mesh(mesh, material) for mesh, material, _ in parts])
    counts = [part.n_points for part, _, _ in parts]
    normals = np.concatenate([np.asarray(part.point_data["Normals"], np.float64) for part, _, _ in parts])
    gloss = np.repeat(np.array([_GLOSS.get(name, (0.0, 0.0)) for _, _, name in parts]), counts, axis=0)
    dull = np.asarray(mesh["rgb"], np.float64) / 255.0
    if is_clear:
        mesh["rgb"] = np.column_stack([mesh["rgb"], np.full(len(dull), 255 * _CLEARNESS)]).astype(np.uint8)
    actor = rgba_actor(mesh, "rgb")
    actor.prop.culling = "back" if culls else "none"
    actor.force_translucent = is_clear
    return Painted(mesh, np.asarray(mesh.points, np.float64), normals, dull, gloss, is_clear, actor)


def baked_mesh(mesh: pv.PolyData, material: Material) -> pv.PolyData:
    """Return the surface as triangles that face along its normals, with an `rgb` point array of colour times light."""
    normals = np.asarray(mesh.point_data["Normals"])
    triangles = _outward(mesh.points, normals, mesh.triangulate().regular_faces)
    baked = pv.PolyData(np.asarray(mesh.points, np.float32), np.insert(triangles, 0, 3, axis=1).ravel())
    light = material.ambient + material.diffuse * light_on(normals)
    colours = np.array(rgb(material.colour)) * light[:, None]
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


def surroundings(directions: Points, is_dark: bool) -> Points:
    """Return the light (n, 3) from directions (n, 3): a floor, a horizon, a sky, and soft boxes above and beside."""
    low, mid, high, boxes = _STUDIO[is_dark]
    x, y, z = directions.T
    up = z[:, None]
    floor = 0.55 * mid + (low - 0.55 * mid) * np.clip(-6.0 * up, 0.0, 1.0)
    sky = mid + (high - mid) * np.clip(1.5 * up, 0.0, 1.0) ** 0.6
    light = np.where(up < 0.0, floor, sky)
    around, above = np.arctan2(y, x), np.arcsin(np.clip(z, -1.0, 1.0))
    from_boxes = np.zeros(len(z))
    for azimuth, wide, elevation, tall, power in _BOXES:
        across = np.abs((around - azimuth + np.pi) % (2.0 * np.pi) - np.pi)
        inside = np.clip((wide - across) / 0.35, 0.0, 1.0) * np.clip(
            (tall - np.abs(above - elevation)) / 0.2, 0.0, 1.0
        )
        from_boxes += boxes * power * inside
    return np.asarray(light + from_boxes[:, None] * np.array([1.0, 0.98, 0.94]))


_STUDIO = {
    False: (np.array([0.30, 0.32, 0.35]), np.array([0.95, 0.97, 1.0]), np.array([0.45, 0.58, 0.80]), 1.0),
    True: (np.array([0.03, 0.035, 0.042]), np.array([0.28, 0.33, 0.40]), np.array([0.08, 0.10, 0.13]), 0.8),
}
_BOXES = (
    (-0.9, 1.3, 1.0, 0.40, 2.6),
    (2.2, 0.9, 0.60, 0.34, 2.0),
    (-2.4, 0.8, 0.50, 0.32, 2.0),
    (-0.5, 0.7, 0.28, 0.26, 1.1),
)
"""Soft boxes: azimuth, half width, elevation, half height in radians, and power."""


@lru_cache(maxsize=4)
def _seats(vehicle: Vehicle) -> pv.PolyData:
    """Return a floor and four seats inside a car of this size, made for the sedan."""
    scale = np.array([vehicle.length / 4.6, vehicle.width / 1.86, vehicle.height / 1.45])
    bounds = [(-1.55, 1.0, -0.66, 0.66, 0.5, 0.78)]
    for x in (-0.85, 0.05):
        for y in (-0.36, 0.36):
            bounds.append((x, x + 0.14, y - 0.24, y + 0.24, 0.7, 1.16))
            bounds.append((x, x + 0.1, y - 0.13, y + 0.13, 1.18, 1.30))
    boxes = appended([pv.Box(box) for box in bounds]).triangulate()
    made: pv.PolyData = boxes.compute_normals(cell_normals=False, split_vertices=True, feature_angle=30)
    made.points = np.asarray(made.points) * scale
    return made
