"""Draw measurements: the line between two places, its parts along the axes, lines to the ground, and the labels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.widgets.drawing.actors import hidden, line_mesh, plain_actor, show_mesh
from riglens.widgets.drawing.camera import OrbitCamera, Size
from riglens.widgets.drawing.label import place_text, put_on_panel, set_words, text_actor, text_width_px
from riglens.widgets.theme import AXIS_COLOURS, MEASURE_COLOUR, Palette
from riglens.widgets.viewport.measured import LEAST_M, Measured, Place, measured_lines

_LINE_PX, _LEG_PX, _DROP_PX = 2.4, 2.4, 1.2
_BAND_OPACITY = 0.6
_END_PX, _FONT_PX, _BESIDE_PX = 4.0, 13, 14
Points = NDArray[np.float64]


class MeasureLayer:
    """The straight line, its parts along x, y and z in their colours, and lines down to the ground: over everything."""

    def __init__(self, overlay: vtkRenderer) -> None:
        self._widths_px = (_LINE_PX, _DROP_PX, *(_LEG_PX,) * 3)
        colours = (MEASURE_COLOUR, MEASURE_COLOUR, *AXIS_COLOURS)
        self._lines = [
            hidden(overlay, plain_actor(pv.PolyData(), color=colour, lighting=False)) for colour in colours
        ]
        self._ends = [
            hidden(overlay, plain_actor(pv.Sphere(radius=1.0), color=MEASURE_COLOUR, lighting=False))
            for _ in range(2)
        ]
        self._text = text_actor()
        self._text.GetTextProperty().SetLineSpacing(1.25)
        self._text.SetVisibility(False)
        self._found: Measured | None = None
        self._palette: Palette | None = None
        overlay.AddViewProp(self._text)

    def show(self, found: Measured | None, palette: Palette) -> None:
        """Show a measurement, or none; without a second place its line is a faint rubber band."""
        self._found, self._palette = found, palette
        self._lines[0].prop.opacity = _BAND_OPACITY if found is not None and found.second is None else 1.0
        for actor, ends in zip(self._lines, _segments(found), strict=True):
            show_mesh(actor, line_mesh(ends[:, 0], ends[:, 1]))
        places = () if found is None else found.places
        for number, actor in enumerate(self._ends):
            actor.visibility = number < len(places)
            if number < len(places):
                actor.position = places[number].point_m
        self._text.SetVisibility(found is not None)
        if found is not None:
            set_words(self._text, "\n".join(f" {line} " for line in measured_lines(found)))
            put_on_panel(self._text, palette, 0.88)

    def aim(self, place: Place | None) -> bool:
        """Stretch a rubber band from the first place to the one under the mouse; whether that changed anything."""
        found = self._found
        if found is None or found.second is not None or found.aim == place or self._palette is None:
            return False
        self.show(replace(found, aim=place), self._palette)
        return True

    def arrange(self, camera: OrbitCamera, size: Size, pixel_ratio: float) -> None:
        """Fit widths to the picture, and keep the labels next to the middle of the line, inside the view."""
        found = self._found
        if found is None:
            return
        for actor, width_px in zip(self._lines, self._widths_px, strict=True):
            actor.prop.line_width = width_px * pixel_ratio
        for place, actor in zip(found.places, self._ends, strict=False):
            actor.scale = _END_PX * pixel_ratio * camera.metres_per_pixel(np.array(place.point_m), size)
        middle = np.mean([found.first.point_m, found.end.point_m], axis=0)
        x, y, _ = camera.project(middle[None], size)[0].tolist()
        beside_px, font_px = _BESIDE_PX * pixel_ratio, _FONT_PX * pixel_ratio
        place_text(self._text, 0.0, 0.0, font_px)
        wide, high = text_width_px(self._text), 1.7 * font_px * len(measured_lines(found))
        left = max(0.0, min(x + beside_px, size[0] - wide - beside_px))
        low = max(beside_px, min(size[1] - y + beside_px, size[1] - high - beside_px))
        place_text(self._text, left, low, font_px)

    @property
    def texts(self) -> list[str]:
        """Return the texts in the view, line by line."""
        if not self._text.GetVisibility():
            return []
        return [line.strip() for line in self._text.GetInput().split("\n")]


def _segments(found: Measured | None) -> list[Points]:
    """Return the ends (n, 2, 3) of the line, of lines to the ground, of parts along x, y and z; metres."""
    nothing = np.zeros((0, 2, 3))
    if found is None:
        return [nothing] * 5
    drops = [(p.point_m, (*p.point_m[:2], 0.0)) for p in found.places if abs(p.point_m[2]) > LEAST_M]
    drop = np.array(drops) if drops else nothing
    if found.end is found.first:
        return [nothing, drop, nothing, nothing, nothing]
    start, end = np.array(found.first.point_m), np.array(found.end.point_m)
    corners = np.tile(start, (4, 1))
    for axis in range(3):
        corners[axis + 1 :, axis] = end[axis]
    legs = [
        np.stack([corners[axis], corners[axis + 1]])[None]
        if abs(end[axis] - start[axis]) > LEAST_M
        else nothing
        for axis in range(3)
    ]
    line = np.stack([start, end])[None]
    return [line, drop, *([nothing] * 3 if found.second is None else legs)]
