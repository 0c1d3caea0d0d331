"""Draw the ground: a plane that fades into the horizon, streets with their marks, rings of distance, and a map.

Without streets of the traffic the car stands on a plain road, for scale.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkProp, vtkRenderer, vtkTexture

from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.streets import StreetView
from riglens.widgets.drawing.actors import exchange, hidden, plain_actor, rgba_actor
from riglens.widgets.theme import Palette, rgb
from riglens.widgets.viewport.ground_map import GroundMap

Points = NDArray[np.float64]
RINGS_M = (5.0, 10.0, 20.0, 30.0, 50.0)
LANES_M = (-5.2, -1.75, 1.75, 5.2)
"""Edges of the lanes across the road; the car is in the middle of one, and the road is divided to its left."""
_DIVIDED_M = 1.75
REACH_M, _CLEAR_M = 260.0, 45.0
"""Radius of the plane, and up to where it has its own colour."""
_PLANE_Z, _ROAD_Z, _MARK_Z, _RING_Z, _MAP_M = -0.08, -0.06, -0.04, -0.02, 0.01
"""Heights: far enough apart to hide one another correctly. VTK's own offsets for coplanar things are one switch for all
actors and make each of them rewrite its depths."""


class GroundLayer:
    """Ground, streets and rings; rebuilt when the palette or the streets change."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._renderer = renderer
        self._actors: list[pv.Actor] = []
        self._rings: list[pv.Actor] = []
        self._width_px = 1.0

    def show(self, palette: Palette, streets: StreetView | None, shown: bool) -> None:
        """Draw the ground in the colours of a palette, with streets or a plain road, unless it is not shown."""
        road = _road(palette) if streets is None else _asphalt(streets.asphalt, palette)
        marks = rgba_actor(
            _painted_marks(_plain_marks() if streets is None else streets.marks, palette), "rgba"
        )
        marks.force_translucent = True
        rings = plain_actor(_rings(), color=palette.ring, lighting=False, opacity=0.8)
        actors = [rgba_actor(_plane(palette), "rgb"), rgba_actor(road, "rgb"), marks, rings]
        exchange(self._renderer, self._actors, actors)
        self._actors, self._rings = actors, [rings]
        self.set_line_width(self._width_px)
        for actor in actors:
            actor.visibility = shown

    def set_line_width(self, width_px: float) -> None:
        """Set the width of the rings."""
        self._width_px = width_px
        for actor in self._rings:
            actor.prop.line_width = 1.2 * width_px


def faded(points: Points, colour: str, palette: Palette) -> NDArray[np.uint8]:
    """Return the colours (n, 3) of places on the ground: towards the rim they become that of the horizon."""
    away = np.hypot(points[:, 0], points[:, 1])
    share = np.clip((away - _CLEAR_M) / (0.55 * REACH_M - _CLEAR_M), 0.0, 1.0)[:, None] ** 0.8
    mixed = (1.0 - share) * np.array(rgb(colour)) + share * np.array(rgb(palette.horizon))
    return np.asarray(255.0 * mixed, np.uint8)


def _plane(palette: Palette) -> pv.PolyData:
    """Return a disc whose rim has the colour of the horizon."""
    radii = np.concatenate([[0.0], np.geomspace(12.0, REACH_M, 20)])
    turn = np.linspace(0.0, 2.0 * np.pi, 65)
    x, y = np.outer(radii, np.cos(turn)), np.outer(radii, np.sin(turn))
    mesh = _lattice(np.stack([x, y, np.full_like(x, _PLANE_Z)], axis=-1))
    mesh["rgb"] = faded(np.asarray(mesh.points, np.float64), palette.ground, palette)
    return mesh


def _road(palette: Palette) -> pv.PolyData:
    x, y = np.meshgrid(
        np.linspace(-0.6 * REACH_M, 0.6 * REACH_M, 61), (LANES_M[0] - 0.4, LANES_M[-1] + 0.4), indexing="ij"
    )
    mesh = _lattice(np.stack([x, y, np.full_like(x, _ROAD_Z)], axis=-1))
    mesh["rgb"] = faded(np.asarray(mesh.points, np.float64), palette.road, palette)
    return mesh


def _lattice(points: Points) -> pv.PolyData:
    """Return a surface over a lattice of points (rows, columns, 3)."""
    index = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    return pv.PolyData(points.reshape(-1, 3).astype(np.float32), np.insert(quads, 0, 4, axis=1).ravel())


def _asphalt(quads: Points, palette: Palette) -> pv.PolyData:
    mesh = _on_ground(quads, _ROAD_Z)
    mesh["rgb"] = faded(np.asarray(mesh.points, np.float64), palette.road, palette)
    return mesh


def _on_ground(quads: Points, z_m: float) -> pv.PolyData:
    """Return a surface of quadrangles (q, 4, 2) at a height."""
    points = np.column_stack([quads.reshape(-1, 2), np.full(4 * len(quads), z_m)])
    faces = np.insert(np.arange(len(points)).reshape(-1, 4), 0, 4, axis=1).ravel()
    return pv.PolyData(points.astype(np.float32), faces)


def _plain_marks() -> Points:
    """Return the marks (q, 4, 2) of the plain road: solid edges, a double line where the directions part, dashes
    elsewhere."""
    bars = [(x, x + 8.0, y, 0.14) for y in (LANES_M[0], LANES_M[-1]) for x in np.arange(-96.0, 96.0, 8.0)]
    bars += [
        (x, x + 8.0, _DIVIDED_M + side, 0.11) for side in (-0.13, 0.13) for x in np.arange(-96.0, 96.0, 8.0)
    ]
    dashed = [y for y in LANES_M[1:-1] if y != _DIVIDED_M]
    bars += [(x, x + 3.0, y, 0.12) for y in dashed for x in np.arange(-94.5, 96.0, 9.0)]
    return np.array([[(a, y - w / 2), (b, y - w / 2), (b, y + w / 2), (a, y + w / 2)] for a, b, y, w in bars])


def _painted_marks(quads: Points, palette: Palette) -> pv.PolyData:
    """Return marks that fade with distance, with an `rgba` point array."""
    mesh = _on_ground(quads, _MARK_Z)
    points = quads.reshape(-1, 2)
    away = np.hypot(points[:, 0], points[:, 1])
    alpha = 255.0 * 0.62 * np.clip((96.0 - away) / 60.0, 0.0, 1.0)
    mesh["rgba"] = np.column_stack(
        [np.tile(255.0 * np.array(rgb(palette.mark)), (len(points), 1)), alpha]
    ).astype(np.uint8)
    return mesh


@lru_cache(maxsize=1)
def _rings() -> pv.PolyData:
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1)
    points = np.concatenate([radius * circle + np.array([0.0, 0.0, _RING_Z]) for radius in RINGS_M])
    lines = np.insert(np.arange(len(points)).reshape(len(RINGS_M), -1), 0, len(turn), axis=1)
    return pv.PolyData(points.astype(np.float32), lines=lines.ravel())


class RoiLayer:
    """ROI box outline; rebuilt when the grid or the palette changes."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._actor = plain_actor(pv.PolyData(), lighting=False, line_width=1)
        renderer.AddActor(self._actor)

    def set_grid(self, grid: VoxelGrid, palette: Palette) -> None:
        """Outline a grid's ROI."""
        low = np.array(grid.origin_m)
        high = low + np.array(grid.roi_m)
        bounds = (low[0], high[0], low[1], high[1], low[2], high[2])
        self._actor.mapper.SetInputData(pv.Box(bounds).extract_all_edges())
        self._actor.prop.color = palette.roi

    def set_shown(self, shown: bool) -> None:
        """Show the outline, or leave it out."""
        self._actor.visibility = shown


class GroundMapLayer:
    """One rectangle with a picture on it, so that a map of any size costs a frame next to nothing."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._actor = hidden(renderer, plain_actor(pv.PolyData(), lighting=False, color="#ffffff"))
        self._actor.force_translucent = True
        self._image, texture = pv.ImageData(dimensions=(1, 1, 1)), vtkTexture()
        texture.SetInputData(self._image)
        texture.SetColorModeToDirectScalars()
        texture.InterpolateOff()
        self._actor.SetTexture(texture)
        self._placed: object = None

    @property
    def prop(self) -> vtkProp:
        """Return the prop that is drawn."""
        return self._actor

    def show(self, shown: GroundMap | None) -> None:
        """Show another map, or none."""
        self._actor.visibility = shown is not None
        if shown is None:
            return
        place = (shown.origin_m, shown.cell_m, shown.steps.shape)
        if place != self._placed:
            self._placed = place
            self._actor.mapper.SetInputData(_rectangle(shown))
            self._image.clear_data()
            self._image.dimensions = (*shown.steps.shape, 1)
        self._image.point_data["rgba"] = shown.pixels().reshape(-1, 4)
        self._image.set_active_scalars("rgba")


def _rectangle(shown: GroundMap) -> pv.PolyData:
    """Return the ground that a map covers, with the corners of its picture."""
    (x, y), (nx, ny) = shown.origin_m, shown.steps.shape
    right, top = x + nx * shown.cell_m, y + ny * shown.cell_m
    corners = np.array([(x, y), (right, y), (right, top), (x, top)])
    mesh = pv.PolyData(np.column_stack([corners, np.full(4, _MAP_M)]), [4, 0, 1, 2, 3])
    mesh.active_texture_coordinates = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    return mesh
