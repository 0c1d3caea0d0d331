"""Rigs to compare: rows, columns, sort keys and bars as a Qt model, and the whole as text for spreadsheets."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from PySide6.QtCore import Qt, Signal

from riglens.core.metric.scores import ClassScores, Reading, Scores
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import AnyKind, shown_kinds
from riglens.core.shown_text import spreadsheet_cell, visible
from riglens.core.targets.quantities import RESOLVED, Figures
from riglens.widgets.panels.figures.table import SORT, Figure, FigureModel, Heading, Index, delimited
from riglens.widgets.panels.scores.text import (
    DETECTED,
    NONE,
    ON_TARGET,
    Column,
    MetricColumn,
    change_text,
    columns,
    exact_text,
    looks_at_more,
    value_text,
)
from riglens.widgets.panels.targets.text import UNRESOLVED
from riglens.widgets.theme import CLASS_COLOURS

Origin = Literal["current", "snapshot", "preset", "file"]
ORIGIN_TITLES: dict[Origin, str] = {
    "current": "being edited",
    "snapshot": "snapshot",
    "preset": "preset",
    "file": "file",
}
ALL_CLASSES = "all classes"
_SHORT_CLASSES = {"pedestrian": "ped.", "bicycle": "bike"}
_SHOWN_OF_ALL = {"on_target": "on target", "seen": "seen", "s_ms": "S-MS"}


@dataclass(frozen=True)
class CompareRow:
    """One rig; `where` is its preset's name or its path, `scores` and `figures` None until they are computed.

    No `figures` of any class: they cannot be counted.
    """

    key: str
    name: str
    origin: Origin
    rig: Rig
    where: str = ""
    scores: Scores | None = None
    figures: Figures | None = None

    @property
    def title(self) -> str:
        """The name as shown; the rig being edited may have the name of the preset that it began as."""
        return visible(f"{self.name} (open)" if self.origin == "current" else self.name)

    @property
    def sensors(self) -> str:
        """Return the number of sensors that count, by kind, in words."""
        shown = shown_kinds(sensor.kind for sensor in self.rig.sensors if sensor.enabled)
        return " + ".join(f"{len(self.rig.enabled_of(kind.model))} {kind.title[0].upper()}" for kind in shown)


@dataclass(frozen=True)
class ScoreColumn:
    """One number per rig: a figure of a class."""

    class_name: str
    score: Column
    title: str

    @property
    def short(self) -> str:
        """The title where space is short."""
        return self.title.replace(self.class_name, _SHORT_CLASSES.get(self.class_name, self.class_name))

    def value(self, scores: Scores | None, figures: Figures | None) -> float | None:
        """Return the number, in nat or as a fraction; None while it is not known."""
        if isinstance(self.score, MetricColumn):
            return None if scores is None else self.score.value(scores.classes[self.class_name])
        if not figures:
            return None if figures is None else math.nan
        found = figures[self.class_name]
        return found.on_target if self.score is ON_TARGET else found.detected


def columns_for(class_name: str) -> tuple[ScoreColumn, ...]:
    """Return all figures of one class, or the three main ones of every class for ALL_CLASSES."""
    known = {column.key: column for column in (ON_TARGET, DETECTED, *columns())}
    if class_name != ALL_CLASSES:
        return tuple(ScoreColumn(class_name, column, column.title) for column in known.values())
    return tuple(
        ScoreColumn(name, known[key], f"{name} {title}")
        for name in CLASSES
        for key, title in _SHOWN_OF_ALL.items()
    )


_FIGURES = ("on target (fraction)", "detected (fraction)", "objects")


def _fields(shown: Sequence[AnyKind]) -> dict[str, Callable[[ClassScores], float]]:
    """Return the exported values of a class's scores, by title."""

    def of_kind(kind: str, figure: str) -> Callable[[ClassScores], float]:
        return lambda found: float(getattr(found.kinds[kind], figure))

    found: dict[str, Callable[[ClassScores], float]] = {"H total (nat)": lambda c: c.h_total}
    for kind in sorted(shown, key=lambda kind: kind.name):
        found[f"{kind.title} S-MIG (nat)"] = of_kind(kind.name, "s_mig")
        found[f"{kind.title} seen (fraction)"] = of_kind(kind.name, "seen")
    return found | {"S-MS (nat)": lambda c: c.s_ms, "seen (fraction)": lambda c: c.any_seen}


def table_text(rows: Sequence[CompareRow], delimiter: str) -> str:
    """Return every number of every rig in full precision, whatever the window shows; one line per rig."""
    shown = shown_kinds(sensor.kind for row in rows for sensor in row.rig.sensors)
    titles = [f"{name} {title}" for name in CLASSES for title in (*_FIGURES, *_fields(shown))]
    lines: list[Sequence[object]] = [["rig", "origin", "where", *(kind.plural for kind in shown), *titles]]
    for row in rows:
        said = [spreadsheet_cell(text) for text in (row.name, ORIGIN_TITLES[row.origin], row.where)]
        counts = (len(row.rig.enabled_of(kind.model)) for kind in shown)
        lines.append((*said, *counts, *_numbers(row, shown)))
    return delimited(lines, delimiter)


def _numbers(row: CompareRow, shown: Sequence[AnyKind]) -> list[str]:
    found: list[str] = []
    for name in CLASSES:
        if row.figures:
            own = row.figures[name]
            found += (
                [repr(own.on_target), repr(own.detected), str(own.objects)] if own.objects else ["", "", "0"]
            )
        else:
            found += [""] * len(_FIGURES)
        scores = row.scores
        found += [
            repr(read(scores.classes[name])) if scores is not None else "" for read in _fields(shown).values()
        ]
    return found


Shown = Literal["values", "first", "baseline"]
RIG, SENSORS, FIRST_SCORE = 0, 1, 2
FOLLOWS = "…"
_UNKNOWN, _NONE = (Figure(text, (None,), tone="muted") for text in (FOLLOWS, NONE))


class CompareModel(FigureModel):
    """Rows in the order in which they were added; a row without scores shows that they follow."""

    renamed = Signal(str, str)
    """Key of a row and the name that the user typed."""

    def __init__(self) -> None:
        super().__init__()
        self._rigs: tuple[CompareRow, ...] = ()
        self._scores = columns_for(ALL_CLASSES)
        self._kind: Shown = "values"
        self._reading: Reading = "covered"
        self._baseline: tuple[Scores | None, Figures | None] = (None, None)
        self._refresh(anew=True)

    # ------------------------------------------------------------------ what is shown
    def set_rows(self, rows: Sequence[CompareRow]) -> None:
        """Show these rigs; the view keeps its scroll position when only numbers are new."""
        is_same = [row.key for row in rows] == [row.key for row in self._rigs]
        self._rigs = tuple(rows)
        self._refresh(anew=not is_same)

    def set_class(self, class_name: str) -> None:
        """Show all scores of a class, or the main ones of ALL_CLASSES."""
        self._scores = columns_for(class_name)
        self._refresh(anew=True)

    def set_shown(self, shown: Shown) -> None:
        """Show values, or differences to the first rig or to the baseline."""
        self._kind = shown
        self._refresh()

    def set_baseline(self, scores: Scores | None, figures: Figures | None, reading: Reading) -> None:
        """Set the figures of the baseline, and the reading, which decides the meaning of a smaller S-MS."""
        self._baseline, self._reading = (scores, figures), reading
        self._refresh()

    @property
    def rows(self) -> tuple[CompareRow, ...]:
        """The rigs, in the order in which they were added."""
        return self._rigs

    @property
    def columns(self) -> tuple[ScoreColumn, ...]:
        """The scores that are shown, from the column FIRST_SCORE on."""
        return self._scores

    @property
    def _reference(self) -> tuple[Scores | None, Figures | None]:
        """Return the figures of the rig that differences refer to."""
        if self._kind == "first":
            return (self._rigs[0].scores, self._rigs[0].figures) if self._rigs else (None, None)
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

    def figure(self, row: CompareRow, column: ScoreColumn) -> float | None:
        """Return the shown value of a rig, or its difference; None while unknown, NaN where there is none."""
        value = column.value(row.scores, row.figures)
        if value is None or self._kind == "values" or math.isnan(value):
            return value
        before = column.value(*self._reference)
        return None if before is None else value - before

    def figure_text(self, column: ScoreColumn, figure: float) -> str:
        """Return a figure as the cells show it."""
        if self._kind != "values" and not math.isnan(figure):
            return change_text(figure, column.score)
        return value_text(column.score, figure)

    # ------------------------------------------------------------------ cells
    def _refresh(self, anew: bool = False) -> None:
        scores = [
            Heading(column.title, f"{column.class_name}: {column.score.tip}", column.short)
            for column in self._scores
        ]
        self.show(
            [Heading(row.title) for row in self._rigs],
            [Heading("Rig", is_left=True), Heading("Sensors", is_left=True), *scores],
            [[*_about(row), *(self._cell(row, column) for column in self._scores)] for row in self._rigs],
            anew,
        )

    def _cell(self, row: CompareRow, column: ScoreColumn) -> Figure:
        value = self.figure(row, column)
        if value is None or math.isnan(value):
            return _UNKNOWN if value is None else _NONE
        shown = Figure(self.figure_text(column, value), (value,), exact_text(column.score, value))
        if self._kind == "values":
            return replace(
                shown, bar=self._bar_share(column, value), bar_colour=CLASS_COLOURS[column.class_name]
            )
        if not value or not column.score.is_share:
            return shown
        if column.score is ON_TARGET and abs(value) < RESOLVED:
            return replace(shown, tip=f"{shown.tip}: {UNRESOLVED}")
        return replace(shown, tone="more" if looks_at_more(value, column.score, self._reading) else "less")

    def _bar_share(self, column: ScoreColumn, value: float) -> float:
        """Return the length of a value relative to the largest of its column; shares are of the whole."""
        if column.score.is_share:
            return value
        values = [column.value(row.scores, row.figures) for row in self._rigs]
        largest = max(abs(value) for value in values if value is not None)
        return abs(value) / largest if largest else 0.0


def _about(row: CompareRow) -> tuple[Figure, Figure]:
    """Return the name and the sensors of a rig."""
    tip = f"{row.name}: {ORIGIN_TITLES[row.origin]}{f', {row.where}' if row.where else ''}"
    name = Figure(row.title, tip=tip, is_bold=row.origin == "current")
    return name, Figure(row.sensors, tip=tip, tone="muted", is_bold=name.is_bold)
