"""The list of sensors by kind: tick, name, short type, loss without it, lock and eye; several can be selected.

Which sensors are selected beside the one that is edited is known to this list alone.
"""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QEvent, QItemSelectionModel, QModelIndex, QPersistentModelIndex, Qt, Signal
from PySide6.QtGui import QMouseEvent
from PySide6.QtWidgets import QAbstractItemView, QMenu, QTreeWidgetItem, QWidget

from riglens.widgets.panels.context_menu import give_context_menu
from riglens.widgets.panels.sensor_list import KINDS, TICK_PX, Names, SensorList
from riglens.widgets.panels.sensor_rows import EYE, LOCK, NAME


class SensorTree(SensorList):
    """Follows a rig; says what the user wants by signals and changes nothing by itself."""

    selected = Signal(object)
    """Name of the sensor to edit, None when nothing is selected."""
    enabled_toggled = Signal(tuple, bool)
    hidden_toggled = Signal(tuple, bool)
    locked_toggled = Signal(tuple, bool)
    """Names, and whether they shall be enabled, hidden or locked."""
    renamed = Signal(str, str)
    refused = Signal(str)
    """A name that cannot be given, with the reason."""
    menu_wanted = Signal(object)
    """A QMenu for the selected sensors, to be filled with more before it opens."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(
            QAbstractItemView.EditTrigger.DoubleClicked | QAbstractItemView.EditTrigger.EditKeyPressed
        )
        give_context_menu(self, self.context_menu)
        self.itemChanged.connect(self._on_changed)
        self.itemClicked.connect(self._on_clicked)
        self.itemDoubleClicked.connect(self._on_clicked)
        self.itemSelectionChanged.connect(self._on_selection)

    # ------------------------------------------------------------------ what the user does
    def choose(self, names: Names) -> None:
        """Select several sensors; the last one is the one to edit."""
        self.blockSignals(True)
        for name, item in self._items.items():
            item.setSelected(name in names)
        self.blockSignals(False)
        if names:
            self.setCurrentItem(self._items[names[-1]], NAME, QItemSelectionModel.SelectionFlag.NoUpdate)
        self._on_selection()

    def edit(  # type: ignore[override]
        self, index: QModelIndex, trigger: QAbstractItemView.EditTrigger, event: QEvent
    ) -> bool:
        """Only names are edited."""
        return index.column() == NAME and super().edit(index, trigger, event)

    def selectionCommand(
        self, index: QModelIndex | QPersistentModelIndex, event: QEvent | None = None
    ) -> QItemSelectionModel.SelectionFlag:
        """A click on tick, lock or eye leaves the selection as it is, so that it can be about all of it."""
        if isinstance(event, QMouseEvent):
            tick_px = self.visualRect(index).left() + TICK_PX
            if index.column() in (LOCK, EYE) or event.position().x() < tick_px:
                return QItemSelectionModel.SelectionFlag.NoUpdate
        return super().selectionCommand(index, event)

    def rename_selected(self) -> None:
        """Open the editor on the name of the selected sensor."""
        item = self.currentItem()
        if item is not None and self.name_of(item) is not None and self.name_of(item) not in self._locked:
            self.editItem(item, NAME)

    def _meant(self, name: str) -> Names:
        """The sensors that a click on one of them is about: all selected ones when it is selected, too."""
        chosen = self.chosen
        return chosen if name in chosen else (name,)

    def _on_changed(self, item: QTreeWidgetItem, column: int) -> None:
        name = self.name_of(item)
        if name is None or column != NAME:
            return
        if item.text(NAME) != name:
            self._rename(item, name)
            return
        self.enabled_toggled.emit(self._meant(name), item.checkState(NAME) == Qt.CheckState.Checked)

    def _rename(self, item: QTreeWidgetItem, name: str) -> None:
        wanted = item.text(NAME).strip()
        reason = ""
        if not wanted:
            reason = "Name: found nothing, accepted is any text that no other sensor uses."
        elif wanted != name and wanted in self._items:
            reason = f"Name: '{wanted}' is used by another sensor; names must be unique."
        if reason or wanted == name:
            self.blockSignals(True)
            item.setText(NAME, name)
            self.blockSignals(False)
        if reason:
            self.refused.emit(reason)
        elif wanted != name:
            self.renamed.emit(name, wanted)

    def _on_clicked(self, item: QTreeWidgetItem, column: int) -> None:
        """A click on lock or eye; the second click of a fast pair counts as one, too."""
        name = self.name_of(item)
        if name is not None and column == EYE:
            self.hidden_toggled.emit(self._meant(name), name not in self._hidden)
        elif name is not None and column == LOCK:
            self.locked_toggled.emit(self._meant(name), name not in self._locked)

    def _on_selection(self) -> None:
        chosen = self.chosen
        current = self.currentItem()
        name = self.name_of(current) if current is not None else None
        self.selected.emit(name if name in chosen else chosen[0] if chosen else None)

    # ------------------------------------------------------------------ context menu
    def context_menu(self) -> QMenu:
        """What can be done with the selected sensors; without one, what selects some."""
        menu = QMenu(self)
        chosen = self.chosen
        if chosen:
            for title, names_on, signal in (
                ("Enabled", self._enabled, self.enabled_toggled),
                ("Hidden", self._hidden, self.hidden_toggled),
                ("Locked", self._locked, self.locked_toggled),
            ):
                action = menu.addAction(title)
                action.setCheckable(True)
                action.setChecked(all(name in names_on for name in chosen))
                action.triggered.connect(partial(signal.emit, chosen))
            menu.addSeparator()
            self.menu_wanted.emit(menu)
            menu.addSeparator()
        for kind, title in KINDS:
            of_kind = tuple(name for name, k in zip(self._items, self._kinds, strict=True) if k == kind)
            words = title if kind == "lidar" else title.lower()
            menu.addAction(f"Select all {words}", partial(self.choose, of_kind)).setEnabled(bool(of_kind))
        return menu
