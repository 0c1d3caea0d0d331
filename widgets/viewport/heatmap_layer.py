"""The heatmap: one square per cell, as large on the screen as in the world, higher values over lower ones.

Cells are drawn as points whose size a line of shader code computes, which costs a third of glyphs. While
something is dragged a coarser level (blocks of cells with their largest value) keeps software OpenGL fluent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import matplotlib
import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from widgets.viewport.camera import OrbitCamera, Size

COLOUR_MAP = "inferno"
MAX_CELLS = 200_000
DRAG_CELLS = 30_000
_HIDDEN_BELOW = 0.02
_ALPHA_LOW, _ALPHA_HIGH = 0.01, 0.50
_SLANTED = 1.25
_GL_PROGRAM_POINT_SIZE = 0x8642
_FAR_M = 1e4
_POSITION_HOOK = "//VTK::PositionVC::Impl"
_SIZE_CODE = "  gl_PointSize = clamp(cellScale / gl_Position.w, 1.0, 96.0);\n"
_COLOUR_HOOK = "//VTK::Color::Impl"
# Cells between the eye and the car are almost clear, or traffic would hide car and sensors: in a space where
# car and sensors fill the unit sphere, those inside the cone from the eye to that sphere.
_FADE_CODE = """
  vec3 eye = vec3(eyeX, eyeY, eyeZ);
  vec3 carCentre = vec3(0.0, 0.0, 1.4);
  vec3 carRadii = vec3(3.2, 1.8, 2.1);
  vec3 toCell = (vertexMC.xyz - eye) / carRadii;
  vec3 toCar = (carCentre - eye) / carRadii;
  float along = dot(toCell, normalize(toCar));
  float beside = length(toCell - along * normalize(toCar)) * length(toCar) / max(along, 1e-6);
  float before = 1.0 - smoothstep(length(toCar) - 0.7, length(toCar) + 0.3, along);
  vertexColorVSOutput.a *= 1.0 - 0.99 * before * (1.0 - smoothstep(0.9, 1.5, beside));
"""


@dataclass(frozen=True)
class HeatmapData:
    """What the heatmap shows: cell centres (m, 3) and edge in metres, a value per cell (m,), and its legend.

    Pass the same `centres_m` array again when only the values change: then nothing else is recomputed.
    `note` says which grid is shown (e.g. "cells of 0.4 m, grid 0.1 m"). Values in the lowest 2 % of the range
    from `vmin` to `vmax` are not drawn.
    """

    centres_m: NDArray[np.float32]
    cell_m: float
    values: NDArray[np.float32]
    title: str
    unit: str
    vmin: float
    vmax: float
    note: str = ""


@dataclass(frozen=True)
class Level:
    """Cells of one resolution and how to get their values from those of the full one."""

    centres_m: NDArray[np.float32]
    cell_m: float
    values_of: Callable[[NDArray[np.float32]], NDArray[np.float32]]


def full_level(centres_m: NDArray[np.float32], cell_m: float) -> Level:
    """The level that shows every cell."""
    return Level(np.asarray(centres_m, dtype=np.float32), cell_m, lambda values: values)


def coarse_level(centres_m: NDArray[np.float32], cell_m: float, most: int = DRAG_CELLS) -> Level:
    """Blocks of 2, 3, ... cells per edge until there are at most `most`; a block shows its largest value."""
    level, factor = full_level(centres_m, cell_m), 1
    while len(level.centres_m) > most:
        factor += 1
        level = _blocks(np.asarray(centres_m, dtype=np.float32), cell_m, factor)
    return level


def _blocks(centres_m: NDArray[np.float32], cell_m: float, factor: int) -> Level:
    edge_m = cell_m * factor
    low = centres_m.min(axis=0) - cell_m / 2
    block = np.floor((centres_m - low) / edge_m).astype(np.int64)
    key = (block[:, 0] << 42) | (block[:, 1] << 21) | block[:, 2]
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.diff(key[order], prepend=-1))
    centres = (low + (block[order[first]] + 0.5) * edge_m).astype(np.float32)
    return Level(centres, edge_m, lambda values: np.maximum.reduceat(values[order], first))


@lru_cache(maxsize=4)
def colour_table(name: str = COLOUR_MAP) -> NDArray[np.uint8]:
    """The colour map as (256, 4) uint8; opacity grows with the value."""
    colours = matplotlib.colormaps[name](np.linspace(0.12, 1.0, 256))
    colours[:, 3] = _ALPHA_LOW + (_ALPHA_HIGH - _ALPHA_LOW) * np.linspace(0.0, 1.0, 256) ** 1.6
    return np.asarray(np.round(colours * 255), dtype=np.uint8)


def colour_index(values: NDArray[np.float32], vmin: float, vmax: float) -> NDArray[np.int64]:
    """Row of the colour table per value, 0..255; values outside the range take the end colours."""
    span = max(vmax - vmin, 1e-30)
    return np.asarray(np.clip((values - vmin) / span * 255.0, 0.0, 255.0), dtype=np.int64)


class HeatmapLayer:
    """The heatmap of a scene; `set_data` then `arrange` before each frame."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._data: HeatmapData | None = None
        self._levels: tuple[Level, Level] | None = None
        self._drawn: Level | None = None
        self._mesh = pv.PolyData()
        self._mapper = _cell_mapper()
        self._actor = _cell_actor(self._mapper)
        renderer.AddObserver("StartEvent", _let_shaders_size_points)
        renderer.AddActor(self._actor)

    def set_data(self, data: HeatmapData | None) -> None:
        """Show other values, other cells, or nothing."""
        same_cells = data is not None and self._data is not None and data.centres_m is self._data.centres_m
        self._data, self._drawn = data, None
        if data is not None and not same_cells:
            self._levels = full_level(data.centres_m, data.cell_m), coarse_level(data.centres_m, data.cell_m)
        if data is None:
            self._actor.SetVisibility(False)

    def arrange(self, camera: OrbitCamera, size: Size, quick: bool) -> None:
        """Choose the level and size its cells for this camera; higher values are drawn over lower ones."""
        if self._data is None or self._levels is None:
            return
        level = self._levels[1 if quick else 0]
        self._aim(level.cell_m, camera, size)
        if self._drawn is level:
            return
        self._drawn = level
        values = level.values_of(self._data.values)
        index = colour_index(values, self._data.vmin, self._data.vmax)
        shown = np.flatnonzero(index > _HIDDEN_BELOW * 255)
        shown = shown[np.argsort(index[shown].astype(np.uint8), kind="stable")]
        self._put(level.centres_m[shown], colour_table()[index[shown]])

    def _put(self, points: NDArray[np.float32], rgba: NDArray[np.uint8]) -> None:
        self._actor.SetVisibility(len(points) > 0)
        if not len(points):
            return
        if self._mesh.n_points == len(points):
            arrays = self._mesh.GetPoints().GetData(), self._mesh.GetPointData().GetArray("rgba")
            for array, values in zip(arrays, (points, rgba), strict=True):
                vtk_to_numpy(array)[:] = values
                array.Modified()
            self._mesh.GetPoints().Modified()
            self._mesh.Modified()
            return
        self._mesh = pv.PolyData(points, verts=np.concatenate([[len(points)], np.arange(len(points))]))
        self._mesh["rgba"] = rgba
        self._mapper.SetInputData(self._mesh)

    def _aim(self, cell_m: float, camera: OrbitCamera, size: Size) -> None:
        """Tell the shader how large a cell is and where the eye is.

        Seen at a slant cells overlap a little, or gaps would show. Parallel views are seen from far away.
        """
        pixels_at_1m = cell_m * size[1] / 2 / np.tan(np.radians(camera.view_angle_deg) / 2)
        scale = pixels_at_1m / camera.distance_m if camera.parallel else _SLANTED * pixels_at_1m
        eye = camera.focal_m - (_FAR_M if camera.parallel else camera.distance_m) * camera.axes()[2]
        uniforms = self._actor.GetShaderProperty().GetVertexCustomUniforms()
        uniforms.SetUniformf("cellScale", float(scale))
        for axis, value in zip("XYZ", eye, strict=True):
            uniforms.SetUniformf(f"eye{axis}", float(value))


def _cell_mapper() -> vtkPolyDataMapper:
    """Colours straight from the array, coordinates in metres for the shader (VTK would scale them)."""
    mapper = vtkPolyDataMapper()
    mapper.SetVBOShiftScaleMethod(0)
    mapper.SetColorModeToDirectScalars()
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray("rgba")
    return mapper


def _cell_actor(mapper: vtkPolyDataMapper) -> vtkActor:
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.SetPickable(False)
    actor.SetVisibility(False)
    actor.ForceTranslucentOn()
    actor.GetProperty().SetLighting(False)
    for hook, code in ((_POSITION_HOOK, _SIZE_CODE), (_COLOUR_HOOK, _FADE_CODE)):
        actor.GetShaderProperty().AddVertexShaderReplacement(hook, True, f"{hook}\n{code}", False)
    return actor


def _let_shaders_size_points(renderer: pv.Renderer, _event: str) -> None:
    state = renderer.GetRenderWindow().GetState()
    if state is not None:
        state.vtkglEnable(_GL_PROGRAM_POINT_SIZE)
