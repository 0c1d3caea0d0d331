"""The colour bar of the heatmap: title, unit, round numbers, and which grid and slice are shown.

Folded it is smaller and shows title, bar and the numbers at its ends.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkRenderer, vtkTextActor

from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.drawing.camera import Size
from riglens.widgets.drawing.label import (
    Box,
    ColourBar,
    Plate,
    flat_actor,
    place_text,
    set_words,
    text_actor,
    unit_px,
)
from riglens.widgets.heatmap.scale import HeatLook, Tick, bar_colours, bar_ticks
from riglens.widgets.theme import Palette, rgb

_WIDTH_PX, _MARGIN_PX, _INSET_PX = 284, 12, 14
_LINE_PX, _HEAD_PX, _FOOT_PX, _BAR_PX, _TICK_PX = 16, 24, 30, 12, 4
_TITLE_PX, _SMALL_PX = 13, 11
_EM_PER_LETTER = 0.6
"""Width of a letter, in heights of the font."""
_FOLDED_WIDTH_PX, _FOLDED_BAR_PX, _FOLDED_HEAD_PX, _FOLDED_FOOT_PX = 190, 7, 20, 22
_MOST_TICKS = 11
NO_CELLS = "no boxes of this class"


class Spot(NamedTuple):
    """State of the legend: folded or not, and its corner of the view."""

    is_folded: bool = False
    is_left: bool = False
    is_high: bool = False


class LegendLayer:
    """A colour bar with title and numbers on a plate in a corner; hidden without a heatmap."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._bar = ColourBar()
        self.plate = Plate()
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
        """Return the props of the legend from back to front."""
        return [self.plate.actor, self._bar.actor, self._marks, *self._texts()]

    def _texts(self) -> list[vtkTextActor]:
        return [self._title, self._note, self._slice, *self._numbers]

    @property
    def texts(self) -> tuple[str, ...]:
        """Return the texts of the legend: title, note, slice, numbers; nothing when it is hidden."""
        return tuple(text.GetInput() for text in self._texts() if text.GetVisibility() and text.GetInput())

    @property
    def top_px(self) -> float:
        """Return the top of the legend, in pixels from below; 0 when it is hidden."""
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
        self._bar.set_colours(bar_colours(data, look, palette))
        has_unit = bool(data.unit) and (not look.draped or data.scale != "ramp")
        set_words(self._title, f"{data.title} [{data.unit}]" if has_unit else data.title)
        set_words(self._note, _note(data, look))
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
        set_words(self._note, f"cells of {cell_m:.3g} m while dragging" if is_coarse else self._data.note)

    def box(self, size: Size, pixel_ratio: float, crowded: bool, spot: Spot, base_px: float = 0.0) -> Box:
        """Return the area that the legend covers in a view of this size in pixels; what is below `base_px` is taken."""
        unit = unit_px(size, pixel_ratio, crowded)
        if spot.is_folded:
            width, height = (
                _FOLDED_WIDTH_PX * unit,
                (_FOLDED_FOOT_PX + _FOLDED_BAR_PX + _FOLDED_HEAD_PX) * unit,
            )
        else:
            lines = 2 if self._slice.GetInput() else 1
            width, height = _WIDTH_PX * unit, (_FOOT_PX + _BAR_PX + lines * _LINE_PX + _HEAD_PX) * unit
        margin = _MARGIN_PX * unit
        left = margin if spot.is_left else size[0] - margin - width
        low = size[1] - margin - height if spot.is_high else base_px + margin
        return Box(left, low, width, height)

    def place(self, size: Size, pixel_ratio: float, crowded: bool, spot: Spot, base_px: float = 0.0) -> None:
        """Keep the legend in a corner of a view of this size in pixels, above `base_px`; it is small in small views."""
        if self._data is None or self._placed == (size, pixel_ratio, spot, base_px):
            return
        self._placed = size, pixel_ratio, spot, base_px
        unit, box = unit_px(size, pixel_ratio, crowded), self.box(size, pixel_ratio, crowded, spot, base_px)
        self._top_px = 0.0 if spot.is_left or spot.is_high else box.low + box.height
        self.plate.cover(*box)
        foot, bar = (_FOLDED_FOOT_PX, _FOLDED_BAR_PX) if spot.is_folded else (_FOOT_PX, _BAR_PX)
        x, y, width = box.left + _INSET_PX * unit, box.low + foot * unit, box.width - 2 * _INSET_PX * unit
        self._bar.cover(x, y, width, bar * unit)
        over = y + (bar + 5) * unit
        lines = 0 if spot.is_folded else 2 if self._slice.GetInput() else 1
        place_text(self._slice, x, over, _SMALL_PX * unit)
        place_text(self._note, x, over + max(lines - 1, 0) * _LINE_PX * unit, _SMALL_PX * unit)
        place_text(
            self._title, x, over + lines * _LINE_PX * unit + unit, (_TITLE_PX if lines else _SMALL_PX) * unit
        )
        for text in (self._slice, self._note):
            text.SetVisibility(not spot.is_folded)
        self._place_ticks(x, y, width, bar, unit)
        for number in self._numbers[1 : len(self._ticks) - 1]:
            number.SetVisibility(not spot.is_folded or self._data.scale == "steps")

    def _place_ticks(self, x: float, y: float, width: float, bar: float, unit: float) -> None:
        """Place a frame around the bar, marks under it and their numbers; numbers at the ends stay under the bar."""
        assert self._data is not None
        high, right = y + bar * unit, x + width
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
            half = 0.5 * _EM_PER_LETTER * len(tick.text) * _SMALL_PX * unit
            middle = max(x + half, min(right - half, x + tick.place * width))
            place_text(number, middle, y - (_TICK_PX + 14) * unit, _SMALL_PX * unit)
            number.GetTextProperty().SetJustificationToCentered()

    def _style(self, palette: Palette) -> None:
        self.plate.set_colour(palette.background)
        self._marks.GetProperty().SetColor(*rgb(palette.text))
        for text in self._texts():
            text.GetTextProperty().SetColor(*rgb(palette.text))


def _says(data: HeatmapData, look: HeatLook, palette: Palette) -> object:
    """Return all values that a legend is made from."""
    words = data.title, data.unit, _note(data, look), data.scale, slice_text(look), look.draped
    return *words, bar_ticks(data, look), bar_colours(data, look, palette).tobytes(), palette


def _note(data: HeatmapData, look: HeatLook) -> str:
    """Return which cells are drawn, or over what values on the ground are taken."""
    if not len(data.values):
        return NO_CELLS
    if not look.draped:
        return data.note
    return "all heights together" if look.slice_m is None else "heights of the slice together"


def slice_text(look: HeatLook) -> str:
    """Return the heights shown, "" for all of them."""
    if look.slice_m is None:
        return ""
    return f"slice: z from {look.slice_m[0]:.4g} to {look.slice_m[1]:.4g} m"
