"""The compare panel: several rigs on the same traffic, side by side, sortable, with progress and Cancel."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QPoint, QSortFilterProxyModel, Qt, Signal
from PySide6.QtGui import QGuiApplication, QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QMenu,
    QProgressBar,
    QPushButton,
    QTableView,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from core.metric.scores import Reading, Scores
from core.scene.boxes import CLASSES
from widgets.panels.bar_delegate import BarDelegate
from widgets.panels.compare_model import FIRST_SCORE, RIG, SENSORS, SORT, CompareModel, Shown
from widgets.panels.compare_rows import ALL_CLASSES, CompareRow, table_text
from widgets.panels.form import ChoiceBox
from widgets.panels.icons import icon
from widgets.panels.own_keys import OwnKeys, StandardKey
from widgets.panels.score_text import SIGN_NOTE
from widgets.panels.style import MARGIN, SPACING, as_panel, numbers_font

SHOWN: dict[Shown, str] = {
    "values": "values",
    "first": "difference to the first",
    "baseline": "difference to the baseline",
}
_NAME_PX, _SENSORS_PX = 132, 84
_NARROW_PX = 1000


class ComparePanel(QWidget):
    """Follows a list of rows; says what the user wants done with them."""

    open_wanted = Signal(str)
    """Key of the rig to open, or of the snapshot to restore."""
    pin_wanted = Signal(str)
    remove_wanted = Signal(tuple)
    """Keys of the rigs to take out."""
    renamed = Signal(str, str)
    snapshot_wanted = Signal()
    score_wanted = Signal(bool)
    """Compute what is missing; or, when False, give it up."""
    export_wanted = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self.model = CompareModel()
        self.model.renamed.connect(self.renamed)
        self._sorted = QSortFilterProxyModel(self)
        self._sorted.setSourceModel(self.model)
        self._sorted.setSortRole(SORT)
        self.table = self._make_table()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addLayout(self._controls())
        column.addWidget(self.table, 1)
        self._size_columns()

    # ------------------------------------------------------------------ what is shown
    def set_rows(self, rows: Sequence[CompareRow]) -> None:
        """Show these rigs, in this order unless the table is sorted by a column."""
        self.model.set_rows(rows)

    def set_baseline(self, scores: Scores | None, reading: Reading) -> None:
        """What differences to the baseline count from."""
        self.model.set_baseline(scores, reading)

    def show_progress(self, done: int, total: int, given_up: bool = False) -> None:
        """How many of the rigs asked for are scored; nothing is shown when all are."""
        is_missing = done < total
        self._bar.setMaximum(max(total, 1))
        self._bar.setValue(done)
        self._bar.setVisible(is_missing and not given_up)
        self._cancel.setVisible(is_missing)
        self._cancel.setText("Score" if given_up else "Cancel")

    @property
    def chosen(self) -> tuple[str, ...]:
        """Keys of the selected rigs."""
        rows = {self._sorted.mapToSource(index).row() for index in self.table.selectedIndexes()}
        return tuple(self.model.rows[row].key for row in sorted(rows))

    def names(self) -> list[str]:
        """Names of the rigs in the order in which the table shows them."""
        return [str(self._sorted.index(row, RIG).data()) for row in range(self._sorted.rowCount())]

    def text_of(self, name: str, title: str) -> str:
        """What a cell shows: of the rig of that name, in the column of that title."""
        columns = range(self.model.columnCount())
        titles = [self.model.headerData(c, Qt.Orientation.Horizontal) for c in columns]
        return str(self._sorted.index(self.names().index(name), titles.index(title)).data())

    def as_text(self, delimiter: str) -> str:
        """All rows with every digit, in the order shown."""
        order = [
            self._sorted.mapToSource(self._sorted.index(r, 0)).row() for r in range(len(self.model.rows))
        ]
        return table_text([self.model.rows[row] for row in order], delimiter)

    def copy(self) -> None:
        """The table into the clipboard, columns separated by tabs."""
        QGuiApplication.clipboard().setText(self.as_text("\t"))

    # ------------------------------------------------------------------ building
    def _make_table(self) -> QTableView:
        table = QTableView()
        table.setModel(self._sorted)
        table.setItemDelegate(BarDelegate(table))
        table.setSortingEnabled(True)
        table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        table.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        table.setEditTriggers(QAbstractItemView.EditTrigger.EditKeyPressed)
        table.setAlternatingRowColors(True)
        table.setShowGrid(False)
        table.setFont(numbers_font(table.font()))
        table.verticalHeader().hide()
        table.verticalHeader().setDefaultSectionSize(26)
        header = table.horizontalHeader()
        header.setHighlightSections(False)
        header.setTextElideMode(Qt.TextElideMode.ElideRight)
        header.setSortIndicatorClearable(True)
        header.setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
        table.doubleClicked.connect(lambda index: self.open_wanted.emit(self._key(index.row())))
        table.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        table.customContextMenuRequested.connect(self._open_menu)
        OwnKeys(table, {StandardKey.Copy: self.copy, StandardKey.Delete: self._remove})
        return table

    def _controls(self) -> QHBoxLayout:
        self._add = QToolButton()
        self._add.setObjectName("compare_add")
        self._add.setText("Add")
        self._add.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self._add.setToolTip("Rigs to compare with the one being edited")
        snapshot = QPushButton(icon("snapshot"), "Snapshot")
        snapshot.setObjectName("snapshot")
        snapshot.setToolTip("Keep the rig as it is now in this list (Ctrl+T)")
        snapshot.clicked.connect(self.snapshot_wanted)
        self._class, self._shown = ChoiceBox(), ChoiceBox()
        self._class.setObjectName("compare_class")
        self._class.addItems([ALL_CLASSES, *CLASSES])
        self._class.activated.connect(self._choose_class)
        self._shown.setObjectName("compare_shown")
        for shown, title in SHOWN.items():
            self._shown.addItem(title, shown)
        self._shown.activated.connect(lambda _: self.model.set_shown(self._shown.currentData()))
        self._bar = QProgressBar()
        self._bar.setFormat("%v of %m scored")
        self._bar.setFixedWidth(120)
        self._cancel = QPushButton("Cancel")
        self._cancel.setObjectName("compare_cancel")
        self._cancel.clicked.connect(lambda: self.score_wanted.emit(self._cancel.text() == "Score"))
        unit = QLabel("10³ nat")
        unit.setObjectName("hint")
        unit.setToolTip(SIGN_NOTE)
        copy, export = self._tool("copy", "Copy the table", self.copy), QPushButton("CSV…")
        export.setObjectName("compare_export")
        export.setToolTip("Save all numbers with every digit")
        export.clicked.connect(self.export_wanted)
        line = QHBoxLayout()
        line.setContentsMargins(MARGIN, 5, MARGIN, 5)
        line.setSpacing(SPACING)
        first: tuple[QWidget, ...] = (self._add, snapshot, self._class, self._shown, unit)
        last: tuple[QWidget, ...] = (self._bar, self._cancel, copy, export)
        for widget in first:
            line.addWidget(widget)
        line.addStretch(1)
        for widget in last:
            line.addWidget(widget)
        self.show_progress(0, 0)
        return line

    def _tool(self, picture: str, tip: str, slot: object) -> QToolButton:
        button = QToolButton()
        button.setObjectName(f"compare_{picture}")
        button.setIcon(icon(picture))
        button.setToolTip(tip)
        button.clicked.connect(slot)
        return button

    def set_add_menu(self, menu: QMenu) -> None:
        """What can be added."""
        self._add.setMenu(menu)

    def _size_columns(self) -> None:
        header = self.table.horizontalHeader()
        header.setMinimumSectionSize(_SENSORS_PX)
        for column in range(self.model.columnCount()):
            is_score = column >= FIRST_SCORE
            mode = QHeaderView.ResizeMode.Stretch if is_score else QHeaderView.ResizeMode.Interactive
            header.setSectionResizeMode(column, mode)
        header.resizeSection(RIG, _NAME_PX)
        header.resizeSection(SENSORS, _SENSORS_PX)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Titles are short where there is no room for long ones."""
        super().resizeEvent(event)
        self.model.set_narrow(event.size().width() < _NARROW_PX)

    # ------------------------------------------------------------------ what the user does
    def _choose_class(self, _: int) -> None:
        self.model.set_class(self._class.currentText())
        self._size_columns()

    def _key(self, row: int) -> str:
        return self.model.rows[self._sorted.mapToSource(self._sorted.index(row, RIG)).row()].key

    def _remove(self) -> None:
        self.remove_wanted.emit(self.chosen)

    def _open_menu(self, position: QPoint) -> None:
        menu = self.context_menu()
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(self.table.viewport().mapToGlobal(position))

    def context_menu(self) -> QMenu:
        """What can be done with the selected rigs."""
        menu = QMenu(self)
        chosen = self.chosen
        one = chosen[0] if len(chosen) == 1 else None
        rows = {row.key: row for row in self.model.rows}
        title = "Restore" if one is not None and rows[one].origin == "snapshot" else "Open"
        menu.addAction(title, lambda: self.open_wanted.emit(one)).setEnabled(one is not None)
        menu.addAction("Pin as baseline", lambda: self.pin_wanted.emit(one)).setEnabled(one is not None)
        rename = menu.addAction("Rename", lambda: self.table.edit(self.table.currentIndex()))
        rename.setEnabled(one is not None and rows[one].origin == "snapshot")
        menu.addSeparator()
        menu.addAction("Remove from the list", self._remove).setEnabled(bool(chosen))
        return menu
