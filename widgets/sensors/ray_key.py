"""Key of the rays: a stroke of each colour and weight that is drawn, with a word, above the heatmap's legend."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkRenderer, vtkTextActor

from riglens.core.rig.model import Sensor
from riglens.core.sensors.registry import kind_of, kinds
from riglens.widgets.drawing.camera import Size
from riglens.widgets.drawing.label import (
    Plate,
    flat_actor,
    place_text,
    set_words,
    text_actor,
    text_width_px,
    unit_px,
)
from riglens.widgets.sensors.appearance import colour_of
from riglens.widgets.theme import Palette, rgb

_MARGIN_PX, _INSET_PX, _HIGH_PX, _BASE_PX = 12, 10, 22, 7
_STROKE_PX, _GAP_PX, _NEXT_PX, _FONT_PX = 18, 6, 14, 11
_THIN_PX, _THICK_PX = 1.5, 3.0


class KeyEntry(NamedTuple):
    """A colour of rays, their sensors, and whether they are bolder than others; text only without a colour."""

    words: str
    colour: str = ""
    is_bold: bool = False


def entries_of(casting: list[Sensor], selected: Sensor | None, palette: Palette) -> list[KeyEntry]:
    """Return the colours in which some sensors are drawn, of which one may be selected."""
    others = {sensor.kind for sensor in casting if sensor is not selected}
    shown = [kind for kind in kinds() if kind.name in others]
    found = [KeyEntry(kind.title, colour_of(kind.name), True) for kind in shown]
    if selected is not None and selected in casting:
        found.append(KeyEntry(f"selected {kind_of(selected).title}", palette.selected, True))
    return found


_Entry = tuple[KeyEntry, vtkTextActor, vtkActor2D, pv.PolyData]


class RayKeyLayer:
    """Strokes and words on a plate in the lower right corner, above other items."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._renderer = renderer
        self.plate = Plate()
        self._entries: list[_Entry] = []
        self._shown: object = None
        self._placed: object = None
        self._top_px = 0.0
        self.plate.actor.SetVisibility(False)
        self._add(self.plate.actor)

    def _add(self, prop: vtkActor2D) -> None:
        prop.SetPickable(False)
        self._renderer.AddViewProp(prop)

    @property
    def texts(self) -> tuple[str, ...]:
        """Return the texts of the key."""
        return tuple(entry.words for entry, *_ in self._entries)

    @property
    def top_px(self) -> float:
        """Return the top of the key, in pixels from below; 0 when it is hidden."""
        return self._top_px if self._entries else 0.0

    def set_entries(self, entries: list[KeyEntry], palette: Palette) -> None:
        """Say something else, or nothing."""
        if self._shown == (entries, palette.background, palette.text):
            return
        self._shown = entries, palette.background, palette.text
        for _, text, stroke, _ in self._entries:
            self._renderer.RemoveViewProp(text)
            self._renderer.RemoveViewProp(stroke)
        self._entries, self._placed = [], None
        self.plate.actor.SetVisibility(bool(entries))
        self.plate.set_colour(palette.background)
        for entry in entries:
            mesh = pv.PolyData(np.zeros((2, 3)), lines=[2, 0, 1])
            text, stroke = text_actor(), flat_actor(mesh)
            set_words(text, entry.words)
            text.GetTextProperty().SetColor(*rgb(palette.text))
            stroke.GetProperty().SetColor(*rgb(entry.colour or palette.background))
            stroke.SetVisibility(bool(entry.colour))
            self._add(text)
            self._add(stroke)
            self._entries.append((entry, text, stroke, mesh))

    def place(self, size: Size, pixel_ratio: float, above_px: float, crowded: bool = False) -> None:
        """Keep it in the corner of a view of this size in pixels, above the occupied ones."""
        if not self._entries or self._placed == (size, pixel_ratio, above_px, crowded):
            return
        self._placed = size, pixel_ratio, above_px, crowded
        unit = unit_px(size, pixel_ratio, crowded)
        low, right = above_px + _MARGIN_PX * unit / (2 if above_px else 1), size[0] - _MARGIN_PX * unit
        rows, left = self._rows(right - 2.0 * _MARGIN_PX * unit, unit), right
        for number, row in enumerate(rows):
            base = low + number * _HIGH_PX * unit
            left = min(left, self._place_row(row, base, right - _INSET_PX * unit, unit))
        self._top_px = low + len(rows) * _HIGH_PX * unit
        left += (_NEXT_PX - _INSET_PX) * unit
        self.plate.cover(left, low, right - left, self._top_px - low)

    def _rows(self, room_px: float, unit: float) -> list[list[_Entry]]:
        """Return the entries from the lowest row up: one row, or a title in a separate row where all do not fit."""
        for _, text, _, _ in self._entries:
            place_text(text, 0.0, 0.0, _FONT_PX * unit)
        needed = sum(
            text_width_px(text) + (_NEXT_PX + (_STROKE_PX + _GAP_PX if entry.colour else 0.0)) * unit
            for entry, text, _, _ in self._entries
        )
        has_title = len(self._entries) > 1 and not self._entries[0][0].colour
        if needed <= room_px or not has_title:
            return [self._entries]
        return [self._entries[1:], self._entries[:1]]

    def _place_row(self, row: list[_Entry], low: float, x: float, unit: float) -> float:
        """Put entries side by side up to a place, in pixels; returns where the first begins."""
        for entry, text, stroke, mesh in reversed(row):
            x -= text_width_px(text)
            text.SetPosition(round(x), round(low + _BASE_PX * unit))
            x -= _GAP_PX * unit if entry.colour else 0.0
            y = low + _HIGH_PX * unit / 2
            mesh.points = np.array([(x - _STROKE_PX * unit, y, 0.0), (x, y, 0.0)])
            stroke.GetProperty().SetLineWidth((_THICK_PX if entry.is_bold else _THIN_PX) * unit)
            x -= ((_STROKE_PX if entry.colour else 0.0) + _NEXT_PX) * unit
        return x
