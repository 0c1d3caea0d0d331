"""Heatmap: one square per cell, as large on the screen as in the world, higher values over lower ones.

Cells are drawn as two triangles, which two lines of shader code spread to a square that faces the eye. OpenGL's
points would cost less, but drivers limit their size and drop those whose centre is outside the picture. While
something is dragged a coarser level (blocks of cells with their largest value) keeps software OpenGL responsive.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkCellArray
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer

from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.drawing.actors import numpy_of, vtk_ids
from riglens.widgets.drawing.camera import OrbitCamera, Size
from riglens.widgets.heatmap.levels import (
    SMALLEST_PX,
    DetailLevel,
    RowsBehind,
    cell_scale_px,
    coarse_level,
    full_level,
    in_parts,
)
from riglens.widgets.heatmap.pick import CAR_CENTRE_M, CAR_RADII_M, CLEAR_BEFORE, CLEAR_BESIDE, eye_m
from riglens.widgets.heatmap.scale import (
    DEFAULT_LOOK,
    HeatLook,
    alphas,
    colour_rows,
    colours,
    in_slice,
    strength,
)

_POSITION_HOOK = "//VTK::PositionVC::Impl"
_TRIANGLES = np.array([0, 1, 3, 0, 3, 2])
"""Corners of a square in two triangles; the shader takes the two bits of a corner for right and up."""
# Squares face the eye, so the lower edges of the lowest dip into the ground: behind everything else they are drawn
# in front of it.
_SIZE_CODE = f"""
  vec2 corner = vec2(gl_VertexID & 1, (gl_VertexID >> 1) & 1) * 2.0 - 1.0;
  gl_Position.xy += corner * max(cellScale, {SMALLEST_PX} * gl_Position.w) / vec2(widthPx, heightPx);
  gl_Position.z = mix(gl_Position.z, -0.99 * gl_Position.w, inFront);
"""
_COLOUR_HOOK = "//VTK::Color::Impl"
# Cells between the eye and the car are almost clear, or traffic would hide car and sensors: in a space where
# car and sensors fill the unit sphere, those inside the cone from the eye to that sphere.
_FADE_CODE = f"""
  vec3 eye = vec3(eyeX, eyeY, eyeZ);
  vec3 carCentre = vec3{CAR_CENTRE_M};
  vec3 carRadii = vec3{CAR_RADII_M};
  vec3 toCell = (vertexMC.xyz - eye) / carRadii;
  vec3 toCar = (carCentre - eye) / carRadii;
  float along = dot(toCell, normalize(toCar));
  float beside = length(toCell - along * normalize(toCar)) * length(toCar) / max(along, 1e-6);
  float before = 1.0 - smoothstep(length(toCar) + {CLEAR_BEFORE[0]}, length(toCar) + {CLEAR_BEFORE[1]}, along);
  vertexColorVSOutput.a *= 1.0 - 0.99 * before * (1.0 - smoothstep({CLEAR_BESIDE[0]}, {CLEAR_BESIDE[1]}, beside));
  vertexColorVSOutput.a = max(0.0, vertexColorVSOutput.a * thinned - tooFaint);
"""
_TOO_FAINT = 0.006
"""Cells so much fainter lose their colour in rounding, but not their shade: seen level they are left out."""


class _Cells:
    """The cells of one level, four points each. They never move; a frame writes their colours and their order."""

    def __init__(self, level: DetailLevel) -> None:
        self.level = level
        count = 4 * len(level.centres_m)
        self.mesh = pv.PolyData()
        if count:
            self.mesh.points = np.repeat(level.centres_m, 4, axis=0)
        self._rgba = vtkUnsignedCharArray()
        self._rgba.SetName("rgba")
        self._rgba.SetNumberOfComponents(4)
        self._rgba.SetNumberOfTuples(count)
        self.mesh.GetPointData().AddArray(self._rgba)
        self._order = vtkCellArray()
        self.mesh.SetPolys(self._order)
        self.order = np.zeros(0, np.int64)
        self.rows_behind = RowsBehind(level)

    def write(self, rgba: NDArray[np.uint8], order: NDArray[np.int64]) -> None:
        """Write colours (n, 4) of all cells, and the numbers (k,) of those that are drawn, the last on top."""
        if not len(rgba):
            return
        numpy_of(self._rgba)[:] = np.repeat(rgba, 4, axis=0)
        self._rgba.Modified()
        self.order = order
        self.draw_only(order)

    def draw_only(self, order: NDArray[np.int64]) -> None:
        """Draw these cells, by their numbers (k,), the last on top."""
        corners = (4 * order[:, None] + _TRIANGLES).ravel()
        self._order.SetData(vtk_ids(np.arange(0, len(corners) + 1, 3)), vtk_ids(corners))
        self.mesh.Modified()


class HeatmapLayer:
    """The heatmap of a scene; `set_data` and `set_look`, then `arrange` before each frame.

    It is drawn in `renderer`, over everything that it is not behind, or in `backdrop` behind all of them
    while something moves.
    """

    def __init__(self, renderer: vtkRenderer, backdrop: vtkRenderer) -> None:
        self._data: HeatmapData | None = None
        self._look = DEFAULT_LOOK
        self._cells: dict[bool, _Cells] = {}
        self._drawn: _Cells | None = None
        self._is_empty = True
        self._mapper = _cell_mapper()
        self._actor, self._actor_behind = _cell_actor(self._mapper), _cell_actor(self._mapper)
        for where, actor in ((renderer, self._actor), (backdrop, self._actor_behind)):
            where.GetCullers().RemoveAllItems()  # they know the middles of the squares, which may be out of sight
            where.AddActor(actor)

    @property
    def drawn_cell_m(self) -> float | None:
        """Edge of the cells as they are drawn now, coarser while something moves; None without a heatmap."""
        return self._drawn.level.cell_m if self._drawn is not None else None

    def set_data(self, data: HeatmapData | None) -> None:
        """Show other values, other cells, or nothing."""
        same_cells = data is not None and self._data is not None and data.centres_m is self._data.centres_m
        self._data, self._drawn = data, None
        if not same_cells:
            self._cells = {}
        if data is None:
            self._is_empty = True
            self._actor.SetVisibility(False)
            self._actor_behind.SetVisibility(False)

    def set_look(self, look: HeatLook) -> None:
        """Draw the same values in another way."""
        if look.slice_m != self._look.slice_m:
            self._cells = {}
        self._look, self._drawn = look, None

    def arrange(self, camera: OrbitCamera, size: Size, quick: bool) -> None:
        """Choose the level and size its cells for this camera; stronger cells are drawn over weaker ones.

        While something moves (`quick`) they are drawn in the backdrop; `size` is that of the renderer they are in.
        """
        if self._data is None:
            return
        cells = self._cells_of(self._data, quick)
        if self._drawn is not cells:
            self._drawn = cells
            self._paint(cells, self._data)
        self._aim(cells, camera, size, quick)
        self._actor.SetVisibility(not self._is_empty and not quick)
        self._actor_behind.SetVisibility(not self._is_empty and quick)

    def parts(self, camera: OrbitCamera, size: Size) -> Iterator[None]:
        """Select the cells part by part, for drawing: each part is selected when this yields."""
        cells = self._drawn
        if cells is None or self._is_empty:
            return
        try:
            for part in in_parts(cells.level.centres_m, cells.order, cells.level.cell_m, camera, size):
                cells.draw_only(part)
                yield
        finally:
            cells.draw_only(cells.order)

    def _cells_of(self, data: HeatmapData, quick: bool) -> _Cells:
        if quick not in self._cells:
            level = full_level(data.centres_m, data.cell_m, in_slice(self._look, data.centres_m[:, 2]))
            self._cells[quick] = _Cells(coarse_level(level) if quick else level)
        return self._cells[quick]

    def _paint(self, cells: _Cells, data: HeatmapData) -> None:
        values, weights = cells.level.merged(data)
        places = strength(data, values, weights, self._look.log)
        shown = np.flatnonzero(places > self._look.threshold)
        self._is_empty = not len(shown)
        rgba = np.empty((len(places), 4), np.uint8)
        rgba[:, :3] = colours(data.scale)[colour_rows(data.scale, values, places, data.vmax)]
        rgba[:, 3] = alphas(places, self._look.opacity, data.scale, cells.level.cell_m / data.cell_m)
        cells.rows_behind.count(shown, places[shown])
        cells.write(rgba, shown[np.argsort((places[shown] * 255).astype(np.uint8), kind="stable")])
        self._mapper.SetInputData(cells.mesh)

    def _aim(self, cells: _Cells, camera: OrbitCamera, size: Size, behind: bool) -> None:
        """Pass the size of a cell and the position of the eye to the shader. Parallel views are seen from far away."""
        values = dict(zip(("eyeX", "eyeY", "eyeZ"), eye_m(camera), strict=True))
        values |= {"cellScale": cell_scale_px(cells.level.cell_m, camera, size), "inFront": behind}
        values |= {"widthPx": size[0], "heightPx": size[1]}
        values |= {
            "thinned": cells.rows_behind.thinned(camera),
            "tooFaint": _TOO_FAINT * camera.from_the_side,
        }
        actor = self._actor_behind if behind else self._actor
        uniforms = actor.GetShaderProperty().GetVertexCustomUniforms()
        for name, value in values.items():
            uniforms.SetUniformf(name, float(value))


def _cell_mapper() -> vtkPolyDataMapper:
    """Return a mapper with colours straight from the array and coordinates in metres for the shader (VTK would scale
    them)."""
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
