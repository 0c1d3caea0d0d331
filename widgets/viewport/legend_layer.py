"""The colour bar of the heatmap: title, unit, numbers, and which grid is shown."""

from __future__ import annotations

import pyvista as pv
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor

from widgets.theme import Palette, rgb
from widgets.viewport.heatmap_layer import HeatmapData, colour_table


class LegendLayer:
    """A slim colour bar at the right edge; hidden without a heatmap."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._table = vtkLookupTable()
        self._bar = vtkScalarBarActor()
        self._bar.SetLookupTable(self._table)
        self._bar.SetNumberOfLabels(5)
        self._bar.UnconstrainedFontSizeOn()
        self._bar.SetVisibility(False)
        self._bar.SetPickable(False)
        renderer.AddViewProp(self._bar)

    def set_data(self, data: HeatmapData | None, palette: Palette, pixel_ratio: float) -> None:
        """Label the bar for a heatmap, or hide it."""
        self._bar.SetVisibility(data is not None)
        if data is None:
            return
        colours = colour_table()
        self._table.SetNumberOfTableValues(len(colours))
        for row, (red, green, blue, _) in enumerate(colours / 255.0):
            self._table.SetTableValue(row, red, green, blue, 1.0)
        self._table.SetTableRange(data.vmin, data.vmax)
        unit = f" [{data.unit}]" if data.unit else ""
        note = f"\n{data.note}" if data.note else ""
        self._bar.SetTitle(f"{data.title}{unit}{note}")
        self._bar.SetLabelFormat("%-#.3g")
        self._place(palette, pixel_ratio)

    def _place(self, palette: Palette, pixel_ratio: float) -> None:
        bar = self._bar
        bar.SetOrientationToHorizontal()
        bar.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
        bar.SetPosition(0.68, 0.03)
        bar.SetWidth(0.29)
        bar.SetHeight(0.11)
        bar.SetBarRatio(0.22)
        bar.SetTextPositionToSucceedScalarBar()
        for text, size in ((bar.GetTitleTextProperty(), 13), (bar.GetLabelTextProperty(), 12)):
            text.SetColor(*rgb(palette.text))
            text.SetFontFamilyToArial()
            text.SetFontSize(round(size * pixel_ratio))
            text.BoldOff()
            text.ItalicOff()
            text.ShadowOff()
