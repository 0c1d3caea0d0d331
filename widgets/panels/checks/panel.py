"""The checks of a rig: a list of them, and the page of the chosen one, which scrolls by itself where it has to."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QListWidget, QStackedWidget, QWidget

from riglens.widgets.panels.controls.building import filled
from riglens.widgets.panels.controls.scrolled import scrolled
from riglens.widgets.panels.controls.style import as_panel

COMPUTING = "computing…"
_MARGIN_PX = 24


class ChecksPanel(QWidget):
    """Panel of several pages, of which it shows one at a time; each page belongs to the feature that adds it."""

    page_changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self.names, self._pages = QListWidget(), QStackedWidget()
        self._order: list[QWidget] = []
        self.names.setObjectName("checks")
        self.names.currentRowChanged.connect(self._pages.setCurrentIndex)
        self._pages.currentChanged.connect(lambda _: self.page_changed.emit())
        filled(QHBoxLayout(self), self.names, self._pages, 1, spacing=0)

    def add(self, title: str, page: QWidget) -> None:
        """Add the page of a check at the end."""
        self.names.addItem(title)
        self._order.append(page)
        self._pages.addWidget(scrolled(page))
        self.names.setFixedWidth(self.names.sizeHintForColumn(0) + _MARGIN_PX)
        if self.names.currentRow() < 0:
            self.names.setCurrentRow(0)

    def choose(self, page: QWidget) -> None:
        """Show a page."""
        self.names.setCurrentRow(self._order.index(page))
