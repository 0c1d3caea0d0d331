"""The colour bar of the heatmap: title, unit, round numbers, and which grid and slice are shown."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkRenderer, vtkTextActor

from riglens.widgets.drawing.camera import Size
from riglens.widgets.drawing.label import (
    ColourBar,
    Plate,
    flat_actor,
    place_text,
    set_words,
    text_actor,
    unit_px,
)
from riglens.widgets.heatmap.scale import HeatLook, HeatmapData, Tick, bar_colours, bar_ticks
from riglens.widgets.theme import Palette, rgb

_WIDTH_PX, _MARGIN_PX, _INSET_PX = 284, 12, 14
_LINE_PX, _HEAD_PX, _FOOT_PX, _BAR_PX, _TICK_PX = 16, 24, 30, 12, 4
_TITLE_PX, _SMALL_PX = 13, 11
_MOST_TICKS = 11
NO_CELLS = "no boxes of this class"


class LegendLayer:
    """A colour bar with title and numbers on a plate in the lower right corner; hidden without a heatmap."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._bar = ColourBar()
        self._plate = Plate()
        self._marks_mesh = pv.PolyData()
        self._marks = flat_actor(self._marks_mesh)
        self._title, self._note, self._slice = text_actor(), text_actor(), text_actor()
        self._numbers = [text_actor() for _ in range(_MOST_TICKS)]
        self._ticks: tuple[Tick, ...] = ()
        self._data: HeatmapData | None = None
        self._placed: object = None
        self._says: object = None
        self._top_px = 0.0
        for prop in self._props():
            prop.SetPickable(False)
            prop.SetVisibility(False)
            renderer.AddViewProp(prop)

    def _props(self) -> list[vtkActor2D]:
        """Everything the legend consists of, from back to front."""
        return [self._plate.actor, self._bar.actor, self._marks, *self._texts()]

    def _texts(self) -> list[vtkTextActor]:
        return [self._title, self._note, self._slice, *self._numbers]

    @property
    def texts(self) -> tuple[str, ...]:
        """What the legend says now: title, note, slice, numbers; nothing when it is hidden."""
        return tuple(text.GetInput() for text in self._texts() if text.GetVisibility() and text.GetInput())

    @property
    def top_px(self) -> float:
        """Where it ends, in pixels from below; 0 when it is hidden."""
        return self._top_px if self._data is not None else 0.0

    def set_data(self, data: HeatmapData | None, look: HeatLook, palette: Palette) -> None:
        """Label the bar for a heatmap, or hide it."""
        self._data = data
        says = None if data is None else _says(data, look, palette)
        if says is not None and says == self._says:
            return  # the values of a drag change, what the legend says of them seldom
        self._says, self._placed = says, None
        for prop in self._props():
            prop.SetVisibility(data is not None)
        if data is None:
            return
        self._bar.set_colours(bar_colours(data, look, palette.background))
        set_words(self._title, f"{data.title} [{data.unit}]" if data.unit else data.title)
        set_words(self._note, data.note if len(data.values) else NO_CELLS)
        set_words(self._slice, slice_text(look))
        self._ticks = bar_ticks(data, look)[:_MOST_TICKS]
        for number, tick in zip(self._numbers, self._ticks, strict=False):
            number.SetInput(tick.text)
        for number in self._numbers[len(self._ticks) :]:
            number.SetVisibility(False)
        self._style(palette)

    def set_drawn(self, cell_m: float | None) -> None:
        """Say which cells the picture shows now: larger ones while something moves."""
        if self._data is None or cell_m is None or not len(self._data.values):
            return
        is_coarse = cell_m > 1.001 * self._data.cell_m
        set_words(self._note, f"cells of {cell_m:.3g} m while it moves" if is_coarse else self._data.note)

    def place(self, size: Size, pixel_ratio: float, crowded: bool = False) -> None:
        """Keep the legend in the corner of a view of this size in pixels; small views get a small one."""
        if self._data is None or self._placed == (size, pixel_ratio):
            return
        self._placed = size, pixel_ratio
        unit, lines = unit_px(size, pixel_ratio, crowded), 2 if self._slice.GetInput() else 1
        height_px = _FOOT_PX + _BAR_PX + lines * _LINE_PX + _HEAD_PX
        left, low = size[0] - (_MARGIN_PX + _WIDTH_PX) * unit, _MARGIN_PX * unit
        self._top_px = low + height_px * unit
        self._plate.cover(left, low, _WIDTH_PX * unit, height_px * unit)
        x, y, width = left + _INSET_PX * unit, low + _FOOT_PX * unit, (_WIDTH_PX - 2 * _INSET_PX) * unit
        self._bar.cover(x, y, width, _BAR_PX * unit)
        over = y + (_BAR_PX + 5) * unit
        place_text(self._slice, x, over, _SMALL_PX * unit)
        place_text(self._note, x, over + (lines - 1) * _LINE_PX * unit, _SMALL_PX * unit)
        place_text(self._title, x, over + lines * _LINE_PX * unit + unit, _TITLE_PX * unit)
        self._place_ticks(x, y, width, unit)

    def _place_ticks(self, x: float, y: float, width: float, unit: float) -> None:
        """A frame around the bar, marks under it and their numbers; numbers at the ends stay under the bar."""
        assert self._data is not None
        high, right = y + _BAR_PX * unit, x + width
        corners = [(x, y), (right, y), (right, high), (x, high)]
        lines = [[corner, corners[row - 1]] for row, corner in enumerate(corners)]
        if self._data.scale != "steps":
            places = [x + tick.place * width for tick in self._ticks]
            lines += [[(place, y), (place, y - _TICK_PX * unit)] for place in places]
        points = np.array(lines).reshape(-1, 2)
        self._marks_mesh.points = np.column_stack([points, np.zeros(len(points))])
        self._marks_mesh.lines = np.array([[2, 2 * row, 2 * row + 1] for row in range(len(lines))]).ravel()
        self._marks.GetProperty().SetLineWidth(max(1.0, unit))
        for tick, number in zip(self._ticks, self._numbers, strict=False):
            place_text(number, x + tick.place * width, y - (_TICK_PX + 14) * unit, _SMALL_PX * unit)
            justification = 0 if tick.place < 0.04 else 2 if tick.place > 0.93 else 1
            number.GetTextProperty().SetJustification(justification)

    def _style(self, palette: Palette) -> None:
        self._plate.set_colour(palette.background)
        self._marks.GetProperty().SetColor(*rgb(palette.text))
        for text in self._texts():
            text.GetTextProperty().SetColor(*rgb(palette.text))


def _says(data: HeatmapData, look: HeatLook, palette: Palette) -> object:
    """All that a legend is made from."""
    words = data.title, data.unit, data.note if len(data.values) else NO_CELLS, data.scale, slice_text(look)
    return *words, bar_ticks(data, look), bar_colours(data, look, palette.background).tobytes(), palette


def slice_text(look: HeatLook) -> str:
    """Which heights are shown, "" for all of them."""
    if look.slice_m is None:
        return ""
    return f"slice: z from {look.slice_m[0]:.4g} to {look.slice_m[1]:.4g} m"
