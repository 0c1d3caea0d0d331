"""Panels that scroll where there is too little room for them: no window is ever larger than its screen for a panel."""

from __future__ import annotations

import re

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFrame, QScrollArea, QWidget

_LONG_WORD = re.compile(r"\S{20,}")
_BREAK = "\u200b"  # zero width space


def breakable(text: str) -> str:
    """Return a text for a label whose long words, such as paths and names, may go on in the next line."""
    return _LONG_WORD.sub(lambda word: _BREAK.join(word[0]), text)


def scrolled(content: QWidget) -> QScrollArea:
    """Return an area as large as its dock that scrolls to what does not fit."""
    area = QScrollArea()
    area.setWidget(content)
    area.setWidgetResizable(True)
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # its fields take the focus
    return area
