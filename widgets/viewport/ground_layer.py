"""Draw the ground: a plane with a grid every 10 m, flat metre labels, the axes triad at the origin, and a map.

The triad sticks out of the ground, so it is drawn with the things on it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkProp, vtkRenderer, vtkTexture

from riglens.core.scene.grid import VoxelGrid
from riglens.widgets.drawing.actors import exchange, hidden, line_mesh, plain_actor
from riglens.widgets.drawing.camera import OrbitCamera, Size
from riglens.widgets.theme import Palette, mix
from riglens.widgets.viewport.ground_map import GroundMap

_STEP_M = 10.0
_LEAST_LETTER_M, _MOST_LETTER_M, _LETTER_STEP = 0.45, 2.2, 1.25
_LETTER_PX = 9.0
"""Labels grow in steps as the view goes away, as long as there is room for them between two lines."""
_AXES = {"x": 2.9, "y": 1.6}
"""Length in metres from the origin under the middle of the car: a little beyond the body of a common car."""
_AXIS_WIDTH_M, _AXIS_M, _AXIS_LETTER_M = 0.03, 0.006, 0.3
_PLANE_M, _LINE_M, _LABEL_M = -0.08, -0.03, -0.015
_MAP_M = 0.01
"""Heights of plane, lines and labels: far enough apart to hide one another correctly. VTK's own offsets for
coplanar things are one switch for all actors and make each of them rewrite its depths."""


class GroundLayer:
    """Ground grid with labels; rebuilt when the ROI or the palette changes."""

    def __init__(self, renderer: vtkRenderer, triad_renderer: vtkRenderer) -> None:
        self._renderer, self._triad_renderer = renderer, triad_renderer
        self._actors: list[pv.Actor] = []
        self._triad: list[pv.Actor] = []
        self._labels = _Labels(0.0, 0.0)

    def set_grid(self, grid: VoxelGrid, palette: Palette) -> None:
        """Draw the ground for a ROI: grid lines reach the next 10 m beyond it."""
        half_x, half_y = (_STEP_M * math.ceil(length / 2 / _STEP_M) for length in grid.roi_m[:2])
        fine, strong = _grid_lines(half_x, half_y)
        self._labels = _Labels(half_x, half_y)
        actors = [
            plain_actor(_plane(half_x, half_y), color=palette.ground, lighting=False),
            plain_actor(fine, color=palette.grid_line, lighting=False),
            plain_actor(strong, color=palette.grid_line_strong, lighting=False),
            plain_actor(self._labels.mesh, color=mix(palette.text, palette.ground, 0.35), lighting=False),
        ]
        triad = _triad(palette)
        exchange(self._renderer, self._actors, actors)
        exchange(self._triad_renderer, self._triad, triad)
        self._actors, self._triad = actors, triad

    def set_shown(self, shown: bool) -> None:
        """Show ground and axes, or leave them out."""
        for actor in (*self._actors, *self._triad):
            actor.visibility = shown

    def arrange(self, camera: OrbitCamera, size: Size, pixel_ratio: float) -> None:
        """Keep the labels legible in a view of this size in pixels."""
        wanted_m = _LETTER_PX * pixel_ratio * camera.metres_per_pixel(np.array(camera.focal_m), size)
        steps = math.ceil(math.log(max(1.0, wanted_m / _LEAST_LETTER_M), _LETTER_STEP) - 1e-9)
        self._labels.set_height(min(_MOST_LETTER_M, _LEAST_LETTER_M * _LETTER_STEP**steps))


def _plane(half_x: float, half_y: float) -> pv.PolyData:
    return pv.Plane(
        center=(0.0, 0.0, _PLANE_M), i_size=2 * half_x, j_size=2 * half_y, i_resolution=1, j_resolution=1
    )


def _grid_lines(half_x: float, half_y: float) -> tuple[pv.PolyData, pv.PolyData]:
    """Return lines every 2 m and, separately, every 10 m."""
    fine: list[tuple[tuple[float, float, float], tuple[float, float, float]]] = []
    strong: list[tuple[tuple[float, float, float], tuple[float, float, float]]] = []
    for x in np.arange(-half_x, half_x + 1e-6, 2.0):
        (strong if x % _STEP_M == 0.0 else fine).append(((x, -half_y, _LINE_M), (x, half_y, _LINE_M)))
    for y in np.arange(-half_y, half_y + 1e-6, 2.0):
        (strong if y % _STEP_M == 0.0 else fine).append(((-half_x, y, _LINE_M), (half_x, y, _LINE_M)))
    pairs = [np.array(lines) for lines in (fine, strong)]
    return line_mesh(pairs[0][:, 0], pairs[0][:, 1]), line_mesh(pairs[1][:, 0], pairs[1][:, 1])


class _Labels:
    """Metre labels along the car's x and y axes, lying on the ground, read with x to the right."""

    def __init__(self, half_x: float, half_y: float) -> None:
        self.mesh = pv.PolyData()
        anchors = [np.zeros((0, 3))]
        for text, x, y in _label_places(half_x, half_y):
            letters = pv.Text3D(text, depth=0.0)
            left, right, low, high = letters.bounds[:4]
            start_x, start_y = right if x > half_x else left, high if y > half_y else low
            letters.points = letters.points - [start_x, start_y, 0.0]
            x, y = x - 0.4 * (x > half_x), y - 0.4 * (y > half_y)  # the last ones end before their line
            self.mesh = self.mesh.append_polydata(pv.PolyData(letters.points, letters.faces))
            anchors.append(np.tile([x, y, _LABEL_M], (letters.n_points, 1)))
        self._anchors, self._letters = np.concatenate(anchors), np.array(self.mesh.points)
        self._height_m = 0.0
        self.set_height(_LEAST_LETTER_M)

    def set_height(self, height_m: float) -> None:
        """Draw letters of another height."""
        if height_m != self._height_m and len(self._anchors):
            self._height_m = height_m
            self.mesh.points = self._anchors + height_m * self._letters


def _label_places(half_x: float, half_y: float) -> Iterator[tuple[str, float, float]]:
    """Yield the text of each label, and where it begins."""
    for x in np.arange(-half_x, half_x + 1e-6, _STEP_M):
        if x:
            yield f"{x:+.0f} m", x + 0.2, 0.2
    for y in np.arange(-half_y, half_y + 1e-6, _STEP_M):
        if y:
            yield f"{y:+.0f} m", 0.2, y + 0.2


def _triad(palette: Palette) -> list[pv.Actor]:
    """Return axes of the vehicle frame, flat on the ground, with their letters; unlike a gizmo they cannot be
    grasped."""
    actors, above = [], np.array([0.0, 0.0, _AXIS_M])
    for axis, (letter, length_m) in enumerate(_AXES.items()):
        along = np.eye(3)[axis]
        across = np.eye(3)[1 - axis] * _AXIS_WIDTH_M / 2
        corners = np.array([-across, across, length_m * along + across, length_m * along - across])
        bar = pv.PolyData(corners + above, [4, 0, 1, 2, 3])
        name = pv.Text3D(letter, depth=0.0)
        name.points = _AXIS_LETTER_M * (np.asarray(name.points) - name.center)
        name.points = np.asarray(name.points) + (length_m + _AXIS_LETTER_M) * along + above
        actors.append(
            plain_actor(
                bar.append_polydata(pv.PolyData(name.points, name.faces)),
                color=palette.axes[axis],
                lighting=False,
            )
        )
    return actors


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
