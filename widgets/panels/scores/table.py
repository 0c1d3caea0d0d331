"""The table of scores: value and change of the leading figures by class, and details of the paper on request."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from itertools import compress

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QFontMetrics, QFontMetricsF, QResizeEvent
from PySide6.QtWidgets import QHeaderView

from riglens.core.figures.figure import ALL, CLASSES_AND_ALL, Estimate, Figure
from riglens.core.figures.text import (
    EXACT_UNITS,
    UNITS,
    change_estimate_text,
    estimate_text,
    parts_text,
    tip_text,
    value_text,
    verdict,
)
from riglens.core.figures.values import Compared, Values, class_figures, in_reading
from riglens.core.figures.weakest import NOWHERE, half_text, weakest_text, worst_names
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_values import NONE
from riglens.widgets.panels.controls.item_views import OwnKeys, StandardKey
from riglens.widgets.panels.figures.table import NOTHING, Cell, FigureTable, Heading, Tone, TwoLines
from riglens.widgets.theme import CLASS_COLOURS

ABOUT, FOLLOWS = "≈ ", "…"
LAST_SAVED = "the last saved rig"
CLASS_PX, CHANGE_PX = 108, 88
NARROW_PX = 1400
ROW_PX, TWO_LINES_PX = 24, 34
MEAN = "class mean"
ESTIMATE_NOTE = "Estimated on larger voxels; the exact number follows when the mouse rests."
LONGEST_VALUE = "100.0 ±10.0 %"
LONGEST_CHANGES, _CELL_MARGIN_PX = ("−100.00 pp", "−10.0 ±10.0 pp", "−1000.00 ↓"), 6
_TIGHT = {"share": ("100.0 ±10.0", "−10.0 ±10.0"), "nat": ("−100.00", "−100.00 ↓")}
"""Value and change for which a column has room, by unit, where space is so short that titles name the units."""
CHANGE_TIP = "Change from the baseline: the snapshot or chosen rig, or else the rig last saved or opened."
_NOT_MEANT = Cell("", (None,), "Entropies are not averaged over classes.", tone="muted")
_FOLLOWS = Cell(FOLLOWS, (None,), ESTIMATE_NOTE, tone="muted", is_italic=True)


class ScoreTable(FigureTable):
    """Value and change of every figure by class and of their mean, each figure in two columns.

    Where there is room a second line says what single kinds of sensors give, or where the figure is worst.
    """

    def __init__(self) -> None:
        super().__init__("Scores by class")
        known = class_figures()
        self._details = tuple(one for one in known if one.of_paper and not one.leads)
        self._shown: tuple[Figure, ...] = (*(one for one in known if one.leads), *self._details)
        self._reading = "covered"
        self._baseline = LAST_SAVED
        self.setSelectionMode(self.SelectionMode.ContiguousSelection)
        OwnKeys(self, {StandardKey.Copy: self.copy})
        titles = [heading for figure in self._shown for heading in _headings(figure)]
        self.figures.show(_classes({}), titles, [[NOTHING] * len(titles)] * len(CLASSES_AND_ALL))
        self.setItemDelegate(TwoLines(QSize(0, TWO_LINES_PX), TWO_LINES_PX, self))
        rows, header = self.verticalHeader(), self.horizontalHeader()
        rows.setDefaultSectionSize(ROW_PX)
        rows.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        rows.setMinimumWidth(CLASS_PX)
        header.setTextElideMode(Qt.TextElideMode.ElideRight)  # without it, the beginning is cut
        self._is_tight = False
        self._share_width()
        self.set_details(False)
        self.setMinimumHeight(header.sizeHint().height() + len(CLASSES_AND_ALL) * ROW_PX)

    def _least_px(self) -> tuple[int, int]:
        """Return the widths of a column of values and of changes with room for the longest that there can be."""
        wide = QFontMetrics(self.font()).horizontalAdvance
        change_px = max(CHANGE_PX, max(map(wide, LONGEST_CHANGES)) + 2 * _CELL_MARGIN_PX + 1)
        return wide(LONGEST_VALUE) + 2 * _CELL_MARGIN_PX, change_px

    def _share_width(self) -> None:
        """Give columns of changes their width; those of values share the rest."""
        header = self.horizontalHeader()
        value_px, change_px = self._least_px()
        header.setMinimumSectionSize(value_px)
        for place in range(header.count()):
            mode = QHeaderView.ResizeMode.Fixed if place % 2 else QHeaderView.ResizeMode.Stretch
            header.setSectionResizeMode(place, mode)
            header.resizeSection(place, change_px)

    def _share_tightly(self) -> None:
        """Give each column what its figures need without their units, and its title where all of them have the room,
        and an equal share of the rest."""
        header, wide = self.horizontalHeader(), QFontMetricsF(self.font()).horizontalAdvance
        figures_px = [
            math.ceil(wide(text)) + 2 * _CELL_MARGIN_PX
            for figure in self._shown
            for text in _TIGHT["nat" if figure.unit == "nat" else "share"]
        ]
        is_shown = [not self.isColumnHidden(place) for place in range(header.count())]
        needed_px = list(map(max, figures_px, map(header.sectionSizeHint, range(header.count()))))
        if sum(compress(needed_px, is_shown)) > self.viewport().width():
            needed_px = figures_px
        shown_px = list(compress(needed_px, is_shown))
        spare_px = max(0, self.viewport().width() - sum(shown_px)) // len(shown_px)
        header.setMinimumSectionSize(min(needed_px))
        header.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        for place, needed in enumerate(needed_px):
            if is_shown[place]:
                header.resizeSection(place, needed + spare_px)

    @property
    def shown(self) -> tuple[Figure, ...]:
        """The figures from left to right, those that are details last."""
        return self._shown

    def set_details(self, shown: bool) -> None:
        """Show the details of the paper beside the leading figures, or hide them."""
        for figure in self._details:
            for key in (figure.key, f"{figure.key} change"):
                self.setColumnHidden(self.place_of(key), not shown)
        if self._is_tight:
            self._share_tightly()

    def place_of(self, column: str) -> int:
        """Return the column of a key, followed by " change" for its change."""
        key, _, is_change = column.partition(" ")
        return 2 * [shown.key for shown in self._shown].index(key) + bool(is_change)

    def cell(self, class_name: str, column: str) -> Cell:
        """Return the cell of a class, or of `ALL`, and a column key, followed by " change" for its change."""
        return self.figures.cell(CLASSES_AND_ALL.index(class_name), self.place_of(column))

    def set_baseline(self, name: str) -> None:
        """Set the baseline of changes, for tooltips."""
        self._baseline = name

    def set_reading(self, reading: str) -> None:
        """Set the reading of S-MIG, which decides the direction of some figures."""
        self._reading = reading

    # ------------------------------------------------------------------ what is shown
    def show_figures(self, need: str, found: Mapping[str, Compared]) -> None:
        """Show the figures that need the same evaluation, by key: values and changes against the baseline."""
        if need == "voxels":
            self._show_classes(found.values())
        self._show(
            {
                key: [
                    self._pair(in_reading(figure, self._reading), who, found[key]) for who in CLASSES_AND_ALL
                ]
                for key, figure in self._of(need).items()
                if key in found
            },
        )

    def _pair(self, figure: Figure, who: str, found: Compared) -> tuple[Cell, Cell]:
        """Return value and change of a figure of a class, or of the mean of the classes, which figures of voxels do not
        have; neither better nor worse where the change is too small."""
        if who == ALL and figure.needs != "objects":
            return _NOT_MEANT, _NOT_MEANT
        value, change = found.value[who], found.change[who]
        weakest = found.weakest.get(who, NOWHERE)
        worst, half = weakest_text(figure, weakest), half_text(figure, weakest, is_short=True)
        where = MEAN if who == ALL else who
        tip = tip_text(
            figure, where, value, change, self._baseline, "\n".join(filter(None, (worst, found.about)))
        )
        is_muted = not value.exists or value.state == "outside"
        numbers = (value.value, value.se) if figure.needs == "objects" else (value.value,)
        return (
            Cell(
                estimate_text(figure, value),
                numbers if value.exists else (None,) * len(numbers),
                tip,
                tone="muted" if is_muted else "text",
                error=" · ".join(filter(None, (parts_text(figure, value) or worst_names(weakest), half))),
            ),
            Cell(
                change_estimate_text(figure, change),
                (change.value if change.exists else None,),
                tip,
                tone="muted" if is_muted else _tone(figure, change),
            ),
        )

    def show_estimate(self, found: Values) -> None:
        """Show rough values of figures of voxels without changes; they cannot be copied."""

        def rough(figure: Figure, value: Estimate) -> Cell:
            text = ABOUT + value_text(figure, value.value, decimals=1) if value.exists else NONE
            return Cell(text, (None,), ESTIMATE_NOTE, tone="muted", is_italic=True)

        self._show(
            {
                key: [(_NOT_MEANT,) * 2, *((rough(figure, found[key][name]), _FOLLOWS) for name in CLASSES)]
                for key, figure in self._of("voxels").items()
            },
        )

    def show_pending(self) -> None:
        """Show no figures of voxels: none is known of this rig."""
        rows = [(_NOT_MEANT, _NOT_MEANT), *[(_FOLLOWS, _FOLLOWS)] * len(CLASSES)]
        self._show(dict.fromkeys(self._of("voxels"), rows))

    def forget(self, need: str, reason: str) -> None:
        """Show no figure that needs an evaluation, and the reason."""
        none = Cell(tip=reason, tone="muted")
        self._show(dict.fromkeys(self._of(need), [(none, none)] * len(CLASSES_AND_ALL)))

    def grey(self, need: str) -> None:
        """Show the figures that need an evaluation in the muted colour."""
        first = (self.place_of(key) for key in self._of(need))
        self.figures.grey(place + part for place in first for part in (0, 1))

    def _of(self, need: str) -> dict[str, Figure]:
        return {figure.key: figure for figure in self._shown if figure.needs == need}

    def _show(self, pairs: Mapping[str, list[tuple[Cell, Cell]]]) -> None:
        """Show value and change of figures, by key, class by class."""
        self.figures.show_columns(
            {
                self.place_of(key) + part: [pair[part] for pair in rows]
                for key, rows in pairs.items()
                for part in (0, 1)
            }
        )

    def _show_classes(self, found: Collection[Compared]) -> None:
        """Mute the titles of classes that have no figure, and say why."""
        empty = {}
        for name in CLASSES:
            values = [one.value[name] for one in found]
            if values and not any(value.exists for value in values):
                empty[name] = values[0].reason
        self.figures.set_row_titles(_classes(empty))

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Shorten titles where space is short, and name units in them alone where the leading figures need it."""
        super().resizeEvent(event)
        self._share_height(event.size().height())
        width_px = event.size().width()
        self.figures.set_narrow(width_px < NARROW_PX)
        is_tight = width_px < sum(one.leads for one in self._shown) * sum(self._least_px())
        self.figures.name_units(is_tight)
        if self._is_tight and not is_tight:
            self._share_width()
        self._is_tight = is_tight
        if is_tight:
            self._share_tightly()

    def _share_height(self, height_px: int) -> None:
        """Give rows two lines where there is room, the first one before the others."""
        rows, spare_px = self.verticalHeader(), height_px - len(CLASSES_AND_ALL) * ROW_PX
        more_px = TWO_LINES_PX - ROW_PX
        for row in range(len(CLASSES_AND_ALL)):
            needed_px = more_px * (1 if row == 0 else len(CLASSES_AND_ALL))
            rows.resizeSection(row, TWO_LINES_PX if spare_px >= needed_px else ROW_PX)


def _tone(figure: Figure, change: Estimate) -> Tone:
    if not change.exists or change.value == 0.0:
        return "muted"
    tones: dict[str, Tone] = {"better": "more", "worse": "less"}
    return tones.get(verdict(figure, change), "text")


def _classes(empty: Mapping[str, str]) -> list[Heading]:
    """Return the titles of the rows; classes without anything to measure are muted, with the reason."""
    return [
        Heading(MEAN, "Mean of the classes.", copied=(MEAN,)),
        *(
            Heading(name, empty.get(name, ""), colour=CLASS_COLOURS[name], is_muted=name in empty)
            for name in CLASSES
        ),
    ]


def _headings(figure: Figure) -> tuple[Heading, Heading]:
    unit, errors = EXACT_UNITS[figure.unit], ("standard error",) if figure.needs == "objects" else ()
    shown = f", {UNITS[figure.unit]}" if figure.unit == "nat" else ""
    return (
        Heading(
            f"{figure.title}{shown}",
            figure.tip,
            f"{figure.short}{shown}",
            copied=(f"{figure.title} ({unit})", *errors),
            unit="%" if figure.unit == "share" else "",
        ),
        Heading(
            "change",
            CHANGE_TIP,
            copied=(f"change ({unit})",),
            unit="pp" if figure.unit == "share" else "",
        ),
    )
