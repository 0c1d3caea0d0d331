"""The compare panel: several rigs on the same traffic as table and bars, with progress and Cancel."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QSortFilterProxyModel, Qt, Signal
from PySide6.QtGui import QGuiApplication, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QMenu,
    QProgressBar,
    QPushButton,
    QSplitter,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from riglens.core.scene.boxes import CLASSES
from riglens.widgets.panels.compare.chart import CompareChart
from riglens.widgets.panels.compare.model import (
    ALL_CLASSES,
    FIRST_FIGURE,
    MEAN,
    RIG,
    SENSORS,
    CompareModel,
    CompareRow,
    Shown,
    table_text,
)
from riglens.widgets.panels.controls.building import button, filled, plain_label, tool
from riglens.widgets.panels.controls.icons import icon
from riglens.widgets.panels.controls.item_views import OwnKeys, StandardKey, give_context_menu
from riglens.widgets.panels.controls.menus import add_entry
from riglens.widgets.panels.controls.scrolled import scrolled
from riglens.widgets.panels.controls.style import MARGIN, SPACING, as_panel
from riglens.widgets.panels.fields.form import ChoiceBox
from riglens.widgets.panels.figures.table import SORT, FigureTable
from riglens.widgets.panels.scores.text import SIGN_NOTE

_NAME_PX, _SENSORS_PX, _SCORE_PX = 132, 84, 84
_ROW_PX, _HIGHEST_ROW_PX = 24, 36
_WIDEST_NAME_PX = 240
_TITLE_PX = 140
"""Room for a title in full."""


class CompareTable(FigureTable):
    """Table of a CompareModel; the visible rows share its height, so that none is cut off."""

    open_wanted = Signal(str)
    """Key of the rig to open, or of the snapshot to restore."""
    pin_wanted = Signal(str)
    remove_wanted = Signal(tuple)
    """Keys of the rigs to remove."""
    order_changed = Signal()

    def __init__(self, model: CompareModel, parent: QWidget | None = None) -> None:
        super().__init__("Compare: rigs and their scores", model, parent)
        self._rigs = model
        self._sorted = QSortFilterProxyModel(self)
        self._sorted.setSourceModel(model)
        self._sorted.setSortRole(SORT)
        self.setModel(self._sorted)
        self._set_up()
        self._sorted.layoutChanged.connect(self.order_changed)
        self.doubleClicked.connect(lambda index: self.open_wanted.emit(self.shown_rows()[index.row()].key))
        give_context_menu(self, self.context_menu)
        self._name_px = _NAME_PX
        self.size_columns()
        for changed in (self._sorted.modelReset, self._sorted.dataChanged):
            changed.connect(lambda *_: self._fit_names())

    def _set_up(self) -> None:
        self.setSortingEnabled(True)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.EditKeyPressed)
        self.verticalHeader().hide()
        self.verticalHeader().setMinimumSectionSize(_ROW_PX)
        header = self.horizontalHeader()
        header.setTextElideMode(Qt.TextElideMode.ElideNone)  # Qt measures two lines as one
        header.setMinimumSectionSize(_SCORE_PX)
        header.setSortIndicatorClearable(True)
        header.setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
        header.sectionCountChanged.connect(lambda *_: self.size_columns())

    def size_columns(self) -> None:
        """Give the scores the room that the names leave."""
        header = self.horizontalHeader()
        for column in range(self._rigs.columnCount()):
            is_score = column >= FIRST_FIGURE
            mode = QHeaderView.ResizeMode.Stretch if is_score else QHeaderView.ResizeMode.Interactive
            header.setSectionResizeMode(column, mode)
        header.resizeSection(RIG, self._name_px)
        header.resizeSection(SENSORS, _SENSORS_PX)
        self._fit_titles()

    def _fit_titles(self) -> None:
        """Shorten titles where space is short."""
        titles_px = self.width() - self._name_px - _SENSORS_PX
        self._rigs.set_narrow(titles_px < len(self._rigs.columns) * _TITLE_PX)

    def _fit_names(self) -> None:
        """Give the names of the rigs the room that they need, unless the user has given them another."""
        header = self.horizontalHeader()
        if header.sectionSize(RIG) == self._name_px:
            self._name_px = min(max(_NAME_PX, self.sizeHintForColumn(RIG)), _WIDEST_NAME_PX)
            header.resizeSection(RIG, self._name_px)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Shorten titles where space is short, and fit whole rows."""
        super().resizeEvent(event)
        self._fit_titles()
        in_sight = max(1, event.size().height() // _ROW_PX)
        self.verticalHeader().setDefaultSectionSize(
            min(max(_ROW_PX, event.size().height() // in_sight), _HIGHEST_ROW_PX)
        )

    # ------------------------------------------------------------------ rows
    def shown_rows(self) -> list[CompareRow]:
        """Return the rigs in the order in which the table shows them."""
        order = (
            self._sorted.mapToSource(self._sorted.index(row, RIG)).row()
            for row in range(self._sorted.rowCount())
        )
        return [self._rigs.rows[row] for row in order]

    @property
    def chosen(self) -> tuple[str, ...]:
        """Keys of the selected rigs."""
        rows = {self._sorted.mapToSource(index).row() for index in self.selectedIndexes()}
        return tuple(self._rigs.rows[row].key for row in sorted(rows))

    def choose(self, key: str) -> None:
        """Select one rig."""
        keys = [row.key for row in self.shown_rows()]
        if key in keys:
            self.selectRow(keys.index(key))

    def text_of(self, name: str, title: str) -> str:
        """Return the text of a cell: of the rig of that name, in the column of that title."""
        row = [rig.name for rig in self._rigs.rows].index(name)
        return self._rigs.cell(row, self._rigs.column_titles.index(title)).text

    # ------------------------------------------------------------------ what the user does
    def take_keys(self, copy: Callable[[], None]) -> None:
        """Handle keys while the table has the focus: Ctrl+A selects its rows, Ctrl+C copies all, Del removes the
        selection."""
        OwnKeys(
            self,
            {
                StandardKey.SelectAll: self.selectAll,
                StandardKey.Copy: copy,
                StandardKey.Delete: self._remove,
            },
        )

    def _remove(self) -> None:
        self.remove_wanted.emit(self.chosen)

    def context_menu(self) -> QMenu:
        """Return a menu of what can be done with the selected rigs."""
        menu = QMenu(self)
        chosen = self.chosen
        one = chosen[0] if len(chosen) == 1 else None
        rows = {row.key: row for row in self._rigs.rows}
        title = "Restore" if one is not None and rows[one].origin == "snapshot" else "Open"
        add_entry(menu, title, lambda: self.open_wanted.emit(one)).setEnabled(one is not None)
        add_entry(menu, "Use as baseline", lambda: self.pin_wanted.emit(one)).setEnabled(one is not None)
        rename = add_entry(menu, "Rename", lambda: self.edit(self.currentIndex()))
        rename.setEnabled(one is not None and rows[one].origin == "snapshot")
        menu.addSeparator()
        add_entry(menu, "Remove from the list", self._remove).setEnabled(bool(chosen))
        return menu


SHOWN: dict[Shown, str] = {
    "values": "values",
    "first": "difference to the first",
    "baseline": "difference to the baseline",
}
BESIDE_PX, BELOW_PX = 1500, 420
"""From this width on, bars are next to the table; from this height on, below it; otherwise in its place."""


class ComparePanel(QWidget):
    """Panel that follows a list of rows; emits the user's requests."""

    open_wanted = Signal(str)
    """Key of the rig to open, or of the snapshot to restore."""
    snapshot_wanted = Signal()
    score_wanted = Signal(bool)
    """Compute the missing scores; or, when False, abandon them."""
    export_wanted = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self.model = CompareModel()
        self.table, self.chart = CompareTable(self.model), CompareChart(self.model)
        self._halves = QSplitter()
        self._halves.setChildrenCollapsible(False)
        self._scrolled_chart = scrolled(self.chart)
        for half in (self.table, self._scrolled_chart):
            self._halves.addWidget(half)
        filled(QVBoxLayout(self), self._controls(), self._halves, 1, spacing=0)
        self._connect()
        self._arrange()

    def _connect(self) -> None:
        self.table.take_keys(self.copy)
        for part in (self.table, self.chart):
            part.open_wanted.connect(self.open_wanted)
        self.chart.chosen.connect(self.table.choose)
        for changed in (
            self.table.order_changed, self.model.dataChanged, self.model.modelReset,
            self.table.selectionModel().selectionChanged,
        ):  # fmt: skip
            changed.connect(lambda *_: self._show_bars())

    # ------------------------------------------------------------------ what is shown

    def show_progress(self, done: int, total: int, given_up: bool = False) -> None:
        """Show how many of the requested rigs are scored; nothing when all are."""
        is_missing = done < total
        self._bar.setMaximum(max(total, 1))
        self._bar.setValue(done)
        self._bar.setVisible(is_missing and not given_up)
        self._cancel.setVisible(is_missing)
        self._cancel.setText("Score" if given_up else "Cancel")

    def as_text(self, delimiter: str) -> str:
        """Return all rows in full precision, in the order shown."""
        return table_text(self.table.shown_rows(), delimiter)

    def copy(self) -> None:
        """Copy the table to the clipboard, columns separated by tabs."""
        QGuiApplication.clipboard().setText(self.as_text("\t"))

    # ------------------------------------------------------------------ bars
    def set_bars(self, shown: bool) -> None:
        """Show or hide the bars."""
        self.bars.setChecked(shown)

    def _show_bars(self) -> None:
        if self.bars.isChecked():
            self.chart.show_rows(self.table.shown_rows(), self.table.chosen)

    def _arrange(self) -> None:
        """Arrange table and bars side by side, one above the other, or one at a time, as there is room."""
        wanted, size = self.bars.isChecked(), self.size()
        is_wide, is_high = size.width() >= BESIDE_PX, size.height() >= BELOW_PX
        self._halves.setOrientation(Qt.Orientation.Horizontal if is_wide else Qt.Orientation.Vertical)
        self.table.setVisible(not wanted or is_wide or is_high)
        self._scrolled_chart.setVisible(wanted)
        self._show_bars()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Arrange the parts again: another size may have room for both."""
        super().resizeEvent(event)
        self._arrange()

    # ------------------------------------------------------------------ building
    def _controls(self) -> QHBoxLayout:
        tip = "Add rigs to compare with the one being edited."
        self._add = button(QToolButton(), tip=tip, name="compare_add", text="Add")
        self._add.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        snapshot = button(
            QPushButton(icon("snapshot"), "Snapshot"), self.snapshot_wanted,
            "Add the current rig to this list (Ctrl+T).", "snapshot",
        )  # fmt: skip
        self._class, self._shown = ChoiceBox(), ChoiceBox()
        self._class.setObjectName("compare_class")
        self._class.addItems([ALL_CLASSES, MEAN, *CLASSES])
        self._class.activated.connect(self._choose_class)
        self._shown.setObjectName("compare_shown")
        for shown, title in SHOWN.items():
            self._shown.addItem(title, shown)
        self._shown.activated.connect(lambda _: self.model.set_shown(self._shown.currentData()))
        self._bar = QProgressBar()
        self._bar.setFormat("%v of %m scored")
        self._bar.setFixedWidth(120)
        self._cancel = button(
            QPushButton("Cancel"), lambda: self.score_wanted.emit(self._cancel.text() == "Score"), "", "compare_cancel"
        )  # fmt: skip
        unit = plain_label("S-MS in 10³ nat", "hint")
        unit.setToolTip(SIGN_NOTE)
        self.bars = tool(icon("bars"), None, "Show the figures as bars.", "compare_bars")
        self.bars.setCheckable(True)
        self.bars.toggled.connect(lambda _: self._arrange())
        copy = tool(icon("copy"), self.copy, "Copy the table.", "compare_copy")
        tip = "Save all numbers in full precision."
        export = button(QPushButton("CSV…"), self.export_wanted, tip, "compare_export")
        line = filled(
            QHBoxLayout(), self._add, snapshot, self._class, self._shown, unit, None,
            self._bar, self._cancel, self.bars, copy, export,
            margins=(MARGIN, 5, MARGIN, 5), spacing=SPACING,
        )  # fmt: skip
        self.show_progress(0, 0)
        return line

    def set_add_menu(self, menu: QMenu) -> None:
        """Build the menu of what can be added."""
        self._add.setMenu(menu)

    def _choose_class(self, _: int) -> None:
        self.model.set_class(self._class.currentText())
