"""The table of scores: class, then value and change of three figures, and of S-MIG by kind on request."""

from __future__ import annotations

import math

from PySide6.QtCore import Qt
from PySide6.QtGui import (
    QBrush,
    QColor,
    QFontMetrics,
    QGuiApplication,
    QResizeEvent,
)
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QTableWidget,
    QTableWidgetItem,
)

from riglens.core.metric.scores import MetricSettings, Scores
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.quantities import ON_TARGET as ON_TARGET_QUANTITY
from riglens.core.targets.quantities import WHO, Cells
from riglens.widgets.panels.controls.icons import swatch
from riglens.widgets.panels.controls.item_views import OwnKeys, StandardKey
from riglens.widgets.panels.controls.style import numbers_font, plain_tip, tones
from riglens.widgets.panels.scores.text import (
    COLUMNS,
    NONE,
    NOTHING_NOTE,
    ON_TARGET,
    MetricColumn,
    change_text,
    exact_text,
    looks_at_more,
    rough_text,
    sampled_change_text,
    sampled_text,
    value_text,
)
from riglens.widgets.panels.targets.text import tip_text
from riglens.widgets.theme import CLASS_COLOURS

ABOUT, FOLLOWS = "≈ ", "…"
LAST_SAVED = "the rig as last saved"
CLASS_PX, LEAST_PX, CHANGE_PX = 112, 60, 88
NARROW_PX = 1400
ROW_PX = 26
SHOWN = (ON_TARGET, *COLUMNS)
"""The figures of a class from left to right; each is followed by its change."""
DETAILS = ("camera", "lidar")
"""S-MIG by kind, of which S-MS is made: shown on request."""
PLACES = 1 + 2 * len(SHOWN)
STANDARD_ERROR = Qt.ItemDataRole.UserRole.value + 1
ESTIMATE_NOTE = "Estimated on larger voxels; the exact number follows as soon as the mouse rests"
LONGEST_CHANGES, _CELL_MARGIN_PX = ("−100.00 pp", "−10.0 ±10.0 pp", "−1000.00 ↓"), 8
CHANGE_TIP = "Change against the baseline: the pinned rig, or else the rig as it was last saved or opened"


class ScoreTable(QTableWidget):
    """Class, then value and change for every column."""

    def __init__(self) -> None:
        super().__init__(len(CLASSES), PLACES)
        OwnKeys(self, {StandardKey.Copy: self._copy})
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ContiguousSelection)
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.setTabKeyNavigation(False)
        self.setFont(numbers_font(self.font()))
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(ROW_PX)
        self._baseline = LAST_SAVED
        self._set_header()
        for row, name in enumerate(CLASSES):
            self._fill_row(row, name)
        self.set_details(False)
        self.setMinimumHeight(self.horizontalHeader().sizeHint().height() + len(CLASSES) * ROW_PX)

    def _set_header(self) -> None:
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setMinimumSectionSize(LEAST_PX)
        for place in range(self.columnCount()):
            is_value = place % 2 == 1
            mode = QHeaderView.ResizeMode.Stretch if is_value else QHeaderView.ResizeMode.Fixed
            header.setSectionResizeMode(place, mode)
            header.resizeSection(place, self._change_px() if place else CLASS_PX)
        titles: list[tuple[str, str]] = [("Class", "")]
        for column in SHOWN:
            titles += [(column.title, column.tip), ("change", CHANGE_TIP)]
        for place, (title, tip) in enumerate(titles):
            item = QTableWidgetItem(title)
            item.setToolTip(tip)
            side = Qt.AlignmentFlag.AlignRight if place else Qt.AlignmentFlag.AlignLeft
            item.setTextAlignment(side | Qt.AlignmentFlag.AlignVCenter)
            self.setHorizontalHeaderItem(place, item)

    def _change_px(self) -> int:
        """Return the width of a column of changes: room for the longest that there can be."""
        wide = QFontMetrics(self.font()).horizontalAdvance
        return max(CHANGE_PX, max(map(wide, LONGEST_CHANGES)) + 2 * _CELL_MARGIN_PX)

    def _fill_row(self, row: int, name: str) -> None:
        title = QTableWidgetItem(swatch(CLASS_COLOURS[name]), name)
        title.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
        self.setItem(row, 0, title)
        for place in range(1, PLACES):
            item = QTableWidgetItem(NONE)
            item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            item.setForeground(QBrush(QColor(tones().muted)))
            self.setItem(row, place, item)

    def set_details(self, shown: bool) -> None:
        """Show S-MIG by kind beside the three figures, or hide it."""
        for key in DETAILS:
            for place in (_place_of(key), _place_of(key) + 1):
                self.setColumnHidden(place, not shown)

    def cell(self, class_name: str, column: str) -> QTableWidgetItem:
        """Return the item of a class and a column key, followed by " change" for its change."""
        key, _, is_change = column.partition(" ")
        place = _place_of(key) + (1 if is_change else 0)
        item = self.item(CLASSES.index(class_name), place)
        assert item is not None
        return item

    def set_baseline(self, name: str) -> None:
        """Set what the changes count from, for tooltips."""
        self._baseline = name

    def show_scores(self, scores: Scores, baseline: Scores, settings: MetricSettings) -> None:
        """Show exact values and their change against the baseline."""
        for name in CLASSES:
            now, before = scores.classes[name], baseline.classes[name]
            self._show_class(name, now.h_total > 0.0)
            for column in COLUMNS:
                value = column.value(now)
                change = 0.0 if math.isnan(value) else value - column.value(before)
                self._show_value(self.cell(name, column.key), column, value, now.h_total > 0.0)
                self._show_change(self.cell(name, f"{column.key} change"), column, change, settings)

    def _show_class(self, name: str, has_boxes: bool) -> None:
        """Show the name of a class, muted where it has no boxes."""
        title = self.item(CLASSES.index(name), 0)
        assert title is not None
        title.setForeground(QBrush(QColor(tones().text if has_boxes else tones().muted)))
        title.setToolTip("" if has_boxes else NOTHING_NOTE)

    def show_estimate(self, scores: Scores) -> None:
        """Show rough values without changes; they cannot be copied."""
        for name in CLASSES:
            for column in COLUMNS:
                value = column.value(scores.classes[name])
                text = NONE if math.isnan(value) else ABOUT + rough_text(column, value)
                self._show_rough(self.cell(name, column.key), text)
                self._show_rough(self.cell(name, f"{column.key} change"), FOLLOWS)

    def _show_rough(self, item: QTableWidgetItem, text: str) -> None:
        item.setText(text)
        item.setToolTip(ESTIMATE_NOTE)
        item.setData(Qt.ItemDataRole.UserRole, None)
        item.setForeground(QBrush(QColor(tones().muted)))
        _set_italic(item, True)

    def show_on_target(self, cells: Cells) -> None:
        """Show what is on target by class and its change against the baseline, ± where frames were sampled."""
        for name in CLASSES:
            row = WHO.index(name)
            value, se, change = (float(part[row]) for part in (cells.value, cells.se, cells.change))
            tip = plain_tip(tip_text(ON_TARGET_QUANTITY, name, cells, row, self._baseline))
            self._show_sampled(self.cell(name, "on_target"), sampled_text(value, se), value, se, tip)
            change_se = float(cells.change_se[row])
            told = self.cell(name, "on_target change")
            self._show_sampled(told, sampled_change_text(change, change_se), change, change_se, tip)
            if abs(change) > 2.0 * change_se:  # a change within its error is none to the better or the worse
                told.setForeground(QBrush(QColor(tones().more if change > 0.0 else tones().less)))

    def _show_sampled(self, item: QTableWidgetItem, text: str, value: float, se: float, tip: str) -> None:
        is_none = math.isnan(value)
        item.setText(text)
        item.setData(Qt.ItemDataRole.UserRole, None if is_none else value)
        item.setData(STANDARD_ERROR, None if is_none else se)
        item.setForeground(QBrush(QColor(tones().muted if is_none else tones().text)))
        item.setToolTip(tip)

    def forget_on_target(self, reason: str) -> None:
        """Show no number on road users, and why."""
        for name in CLASSES:
            for key in ("on_target", "on_target change"):
                self._show_sampled(self.cell(name, key), NONE, math.nan, math.nan, plain_tip(reason))

    def grey_on_target(self) -> None:
        """Show what is on target in the muted colour."""
        self._grey(range(1, 3))

    def _show_value(
        self, item: QTableWidgetItem, column: MetricColumn, value: float, has_boxes: bool
    ) -> None:
        item.setText(value_text(column, value))
        _set_italic(item, False)
        item.setToolTip(exact_text(column, value) if has_boxes else NOTHING_NOTE)
        item.setData(Qt.ItemDataRole.UserRole, None if math.isnan(value) else value)
        item.setForeground(QBrush(QColor(tones().text if has_boxes else tones().muted)))

    def _show_change(
        self, item: QTableWidgetItem, column: MetricColumn, change: float, settings: MetricSettings
    ) -> None:
        item.setText(change_text(change, column))
        _set_italic(item, False)
        item.setData(Qt.ItemDataRole.UserRole, change)
        more = looks_at_more(change, column, settings.reading)
        told = (tones().more if more else tones().less) if column.is_share else tones().text
        colour = tones().muted if change == 0 else told
        item.setForeground(QBrush(QColor(colour)))
        meaning = "the same as" if change == 0 else "looks at more than" if more else "looks at less than"
        item.setToolTip(plain_tip(f"{exact_text(column, change)}: {meaning} {self._baseline}"))

    def grey(self) -> None:
        """Show every score in the muted colour; what is on target is counted, and greyed, by itself."""
        self._grey(range(3, PLACES))

    def _grey(self, places: range) -> None:
        muted = QBrush(QColor(tones().muted))
        for row in range(self.rowCount()):
            for place in places:
                item = self.item(row, place)
                if item is not None:
                    item.setForeground(muted)

    def as_text(self) -> str:
        """Return titles and exact values, with tabs between columns."""
        titles = ["class", "On target (fraction)", "standard error", "change (fraction)"]
        for column in COLUMNS:
            unit = "fraction" if column.is_share else "nat"
            titles += [f"{column.title} ({unit})", f"change ({unit})"]
        lines = ["\t".join(titles)]
        for row, name in enumerate(CLASSES):
            values = [
                self.model().index(row, place).data(Qt.ItemDataRole.UserRole) for place in range(1, PLACES)
            ]
            values.insert(1, self.model().index(row, 1).data(STANDARD_ERROR))
            lines.append("\t".join([name, *("" if value is None else repr(value) for value in values)]))
        return "\n".join(lines) + "\n"

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Shorten titles where there is no room for long ones."""
        super().resizeEvent(event)
        width = event.size().width()
        is_narrow = width < NARROW_PX
        for column in SHOWN:
            item = self.horizontalHeaderItem(_place_of(column.key))
            assert item is not None
            item.setText(column.short if is_narrow else column.title)

    def _copy(self) -> None:
        QGuiApplication.clipboard().setText(self.as_text())


def _place_of(key: str) -> int:
    """The column of the value of a figure."""
    return 1 + 2 * [column.key for column in SHOWN].index(key)


def _set_italic(item: QTableWidgetItem, italic: bool) -> None:
    font = item.font()
    if font.italic() != italic:
        font.setItalic(italic)
        item.setFont(font)
