"""Rigs to compare: rows, columns, sort keys and bars as a Qt model, and the whole as text for spreadsheets."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from PySide6.QtCore import Qt, Signal

from riglens.core.figures.coverage import VoxelFigure
from riglens.core.figures.figure import ALL, Estimate, Figure
from riglens.core.figures.objects import ObjectFigure
from riglens.core.figures.sentence import changes_between, sentence
from riglens.core.figures.text import (
    EXACT_UNITS,
    UNRESOLVED,
    change_estimate_text,
    change_text,
    decimals_of,
    estimate_text,
    in_sentence,
    parts_text,
    precise_text,
    value_text,
    verdict,
)
from riglens.core.figures.values import Values, class_figures, in_reading
from riglens.core.metric.scores import Reading, Scores
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import shown_kinds
from riglens.core.shown_text import spreadsheet_cell, visible
from riglens.core.shown_values import NONE
from riglens.widgets.panels.figures.table import (
    SORT,
    Cell,
    FigureModel,
    Heading,
    Index,
    Tone,
    delimited,
    exact,
)
from riglens.widgets.theme import CLASS_COLOURS

Origin = Literal["current", "snapshot", "preset", "file"]
ORIGIN_TITLES: dict[Origin, str] = {
    "current": "being edited",
    "snapshot": "snapshot",
    "preset": "preset",
    "file": "file",
}
ALL_CLASSES, MEAN = "all classes", "class mean"
_ONE_LINE = 9
"""Longest short title, in characters, that stands in one line."""
_SHORT_CLASSES = {"pedestrian": "ped.", "bicycle": "bike"}


@dataclass(frozen=True)
class CompareRow:
    """One rig; `where` is its preset's name or its path, `scores` and figures of objects None until they are computed.

    No `counted` figures at all: they cannot be counted.
    """

    key: str
    name: str
    origin: Origin
    rig: Rig
    where: str = ""
    scores: Scores | None = None
    counted: Values | None = None

    @property
    def title(self) -> str:
        """The name as shown; the rig being edited may have the name of the preset that it began as."""
        return visible(f"{self.name} (open)" if self.origin == "current" else self.name)

    @property
    def sensors(self) -> str:
        """Return the number of sensors that count, by kind, in words."""
        shown = shown_kinds(sensor.kind for sensor in self.rig.sensors if sensor.enabled)
        return " + ".join(f"{len(self.rig.enabled_of(kind.model))} {kind.title[0].upper()}" for kind in shown)


Known = tuple[Scores | None, Values | None]
"""Scores and figures of objects of a rig, each None while it is not known."""


@dataclass(frozen=True)
class FigureColumn:
    """One number per rig: a figure of a class."""

    class_name: str
    figure: Figure
    title: str
    short: str

    @property
    def who(self) -> str:
        """The class, or the mean of the classes, in words."""
        return MEAN if self.class_name == ALL else self.class_name

    @property
    def in_two_lines(self) -> str:
        """The short title for narrow columns."""
        if len(self.short) <= _ONE_LINE:
            return self.short
        is_of_all = self.short != self.figure.short
        return "\n".join(self.short.split(" ", 1) if is_of_all else self.short.rsplit(" ", 1))

    def value(self, known: Known) -> Estimate | None:
        """Return the figure of a rig; None while it is not known."""
        scores, counted = known
        if isinstance(self.figure, VoxelFigure):
            return None if scores is None else self.figure.of_scores(scores, self.class_name)
        if counted is None:
            return None
        none = Estimate.none("objects cannot be counted")
        return counted.get(self.figure.key, {}).get(self.class_name, none)


def columns_for(class_name: str, present: Iterable[str] = ()) -> tuple[FigureColumn, ...]:
    """Return all figures of one class that rigs with sensors of some kinds have, the leading ones of every class for
    ALL_CLASSES, or those that have a mean of the classes for MEAN."""
    known = class_figures(present)
    if class_name == MEAN:
        means = (one for one in known if isinstance(one, ObjectFigure) and one.of_classes)
        return tuple(FigureColumn(ALL, one, one.title, one.short) for one in means)
    if class_name != ALL_CLASSES:
        return tuple(FigureColumn(class_name, figure, figure.title, figure.short) for figure in known)
    return tuple(
        FigureColumn(
            name,
            figure,
            f"{name} {in_sentence(figure.short)}",
            f"{_SHORT_CLASSES.get(name, name)} {in_sentence(figure.short)}",
        )
        for name in CLASSES
        for figure in known
        if figure.leads
    )


def kinds_in(rows: Iterable[CompareRow]) -> frozenset[str]:
    """Return the kinds of sensor that some rigs hold."""
    return frozenset(sensor.kind for row in rows for sensor in row.rig.sensors)


def table_text(rows: Sequence[CompareRow], delimiter: str) -> str:
    """Return every figure of every rig in full precision, whatever the window shows; one line per rig."""
    present = kinds_in(rows)
    kinds = shown_kinds(present)
    columns = [column for name in (*CLASSES, MEAN) for column in columns_for(name, present)]
    titles = [f"{one.who} {in_sentence(one.title)} ({EXACT_UNITS[one.figure.unit]})" for one in columns]
    lines: list[Sequence[object]] = [["rig", "origin", "where", *(kind.plural for kind in kinds), *titles]]
    for row in rows:
        said = [spreadsheet_cell(text) for text in (row.name, ORIGIN_TITLES[row.origin], row.where)]
        counts = (len(row.rig.enabled_of(kind.model)) for kind in kinds)
        found = (column.value((row.scores, row.counted)) for column in columns)
        lines.append((*said, *counts, *(exact(one.value if one and one.exists else None) for one in found)))
    return delimited(lines, delimiter)


Shown = Literal["values", "first", "baseline"]
RIG, SENSORS, FIRST_FIGURE = 0, 1, 2
FOLLOWS = "…"
_UNKNOWN = Cell(FOLLOWS, (None,), tone="muted")


class CompareModel(FigureModel):
    """Rows in the order in which they were added; a row without scores shows that they follow."""

    renamed = Signal(str, str)
    """Key of a row and the name that the user typed."""

    def __init__(self) -> None:
        super().__init__()
        self._rigs: tuple[CompareRow, ...] = ()
        self._class_name = ALL_CLASSES
        self._figures_shown = columns_for(ALL_CLASSES)
        self._kind: Shown = "values"
        self._reading: Reading = "covered"
        self._baseline: Known = (None, None)
        self._refresh(anew=True)

    # ------------------------------------------------------------------ what is shown
    def set_rows(self, rows: Sequence[CompareRow]) -> None:
        """Show these rigs; the view keeps its scroll position when only numbers are new."""
        is_same = [row.key for row in rows] == [row.key for row in self._rigs]
        self._rigs = tuple(rows)
        self._choose_columns()
        self._refresh(anew=not is_same)

    def set_class(self, class_name: str) -> None:
        """Show all figures of a class, the leading ones of ALL_CLASSES, or the means of the classes for MEAN."""
        self._class_name = class_name
        self._choose_columns()
        self._refresh(anew=True)

    def _choose_columns(self) -> None:
        self._figures_shown = columns_for(self._class_name, kinds_in(self._rigs))

    def set_shown(self, shown: Shown) -> None:
        """Show values, or differences to the first rig or to the baseline."""
        self._kind = shown
        self._refresh()

    def set_baseline(self, scores: Scores | None, counted: Values | None, reading: Reading) -> None:
        """Set the figures of the baseline, and the reading, which decides the direction of the paper's figures."""
        self._baseline, self._reading = (scores, counted), reading
        self._refresh()

    @property
    def rows(self) -> tuple[CompareRow, ...]:
        """The rigs, in the order in which they were added."""
        return self._rigs

    @property
    def columns(self) -> tuple[FigureColumn, ...]:
        """The figures that are shown, from the column FIRST_FIGURE on."""
        return self._figures_shown

    @property
    def _reference(self) -> Known:
        """Return the figures of the rig that differences refer to."""
        if self._kind == "first":
            return (self._rigs[0].scores, self._rigs[0].counted) if self._rigs else (None, None)
        return self._baseline

    def flags(self, index: Index) -> Qt.ItemFlag:
        is_own_name = index.column() == RIG and self._rigs[index.row()].origin == "snapshot"
        return super().flags(index) | (Qt.ItemFlag.ItemIsEditable if is_own_name else Qt.ItemFlag(0))

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if index.column() == RIG and role in (Qt.ItemDataRole.EditRole, SORT):
            return self._rigs[index.row()].name  # without what the title adds
        return super().data(index, role)

    def setData(self, index: Index, value: Any, role: int = Qt.ItemDataRole.EditRole) -> bool:
        """Give a snapshot another name."""
        if role != Qt.ItemDataRole.EditRole or not str(value).strip():
            return False
        self.renamed.emit(self._rigs[index.row()].key, str(value).strip())
        return True

    def estimate(self, row: CompareRow, column: FigureColumn) -> Estimate | None:
        """Return the shown value of a rig, or its difference; None while it is unknown."""
        value = column.value((row.scores, row.counted))
        if value is None or self._kind == "values":
            return value
        before = column.value(self._reference)
        return None if before is None else value.minus(before)

    def text(self, column: FigureColumn, found: Estimate) -> str:
        """Return a value or a difference with its error; without it where all classes share the width."""
        if self._class_name != ALL_CLASSES:
            written = estimate_text if self._kind == "values" else change_estimate_text
            return written(column.figure, found)
        text = value_text if self._kind == "values" else change_text
        return text(column.figure, found.value, decimals=decimals_of(column.figure, found.se))

    # ------------------------------------------------------------------ cells
    def _refresh(self, anew: bool = False) -> None:
        columns = [
            Heading(column.title, f"{column.who}: {column.figure.tip}", column.in_two_lines)
            for column in self._figures_shown
        ]
        self.show(
            [Heading(row.title) for row in self._rigs],
            [Heading("Rig", is_left=True), Heading("Sensors", is_left=True), *columns],
            [
                [
                    *_about(row, self._judgement(row)),
                    *(self._cell(row, column) for column in self._figures_shown),
                ]
                for row in self._rigs
            ],
            anew,
        )

    def _judgement(self, row: CompareRow) -> str:
        """Say whether a rig is better than the one that differences refer to, the baseline for values."""
        before, is_first = self._reference[1], self._kind == "first"
        if row.counted is None or before is None:
            return ""
        name = self._rigs[0].title if is_first else "the baseline"
        return sentence(changes_between(row.counted, before), name)

    def _cell(self, row: CompareRow, column: FigureColumn) -> Cell:
        found = self.estimate(row, column)
        if found is None:
            return _UNKNOWN
        if not found.exists:
            return Cell(NONE, (None,), found.reason, tone="muted")
        number, is_outside = found.value, found.state == "outside"
        is_value = self._kind == "values"
        tip = (precise_text if is_value else change_estimate_text)(column.figure, found)
        tip = "\n".join(filter(None, (tip, parts_text(column.figure, found) if is_value else "")))
        tip = f"{tip}\nOutside the domain: {found.reason}" if is_outside else tip
        if is_value:
            return Cell(
                self.text(column, found),
                (number,),
                tip,
                tone="muted" if is_outside else "text",
                bar=self._bar_share(column, number),
                bar_colour=CLASS_COLOURS.get(column.class_name),
            )
        said = verdict(in_reading(column.figure, self._reading), found)
        tip = f"{tip}: {said}" if said == UNRESOLVED else tip
        tones: dict[str, Tone] = {"better": "more", "worse": "less"}
        tone = "muted" if is_outside else tones.get(said, "text")
        return Cell(self.text(column, found), (number,), tip, tone=tone)

    def _bar_share(self, column: FigureColumn, value: float) -> float:
        """Return the length of a value relative to the largest of its column; shares are of the whole."""
        if column.figure.unit == "share":
            return value
        values = [column.value((row.scores, row.counted)) for row in self._rigs]
        largest = max(abs(one.value) for one in values if one is not None)
        return abs(value) / largest if largest else 0.0


def _about(row: CompareRow, judgement: str) -> tuple[Cell, Cell]:
    """Return the name and the sensors of a rig, with whether it is better than another."""
    tip = f"{row.name}: {ORIGIN_TITLES[row.origin]}{f', {row.where}' if row.where else ''}"
    tip = "\n".join(filter(None, (tip, judgement)))
    name = Cell(row.title, tip=tip, is_bold=row.origin == "current")
    return name, Cell(row.sensors, tip=tip, tone="muted", is_bold=name.is_bold)
