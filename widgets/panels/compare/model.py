"""Rigs to compare: rows, columns, sort keys and bars as a Qt model, and the whole as text for spreadsheets."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt, Signal
from PySide6.QtGui import QBrush, QColor, QFont

from riglens.core.metric.scores import ClassScores, Reading, Scores
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import kinds
from riglens.core.shown_text import spreadsheet_cell
from riglens.core.targets.quantities import Figures
from riglens.widgets.panels.controls.item_views import BAR_COLOUR, BAR_SHARE
from riglens.widgets.panels.controls.style import plain_tip, tones
from riglens.widgets.panels.scores.text import (
    COLUMNS,
    DETECTED,
    NONE,
    ON_TARGET,
    Column,
    MetricColumn,
    change_text,
    exact_text,
    looks_at_more,
    value_text,
)
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
        return f"{self.name} (open)" if self.origin == "current" else self.name

    @property
    def sensors(self) -> str:
        """How many sensors count, by kind."""
        counts = zip(self.counts, kinds(), strict=True)
        return " + ".join(f"{count} {kind.title[0].upper()}" for count, kind in counts)

    @property
    def counts(self) -> list[int]:
        """How many sensors of each kind count."""
        return [len(self.rig.enabled_of(kind.model)) for kind in kinds()]


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
    known = {column.key: column for column in (ON_TARGET, DETECTED, *COLUMNS)}
    if class_name != ALL_CLASSES:
        return tuple(ScoreColumn(class_name, column, column.title) for column in known.values())
    return tuple(
        ScoreColumn(name, known[key], f"{name} {title}")
        for name in CLASSES
        for key, title in _SHOWN_OF_ALL.items()
    )


_FIGURES = ("on target (fraction)", "detected (fraction)", "road users")


def _fields() -> dict[str, Callable[[ClassScores], float]]:
    """Return what is written of a class's scores, by title."""

    def of_kind(kind: str, figure: str) -> Callable[[ClassScores], float]:
        return lambda found: float(getattr(found.kinds[kind], figure))

    found: dict[str, Callable[[ClassScores], float]] = {"H total (nat)": lambda c: c.h_total}
    for kind in sorted(kinds(), key=lambda kind: kind.name):
        found[f"{kind.title} S-MIG (nat)"] = of_kind(kind.name, "s_mig")
        found[f"{kind.title} seen (fraction)"] = of_kind(kind.name, "seen")
    return found | {"S-MS (nat)": lambda c: c.s_ms, "seen (fraction)": lambda c: c.any_seen}


def table_text(rows: Sequence[CompareRow], delimiter: str) -> str:
    """Return every number of every rig in full precision, whatever the window shows; one line per rig."""
    stream = io.StringIO()
    writer = csv.writer(stream, delimiter=delimiter, lineterminator="\n")
    titles = [f"{name} {title}" for name in CLASSES for title in (*_FIGURES, *_fields())]
    writer.writerow(["rig", "origin", "where", *(kind.plural for kind in kinds()), *titles])
    for row in rows:
        said = map(spreadsheet_cell, (row.name, ORIGIN_TITLES[row.origin], row.where))
        writer.writerow([*said, *row.counts, *_numbers(row)])
    return stream.getvalue()


def _numbers(row: CompareRow) -> list[str]:
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
            repr(read(scores.classes[name])) if scores is not None else "" for read in _fields().values()
        ]
    return found


Index = QModelIndex | QPersistentModelIndex
Shown = Literal["values", "first", "baseline"]
RIG, SENSORS, FIRST_SCORE = 0, 1, 2
SORT = Qt.ItemDataRole.UserRole.value
FOLLOWS = "…"
_ROLE = Qt.ItemDataRole


class CompareModel(QAbstractTableModel):
    """Rows in the order in which they were added; a row without scores shows that they follow."""

    renamed = Signal(str, str)
    """Key of a row and the name that the user typed."""

    def __init__(self) -> None:
        super().__init__()
        self._rows: tuple[CompareRow, ...] = ()
        self._columns = columns_for(ALL_CLASSES)
        self._shown: Shown = "values"
        self._is_narrow = False
        self._reading: Reading = "covered"
        self._baseline: tuple[Scores | None, Figures | None] = (None, None)

    # ------------------------------------------------------------------ what is shown
    def set_rows(self, rows: Sequence[CompareRow]) -> None:
        """Show these rigs; the view keeps its scroll position when only numbers are new."""
        keys = [row.key for row in rows]
        if keys == [row.key for row in self._rows]:
            self._rows = tuple(rows)
            self._numbers_changed()
            return
        self.beginResetModel()
        self._rows = tuple(rows)
        self.endResetModel()

    def set_class(self, class_name: str) -> None:
        """Show all scores of a class, or the main ones of ALL_CLASSES."""
        self.beginResetModel()
        self._columns = columns_for(class_name)
        self.endResetModel()

    def set_shown(self, shown: Shown) -> None:
        """Show values, or differences to the first rig or to the baseline."""
        self._shown = shown
        self._numbers_changed()

    def set_narrow(self, is_narrow: bool) -> None:
        """Give columns short titles, or full ones."""
        if is_narrow != self._is_narrow:
            self._is_narrow = is_narrow
            self.headerDataChanged.emit(Qt.Orientation.Horizontal, FIRST_SCORE, self.columnCount() - 1)

    def set_baseline(self, scores: Scores | None, figures: Figures | None, reading: Reading) -> None:
        """Set what is known of the baseline, and the reading, which decides what a smaller S-MS means."""
        self._baseline, self._reading = (scores, figures), reading
        self._numbers_changed()

    def _numbers_changed(self) -> None:
        if self._rows:
            self.dataChanged.emit(self.index(0, 0), self.index(len(self._rows) - 1, self.columnCount() - 1))

    @property
    def rows(self) -> tuple[CompareRow, ...]:
        """The rigs, in the order in which they were added."""
        return self._rows

    @property
    def columns(self) -> tuple[ScoreColumn, ...]:
        """The scores that are shown, from the column FIRST_SCORE on."""
        return self._columns

    @property
    def _reference(self) -> tuple[Scores | None, Figures | None]:
        """What is known of the rig that differences count from."""
        if self._shown == "first":
            return (self._rows[0].scores, self._rows[0].figures) if self._rows else (None, None)
        return self._baseline

    # ------------------------------------------------------------------ Qt's questions
    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008 Qt's signature
        return 0 if parent.isValid() else len(self._rows)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: B008 Qt's signature
        return 0 if parent.isValid() else FIRST_SCORE + len(self._columns)

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = _ROLE.DisplayRole) -> Any:
        if orientation != Qt.Orientation.Horizontal:
            return None
        column = self._columns[section - FIRST_SCORE] if section >= FIRST_SCORE else None
        if role == _ROLE.DisplayRole:
            if column is None:
                return ("Rig", "Sensors")[section]
            return column.short if self._is_narrow else column.title
        if role == _ROLE.ToolTipRole and column is not None:
            return f"{column.class_name}: {column.score.tip}"
        if role == _ROLE.TextAlignmentRole:
            side = Qt.AlignmentFlag.AlignRight if section >= FIRST_SCORE else Qt.AlignmentFlag.AlignLeft
            return side | Qt.AlignmentFlag.AlignVCenter
        return None

    def flags(self, index: Index) -> Qt.ItemFlag:
        flags = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable
        is_own_name = index.column() == RIG and self._rows[index.row()].origin == "snapshot"
        return flags | Qt.ItemFlag.ItemIsEditable if is_own_name else flags

    def setData(self, index: Index, value: Any, role: int = _ROLE.EditRole) -> bool:
        """Give a snapshot another name."""
        if role != _ROLE.EditRole or not str(value).strip():
            return False
        self.renamed.emit(self._rows[index.row()].key, str(value).strip())
        return True

    def data(self, index: Index, role: int = _ROLE.DisplayRole) -> Any:
        row = self._rows[index.row()]
        if index.column() < FIRST_SCORE:
            return _rig_data(row, index.column(), role)
        if role == _ROLE.TextAlignmentRole:
            return Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        return self._score_data(row, self._columns[index.column() - FIRST_SCORE], role)

    def figure(self, row: CompareRow, column: ScoreColumn) -> float | None:
        """Return what is shown of a rig: the value or the difference; None while unknown, NaN where there is none."""
        value = column.value(row.scores, row.figures)
        if value is None or self._shown == "values" or math.isnan(value):
            return value
        before = column.value(*self._reference)
        return None if before is None else value - before

    def figure_text(self, column: ScoreColumn, figure: float) -> str:
        """Return a figure as the cells show it."""
        if self._shown != "values" and not math.isnan(figure):
            return change_text(figure, column.score)
        return value_text(column.score, figure)

    def _score_data(self, row: CompareRow, column: ScoreColumn, role: int) -> Any:
        figure = self.figure(row, column)
        if figure is None or math.isnan(figure):
            return _waiting_data(role, FOLLOWS if figure is None else NONE)
        if role == SORT:
            return figure
        if role == _ROLE.DisplayRole:
            return self.figure_text(column, figure)
        if role == _ROLE.ToolTipRole:
            return exact_text(column.score, figure)
        if self._shown == "values":
            bar = {BAR_SHARE: self._bar_share(column, figure), BAR_COLOUR: CLASS_COLOURS[column.class_name]}
            return bar.get(role)
        if role == _ROLE.ForegroundRole and figure and column.score.is_share:
            more = looks_at_more(figure, column.score, self._reading)
            return QBrush(QColor(tones().more if more else tones().less))
        return None

    def _bar_share(self, column: ScoreColumn, value: float) -> float:
        """Return the length of a value beside the largest of its column; shares are of the whole."""
        if column.score.is_share:
            return value
        values = [column.value(row.scores, row.figures) for row in self._rows]
        largest = max(abs(value) for value in values if value is not None)
        return abs(value) / largest if largest else 0.0


def _rig_data(row: CompareRow, column: int, role: int) -> Any:
    """Return the name and sensors of a rig."""
    if role == _ROLE.DisplayRole and column == RIG:
        return row.title
    if role in (_ROLE.DisplayRole, _ROLE.EditRole, SORT):
        return row.name if column == RIG else row.sensors
    if role == _ROLE.ToolTipRole:
        return plain_tip(f"{row.name}: {ORIGIN_TITLES[row.origin]}{f', {row.where}' if row.where else ''}")
    if role == _ROLE.FontRole and row.origin == "current":
        font = QFont()
        font.setBold(True)
        return font
    if role == _ROLE.ForegroundRole and column == SENSORS:
        return QBrush(QColor(tones().muted))
    return None


def _waiting_data(role: int, text: str = FOLLOWS) -> Any:
    """Return the data of a cell without a number, or without one yet; it sorts before all others."""
    if role == _ROLE.DisplayRole:
        return text
    if role == _ROLE.ForegroundRole:
        return QBrush(QColor(tones().muted))
    return float("-inf") if role == SORT else None
