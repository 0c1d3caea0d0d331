"""The table of targets: a row per class, a column per ring of distance, each cell with its error and its change."""

from __future__ import annotations

from itertools import pairwise

from PySide6.QtCore import QSize
from PySide6.QtGui import QResizeEvent

from riglens.core.targets.quantities import CLASSES_AND_ALL, EVERYBODY, Quantity, Table
from riglens.widgets.panels.figures.table import Figure, FigureTable, Heading, Tone, TwoLines
from riglens.widgets.panels.targets.text import (
    change_text,
    error_text,
    is_better,
    tells_apart,
    tip_text,
    value_text,
)
from riglens.widgets.theme import CLASS_COLOURS

TITLES = {EVERYBODY: "All objects", "car": "Cars", "bicycle": "Bicycles", "pedestrian": "Pedestrians"}
ROW_PX, CLASS_PX, MIN_CELL_PX = 38, 128, 104
LOW_ROW_PX = 30
"""Rows are as low as this where the panel is too low to show all of them otherwise."""


class TargetTable(FigureTable):
    """Table of one `Table`; the current row selects the rose."""

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

    def show_table(self, table: Table, baseline: str) -> None:
        """Show the numbers, and in tooltips what they change against."""
        edges, title = table.edges_m, table.quantity.title
        names = [f"0–{edges[-1]:g} m", *(f"{a:g}–{b:g} m" for a, b in pairwise(edges))]
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
                [_figure(table, row, column, name, baseline) for column, name in enumerate(names)]
                for row in range(len(CLASSES_AND_ALL))
            ],
        )


def _figure(table: Table, row: int, column: int, ring: str, baseline: str) -> Figure:
    cells, quantity = table.cells, table.quantity
    value, se, change = (float(part[row, column]) for part in (cells.value, cells.se, cells.change))
    objects = int(cells.objects[row, column])
    return Figure(
        value_text(quantity, value),
        (value, se, change, objects),
        tip_text(quantity, f"{TITLES[CLASSES_AND_ALL[row]]}, {ring}", cells, (row, column), baseline),
        tone="text" if objects else "muted",
        error=error_text(quantity, se),
        change=change_text(quantity, change),
        change_tone=_tone(quantity, change),
        is_bold=column == 0,
    )


def _tone(quantity: Quantity, change: float) -> Tone:
    if not tells_apart(quantity, change):
        return "text"
    return "more" if is_better(quantity, change) else "less"
