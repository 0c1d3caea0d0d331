"""Fill the outside of a sensor's field of view: geometry of its rays and ranges, cut off at the ROI, as if there were
no car and no traffic."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.rig.model import Sensor
from riglens.core.scene.grid import VoxelGrid
from riglens.core.sensing.rays import Rays, clip_to_roi, sensor_rays
from riglens.core.sensors.registry import kind_of
from riglens.widgets.drawing.actors import hidden, rgba_actor, show_mesh
from riglens.widgets.drawing.surface import appended
from riglens.widgets.sensors.appearance import appearance_of, ray_colour, selected_ray_colour
from riglens.widgets.theme import Palette, rgb

Points = NDArray[np.float64]
Quads = NDArray[np.int64]
_BEAMS, _TURNS, _ROWS, _COLUMNS = 24, 96, 19, 33
"""Most beams and azimuths, or rows and columns of an image, that make the corners of a surface."""
_OPACITY = (0.05, 0.12)
"""Of all other sensors, and of the selected one."""


def fill_mesh(sensor: Sensor, grid: VoxelGrid, colour: str, opacity: float) -> pv.PolyData:
    """Return the outside of the field of view with an `rgba` array; or nothing."""
    sensor = appearance_of(sensor.kind).outline(sensor)
    blocks, is_closed = _nodes(sensor)
    parts = []
    for nodes in blocks:
        points, triangles = _outside(sensor_rays(sensor, nodes.ravel()), nodes.shape, grid, is_closed)
        if len(triangles):
            parts.append(pv.PolyData(points, np.insert(triangles, 0, 3, axis=1).ravel()))
    if not parts:
        return pv.PolyData()
    mesh = appended(parts)
    points = mesh.points
    rgba = np.append(np.array(rgb(colour)) * 255, 255 * opacity).astype(np.uint8)
    mesh["rgba"] = np.tile(rgba, (len(points), 1))
    return mesh


def _nodes(sensor: Sensor) -> tuple[list[Quads], bool]:
    """Return ray numbers of coarse lattices, (beams upwards, azimuths) or (rows, columns) of each block, and whether
    they go round."""
    columns, rows = sensor.resolution
    beams = appearance_of(sensor.kind).beams(sensor)
    if beams is None:
        blocks = kind_of(sensor).blocks(sensor)
        down, across = _spread(rows // blocks, _ROWS), _spread(columns, _COLUMNS)
        first = np.arange(blocks) * (rows // blocks)
        return [(start + down[:, None]) * columns + across for start in first], False
    upwards, turns = beams.upwards[_spread(rows, _BEAMS)], _spread(columns, _TURNS)
    if beams.goes_round:
        turns = np.append(turns, turns[0])
    return [upwards[:, None] * columns + turns], beams.goes_round


def _spread(count: int, most: int) -> Quads:
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))


def _outside(rays: Rays, shape: tuple[int, ...], grid: VoxelGrid, is_closed: bool) -> tuple[Points, Quads]:
    """Return triangles from the sensor along the lattice's edge (lowest and highest beam if it goes round)."""
    index = np.arange(shape[0] * shape[1]).reshape(shape)
    edges = [index[0], index[-1]] if is_closed else [_once_round(index)]
    t0, t1 = clip_to_roi(grid, rays)
    ends = np.array(rays.origin_m) + t1[:, None] * rays.directions
    points = np.vstack([ends, rays.origin_m])
    pairs = np.concatenate([np.column_stack([edge[:-1], edge[1:]]) for edge in edges])
    triangles = np.column_stack([np.full(len(pairs), len(ends)), pairs])
    good = np.ones(len(points), np.bool_)
    good[:-1] = (t1 > t0) & np.isfinite(ends).all(axis=1)
    return np.nan_to_num(points), triangles[good[triangles].all(axis=1)]


def _once_round(index: Quads) -> Quads:
    return np.concatenate([index[0], index[1:, -1], index[-1, -2::-1], index[-2::-1, 0]])


class _Made(NamedTuple):
    """Surface of a sensor as it was made; holds the sensor, so that no other has its `id`."""

    sensor: Sensor
    grid: VoxelGrid
    colour: str
    mesh: pv.PolyData


class FillsLayer:
    """The surfaces of all sensors that are switched on: those of the selected one stronger."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._actors = [hidden(renderer, rgba_actor(pv.PolyData(), "rgba")) for _ in range(2)]
        for actor in self._actors:
            actor.force_translucent = True
        self._made: dict[bool, list[_Made]] = {False: [], True: []}

    def show(self, sensors: Sequence[Sensor], is_selected: bool, grid: VoxelGrid, palette: Palette) -> None:
        """Fill the field of view of the selected sensor, or those of all others; only those that changed are made."""
        colour_of = selected_ray_colour if is_selected else ray_colour
        known = {id(made.sensor): made for made in self._made[is_selected]}
        shown = []
        for sensor in sensors:
            made, colour = known.get(id(sensor)), colour_of(sensor.kind, palette)
            if made is None or made.grid != grid or made.colour != colour:
                made = _Made(sensor, grid, colour, fill_mesh(sensor, grid, colour, _OPACITY[is_selected]))
            shown.append(made)
        self._made[is_selected] = shown
        full = [made.mesh for made in shown if made.mesh.n_points]
        show_mesh(self._actors[is_selected], appended(full) if full else None)
