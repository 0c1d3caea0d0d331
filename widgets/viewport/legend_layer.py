"""The colour bar of the heatmap: title, unit, numbers, and which grid is shown."""

from __future__ import annotations

import pyvista as pv
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import vtkCoordinate, vtkTextActor

from widgets.theme import Palette, rgb
from widgets.viewport.heatmap_layer import HeatmapData, colour_table


class LegendLayer:
    """A slim colour bar in the lower right corner with its title above; hidden without a heatmap."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._table = vtkLookupTable()
        self._bar = vtkScalarBarActor()
        self._bar.SetLookupTable(self._table)
        self._bar.SetNumberOfLabels(5)
        self._bar.SetLabelFormat("%.3g")
        self._bar.UnconstrainedFontSizeOn()
        self._bar.SetOrientationToHorizontal()
        self._bar.SetBarRatio(0.36)
        self._bar.SetTextPositionToPrecedeScalarBar()
        self._title, self._note = vtkTextActor(), vtkTextActor()
        for prop in (self._bar, self._title, self._note):
            prop.SetVisibility(False)
            prop.SetPickable(False)
            renderer.AddViewProp(prop)

    def set_data(self, data: HeatmapData | None, palette: Palette, pixel_ratio: float) -> None:
        """Label the bar for a heatmap, or hide it."""
        for prop in (self._bar, self._title, self._note):
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
        self._place(palette, pixel_ratio)

    def _place(self, palette: Palette, pixel_ratio: float) -> None:
        _anchor(self._bar.GetPositionCoordinate(), 0.70, 0.028)
        self._bar.SetWidth(0.28)
        self._bar.SetHeight(0.062)
        _anchor(self._title.GetPositionCoordinate(), 0.702, 0.118)
        _anchor(self._note.GetPositionCoordinate(), 0.702, 0.094)
        label = self._bar.GetLabelTextProperty()
        for text, size in (
            (self._title.GetTextProperty(), 15),
            (self._note.GetTextProperty(), 12),
            (label, 12),
        ):
            text.SetColor(*rgb(palette.text))
            text.SetFontFamilyToArial()
            text.SetFontSize(round(size * pixel_ratio))
            text.BoldOff()
            text.ItalicOff()
            text.ShadowOff()


def _anchor(coordinate: vtkCoordinate, x: float, y: float) -> None:
    """Put a coordinate at a share of the view's width and height."""
    coordinate.SetCoordinateSystemToNormalizedViewport()
    coordinate.SetValue(x, y)
