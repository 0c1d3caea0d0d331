"""All text over the scene: the heatmap's legend, title and table of a picture, numbers next to a drag."""

from __future__ import annotations

import numpy as np
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkRenderer, vtkTextActor

from riglens.core.rig.model import Camera
from riglens.widgets.drawing.camera import Pixel, Size
from riglens.widgets.drawing.label import (
    Box,
    Plate,
    place_text,
    put_on_panel,
    set_words,
    text_actor,
    text_width_px,
    unit_px,
)
from riglens.widgets.heatmap.legend import LegendLayer, Spot
from riglens.widgets.sensors.footprints import tints
from riglens.widgets.sensors.ray_key import KeyEntry, RayKeyLayer, entries_of
from riglens.widgets.theme import Palette, mix, rgb
from riglens.widgets.viewport.scene_state import NO_CAPTION, Caption, SceneState

_MARGIN_PX, _INSET_PX = 12, 14
_TITLE_PX, _TEXT_PX, _SMALL_PX = 17, 12, 11
_ROW_PX, _GAP_PX = 19, 18


class CaptionLayer:
    """Title on a plate in the upper left corner, table on one in the lower left."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._renderer = renderer
        self._caption = NO_CAPTION
        self.plates = (Plate(), Plate())
        self._texts: dict[tuple[int, int], vtkTextActor] = {}
        self._placed: object = None
        for plate in self.plates:
            self._add(plate.actor)
            plate.actor.SetVisibility(False)

    def _add(self, prop: vtkActor2D) -> None:
        prop.SetPickable(False)
        self._renderer.AddViewProp(prop)

    def set_caption(self, caption: Caption, palette: Palette) -> None:
        """Say something else, or nothing."""
        for text in self._texts.values():
            self._renderer.RemoveViewProp(text)
        self._caption, self._texts, self._placed = caption, {}, None
        muted = mix(palette.text, palette.background, 0.25)
        self._write((-1, 0), caption.title, palette.text, bold=True)
        self._write((-1, 1), caption.subtitle, palette.text)
        for row, cells in enumerate(caption.table):
            for column, cell in enumerate(cells):
                self._write(
                    (row, column), cell, muted if row == 0 else palette.text, justification=2 * bool(column)
                )
        self._write((len(caption.table), 0), caption.note if caption.table else "", muted)
        for plate, is_shown in zip(self.plates, (bool(caption.title), bool(caption.table)), strict=True):
            plate.set_colour(palette.background)
            plate.actor.SetVisibility(is_shown)

    def _write(
        self, place: tuple[int, int], words: str, colour: str, bold: bool = False, justification: int = 0
    ) -> None:
        if not words:
            return
        text = text_actor(bold, justification)
        set_words(text, words)
        text.GetTextProperty().SetColor(*rgb(colour))
        self._add(text)
        self._texts[place] = text

    def place(self, size: Size, pixel_ratio: float) -> None:
        """Keep title and table in their corners of a picture of this size in pixels."""
        if self._caption == NO_CAPTION or self._placed == (size, pixel_ratio):
            return
        self._placed = size, pixel_ratio
        unit = unit_px(size, pixel_ratio, crowded=bool(self._caption.table))
        self._place_title(size, unit)
        self._place_table(unit)

    def _place_title(self, size: Size, unit: float) -> None:
        left, high = (_MARGIN_PX + _INSET_PX) * unit, size[1] - _MARGIN_PX * unit
        lines = [(self._texts.get((-1, 0)), _TITLE_PX, 25), (self._texts.get((-1, 1)), _TEXT_PX, 21)]
        width, low = 0.0, high - 6 * unit
        for text, font_px, line_px in lines:
            if text is not None:
                low -= line_px * unit
                place_text(text, left, low, font_px * unit)
                width = max(width, text_width_px(text))
        height = high - low + 9 * unit
        self.plates[0].cover(_MARGIN_PX * unit, high - height, width + 2 * _INSET_PX * unit, height)

    def _place_table(self, unit: float) -> None:
        """Lay out the rows from the bottom; a column is as wide as its widest cell, numbers are right-aligned."""
        rows, left, low = len(self._caption.table), (_MARGIN_PX + _INSET_PX) * unit, (_MARGIN_PX + 9) * unit
        right, note = left, self._texts.get((rows, 0))
        if note is not None:
            place_text(note, left, low, _SMALL_PX * unit)
            right = left + text_width_px(note)
            low += (_ROW_PX + 3) * unit
        end = left - _GAP_PX * unit
        for column in range(len(self._caption.table[0]) if rows else 0):
            end = self._place_column(column, end + _GAP_PX * unit, low, unit)
        width = max(right, end) + (_INSET_PX - _MARGIN_PX) * unit
        height = low + (rows * _ROW_PX + 2 - _MARGIN_PX) * unit
        self.plates[1].cover(_MARGIN_PX * unit, _MARGIN_PX * unit, width, height)

    def _place_column(self, column: int, left: float, low: float, unit: float) -> float:
        """Put the cells of a column under each other; where it ends, in pixels."""
        rows = len(self._caption.table)
        cells = {row: text for (row, at), text in self._texts.items() if at == column and 0 <= row < rows}
        for row, text in cells.items():
            place_text(text, left, low + (rows - 1 - row) * _ROW_PX * unit, _TEXT_PX * unit)
        end = left + max((text_width_px(text) for text in cells.values()), default=0.0)
        if column:
            for text in cells.values():
                text.SetPosition(round(end), text.GetPosition()[1])
        return end


_ECHO_PX = 13
_ECHO_OFFSET_PX = (20.0, 26.0)


class EchoLayer:
    """One text on a panel; hidden while there is nothing to say."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._actor = text_actor()
        self._actor.SetPickable(False)
        self._actor.SetVisibility(False)
        self.box: Box | None = None
        renderer.AddViewProp(self._actor)

    def show(
        self, text: str, pixel: tuple[float, float], size: Size, pixel_ratio: float, palette: Palette
    ) -> None:
        """Show a text to the right of and above a pixel (from the upper left), or where it stays in the view."""
        self._actor.SetVisibility(bool(text))
        self.box = None
        if not text:
            return
        put_on_panel(self._actor, palette, 0.88)
        self._actor.GetTextProperty().SetFontSize(round(_ECHO_PX * pixel_ratio))
        self._actor.GetTextProperty().SetLineSpacing(1.25)
        set_words(self._actor, "\n".join(f" {line} " for line in text.split("\n")))
        width, height = text_size_px(text, pixel_ratio)
        x = min(pixel[0] + _ECHO_OFFSET_PX[0] * pixel_ratio, size[0] - width)
        y = min(size[1] - pixel[1] + _ECHO_OFFSET_PX[1] * pixel_ratio, size[1] - height)
        self.box = Box(max(0.0, x), max(0.0, y), width, height)
        self._actor.SetPosition(self.box.left, self.box.low)


def text_size_px(text: str, pixel_ratio: float) -> tuple[float, float]:
    """Estimate the width and height of the panel, well enough to keep it inside the view."""
    lines = text.split("\n")
    letter = _ECHO_PX * pixel_ratio
    return letter * (0.62 * max(map(len, lines)) + 1.0), letter * (1.6 * len(lines) + 0.4)


SPOTS = (Spot(), Spot(True), Spot(True, True), Spot(True, False, True), Spot(True, True, True))
"""Spots of the legend, from the best to the last: it folds and moves rather than cover the car."""
_AWAY_PX, _KEY_PX = 14.0, 30.0
"""Distance of a new spot from the car, and the height that each key adds to the legend."""


def car_box(state: SceneState, size: Size) -> Box:
    """Return the rectangle of a view of this size in pixels that holds the car."""
    vehicle = state.vehicle
    x, y, z = np.meshgrid(
        (-vehicle.length / 2, vehicle.length / 2),
        (-vehicle.width / 2, vehicle.width / 2),
        (0.0, vehicle.height),
    )
    pixels = state.camera.project(np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1), size)[:, :2]
    (left, top), (right, bottom) = pixels.min(axis=0), pixels.max(axis=0)
    return Box(left, size[1] - bottom, right - left, bottom - top)


class WordsLayer:
    """Legend, caption and echo over the scene; `arrange` puts them into their places before each frame."""

    def __init__(self, overlay: vtkRenderer) -> None:
        self._legend, self._caption, self._echo = (
            LegendLayer(overlay),
            CaptionLayer(overlay),
            EchoLayer(overlay),
        )
        self._key, self._ground_key, self._band_key = (RayKeyLayer(overlay) for _ in range(3))
        self._echo_at: tuple[str, Pixel] = ("", (0.0, 0.0))
        self._spot, self._entries, self._bands = SPOTS[0], list[KeyEntry](), list[KeyEntry]()

    def show_ground_key(self, state: SceneState) -> None:
        """Show the key of the colours on the ground, or nothing where there are none."""
        shown, found = state.ground_map if state.show_legend else None, []
        if shown is not None:
            found = [KeyEntry(step.words, step.colour, True) for step in shown.meanings]
            found.insert(0, KeyEntry(shown.title))
        self._ground_key.set_entries(found, state.palette)

    def show_legend(self, state: SceneState) -> None:
        """Label the heatmap of a state, or hide the legend."""
        shown = state.legend_data if state.show_legend else None
        self._legend.set_data(shown, state.heat_look, state.palette)

    def show_key(self, state: SceneState) -> None:
        """Show the key of the rays, or nothing where neither rays nor fields of view are drawn."""
        look = state.ray_look
        casting = state.enabled if state.show_legend and (look.shown or look.fill != "none") else []
        chosen = state.selected_sensor if state.show_selection else None
        self._entries = entries_of(casting, chosen, state.palette)
        cameras = [one for one in casting if isinstance(one, Camera)]
        self._bands = []
        if state.shows_footprints and cameras:
            shown = tints(cameras[0], state.palette, len(look.px_per_m))
            limits = [f"{limit:g}" for limit in look.px_per_m]
            self._bands = [
                KeyEntry(words, tint.colour, True) for words, tint in zip(limits, shown, strict=True)
            ]
            self._bands.insert(0, KeyEntry("px per metre, at least"))
        self._show_key(state.palette)

    def _show_key(self, palette: Palette) -> None:
        """Hide the keys of sensors and bands where the legend is folded."""
        self._key.set_entries([] if self._spot.is_folded else self._entries, palette)
        self._band_key.set_entries([] if self._spot.is_folded else self._bands, palette)

    def show_caption(self, state: SceneState) -> None:
        """Show the title of a state's picture, and its scores."""
        self._caption.set_caption(state.caption, state.palette)

    def set_echo(self, text: str, pixel: Pixel) -> None:
        """Show a few numbers next to a pixel, or hide them."""
        self._echo_at = (text, pixel)

    def arrange(self, state: SceneState, drawn_cell_m: float | None, size: Size, pixel_ratio: float) -> None:
        """Fit everything to a view of this size, and say which cells of the heatmap are drawn."""
        self._legend.set_drawn(drawn_cell_m)
        self._caption.place(size, pixel_ratio)
        self._spot = self._free_spot(state, size, pixel_ratio)
        base_px = self._table_px(state, size, pixel_ratio)
        self._legend.place(size, pixel_ratio, bool(state.caption.table), self._spot, base_px)
        self._show_key(state.palette)
        below_px = max(base_px, self._legend.top_px)
        self._key.place(size, pixel_ratio, below_px, crowded=bool(state.caption.table))
        above_px = max(below_px, self._key.top_px)
        self._band_key.place(size, pixel_ratio, above_px, crowded=bool(state.caption.table))
        above_px = max(above_px, self._band_key.top_px)
        self._ground_key.place(size, pixel_ratio, above_px, crowded=bool(state.caption.table))
        self._echo.show(*self._echo_at, size, pixel_ratio, state.palette)

    def _table_px(self, state: SceneState, size: Size, pixel_ratio: float) -> float:
        """Return the top of the caption's table in pixels where it reaches below the legend, else 0."""
        table = self._caption.plates[1].box()
        if table is None:
            return 0.0
        legend = self._legend.box(size, pixel_ratio, crowded=True, spot=SPOTS[0])
        return table.low + table.height if table.left + table.width > legend.left else 0.0

    def boxes(self) -> list[Box]:
        """Return the pixels that the plates of the legend, the keys and the caption cover, and the echo."""
        keys = (self._key, self._ground_key, self._band_key)
        plates = (self._legend.plate, *(key.plate for key in keys), *self._caption.plates)
        return [box for box in (*(plate.box() for plate in plates), self._echo.box) if box is not None]

    def _free_spot(self, state: SceneState, size: Size, pixel_ratio: float) -> Spot:
        """Return the best place of the legend next to the car; the last one is kept as long as it is as good."""
        if state.legend_data is None or not state.show_legend:
            return SPOTS[0]
        car = car_box(state, size)
        for spot in SPOTS:
            box = self._legend.box(size, pixel_ratio, bool(state.caption.table), spot)
            if not spot.is_folded:
                keys = sum(map(bool, (self._entries, self._bands)))
                box = box._replace(height=box.height + keys * _KEY_PX * pixel_ratio)
            if not box.meets(car, 0.0 if spot == self._spot else _AWAY_PX * pixel_ratio):
                return spot
        return SPOTS[1]
