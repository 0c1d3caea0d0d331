"""The colour bar of the heatmap: title, unit, numbers, and which grid is shown."""

from __future__ import annotations

import pyvista as pv
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkCoordinate, vtkTextActor

from widgets.theme import Palette, rgb
from widgets.viewport.heatmap_layer import HeatmapData, colour_table

_LEFT, _WIDTH = 0.70, 0.28
_SHARES = (0.0, 0.5, 1.0)


class LegendLayer:
    """A slim colour bar in the lower right corner with title and numbers; hidden without a heatmap."""

    def __init__(self, renderer: pv.Renderer) -> None:
        self._table = vtkLookupTable()
        self._bar = vtkScalarBarActor()
        self._bar.SetLookupTable(self._table)
        self._bar.SetNumberOfLabels(0)
        self._bar.SetOrientationToHorizontal()
        self._bar.SetBarRatio(1.0)
        self._bar.SetWidth(_WIDTH)
        self._bar.SetHeight(0.024)
        _anchor(self._bar.GetPositionCoordinate(), _LEFT, 0.052)
        self._title, self._note = _text(_LEFT, 0.112), _text(_LEFT, 0.085)
        self._numbers = [_text(_LEFT + share * _WIDTH, 0.022) for share in _SHARES]
        for prop in self._props():
            prop.SetPickable(False)
            prop.SetVisibility(False)
            renderer.AddViewProp(prop)

    def _props(self) -> list[vtkActor2D]:
        return [self._bar, self._title, self._note, *self._numbers]

    def set_data(self, data: HeatmapData | None, palette: Palette, pixel_ratio: float) -> None:
        """Label the bar for a heatmap, or hide it."""
        for prop in self._props():
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
        self._style(palette, pixel_ratio)

    def _style(self, palette: Palette, pixel_ratio: float) -> None:
        for actor, size in [(self._title, 15), (self._note, 12), *((number, 12) for number in self._numbers)]:
            text = actor.GetTextProperty()
            text.SetColor(*rgb(palette.text))
            text.SetFontFamilyToArial()
            text.SetFontSize(round(size * pixel_ratio))
        for share, number in zip(_SHARES, self._numbers, strict=True):
            number.GetTextProperty().SetJustification(round(2 * share))


def _text(x: float, y: float) -> vtkTextActor:
    actor = vtkTextActor()
    _anchor(actor.GetPositionCoordinate(), x, y)
    return actor


def _anchor(coordinate: vtkCoordinate, x: float, y: float) -> None:
    """Put a coordinate at a share of the view's width and height."""
    coordinate.SetCoordinateSystemToNormalizedViewport()
    coordinate.SetValue(x, y)
