"""The list of sensors, by kind: a tick for "counts in the scores", an eye for "is drawn", names to edit."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QModelIndex, QSize, Qt, Signal
from PySide6.QtGui import QBrush, QColor
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTreeWidget, QTreeWidgetItem, QWidget

from core.rig.model import Camera, Lidar, Rig
from widgets.panels.icons import icon
from widgets.panels.style import tones
from widgets.theme import KIND_COLOURS

NAME, EYE = 0, 1
_OLD_NAME = Qt.ItemDataRole.UserRole
_ROW_FLAGS = (
    Qt.ItemFlag.ItemIsEnabled
    | Qt.ItemFlag.ItemIsSelectable
    | Qt.ItemFlag.ItemIsEditable
    | Qt.ItemFlag.ItemIsUserCheckable
)
_KINDS = (("lidar", "LiDARs"), ("camera", "Cameras"))


class SensorTree(QTreeWidget):
    """Follows a rig; says what the user wants by signals and changes nothing by itself."""

    selected = Signal(object)
    """Name of the sensor, None when nothing is selected."""
    enabled_toggled = Signal(str, bool)
    hidden_toggled = Signal(str, bool)
    renamed = Signal(str, str)
    refused = Signal(str)
    """A name that cannot be given, with the reason."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._shown: tuple[object, ...] = ()
        self._kinds: list[str] = []
        self._rows: list[QTreeWidgetItem] = []
        self._items: dict[str, QTreeWidgetItem] = {}
        self._hidden: frozenset[str] = frozenset()
        self.setColumnCount(2)
        self.setHeaderHidden(True)
        self.setIndentation(8)
        self.setRootIsDecorated(False)
        self.setUniformRowHeights(True)
        self.setIconSize(QSize(16, 16))
        self.setEditTriggers(
            QAbstractItemView.EditTrigger.DoubleClicked | QAbstractItemView.EditTrigger.EditKeyPressed
        )
        header = self.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(NAME, QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(EYE, QHeaderView.ResizeMode.Fixed)
        header.resizeSection(EYE, 30)
        self.itemChanged.connect(self._on_changed)
        self.itemClicked.connect(self._on_clicked)
        self.itemDoubleClicked.connect(self._on_double_clicked)
        self.itemSelectionChanged.connect(self._on_selection)

    def set_rig(self, rig: Rig, hidden: frozenset[str], selected: str | None) -> None:
        """Show a rig. Rows are built anew only when sensors come or go, never while one of them is edited."""
        shown = (tuple((s.name, s.kind, s.enabled) for s in rig.sensors), hidden)
        self.blockSignals(True)
        if shown != self._shown:
            self._shown, self._hidden = shown, hidden
            self._show_rows(rig)
        if selected is not None:
            self.setCurrentItem(self._items[selected])
        else:
            self.setCurrentIndex(QModelIndex())
            self.clearSelection()
        self.blockSignals(False)

    def item_of(self, name: str) -> QTreeWidgetItem:
        """The row of a sensor; KeyError when there is none."""
        return self._items[name]

    # ------------------------------------------------------------------ rows
    def _show_rows(self, rig: Rig) -> None:
        kinds: list[str] = [sensor.kind for sensor in rig.sensors]
        if kinds != self._kinds:
            self._kinds = kinds
            self._rows = self._build_rows(kinds)
        self._items = {sensor.name: row for sensor, row in zip(rig.sensors, self._rows, strict=True)}
        for sensor in rig.sensors:
            self._update_row(self._items[sensor.name], sensor)

    def _build_rows(self, kinds: list[str]) -> list[QTreeWidgetItem]:
        """Empty rows under their group, in the order of the rig's sensors."""
        scrolled = self.verticalScrollBar().value()
        self.clear()
        groups = {kind: self._group(f"{title}  {kinds.count(kind)}") for kind, title in _KINDS}
        rows = [QTreeWidgetItem(groups[kind]) for kind in kinds]
        self.expandAll()
        self.verticalScrollBar().setValue(scrolled)
        return rows

    def _group(self, title: str) -> QTreeWidgetItem:
        group = QTreeWidgetItem(self, [title])
        group.setFlags(Qt.ItemFlag.ItemIsEnabled)
        group.setForeground(NAME, QBrush(QColor(tones().muted)))
        group.setFirstColumnSpanned(True)
        return group

    def _update_row(self, row: QTreeWidgetItem, sensor: Lidar | Camera) -> None:
        hidden = sensor.name in self._hidden
        row.setFlags(_ROW_FLAGS)
        row.setText(NAME, sensor.name)
        row.setData(NAME, _OLD_NAME, sensor.name)
        row.setCheckState(NAME, Qt.CheckState.Checked if sensor.enabled else Qt.CheckState.Unchecked)
        row.setIcon(NAME, icon(sensor.kind, KIND_COLOURS[sensor.kind]))
        row.setIcon(EYE, icon("eye-off" if hidden else "eye", tones().muted if hidden else None))
        row.setToolTip(NAME, "Tick: counts in the scores. Double click or F2: another name.")
        row.setToolTip(
            EYE, "Hidden in the view; it still counts in the scores" if hidden else "Shown in the view"
        )
        text = tones().text if sensor.enabled and not hidden else tones().muted
        row.setForeground(NAME, QBrush(QColor(text)))

    # ------------------------------------------------------------------ what the user does
    def edit(  # type: ignore[override]
        self, index: QModelIndex, trigger: QAbstractItemView.EditTrigger, event: QEvent
    ) -> bool:
        """Only names are edited, never the eye."""
        return index.column() == NAME and super().edit(index, trigger, event)

    def _name(self, item: QTreeWidgetItem) -> str | None:
        name = item.data(NAME, _OLD_NAME)
        return name if isinstance(name, str) else None

    def _on_changed(self, item: QTreeWidgetItem, column: int) -> None:
        name = self._name(item)
        if name is None or column != NAME:
            return
        if item.text(NAME) != name:
            self._rename(item, name)
            return
        self.enabled_toggled.emit(name, item.checkState(NAME) == Qt.CheckState.Checked)

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
        name = self._name(item)
        if name is not None and column == EYE:
            self.hidden_toggled.emit(name, name not in self._hidden)

    def _on_double_clicked(self, item: QTreeWidgetItem, column: int) -> None:
        """The second click of a fast pair on the eye counts as a click, too."""
        self._on_clicked(item, column)

    def _on_selection(self) -> None:
        chosen = self.selectedItems()
        self.selected.emit(self._name(chosen[0]) if chosen else None)
