"""The colour bar of the heatmap: title, unit, numbers, and which grid is shown."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkPolyDataMapper2D, vtkTextActor

from widgets.theme import Palette, rgb
from widgets.viewport.camera import Size
from widgets.viewport.heatmap_layer import HeatmapData, colour_table

_WIDTH_PX, _HEIGHT_PX, _MARGIN_PX = 252, 82, 12
_BAR_PX = (12, 27, 228, 12)
_FULL_VIEW_PX = (640, 400)
_SHARES = (0.0, 0.5, 1.0)


class LegendLayer:
    """A colour bar with title and numbers on a panel in the lower right corner; hidden without a heatmap."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._table = vtkLookupTable()
        self._bar = vtkScalarBarActor()
        self._bar.SetLookupTable(self._table)
        self._bar.SetNumberOfLabels(0)
        self._bar.SetOrientationToHorizontal()
        self._bar.SetBarRatio(1.0)
        for corner in (self._bar.GetPositionCoordinate(), self._bar.GetPosition2Coordinate()):
            corner.SetCoordinateSystemToViewport()
            corner.SetReferenceCoordinate(None)  # type: ignore[arg-type]
        self._panel_points = pv.PolyData(np.zeros((4, 3)), [4, 0, 1, 2, 3])
        self._panel = vtkActor2D()
        mapper = vtkPolyDataMapper2D()
        mapper.SetInputData(self._panel_points)
        self._panel.SetMapper(mapper)
        self._title, self._note = vtkTextActor(), vtkTextActor()
        self._numbers = [vtkTextActor() for _ in _SHARES]
        self._placed: tuple[Size, float] | None = None
        for prop in self.props():
            prop.SetPickable(False)
            prop.SetVisibility(False)
            renderer.AddViewProp(prop)

    def props(self) -> list[vtkActor2D]:
        """Everything the legend consists of, from back to front."""
        return [self._panel, self._bar, self._title, self._note, *self._numbers]

    def set_data(self, data: HeatmapData | None, palette: Palette) -> None:
        """Label the bar for a heatmap, or hide it."""
        for prop in self.props():
            prop.SetVisibility(data is not None)
        if data is None:
            return
        colours = colour_table() / 255.0
        self._table.SetNumberOfTableValues(len(colours))
        for row, (red, green, blue, _) in enumerate(colours):
            self._table.SetTableValue(row, red, green, blue, 1.0)
        self._table.SetTableRange(data.vmin, data.vmax)
        self._title.SetInput(f"{data.title} [{data.unit}]" if data.unit else data.title)
        self._note.SetInput(data.note)
        for share, number in zip(_SHARES, self._numbers, strict=True):
            number.SetInput(f"{data.vmin + share * (data.vmax - data.vmin):.3g}")
        self._style(palette)

    def place(self, size: Size, pixel_ratio: float) -> None:
        """Keep the legend in the corner of a view of this size in pixels; small views get a small one."""
        if self._placed == (size, pixel_ratio):
            return
        self._placed = size, pixel_ratio
        room = min(size[0] / _FULL_VIEW_PX[0], size[1] / _FULL_VIEW_PX[1])
        unit = min(pixel_ratio, max(0.5 * pixel_ratio, room))
        left, low = size[0] - (_MARGIN_PX + _WIDTH_PX) * unit, _MARGIN_PX * unit
        right, high = left + _WIDTH_PX * unit, low + _HEIGHT_PX * unit
        self._panel_points.points = [(left, low, 0), (right, low, 0), (right, high, 0), (left, high, 0)]
        x, y, width, height = (length * unit for length in _BAR_PX)
        self._bar.GetPositionCoordinate().SetValue(left + x, low + y)
        self._bar.GetPosition2Coordinate().SetValue(left + x + width, low + y + height)
        self._title.SetPosition(left + x, low + 59 * unit)
        self._note.SetPosition(left + x, low + 43 * unit)
        for share, number in zip(_SHARES, self._numbers, strict=True):
            number.SetPosition(left + x + share * width, low + 10 * unit)
        self._title.GetTextProperty().SetFontSize(max(6, round(13 * unit)))
        for actor in (self._note, *self._numbers):
            actor.GetTextProperty().SetFontSize(max(6, round(11 * unit)))

    def _style(self, palette: Palette) -> None:
        self._panel.GetProperty().SetColor(*rgb(palette.background))
        self._panel.GetProperty().SetOpacity(0.78)
        for actor in (self._title, self._note, *self._numbers):
            actor.GetTextProperty().SetColor(*rgb(palette.text))
            actor.GetTextProperty().SetFontFamilyToArial()
        for share, number in zip(_SHARES, self._numbers, strict=True):
            number.GetTextProperty().SetJustification(round(2 * share))
