"""The table of the compare panel: sorted by any column, rows chosen, opened, renamed and removed."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QSortFilterProxyModel, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QMenu, QTableView, QWidget

from riglens.widgets.panels.bar_delegate import BarDelegate
from riglens.widgets.panels.compare_model import FIRST_SCORE, RIG, SENSORS, SORT, CompareModel
from riglens.widgets.panels.compare_rows import CompareRow
from riglens.widgets.panels.context_menu import give_context_menu
from riglens.widgets.panels.own_keys import OwnKeys, StandardKey
from riglens.widgets.panels.style import numbers_font

_NAME_PX, _SENSORS_PX, _SCORE_PX = 132, 84, 84
_ROW_PX, _HIGHEST_ROW_PX = 24, 30
_NARROW_PX = 1000


class CompareTable(QTableView):
    """Shows a CompareModel; the rows in sight share its height, so that none is cut."""

    open_wanted = Signal(str)
    """Key of the rig to open, or of the snapshot to restore."""
    pin_wanted = Signal(str)
    remove_wanted = Signal(tuple)
    """Keys of the rigs to take out."""
    order_changed = Signal()

    def __init__(self, model: CompareModel, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._rigs = model
        self._sorted = QSortFilterProxyModel(self)
        self._sorted.setSourceModel(model)
        self._sorted.setSortRole(SORT)
        self.setModel(self._sorted)
        self._set_up()
        self._sorted.layoutChanged.connect(self.order_changed)
        self.doubleClicked.connect(lambda index: self.open_wanted.emit(self.shown_rows()[index.row()].key))
        give_context_menu(self, self.context_menu)
        self.size_columns()

    def _set_up(self) -> None:
        self.setItemDelegate(BarDelegate(self))
        self.setSortingEnabled(True)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.EditKeyPressed)
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.setTabKeyNavigation(False)
        self.setFont(numbers_font(self.font()))
        self.verticalHeader().hide()
        self.verticalHeader().setMinimumSectionSize(_ROW_PX)
        header = self.horizontalHeader()
        header.setHighlightSections(False)
        header.setTextElideMode(Qt.TextElideMode.ElideRight)
        header.setMinimumSectionSize(_SCORE_PX)
        header.setSortIndicatorClearable(True)
        header.setSortIndicator(-1, Qt.SortOrder.AscendingOrder)

    def size_columns(self) -> None:
        """Give the scores what the names leave."""
        header = self.horizontalHeader()
        for column in range(self._rigs.columnCount()):
            is_score = column >= FIRST_SCORE
            mode = QHeaderView.ResizeMode.Stretch if is_score else QHeaderView.ResizeMode.Interactive
            header.setSectionResizeMode(column, mode)
        header.resizeSection(RIG, _NAME_PX)
        header.resizeSection(SENSORS, _SENSORS_PX)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Titles are short where there is no room for long ones, and rows are as high as lets whole ones fit."""
        super().resizeEvent(event)
        self._rigs.set_narrow(event.size().width() < _NARROW_PX)
        in_sight = max(1, event.size().height() // _ROW_PX)
        self.verticalHeader().setDefaultSectionSize(
            min(max(_ROW_PX, event.size().height() // in_sight), _HIGHEST_ROW_PX)
        )

    # ------------------------------------------------------------------ rows
    def shown_rows(self) -> list[CompareRow]:
        """The rigs in the order in which the table shows them."""
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
        """What a cell shows: of the rig of that name, in the column of that title."""
        columns = range(self._rigs.columnCount())
        titles = [self._rigs.headerData(c, Qt.Orientation.Horizontal) for c in columns]
        names = [row.name for row in self.shown_rows()]
        return str(self._sorted.index(names.index(name), titles.index(title)).data())

    # ------------------------------------------------------------------ what the user does
    def take_keys(self, copy: Callable[[], None]) -> None:
        """Have Ctrl+C copy all, and Del remove what is selected, while the table has the focus."""
        OwnKeys(self, {StandardKey.Copy: copy, StandardKey.Delete: self._remove})

    def _remove(self) -> None:
        self.remove_wanted.emit(self.chosen)

    def context_menu(self) -> QMenu:
        """What can be done with the selected rigs."""
        menu = QMenu(self)
        chosen = self.chosen
        one = chosen[0] if len(chosen) == 1 else None
        rows = {row.key: row for row in self._rigs.rows}
        title = "Restore" if one is not None and rows[one].origin == "snapshot" else "Open"
        menu.addAction(title, lambda: self.open_wanted.emit(one)).setEnabled(one is not None)
        menu.addAction("Pin as baseline", lambda: self.pin_wanted.emit(one)).setEnabled(one is not None)
        rename = menu.addAction("Rename", lambda: self.edit(self.currentIndex()))
        rename.setEnabled(one is not None and rows[one].origin == "snapshot")
        menu.addSeparator()
        menu.addAction("Remove from the list", self._remove).setEnabled(bool(chosen))
        return menu
