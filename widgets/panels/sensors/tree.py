"""The list of sensors by kind: tick, name, short type, loss without it, lock and eye; several can be selected."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from itertools import zip_longest

from PySide6.QtCore import (
    QEvent,
    QItemSelectionModel,
    QModelIndex,
    QPersistentModelIndex,
    QPoint,
    QSignalBlocker,
    QSize,
    Qt,
    Signal,
)
from PySide6.QtGui import QBrush, QColor, QMouseEvent, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QAbstractItemView, QMenu, QTreeWidget, QTreeWidgetItem, QWidget

from riglens.core.figures.figure import Figure
from riglens.core.rig.edits import partner_of
from riglens.core.rig.model import Rig, Sensor
from riglens.core.sensors.registry import kinds, shown_kinds
from riglens.core.shown_text import visible
from riglens.widgets.panels.controls.icons import icon
from riglens.widgets.panels.controls.item_views import give_context_menu
from riglens.widgets.panels.controls.menus import add_entry
from riglens.widgets.panels.controls.style import plain_tip, tones
from riglens.widgets.panels.sensors.losses import Loss, heading, meaning, measure_for, usual_measure
from riglens.widgets.panels.sensors.rows import (
    CHOICE_TIP,
    EYE,
    LOCK,
    LOSS,
    NAME,
    SENSOR_NAME,
    SIGN_PX,
    TYPE,
    WIDTHS_PX,
    RowState,
    forget_loss,
    set_loss_stale,
    set_up_columns,
    show_loss,
    show_sensor,
)
from riglens.widgets.sensors.appearance import colour_of

Names = tuple[str, ...]
TICK_PX = 20
_NAME_MARGIN_PX = 8
LINK_GAP_PX = 4
NO_SENSORS = "No sensors yet.\nAdd one in the toolbar, or drag a model\nfrom the library onto the car."
NO_BOXES_TIP = "The data have almost no boxes in this direction: they cannot show what this sensor adds."


_Line = tuple[Sensor, RowState]
"""Content of a row."""


def _look_alike(line: _Line, before: _Line | None) -> bool:
    """Return whether two lines differ in nothing but where the sensor is, which no row shows: a drag repaints none."""
    if before is None:
        return False
    (sensor, state), (old, old_state) = line, before
    return state == old_state and type(sensor) is type(old) and old.with_pose(sensor.pose) == sensor


class SensorList(QTreeWidget):
    """List of a rig's sensors, and which of them are selected, hidden and locked; not interactive by itself."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._shown: tuple[object, ...] = ()
        self._lines: list[_Line] = []
        self._kinds: list[str] = []
        self._has_links = False
        self._rows: list[QTreeWidgetItem] = []
        self._items: dict[str, QTreeWidgetItem] = {}
        self._hidden: frozenset[str] = frozenset()
        self._locked: frozenset[str] = frozenset()
        self._enabled: frozenset[str] = frozenset()
        self._failed: frozenset[str] = frozenset()
        self._selection: Names = ()
        self._rig, self._problems = Rig(), dict[str, str]()
        self._groups: dict[str, QTreeWidgetItem] = {}
        self._measure = usual_measure()
        set_up_columns(self)
        self.show_measure(self._measure)
        self.setIndentation(6)
        self.setRootIsDecorated(False)
        self.setUniformRowHeights(True)
        self.setTextElideMode(Qt.TextElideMode.ElideMiddle)
        self.setIconSize(QSize(16, 16))

    # ------------------------------------------------------------------ what is shown
    def set_rig(
        self, rig: Rig, hidden: frozenset[str], selection: Names, locked: frozenset[str] = frozenset()
    ) -> None:
        """Show a rig and which of its sensors are selected, the current one last.

        Rows are rebuilt only when sensors are added or removed, never while one of them is edited.
        """
        shown = (rig.sensors, hidden, locked, tones())
        if shown != self._shown:
            if self._shown[-1:] != shown[-1:]:
                self._kinds = []  # other colours: rebuild every row
            self._shown, self._hidden, self._locked = shown, hidden, locked
            self._enabled = frozenset(sensor.name for sensor in rig.sensors if sensor.enabled)
            self._rig = rig
            self._show_rows()
        self._show_selection(selection)

    def show_problems(self, problems: Mapping[str, str]) -> None:
        """Mark the sensors with problems, and name them in their tooltips."""
        if problems != self._problems:
            self._problems = dict(problems)
            self._show_rows()

    def set_failed(self, failed: frozenset[str]) -> None:
        """Mark the sensors that are taken as failed."""
        if failed != self._failed:
            self._failed = failed
            self._show_rows()

    def _show_selection(self, selection: Names) -> None:
        """Select these rows and no others."""
        self._selection = selection
        with QSignalBlocker(self):
            if not selection:
                self.setCurrentIndex(QModelIndex())
                self.clearSelection()
                return
            for name, item in self._items.items():
                item.setSelected(name in selection)
            self.setCurrentItem(self._items[selection[-1]], NAME, QItemSelectionModel.SelectionFlag.NoUpdate)

    @property
    def chosen(self) -> Names:
        """Names of all selected sensors, in the order of the list."""
        return tuple(name for name, item in self._items.items() if item.isSelected())

    def name_of(self, item: QTreeWidgetItem) -> str | None:
        """Return the sensor of a row, None for the row of a kind."""
        name = item.data(NAME, SENSOR_NAME)
        return name if isinstance(name, str) else None

    # ------------------------------------------------------------------ what a sensor is worth
    def show_losses(self, losses: Mapping[str, Loss]) -> None:
        """Show the losses without each sensor, as far as known; bars are relative to the largest loss."""
        largest = max((loss.size for loss in losses.values() if loss.size is not None), default=0.0)
        with QSignalBlocker(self):
            for name, loss in losses.items():
                if name in self._items:
                    show_loss(self._items[name], loss, largest)

    def show_measure(self, measure: Figure) -> None:
        """Say in which measure losses are: its unit in the title, its name in the row of each kind."""
        self._measure = measure
        self._name_measures()
        self.headerItem().setText(LOSS, heading(measure))
        self.headerItem().setToolTip(LOSS, f"{meaning(measure)}\n{CHOICE_TIP}")
        for row in self._rows:
            forget_loss(row)

    def _name_measures(self) -> None:
        """Write into the row of each kind in which figure its losses are."""
        with QSignalBlocker(self):
            for kind, group in self._groups.items():
                measure = measure_for(kind, self._measure)
                group.setText(LOSS, measure.short)
                group.setToolTip(LOSS, plain_tip(meaning(measure)))

    def set_losses_stale(self) -> None:
        """Grey the losses: they belong to an earlier rig."""
        with QSignalBlocker(self):
            for row in self._rows:
                set_loss_stale(row)

    # ------------------------------------------------------------------ rows
    def _show_rows(self) -> None:
        blocker, rig = QSignalBlocker(self), self._rig
        names = [sensor.kind for sensor in rig.sensors]
        if names != self._kinds:
            self._kinds, self._lines = names, []
            self._rows = self._build_rows(names)
        self._items = {sensor.name: row for sensor, row in zip(rig.sensors, self._rows, strict=True)}
        lines = [(sensor, self._state_of(rig, sensor.name)) for sensor in rig.sensors]
        for row, line, before in zip_longest(self._rows, lines, self._lines):
            if not _look_alike(line, before):
                show_sensor(row, *line)
        self._lines = lines
        self._has_links = any(sensor.mirror_of is not None for sensor in rig.sensors)
        self._fit_names()
        blocker.unblock()

    def _state_of(self, rig: Rig, name: str) -> RowState:
        problem = self._problems.get(name, "")
        is_failed = name in self._failed
        return RowState(name in self._hidden, name in self._locked, partner_of(rig, name), problem, is_failed)

    def _build_rows(self, names: list[str]) -> list[QTreeWidgetItem]:
        """Make empty rows under their group, in the order of the rig's sensors."""
        scrolled = self.verticalScrollBar().value()
        self.clear()
        self._groups = {
            kind.name: self._group(kind.name, f"{kind.heading}  {names.count(kind.name)}")
            for kind in shown_kinds(names)
        }
        self._name_measures()
        rows = [QTreeWidgetItem(self._groups[name]) for name in names]
        self.expandAll()
        self.verticalScrollBar().setValue(scrolled)
        return rows

    def _group(self, kind: str, title: str) -> QTreeWidgetItem:
        group = QTreeWidgetItem(self, [title])
        group.setFlags(Qt.ItemFlag.ItemIsEnabled)
        for column in (NAME, LOSS):
            group.setForeground(column, QBrush(QColor(tones().muted)))
        group.setTextAlignment(LOSS, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        group.setIcon(NAME, icon(kind, colour_of(kind)))
        return group

    # ------------------------------------------------------------------ looks
    def paintEvent(self, event: QPaintEvent) -> None:
        """Say in an empty list how to add sensors."""
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
        """Give the names the room they need."""
        super().resizeEvent(event)
        self._fit_names()

    def _fit_names(self) -> None:
        """Give up the types, then the locks while none is locked, then a part of the losses where names would be cut
        off."""
        wide = self.fontMetrics().horizontalAdvance
        longest = max(
            (wide(visible(name)) + SIGN_PX * (name in self._problems) for name in self._items), default=0
        )
        if self._has_links:
            longest += self.iconSize().width() + LINK_GAP_PX
        needed = longest + TICK_PX + 2 * self.indentation() + _NAME_MARGIN_PX + sum(WIDTHS_PX.values())
        room = self.viewport().width()
        for column, may_go in ((TYPE, True), (LOCK, not self._locked)):
            is_hidden = may_go and needed > room
            self.setColumnHidden(column, is_hidden)
            needed -= WIDTHS_PX[column] * is_hidden
        least = self.header().sectionSizeHint(LOSS)  # its heading in full
        self.header().resizeSection(LOSS, max(least, WIDTHS_PX[LOSS] - max(0, needed - room)))


class SensorTree(SensorList):
    """Tree that follows a rig; emits the user's requests and changes nothing itself."""

    selected = Signal(tuple)
    """Names of the sensors to select, the one to edit last."""
    enabled_toggled = Signal(tuple, bool)
    hidden_toggled = Signal(tuple, bool)
    locked_toggled = Signal(tuple, bool)
    failed_toggled = Signal(tuple, bool)
    """Names, and whether they are to be enabled, hidden, locked or taken as failed."""
    renamed = Signal(str, str)
    refused = Signal(str)
    """A name that cannot be given, with the reason."""
    measure_menu_wanted = Signal(QPoint)
    """Request for the menu of loss measures at a place of the screen."""
    menu_wanted = Signal(object)
    """A QMenu for the selected sensors, to be filled with more before it opens."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.setEditTriggers(
            QAbstractItemView.EditTrigger.DoubleClicked | QAbstractItemView.EditTrigger.EditKeyPressed
        )
        give_context_menu(self, self.context_menu)
        header = self.header()
        header.setSectionsClickable(True)
        header.setHighlightSections(False)
        header.sectionClicked.connect(self._on_title)
        header.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        header.customContextMenuRequested.connect(lambda _: self._on_title(LOSS))
        self.itemChanged.connect(self._on_changed)
        self.itemClicked.connect(self._on_clicked)
        self.itemDoubleClicked.connect(self._on_clicked)
        self.itemSelectionChanged.connect(self._on_selection)

    # ------------------------------------------------------------------ what the user does
    def choose(self, names: Names) -> None:
        """Ask for several sensors to be selected, the last of which is edited."""
        self.selected.emit(names)

    def edit(  # type: ignore[override]
        self, index: QModelIndex, trigger: QAbstractItemView.EditTrigger, event: QEvent
    ) -> bool:
        """Start editing names only."""
        return index.column() == NAME and super().edit(index, trigger, event)

    def selectionCommand(
        self, index: QModelIndex | QPersistentModelIndex, event: QEvent | None = None
    ) -> QItemSelectionModel.SelectionFlag:
        """Keep the selection on a click on tick, lock or eye, so that the click can apply to all of it."""
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
        """Return the sensors that a click on one of them applies to: all selected ones if it is selected too."""
        chosen = self.chosen
        return chosen if name in chosen else (name,)

    def _on_changed(self, item: QTreeWidgetItem, column: int) -> None:
        name = self.name_of(item)
        if name is None or column != NAME:
            return
        if item.text(NAME) != visible(name):
            self._rename(item, name)
            return
        self.enabled_toggled.emit(self._meant(name), item.checkState(NAME) == Qt.CheckState.Checked)

    def _rename(self, item: QTreeWidgetItem, name: str) -> None:
        wanted, shown = item.text(NAME).strip(), visible(name)
        reason = ""
        if not wanted:
            reason = "The name must not be empty."
        elif wanted not in (name, shown) and wanted in self._items:
            reason = f"Name: '{wanted}' is used by another sensor; names must be unique."
        if reason or wanted in (name, shown):
            with QSignalBlocker(self):
                item.setText(NAME, shown)
        if reason:
            self.refused.emit(reason)
        elif wanted not in (name, shown):
            self.renamed.emit(name, wanted)

    def _on_clicked(self, item: QTreeWidgetItem, column: int) -> None:
        """Handle a click on lock or eye; the second click of a double click counts, too."""
        name = self.name_of(item)
        if name is not None and column == EYE:
            self.hidden_toggled.emit(self._meant(name), name not in self._hidden)
        elif name is not None and column == LOCK:
            self.locked_toggled.emit(self._meant(name), name not in self._locked)

    def _on_selection(self) -> None:
        chosen = self.chosen
        current = self.currentItem()
        newest = self.name_of(current) if current is not None else None
        before = {name: place for place, name in enumerate(self._selection)}
        ordered = sorted(chosen, key=lambda name: (name == newest, before.get(name, len(before))))
        self._selection = tuple(ordered)
        self.selected.emit(self._selection)

    def _on_title(self, column: int) -> None:
        """Emit `measure_menu_wanted`, with the place below the title of the losses, when that is clicked."""
        if column == LOSS:
            header = self.header()
            left = header.sectionViewportPosition(LOSS)
            self.measure_menu_wanted.emit(header.mapToGlobal(QPoint(left, header.height())))

    # ------------------------------------------------------------------ context menu
    def context_menu(self) -> QMenu:
        """Return a menu of what can be done with the selected sensors, or of what selects some."""
        menu = QMenu(self)
        chosen = self.chosen
        if chosen:
            for title, names_on, signal in (
                ("Enabled", self._enabled, self.enabled_toggled),
                ("Hidden", self._hidden, self.hidden_toggled),
                ("Locked", self._locked, self.locked_toggled),
                ("Failed", self._failed, self.failed_toggled),
            ):
                action = add_entry(menu, title, partial(signal.emit, chosen))
                action.setCheckable(True)
                action.setChecked(all(name in names_on for name in chosen))
            menu.addSeparator()
            self.menu_wanted.emit(menu)
            menu.addSeparator()
        for kind in kinds():
            of_kind = tuple(name for name, k in zip(self._items, self._kinds, strict=True) if k == kind.name)
            add_entry(menu, f"Select all {kind.plural}", partial(self.choose, of_kind)).setEnabled(
                bool(of_kind)
            )
        return menu
