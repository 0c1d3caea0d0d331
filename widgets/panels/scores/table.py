"""The table of scores: value and change of four figures by class, and of S-MIG by kind of sensor on request."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from PySide6.QtGui import QFontMetrics, QResizeEvent
from PySide6.QtWidgets import QHeaderView

from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import shown_kinds
from riglens.core.targets.quantities import CLASSES_AND_ALL, SE_FACTOR, Cells, PredictedCells, of_100
from riglens.core.targets.quantities import ON_TARGET as ON_TARGET_QUANTITY
from riglens.core.targets.quantities import PREDICTED as PREDICTED_QUANTITY
from riglens.widgets.panels.controls.item_views import OwnKeys, StandardKey
from riglens.widgets.panels.figures.table import NOTHING, Figure, FigureTable, Heading, Tone
from riglens.widgets.panels.scores.text import (
    NONE,
    NOTHING_NOTE,
    ON_TARGET,
    PREDICTED,
    Column,
    MetricColumn,
    change_text,
    columns,
    exact_text,
    looks_at_more,
    rough_text,
    sampled_change_text,
    sampled_text,
    value_text,
)
from riglens.widgets.panels.targets.text import tells_apart, tip_text
from riglens.widgets.theme import CLASS_COLOURS

ABOUT, FOLLOWS = "≈ ", "…"
LAST_SAVED = "the last saved rig"
CLASS_PX, CHANGE_PX = 108, 88
NARROW_PX = 1400
ROW_PX = 26
ESTIMATE_NOTE = "Estimated on larger voxels; the exact number follows when the mouse rests."
LONGEST_VALUE = "100.0 ±10.0 %"
LONGEST_CHANGES, _CELL_MARGIN_PX = ("−100.00 pp", "−10.0 ±10.0 pp", "−1000.00 ↓"), 6
CHANGE_TIP = "Change from the baseline: the snapshot or chosen rig, or else the rig last saved or opened."
_COUNTED, _SCORES = 0, 4
"""First columns of what is counted on objects, and of the scores."""


class ScoreTable(FigureTable):
    """Value and change of every figure by class."""

    def __init__(self) -> None:
        super().__init__("Scores by class")
        self._columns = columns()
        self._shown: tuple[Column, ...] = (PREDICTED, ON_TARGET, *self._columns)
        self._baseline = LAST_SAVED
        self.setSelectionMode(self.SelectionMode.ContiguousSelection)
        OwnKeys(self, {StandardKey.Copy: self.copy})
        titles = [heading for column in self._shown for heading in _headings(column)]
        self.figures.show(_classes(None), titles, [[NOTHING] * len(titles)] * len(CLASSES))
        rows, header = self.verticalHeader(), self.horizontalHeader()
        rows.setDefaultSectionSize(ROW_PX)
        rows.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        rows.setMinimumWidth(CLASS_PX)
        header.setMinimumSectionSize(
            self.fontMetrics().horizontalAdvance(LONGEST_VALUE) + 2 * _CELL_MARGIN_PX
        )
        for place in range(len(titles)):
            mode = QHeaderView.ResizeMode.Fixed if place % 2 else QHeaderView.ResizeMode.Stretch
            header.setSectionResizeMode(place, mode)
            header.resizeSection(place, self._change_px())
        self.set_details(False)
        self.setMinimumHeight(header.sizeHint().height() + len(CLASSES) * ROW_PX)

    def _change_px(self) -> int:
        """Return the width of a column of changes: room for the longest that there can be."""
        wide = QFontMetrics(self.font()).horizontalAdvance
        return max(CHANGE_PX, max(map(wide, LONGEST_CHANGES)) + 2 * _CELL_MARGIN_PX + 1)

    def set_details(self, shown: bool) -> None:
        """Show S-MIG by kind, of which S-MS is made, beside the four figures, or hide it."""
        for kind in shown_kinds(()):
            for key in (kind.name, f"{kind.name} change"):
                self.setColumnHidden(self.place_of(key), not shown)

    def place_of(self, column: str) -> int:
        """Return the column of a key, followed by " change" for its change."""
        key, _, is_change = column.partition(" ")
        return 2 * [shown.key for shown in self._shown].index(key) + bool(is_change)

    def cell(self, class_name: str, column: str) -> Figure:
        """Return the cell of a class and a column key, followed by " change" for its change."""
        return self.figures.cell(CLASSES.index(class_name), self.place_of(column))

    def set_baseline(self, name: str) -> None:
        """Set the baseline of changes, for tooltips."""
        self._baseline = name

    def show_scores(self, scores: Scores, baseline: Scores, settings: MetricSettings) -> None:
        """Show exact values and their change against the baseline."""
        self.figures.set_row_titles(_classes(scores))
        self.figures.show_columns(
            _SCORES,
            [
                [
                    figure
                    for column in self._columns
                    for figure in self._pair(column, scores, baseline, name, settings)
                ]
                for name in CLASSES
            ],
        )

    def _pair(
        self, column: MetricColumn, scores: Scores, baseline: Scores, name: str, settings: MetricSettings
    ) -> tuple[Figure, Figure]:
        """Return value and change of a score of a class."""
        value, has_boxes = column.value(scores.classes[name]), scores.classes[name].h_total > 0.0
        change = 0.0 if math.isnan(value) else value - column.value(baseline.classes[name])
        more = looks_at_more(change, column, settings.reading)
        meaning = "the same as" if change == 0 else "covers more than" if more else "covers less than"
        first = Figure(
            value_text(column, value),
            (None if math.isnan(value) else value,),
            exact_text(column, value) if has_boxes else NOTHING_NOTE,
            tone="text" if has_boxes else "muted",
        )
        second = Figure(
            change_text(change, column),
            (change,),
            f"{exact_text(column, change)}: {meaning} {self._baseline}",
            tone="muted" if change == 0 else "text" if not column.is_share else "more" if more else "less",
        )
        return first, second

    def show_estimate(self, scores: Scores) -> None:
        """Show rough values without changes; they cannot be copied."""
        follows = Figure(FOLLOWS, (None,), ESTIMATE_NOTE, tone="muted", is_italic=True)

        def rough(column: MetricColumn, name: str) -> Figure:
            value = column.value(scores.classes[name])
            text = NONE if math.isnan(value) else ABOUT + rough_text(column, value)
            return Figure(text, (None,), ESTIMATE_NOTE, tone="muted", is_italic=True)

        shown = [
            [figure for column in self._columns for figure in (rough(column, name), follows)]
            for name in CLASSES
        ]
        self.figures.show_columns(_SCORES, shown)

    def show_pending(self) -> None:
        """Show no values: none is known of this rig."""
        follows = Figure(FOLLOWS, (None,), ESTIMATE_NOTE, tone="muted", is_italic=True)
        self.figures.show_columns(_SCORES, [[follows] * (2 * len(self._columns)) for _ in CLASSES])

    def show_counted(self, on_target: Cells, predicted: PredictedCells) -> None:
        """Show predicted detection and on target by class, with changes against the baseline and ±."""
        rows = []
        for name in CLASSES:
            row = CLASSES_AND_ALL.index(name)
            is_resolved = tells_apart(ON_TARGET_QUANTITY, float(on_target.change[row]))
            tip = tip_text(ON_TARGET_QUANTITY, name, on_target, row, self._baseline)
            is_as_clear = is_resolved and tells_apart(PREDICTED_QUANTITY, float(predicted.cells.change[row]))
            rows.append(
                [
                    *_sampled(
                        predicted.cells, row, float(predicted.se[row]), _tip(predicted, row), is_as_clear
                    ),
                    *_sampled(on_target, row, float(on_target.se[row]), tip, is_resolved),
                ]
            )
            if predicted.outside:
                rows[-1][:2] = [replace(figure, tone="muted") for figure in rows[-1][:2]]
        self.figures.show_columns(_COUNTED, rows)

    def forget_counted(self, reason: str) -> None:
        """Show no number on objects, and the reason."""
        none = Figure(tip=reason, tone="muted")
        self.figures.show_columns(_COUNTED, [[none] * (_SCORES - _COUNTED)] * len(CLASSES))

    def grey_counted(self) -> None:
        """Show what is counted on objects in the muted colour."""
        self.figures.grey(range(_COUNTED, _SCORES))

    def grey(self) -> None:
        """Show every score in the muted colour; what is counted is greyed separately."""
        self.figures.grey(range(_SCORES, self.figures.columnCount()))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Shorten titles where space is short."""
        super().resizeEvent(event)
        self.figures.set_narrow(event.size().width() < NARROW_PX)


def _sampled(cells: Cells, row: int, se: float, tip: str, is_resolved: bool) -> tuple[Figure, Figure]:
    """Return value and change of a class; neither better nor worse within the error of the change, or unresolved."""
    value, change, change_se = (float(part[row]) for part in (cells.value, cells.change, cells.change_se))
    is_none, is_sure = math.isnan(value), is_resolved and abs(change) > 2.0 * change_se
    first = Figure(
        sampled_text(value, se),
        (None, None) if is_none else (value, se),
        tip,
        tone="muted" if is_none else "text",
    )
    tone: Tone = (
        "muted" if math.isnan(change) else "text" if not is_sure else "more" if change > 0.0 else "less"
    )
    second = Figure(
        sampled_change_text(change, change_se), (None if math.isnan(change) else change,), tip, tone=tone
    )
    return first, second


def _tip(predicted: PredictedCells, row: int) -> str:
    """Describe predicted detection of a class: its value, objects, detector and domain."""
    value, objects = float(predicted.cells.value[row]), int(predicted.cells.objects[row])
    lines = [f"Outside the domain: {predicted.outside}"] if predicted.outside else []
    if objects:
        error = 100.0 * SE_FACTOR * float(predicted.se[row])
        lines.append(
            f"{CLASSES_AND_ALL[row]}: AP {100.0 * value:.1f} ± {error:.1f} %, over {objects:,} objects"
        )
        lines.append("± two standard errors, of the calibration and of a sample of frames")
    else:
        lines.append(f"{CLASSES_AND_ALL[row]}: no prediction for the objects in these frames")
    lines.append(predicted.about)
    if said := found_text(predicted, (row,)):
        lines += [said, predicted.found.about if predicted.found else ""]
    return "\n".join(lines)


def found_text(predicted: PredictedCells, rows: Iterable[int] = range(1, len(CLASSES_AND_ALL))) -> str:
    """Say how many of 100 objects of some of `CLASSES_AND_ALL` are found, with two standard errors, or why the rig is
    outside the domain; empty where no calibration says so."""
    found = predicted.found
    if found is None:
        return ""
    shares = {
        CLASSES_AND_ALL[row]: (float(found.cells.value[row]), SE_FACTOR * float(found.se[row]))
        for row in rows
        if found.cells.objects[row]
    }
    said = of_100(shares, found.region)
    return f"Outside the domain: {found.outside}. {said}" if said and found.outside else said


def _classes(scores: Scores | None) -> list[Heading]:
    """Return the titles of the rows; classes without boxes are muted."""
    empty = [name for name in CLASSES if scores is not None and not scores.classes[name].h_total > 0.0]
    return [
        Heading(
            name,
            NOTHING_NOTE if name in empty else "",
            colour=CLASS_COLOURS[name],
            is_muted=name in empty,
        )
        for name in CLASSES
    ]


def _headings(column: Column) -> tuple[Heading, Heading]:
    unit = "fraction" if column.is_share else "nat"
    copied = (f"{column.title} ({unit})", *(("standard error",) if column in (PREDICTED, ON_TARGET) else ()))
    shown = "" if column.is_share else ", 10³ nat"
    return (
        Heading(f"{column.title}{shown}", column.tip, f"{column.short}{shown}", copied=copied),
        Heading("change", CHANGE_TIP, copied=(f"change ({unit})",)),
    )
