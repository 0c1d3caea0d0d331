"""Table of detection ranges: a row per class, heading and kind of sensor, a column per direction."""

from __future__ import annotations

import math
from typing import NamedTuple

from PySide6.QtWidgets import QHeaderView

from riglens.core.sensors.registry import AnyKind, kinds
from riglens.core.targets.detection_range import DetectionRange, RangeRow, Reach
from riglens.core.targets.detection_range_text import HEADINGS, bearing_text, reach_text, stop_text
from riglens.widgets.panels.figures.table import Cell, FigureTable, Heading
from riglens.widgets.theme import CLASS_COLOURS

STOPS = "Can stop from"
STOPS_TIP = (
    "Highest speed from which the car stops before an object straight ahead, detected at the "
    "least distance. Available: that distance less half the lengths of car and object."
)
ROW_PX, TITLE_PX, PAD_PX = 22, 160, 12
WIDEST = "888/888/888"
"""The longest text of a cell: no column of distances is narrower."""


class Line(NamedTuple):
    """A row of the table: a class turned one way, by one kind of sensor."""

    cls: str
    heading_deg: float
    kind: AnyKind

    def reach(self, row: RangeRow) -> Reach:
        """Return the reach of its kind of sensor in one direction."""
        return row.reaches[self.kind.name]


def lines_of(ranges: DetectionRange) -> tuple[Line, ...]:
    """Return the rows of the table: per class and heading one of each kind of sensor."""
    turned = dict.fromkeys((row.cls, row.heading_deg) for row in ranges.rows)
    shown = [kind for kind in kinds() if any(kind.name in row.reaches for row in ranges.rows)]
    return tuple(Line(cls, heading, kind) for cls, heading in turned for kind in shown)


def rows_of(ranges: DetectionRange, line: Line) -> list[RangeRow]:
    """Return the rows of one line, direction by direction."""
    return [row for row in ranges.rows if (row.cls, row.heading_deg) == (line.cls, line.heading_deg)]


def line_title(ranges: DetectionRange, line: Line) -> str:
    """Return the name of a row; the heading is left out where a class has only one."""
    headings = {row.heading_deg for row in ranges.rows if row.cls == line.cls}
    turned = f" {HEADINGS[line.heading_deg]}" if len(headings) > 1 else ""
    return f"{line.cls.capitalize()}{turned}, {line.kind.plural}"


def tip_of(ranges: DetectionRange, line: Line, row: RangeRow) -> str:
    """Describe one cell in full."""
    reach, plan = line.reach(row), ranges.plan
    what = f"{plan.enough(line.kind):g} {line.kind.hits.label}"
    where = f"{line_title(ranges, line)}, {bearing_text(row.bearing_deg)}"
    if reach.most_m == 0.0:
        return f"{where}\nnever {what}, at no distance up to {plan.to_m:g} m"
    lines = [where, f"at least {what} from {reach.from_m:g} m on; first too few at:"]
    if reach.least_m == reach.most_m:
        return "\n".join([*lines, _metres(reach.median_m, plan.to_m)])
    places = ("worst", reach.least_m), ("median", reach.median_m), ("best", reach.most_m)
    lines += [
        f"{_metres(distance, plan.to_m)} at the {place} position between the beams"
        for place, distance in places
    ]
    return "\n".join(lines)


def _metres(distance_m: float, to_m: float) -> str:
    return f"beyond {to_m:g} m" if math.isinf(distance_m) else f"{distance_m:g} m"


class RangeTable(FigureTable):
    """Table of detection ranges; the current row selects the chart."""

    def __init__(self) -> None:
        super().__init__("Detection range in metres")
        self._lines: tuple[Line, ...] = ()
        self.give_titles(TITLE_PX, ROW_PX, self.fontMetrics().horizontalAdvance(WIDEST) + PAD_PX)

    @property
    def line(self) -> Line | None:
        """Return the line whose chart is shown: the chosen one, or the first."""
        return self._lines[self.current_row] if self._lines else None

    def show_range(self, ranges: DetectionRange) -> None:
        """Show detection ranges."""
        self._lines = lines_of(ranges)
        bearings = [bearing_text(bearing) for bearing in ranges.plan.bearings_deg]
        self.figures.show(
            [Heading(line_title(ranges, line), colour=CLASS_COLOURS[line.cls]) for line in self._lines],
            [Heading(title) for title in (*bearings, STOPS)],
            [_figures_of(ranges, line) for line in self._lines],
        )
        to_fit = QHeaderView.ResizeMode.ResizeToContents
        self.horizontalHeader().setSectionResizeMode(len(bearings), to_fit)


def _figures_of(ranges: DetectionRange, line: Line) -> list[Cell]:
    rows = rows_of(ranges, line)
    texts = [reach_text(line.reach(row), ranges.plan.to_m) for row in rows]
    stops = [ranges.stops_from_kmh(row, line.reach(row)) for row in rows]
    ahead = next((stop for stop in stops if stop is not None), None)
    found = [
        Cell(text, tip=tip_of(ranges, line, row), tone="muted" if text == "never" else "text")
        for text, row in zip(texts, rows, strict=True)
    ]
    return [*found, Cell(stop_text(ahead), tip=STOPS_TIP)]
