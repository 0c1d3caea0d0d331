"""The user's pages inside the window: Markdown files with links between them, with a way back."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt, QUrl
from PySide6.QtWidgets import QDialog, QHBoxLayout, QPushButton, QTextBrowser, QVBoxLayout, QWidget

from riglens.widgets.panels.controls.building import button, filled, room_around
from riglens.widgets.panels.controls.style import MARGIN

WIDTH_PX, HEIGHT_PX = 760, 720


class Guide(QDialog):
    """Help page; links to other pages open here, links to the web in a browser; Esc closes it."""

    def __init__(self, page: Path, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Guide")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.text = QTextBrowser()
        self.text.setOpenExternalLinks(True)
        self.text.setFrameShape(QTextBrowser.Shape.NoFrame)
        self.text.document().setDocumentMargin(2 * MARGIN)
        back = button(QPushButton("Back"), self.text.backward)
        start = button(QPushButton("Start"), self.text.home)
        close = button(QPushButton("Close"), self.reject)
        back.setEnabled(False)
        self.text.backwardAvailable.connect(back.setEnabled)
        row = filled(QHBoxLayout(), back, start, None, close, margins=(MARGIN, 0, MARGIN, MARGIN))
        filled(QVBoxLayout(self), self.text, 1, row)
        room = room_around(self)
        self.resize(min(WIDTH_PX, room.width()), min(HEIGHT_PX, room.height()))
        self.text.setSource(QUrl.fromLocalFile(str(page)))
