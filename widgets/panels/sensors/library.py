"""The sensor models of the library: searchable, by kind; dragged onto the car, or added by a double click."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QByteArray, QEvent, QMimeData, QPoint, QSize, Qt, Signal
from PySide6.QtGui import (
    QBrush,
    QColor,
    QDrag,
    QFont,
    QFontMetrics,
    QHelpEvent,
    QKeyEvent,
    QPainter,
    QPaintEvent,
    QPixmap,
)
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QLineEdit,
    QToolTip,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from riglens.core.rig.library import Entry
from riglens.core.sensing.rays import farthest_m
from riglens.core.sensors.registry import AnyKind, kinds
from riglens.widgets.panels.controls.building import filled
from riglens.widgets.panels.controls.icons import icon
from riglens.widgets.panels.controls.style import MARGIN, as_panel, numbers_font, plain_tip, tones
from riglens.widgets.panels.sensors.rows import derived_rows, short_type
from riglens.widgets.sensors.appearance import colour_of

MODEL_MIME = "application/x-riglens-model"
"""MIME type of a dragged model; the data are its name in UTF-8."""
_MODEL = Qt.ItemDataRole.UserRole
_GHOST_OFF_PX = 18
_NOTHING = "No model matches all of these words"


def _model_tip(entry: Entry) -> str:
    """Return title, figures and source of a model."""
    figures = [f"{caption}: {value}" for caption, value in derived_rows(entry.example) if value[:1] != "—"]
    low, high = entry.example.range_m[0], farthest_m(entry.example)
    if high != float("inf"):
        figures.append(f"Range: {low:g} to {high:g} m")
    notes = [entry.note] if entry.note else []
    return "\n".join([f"{entry.title} ({entry.name})", *figures, entry.origin(), *notes])


class LibraryList(QWidget):
    """List of library entries; emits the one that the user adds."""

    add_wanted = Signal(str)
    """Name of a model to be added at a free place."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self._search = QLineEdit()
        self._search.setObjectName("library_search")
        self._search.setPlaceholderText("Search the library")
        self._search.setClearButtonEnabled(True)
        self._search.addAction(icon("search", tones().muted), QLineEdit.ActionPosition.LeadingPosition)
        self._search.textChanged.connect(self._filter)
        self.models = _Models()
        self.models.itemDoubleClicked.connect(self._ask_for)
        self.models.returned.connect(self._ask_for)
        box = filled(QVBoxLayout(), self._search, margins=(MARGIN, 4, MARGIN, 4))
        filled(QVBoxLayout(self), box, self.models, 1, spacing=0)

    def set_entries(self, entries: Sequence[Entry]) -> None:
        """Show these models."""
        self.models.set_entries(entries)
        self._filter(self._search.text())

    @property
    def shown(self) -> list[str]:
        """Names of the models that match the search."""
        return [str(row.data(0, _MODEL)) for row in self.models.rows() if not row.isHidden()]

    def row_of(self, model: str) -> QTreeWidgetItem:
        """Return the row of a model; raise StopIteration when there is none."""
        return next(row for row in self.models.rows() if row.data(0, _MODEL) == model)

    def _filter(self, text: str) -> None:
        """Keep the models that contain every word of the text somewhere."""
        words = text.casefold().split()
        for row in self.models.rows():
            row.setHidden(not all(word in self.models.tip_of(row).casefold() for word in words))
        self.models.show_counts()

    def _ask_for(self, row: QTreeWidgetItem) -> None:
        model = row.data(0, _MODEL)
        if isinstance(model, str):
            self.add_wanted.emit(model)


class _Models(QTreeWidget):
    """Title and short type, under a heading per kind."""

    returned = Signal(object)
    """The row on which Return was pressed."""

    def __init__(self) -> None:
        super().__init__()
        self._kinds: tuple[AnyKind, ...] = ()
        self._entries: dict[str, Entry] = {}
        self._tips: dict[str, str] = {}
        self.setColumnCount(2)
        self.setHeaderHidden(True)
        self.setRootIsDecorated(False)
        self.setIndentation(8)
        self.setIconSize(QSize(16, 16))
        self.setDragEnabled(True)
        self.setDragDropMode(QAbstractItemView.DragDropMode.DragOnly)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setTextElideMode(Qt.TextElideMode.ElideRight)
        header = self.header()
        header.setStretchLastSection(False)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)

    def set_entries(self, entries: Sequence[Entry]) -> None:
        self.clear()
        self._entries, self._tips = {entry.name: entry for entry in entries}, {}
        font = numbers_font(QFont())
        self._kinds = kinds()
        for kind in self._kinds:
            group = QTreeWidgetItem(self, [kind.heading])
            group.setFlags(Qt.ItemFlag.ItemIsEnabled)
            group.setForeground(0, QBrush(QColor(tones().muted)))
            group.setFirstColumnSpanned(True)
            group.setIcon(0, icon(kind.name, colour_of(kind.name)))
            for entry in entries:
                if entry.kind == kind.name:
                    self._add(group, entry, font)
        self.expandAll()
        self.show_counts()

    def _add(self, group: QTreeWidgetItem, entry: Entry, font: QFont) -> None:
        row = QTreeWidgetItem(group, [entry.title, short_type(entry.example)])
        row.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable | Qt.ItemFlag.ItemIsDragEnabled)
        row.setData(0, _MODEL, entry.name)
        row.setFont(1, font)
        row.setForeground(1, QBrush(QColor(tones().muted)))
        row.setTextAlignment(1, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)

    def tip_of(self, row: QTreeWidgetItem) -> str:
        """Return the tooltip of a model; it is made when first wanted, since all of them take a tenth of a second."""
        name = row.data(0, _MODEL)
        if name not in self._tips:
            self._tips[name] = _model_tip(self._entries[name])
        return self._tips[name]

    def viewportEvent(self, event: QEvent) -> bool:
        """Show the tooltip of a model."""
        if isinstance(event, QHelpEvent) and event.type() == QEvent.Type.ToolTip:
            row = self.itemAt(event.pos())
            if row is not None and row.data(0, _MODEL) is not None:
                tip = plain_tip(f"{self.tip_of(row)}\n\nDrag it onto the car, or double-click.")
                QToolTip.showText(event.globalPos(), tip, self.viewport(), self.visualItemRect(row))
                return True
        return super().viewportEvent(event)

    def rows(self) -> list[QTreeWidgetItem]:
        """Return the rows of all models."""
        return [row for group in self._groups() for row in _children(group)]

    def show_counts(self) -> None:
        """Show in each heading the number of models that match the search; hide headings without any."""
        for group, kind in zip(self._groups(), self._kinds, strict=True):
            rows = _children(group)
            left = sum(not row.isHidden() for row in rows)
            found = f"{left}" if left == len(rows) else f"{left} of {len(rows)}"
            group.setText(0, f"{kind.heading}  {found}")
            group.setHidden(not left)
        self.viewport().update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Show a message when nothing matches the search."""
        super().paintEvent(event)
        if self._groups() and all(group.isHidden() for group in self._groups()):
            painter = QPainter(self.viewport())
            painter.setPen(QColor(tones().muted))
            place = self.viewport().rect().adjusted(8, 8, -8, 0)
            painter.drawText(place, Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignHCenter, _NOTHING)
            painter.end()

    def _groups(self) -> list[QTreeWidgetItem]:
        return _children(self.invisibleRootItem())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Handle Return like a double-click."""
        row = self.currentItem()
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and row is not None:
            self.returned.emit(row)
            return
        super().keyPressEvent(event)

    def startDrag(self, actions: Qt.DropAction) -> None:
        """Drag the name of a model next to the mouse, where it does not cover the drop position."""
        drag, row = QDrag(self), self.currentItem()
        if row is None or not row.flags() & Qt.ItemFlag.ItemIsDragEnabled:
            return
        drag.setMimeData(self.mimeData(self.selectedItems()))
        drag.setPixmap(_tag(row.text(0), self.font()))
        drag.setHotSpot(QPoint(-_GHOST_OFF_PX, -_GHOST_OFF_PX))
        drag.exec(Qt.DropAction.CopyAction)

    def mimeTypes(self) -> list[str]:
        """Offer only the MIME type that the 3D view understands."""
        return [MODEL_MIME]

    def mimeData(self, items: Sequence[QTreeWidgetItem]) -> QMimeData:
        """Return the name of the dragged model."""
        data = QMimeData()
        models = [model for item in items if isinstance(model := item.data(0, _MODEL), str)]
        if models:
            data.setData(MODEL_MIME, QByteArray(models[0].encode("utf-8")))
            data.setText(models[0])
        return data


def _tag(text: str, font: QFont) -> QPixmap:
    """Return a small plate with a name."""
    size = QFontMetrics(font).size(Qt.TextFlag.TextSingleLine, text) + QSize(12, 6)
    plate = QPixmap(size)
    plate.fill(QColor(tones().panel))
    painter = QPainter(plate)
    painter.setFont(font)
    painter.setPen(QColor(tones().border))
    painter.drawRect(plate.rect().adjusted(0, 0, -1, -1))
    painter.setPen(QColor(tones().text))
    painter.drawText(plate.rect(), Qt.AlignmentFlag.AlignCenter, text)
    painter.end()
    return plate


def _children(item: QTreeWidgetItem) -> list[QTreeWidgetItem]:
    found = (item.child(place) for place in range(item.childCount()))
    return [child for child in found if child is not None]
