"""The table of targets: a row per class, a column per ring of distance, each cell with its error and its change."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from PySide6.QtCore import QSize
from PySide6.QtGui import QResizeEvent

from riglens.core.figures.figure import ALL, CLASSES_AND_ALL
from riglens.core.figures.text import change_text, error_text, tip_text, value_text, verdict
from riglens.core.figures.values import FigureCells
from riglens.core.shown_values import NONE
from riglens.widgets.panels.figures.table import Cell, FigureTable, Heading, Tone, TwoLines
from riglens.widgets.theme import CLASS_COLOURS

TITLES = {ALL: "All objects", "car": "Cars", "bicycle": "Bicycles", "pedestrian": "Pedestrians"}
ROW_PX, CLASS_PX, MIN_CELL_PX = 38, 128, 104
LOW_ROW_PX = 30
"""Rows are as low as this where the panel is too low to show all of them otherwise."""


class TargetTable(FigureTable):
    """Table of one figure; the current row selects the rose."""

    def __init__(self) -> None:
        super().__init__("Targets: figures by class and distance")
        self.setItemDelegate(TwoLines(QSize(MIN_CELL_PX, LOW_ROW_PX), ROW_PX, self))
        self.give_titles(CLASS_PX, ROW_PX, MIN_CELL_PX)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep every class visible while there is room for two lines each."""
        super().resizeEvent(event)
        share_px = self.viewport().height() // len(CLASSES_AND_ALL)
        self.verticalHeader().setDefaultSectionSize(max(LOW_ROW_PX, min(share_px, ROW_PX)))

    @property
    def who(self) -> str:
        """Return the row whose rose is shown."""
        return CLASSES_AND_ALL[self.current_row]

    def show_figure(
        self, whole: FigureCells, rings: FigureCells, edges_m: Sequence[float], baseline: str
    ) -> None:
        """Show a figure at all distances and ring by ring, and in tooltips what it changes against."""
        title = whole.figure.title
        names = [f"0–{edges_m[-1]:g} m", *(f"{a:g}–{b:g} m" for a, b in pairwise(edges_m))]
        places = [(whole, 0), *((rings, ring) for ring in range(len(edges_m) - 1))]
        self.figures.show(
            [
                Heading(TITLES[who], colour=CLASS_COLOURS.get(who, ""), copied=(who,))
                for who in CLASSES_AND_ALL
            ],
            [
                Heading(name, copied=(f"{title} {name}", "standard error", "change", "objects"))
                for name in names
            ],
            [
                [_cell(*place, who, name, baseline) for name, place in zip(names, places, strict=True)]
                for who in CLASSES_AND_ALL
            ],
        )


def _cell(cells: FigureCells, part: int, who: str, ring: str, baseline: str) -> Cell:
    figure, (value, change) = cells.figure, cells.at(who, part)
    where, is_bold = f"{TITLES[who]}, {ring}", cells.cells.value.shape[1] == 1
    if not value.exists:
        return Cell(
            NONE, (None, None, None, value.objects), f"{where}: {value.reason}", "muted", is_bold=is_bold
        )
    tones: dict[str, Tone] = {"better": "more", "worse": "less"}
    is_outside = value.state == "outside"
    return Cell(
        value_text(figure, value.value, decimals=1),
        (value.value, value.se, change.value if change.exists else None, value.objects),
        tip_text(figure, where, value, change, baseline, cells.detector),
        tone="muted" if is_outside else "text",
        error=error_text(figure, value.se),
        change=change_text(figure, change.value, decimals=1) if change.exists and change.value else "",
        change_tone="muted" if is_outside else tones.get(verdict(figure, change), "text"),
        is_bold=is_bold,
    )
