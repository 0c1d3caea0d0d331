"""The ego car in the scene: its surfaces with their materials, and a soft shadow on the ground."""

from __future__ import annotations

import numpy as np
import pyvista as pv

from core.rig.model import Vehicle
from widgets.theme import Palette
from widgets.viewport.body import body_parts
from widgets.viewport.materials import car_materials, rgba_actor, surface_actor


class BodyLayer:
    """The car; rebuilt when the vehicle or the palette changes."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._renderer = renderer
        self._actors: list[pv.Actor] = []

    def set_vehicle(self, vehicle: Vehicle, palette: Palette) -> None:
        """Draw a vehicle; raises InputError for an unknown body and then keeps the old one."""
        parts = body_parts(vehicle)
        for actor in self._actors:
            self._renderer.RemoveActor(actor)
        materials = car_materials(palette)
        self._actors = [surface_actor(part.mesh, materials[part.material]) for part in parts]
        self._actors.append(rgba_actor(shadow_mesh(vehicle), "rgba"))
        for actor in self._actors:
            self._renderer.AddActor(actor)


def shadow_mesh(vehicle: Vehicle) -> pv.PolyData:
    """A dark patch under the car that fades outwards, with an `rgba` point array."""
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
