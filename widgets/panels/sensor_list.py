"""The rows of the list of sensors: one per sensor under its kind, brought in line with a rig."""

from __future__ import annotations

from PySide6.QtCore import QItemSelectionModel, QModelIndex, QSize, Qt
from PySide6.QtGui import QBrush, QColor, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QTreeWidget, QTreeWidgetItem, QWidget

from riglens.core.metric.scores import Scores
from riglens.core.rig.model import Rig
from riglens.widgets.panels.icons import icon
from riglens.widgets.panels.marginal_view import loss_tip, lost_share
from riglens.widgets.panels.sensor_rows import (
    NAME,
    SENSOR_NAME,
    TYPE,
    WIDTHS_PX,
    RowState,
    set_loss_stale,
    set_up_columns,
    show_loss,
    show_sensor,
)
from riglens.widgets.panels.style import tones
from riglens.widgets.theme import KIND_COLOURS

Names = tuple[str, ...]
TICK_PX = 20
_NAME_MARGIN_PX = 8
NO_SENSORS = "No sensors yet.\nAdd one in the toolbar, or drag a model\nfrom the library onto the car."
KINDS = (("lidar", "LiDARs"), ("camera", "Cameras"))


class SensorList(QTreeWidget):
    """Shows a rig, and which of its sensors are selected, hidden and locked; the user can do nothing with it yet."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._shown: tuple[object, ...] = ()
        self._kinds: list[str] = []
        self._rows: list[QTreeWidgetItem] = []
        self._items: dict[str, QTreeWidgetItem] = {}
        self._hidden: frozenset[str] = frozenset()
        self._locked: frozenset[str] = frozenset()
        self._enabled: frozenset[str] = frozenset()
        set_up_columns(self)
        self.setIndentation(6)
        self.setRootIsDecorated(False)
        self.setUniformRowHeights(True)
        self.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.setIconSize(QSize(16, 16))

    # ------------------------------------------------------------------ what is shown
    def set_rig(
        self, rig: Rig, hidden: frozenset[str], selected: str | None, locked: frozenset[str] = frozenset()
    ) -> None:
        """Show a rig. Rows are built anew only when sensors come or go, never while one of them is edited."""
        shown = (rig.sensors, hidden, locked, tones())
        chosen = self.chosen
        self.blockSignals(True)
        if shown != self._shown:
            if self._shown[-1:] != shown[-1:]:
                self._kinds = []  # other colours: build every row anew
            self._shown, self._hidden, self._locked = shown, hidden, locked
            self._enabled = frozenset(sensor.name for sensor in rig.sensors if sensor.enabled)
            self._show_rows(rig)
        self._show_selection(selected, chosen)
        self.blockSignals(False)

    def _show_selection(self, selected: str | None, chosen: Names) -> None:
        """Select one sensor; those selected with it stay when it was one of them."""
        if selected is None:
            self.setCurrentIndex(QModelIndex())
            self.clearSelection()
            return
        kept = {name for name in chosen if name in self._items} if selected in chosen else set()
        for name, item in self._items.items():
            item.setSelected(name == selected or name in kept)
        self.setCurrentItem(self._items[selected], NAME, QItemSelectionModel.SelectionFlag.NoUpdate)

    @property
    def chosen(self) -> Names:
        """Names of all selected sensors, in the order of the list."""
        return tuple(name for name, item in self._items.items() if item.isSelected())

    def item_of(self, name: str) -> QTreeWidgetItem:
        """The row of a sensor; KeyError when there is none."""
        return self._items[name]

    def name_of(self, item: QTreeWidgetItem) -> str | None:
        """The sensor of a row, None for the row of a kind."""
        name = item.data(NAME, SENSOR_NAME)
        return name if isinstance(name, str) else None

    # ------------------------------------------------------------------ what a sensor is worth
    def show_losses(self, now: Scores, without: dict[str, Scores]) -> None:
        """Exact scores of the rig, and of the rig without each of the sensors that are known by now."""
        shares = {name: lost_share(now, scores) for name, scores in without.items() if name in self._items}
        largest = max(shares.values(), default=0.0)
        self.blockSignals(True)
        for name, share in shares.items():
            show_loss(self._items[name], share, largest, loss_tip(now, without[name]))
        self.blockSignals(False)

    def set_losses_stale(self) -> None:
        """Grey the losses: they are of an earlier rig."""
        self.blockSignals(True)
        for row in self._rows:
            set_loss_stale(row)
        self.blockSignals(False)

    # ------------------------------------------------------------------ rows
    def _show_rows(self, rig: Rig) -> None:
        kinds: list[str] = [sensor.kind for sensor in rig.sensors]
        if kinds != self._kinds:
            self._kinds = kinds
            self._rows = self._build_rows(kinds)
        self._items = {sensor.name: row for sensor, row in zip(rig.sensors, self._rows, strict=True)}
        for sensor in rig.sensors:
            state = RowState(sensor.name in self._hidden, sensor.name in self._locked)
            show_sensor(self._items[sensor.name], sensor, state)
        self._fit_names()

    def _build_rows(self, kinds: list[str]) -> list[QTreeWidgetItem]:
        """Empty rows under their group, in the order of the rig's sensors."""
        scrolled = self.verticalScrollBar().value()
        self.clear()
        groups = {kind: self._group(kind, f"{title}  {kinds.count(kind)}") for kind, title in KINDS}
        rows = [QTreeWidgetItem(groups[kind]) for kind in kinds]
        self.expandAll()
        self.verticalScrollBar().setValue(scrolled)
        return rows

    def _group(self, kind: str, title: str) -> QTreeWidgetItem:
        group = QTreeWidgetItem(self, [title])
        group.setFlags(Qt.ItemFlag.ItemIsEnabled)
        group.setForeground(NAME, QBrush(QColor(tones().muted)))
        group.setFirstColumnSpanned(True)
        group.setIcon(NAME, icon(kind, KIND_COLOURS[kind]))
        return group

    # ------------------------------------------------------------------ looks
    def paintEvent(self, event: QPaintEvent) -> None:
        """Say in an empty list where sensors come from."""
        super().paintEvent(event)
        if not self._rows:
            last = self.topLevelItem(self.topLevelItemCount() - 1)
            below = 0 if last is None else self.visualItemRect(last).bottom()
            painter = QPainter(self.viewport())
            painter.setPen(QColor(tones().muted))
            place = self.viewport().rect().adjusted(8, below + 8, -8, 0)
            top = Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignHCenter
            painter.drawText(place, top | Qt.TextFlag.TextWordWrap, NO_SENSORS)
            painter.end()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Give names the room that they need."""
        super().resizeEvent(event)
        self._fit_names()

    def _fit_names(self) -> None:
        """Leave the types out where names would be cut."""
        longest = max((self.fontMetrics().horizontalAdvance(name) for name in self._items), default=0)
        needed = longest + TICK_PX + 2 * self.indentation() + _NAME_MARGIN_PX + sum(WIDTHS_PX.values())
        self.setColumnHidden(TYPE, needed > self.viewport().width())
