"""A report before it is written: its texts, tables and pictures as they are printed, and where it may go."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor, QPalette, QTextDocument
from PySide6.QtWidgets import QDialog, QHBoxLayout, QLabel, QPushButton, QTextBrowser, QVBoxLayout, QWidget

NOTE = "As it is printed. The car that turns is seen in a browser."


class ReportDialog(QDialog):
    """Shows a document and asks for what is to become of it; nothing is written by itself."""

    save_wanted = Signal(str)
    """The report is to be saved, as ".html" or ".pdf"."""
    browser_wanted = Signal()
    """The page is to be shown in the browser of the system."""

    def __init__(self, document: QTextDocument, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Report")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.resize(820, 860)
        document.setParent(self)
        document.setDocumentMargin(24.0)
        self.page = QTextBrowser()
        self.page.setOpenLinks(False)
        paper = self.page.palette()
        paper.setColor(QPalette.ColorRole.Base, QColor("#ffffff"))  # as the print, in a dark window, too
        paper.setColor(QPalette.ColorRole.Text, QColor("#000000"))
        self.page.setPalette(paper)
        self.page.setStyleSheet("QTextBrowser { background: #ffffff; color: #000000; }")
        self.page.setDocument(document)
        self.browser = QPushButton("Open in browser")
        self.html, self.pdf = QPushButton("Save page…"), QPushButton("Save PDF…")
        self.browser.clicked.connect(lambda: self.browser_wanted.emit())
        self.html.clicked.connect(lambda: self.save_wanted.emit(".html"))
        self.pdf.clicked.connect(lambda: self.save_wanted.emit(".pdf"))
        note = QLabel(NOTE)
        note.setObjectName("hint")
        row = QHBoxLayout()
        row.addWidget(note, 1)
        for button in (self.browser, self.html, self.pdf):
            button.setAutoDefault(False)
            row.addWidget(button)
        layout = QVBoxLayout(self)
        layout.addWidget(self.page)
        layout.addLayout(row)
