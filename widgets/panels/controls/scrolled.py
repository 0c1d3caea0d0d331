"""Panels that scroll where there is too little room for them: no window is ever larger than its screen for a panel."""

from __future__ import annotations

import re

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent
from PySide6.QtWidgets import QFrame, QLabel, QScrollArea, QWidget

from riglens.core.shown_text import visible_lines

_LONG_WORD = re.compile(r"\S{20,}")
_BREAK = "\u200b"  # zero width space


def breakable(text: str) -> str:
    """Return a text for a label: long words, such as paths and names, may wrap, and control characters are legible."""
    return _LONG_WORD.sub(lambda word: _BREAK.join(word[0]), visible_lines(text))


_SLACK_PX = 60
"""Room that a shorter text may leave unused."""


class ElidedLabel(QLabel):
    """One line that is cut off with an ellipsis where there is too little room for it; the tooltip is the owner's.

    A text that is as long or a little shorter takes the place of the one before: a layout that makes room anew lays
    out the whole window, which takes longer than the line.
    """

    def __init__(self, text: str = "") -> None:
        super().__init__(text)
        self.setTextFormat(Qt.TextFormat.PlainText)
        self._text = text

    def text(self) -> str:
        """Return the text, whole."""
        return self._text

    def setText(self, text: str) -> None:
        """Show another text."""
        wide = self.fontMetrics().horizontalAdvance
        self._text = text
        self.setAccessibleName(text)
        if 0 <= wide(super().text()) - wide(text) <= _SLACK_PX:
            self.update()
        else:
            super().setText(text)

    def minimumSizeHint(self) -> QSize:
        least_px = self.fontMetrics().horizontalAdvance("…")
        return QSize(least_px, super().minimumSizeHint().height())

    def paintEvent(self, event: QPaintEvent) -> None:
        area = self.contentsRect()
        shown = self.fontMetrics().elidedText(self.text(), Qt.TextElideMode.ElideRight, area.width())
        painter = QPainter(self)
        self.style().drawItemText(
            painter,
            area,
            int(self.alignment()),
            self.palette(),
            self.isEnabled(),
            shown,
            self.foregroundRole(),
        )
        painter.end()


def scrolled(content: QWidget) -> QScrollArea:
    """Return an area as large as its dock that scrolls to what does not fit."""
    area = QScrollArea()
    area.setWidget(content)
    area.setWidgetResizable(True)
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # its fields take the focus
    return area
