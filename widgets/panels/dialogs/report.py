"""A report before it is written: its pages as they are printed, and where it may go."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QImageReader, QPainter, QPaintEvent, QPixmap
from PySide6.QtWidgets import QDialog, QHBoxLayout, QPushButton, QScrollArea, QVBoxLayout, QWidget

from riglens.widgets.panels.controls.building import button, filled, plain_label

NOTE = "Print preview. Open it in a browser for the 3D view."
GAP_PX = 14


class Pages(QWidget):
    """Pictures of pages under one another; each is read when it comes into sight."""

    def __init__(self, pictures: Sequence[Path]) -> None:
        super().__init__()
        self._pictures = tuple(pictures)
        self._known: dict[int, QPixmap] = {}
        sizes = [QImageReader(str(path)).size() for path in pictures]
        self._size = sizes[0] if sizes else QSize(1, 1)
        self.setFixedSize(
            self._size.width() + 2 * GAP_PX, len(sizes) * (self._size.height() + GAP_PX) + GAP_PX
        )

    @property
    def read(self) -> tuple[int, ...]:
        """Return the pages that have been read, from 0 on."""
        return tuple(sorted(self._known))

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the pages in sight."""
        step = self._size.height() + GAP_PX
        first = max(0, event.rect().top() // step)
        last = min(len(self._pictures) - 1, event.rect().bottom() // step)
        painter = QPainter(self)
        for number in range(first, last + 1):
            if number not in self._known:
                self._known[number] = QPixmap(str(self._pictures[number]))
            painter.drawPixmap(GAP_PX, GAP_PX + number * step, self._known[number])
        painter.end()


class ReportDialog(QDialog):
    """Dialog that shows pages and requests an action on them; writes nothing itself."""

    save_wanted = Signal(str)
    """The report is to be saved, as ".html" or ".pdf"."""
    browser_wanted = Signal()
    """The page is to be shown in the browser of the system."""

    def __init__(self, pictures: Sequence[Path], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Report")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.pages = Pages(pictures)
        scroll = QScrollArea()
        scroll.setWidget(self.pages)
        scroll.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self.resize(self.pages.width() + 60, 860)
        self.browser = button(QPushButton("Open in browser"), self.browser_wanted)
        self.html = button(QPushButton("Save page…"), lambda: self.save_wanted.emit(".html"))
        self.pdf = button(QPushButton("Save PDF…"), lambda: self.save_wanted.emit(".pdf"))
        for made in (self.browser, self.html, self.pdf):
            made.setAutoDefault(False)
        note = plain_label(f"{len(pictures)} pages. {NOTE}", "hint")
        row = filled(QHBoxLayout(), note, 1, self.browser, self.html, self.pdf)
        layout = QVBoxLayout(self)
        layout.addWidget(scroll)
        layout.addLayout(row)
