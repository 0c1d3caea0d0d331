"""What a picture for a report says beside the scene: the rig's name over it, and a table of scores below."""

from __future__ import annotations

from dataclasses import dataclass

from vtkmodules.vtkRenderingCore import vtkActor2D, vtkRenderer, vtkTextActor

from riglens.widgets.theme import Palette, mix, rgb
from riglens.widgets.viewport.camera import Size
from riglens.widgets.viewport.label import Plate, place_text, text_actor, text_width_px, unit_px

_MARGIN_PX, _INSET_PX = 12, 14
_TITLE_PX, _TEXT_PX, _SMALL_PX = 17, 12, 11
_ROW_PX, _GAP_PX = 19, 18


@dataclass(frozen=True)
class Caption:
    """Words of a picture; what is empty is left out.

    `table` are rows of equal length: the first is the head, the first column names the rows, the rest are numbers.
    """

    title: str = ""
    subtitle: str = ""
    table: tuple[tuple[str, ...], ...] = ()
    note: str = ""


NO_CAPTION = Caption()


class CaptionLayer:
    """Title on a plate in the upper left corner, table on one in the lower left."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._renderer = renderer
        self._caption = NO_CAPTION
        self._plates = (Plate(), Plate())
        self._texts: dict[tuple[int, int], vtkTextActor] = {}
        self._placed: object = None
        for plate in self._plates:
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
        for plate, is_shown in zip(self._plates, (bool(caption.title), bool(caption.table)), strict=True):
            plate.set_colour(palette.background)
            plate.actor.SetVisibility(is_shown)

    def _write(
        self, place: tuple[int, int], words: str, colour: str, bold: bool = False, justification: int = 0
    ) -> None:
        if not words:
            return
        text = text_actor(bold, justification)
        text.SetInput(words)
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
        self._plates[0].cover(_MARGIN_PX * unit, high - height, width + 2 * _INSET_PX * unit, height)

    def _place_table(self, unit: float) -> None:
        """Rows from below; a column is as wide as its widest cell, numbers end under each other."""
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
        self._plates[1].cover(_MARGIN_PX * unit, _MARGIN_PX * unit, width, height)

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
