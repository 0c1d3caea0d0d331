"""A table with a row for each sensor of a rig; a click selects the sensor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from PySide6.QtCore import Signal

from riglens.core.shown_text import visible
from riglens.widgets.panels.figures.table import Cell, FigureTable, Heading

_LEAST_PX, _ROW_PX, _CELL_PX = 110, 24, 60


class SensorTable(FigureTable):
    """Titles with tooltips over the figures of each sensor."""

    chosen = Signal(str)
    """The row of this sensor was clicked."""

    def __init__(self, name: str, columns: Mapping[str, str]) -> None:
        super().__init__(name)
        self.give_titles(_LEAST_PX, _ROW_PX, _CELL_PX)
        in_two_lines = ("\n".join(title.rsplit(" ", 1)) for title in columns)
        self._columns = [
            Heading(title, tip, short)
            for (title, tip), short in zip(columns.items(), in_two_lines, strict=True)
        ]
        self._names: list[str] = []
        self.figures.set_narrow(True)
        self.show_rows({})
        self.clicked.connect(lambda at: self.chosen.emit(self._names[at.row()]))
        self.verticalHeader().sectionClicked.connect(lambda row: self.chosen.emit(self._names[row]))

    def show_rows(self, rows: Mapping[str, Sequence[Cell]], is_current: bool = True) -> None:
        """Show the figures of every sensor, greyed unless current."""
        anew, self._names = list(rows) != self._names, list(rows)
        headings = [Heading(visible(name), copied=(name,)) for name in rows]
        self.figures.show(headings, self._columns, list(rows.values()), anew)
        if not is_current:
            self.figures.grey()

    def as_text(self) -> str:
        """Return titles and figures with tabs between columns; nothing while there are none."""
        return self.figures.as_text("sensor") if self._names else ""

    def texts_of(self, name: str) -> list[str]:
        """Return the figures of a sensor as shown."""
        row = self._names.index(name)
        return [self.figures.cell(row, place).text for place in range(len(self._columns))]
