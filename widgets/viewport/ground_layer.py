"""The ground: a plane with a grid every 10 m, metre labels lying on it, and the axes triad at the origin.

The triad sticks out of the ground, so it is drawn among the things that stand there.
"""

from __future__ import annotations

import math

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkRenderer

from core.scene.grid import VoxelGrid
from widgets.theme import Palette, mix
from widgets.viewport.materials import line_mesh, plain_actor

_STEP_M = 10.0
_LABEL_HEIGHT_M = 0.45
_WIDE_LINE = 0.6
_PLANE_M, _LINE_M, _LABEL_M = -0.08, -0.03, -0.015
"""Heights of plane, lines and labels: far enough apart to hide one another rightly. VTK's own offsets for what
lies in one plane are a switch for all actors alike and make each of them write its depths anew."""


class GroundLayer:
    """Ground grid with labels; rebuilt when the ROI or the palette changes."""

    def __init__(self, renderer: vtkRenderer, triad_renderer: vtkRenderer) -> None:
        self._renderer, self._triad_renderer = renderer, triad_renderer
        self._actors: list[pv.Actor] = []
        self._triad: list[pv.Actor] = []
        self._lines: dict[pv.Actor, str] = {}
        self._ground_colour = ""
        self._quick = False

    def set_grid(self, grid: VoxelGrid, palette: Palette) -> None:
        """Draw the ground for a ROI: grid lines reach the next 10 m beyond it."""
        for actor in self._actors:
            self._renderer.RemoveActor(actor)
        for actor in self._triad:
            self._triad_renderer.RemoveActor(actor)
        half_x, half_y = (_STEP_M * math.ceil(length / 2 / _STEP_M) for length in grid.roi_m[:2])
        fine, strong = _grid_lines(half_x, half_y)
        self._lines = {
            plain_actor(fine, lighting=False): palette.grid_line,
            plain_actor(strong, lighting=False): palette.grid_line_strong,
        }
        self._ground_colour = palette.ground
        self._actors = [
            plain_actor(_plane(half_x, half_y), color=palette.ground, lighting=False),
            *self._lines,
            plain_actor(
                _labels(half_x, half_y), color=mix(palette.text, palette.ground, 0.35), lighting=False
            ),
        ]
        self.set_quick(self._quick)
        for actor in self._actors:
            self._renderer.AddActor(actor)
        self._triad = _triad(palette)
        for actor in self._triad:
            self._triad_renderer.AddActor(actor)

    def set_quick(self, quick: bool) -> None:
        """Fainter lines while something moves: the ground is then drawn smaller and stretched, its lines are wide."""
        self._quick = quick
        for actor, colour in self._lines.items():
            actor.prop.color = mix(colour, self._ground_colour, _WIDE_LINE) if quick else colour


def _plane(half_x: float, half_y: float) -> pv.PolyData:
    return pv.Plane(
        center=(0.0, 0.0, _PLANE_M), i_size=2 * half_x, j_size=2 * half_y, i_resolution=1, j_resolution=1
    )


def _grid_lines(half_x: float, half_y: float) -> tuple[pv.PolyData, pv.PolyData]:
    """Lines every 2 m and, apart from them, every 10 m."""
    fine: list[tuple[tuple[float, float, float], tuple[float, float, float]]] = []
    strong: list[tuple[tuple[float, float, float], tuple[float, float, float]]] = []
    for x in np.arange(-half_x, half_x + 1e-6, 2.0):
        (strong if x % _STEP_M == 0.0 else fine).append(((x, -half_y, _LINE_M), (x, half_y, _LINE_M)))
    for y in np.arange(-half_y, half_y + 1e-6, 2.0):
        (strong if y % _STEP_M == 0.0 else fine).append(((-half_x, y, _LINE_M), (half_x, y, _LINE_M)))
    pairs = [np.array(lines) for lines in (fine, strong)]
    return line_mesh(pairs[0][:, 0], pairs[0][:, 1]), line_mesh(pairs[1][:, 0], pairs[1][:, 1])


def _labels(half_x: float, half_y: float) -> pv.PolyData:
    """Metre labels along the car's x and y axes, lying on the ground, read with x to the right."""
    mesh = pv.PolyData()
    for x in np.arange(-half_x, half_x + 1e-6, _STEP_M):
        if x:
            mesh = mesh.append_polydata(_text(f"{x:+.0f} m", x + 0.2, 0.2))
    for y in np.arange(-half_y, half_y + 1e-6, _STEP_M):
        if y:
            mesh = mesh.append_polydata(_text(f"{y:+.0f} m", 0.2, y + 0.2))
    return mesh


def _text(text: str, x: float, y: float) -> pv.PolyData:
    label = pv.Text3D(text, depth=0.0)
    label.points = label.points - [label.bounds[0], label.bounds[2], 0.0]
    label.points = label.points * _LABEL_HEIGHT_M + [x, y, _LABEL_M]
    return pv.PolyData(label.points, label.faces)


def _triad(palette: Palette) -> list[pv.Actor]:
    """Axes of the vehicle frame at its origin, on the ground: x red, y green, z blue."""
    actors = []
    for axis, length in enumerate((3.4, 2.0, 2.0)):
        direction = np.eye(3)[axis]
        shaft = pv.Cylinder(
            center=direction * length / 2, direction=direction, radius=0.012, height=length, resolution=8
        )
        tip = pv.Cone(
            center=direction * length, direction=direction, height=0.16, radius=0.045, resolution=16
        )
        actor = plain_actor(shaft.append_polydata(tip), color=palette.axes[axis], lighting=False)
        actors.append(actor)
    return actors
