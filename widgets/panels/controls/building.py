"""Build panels: boxes of parts, labels and buttons."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from PySide6.QtCore import QRect, Qt, SignalInstance
from PySide6.QtGui import QGuiApplication, QIcon
from PySide6.QtWidgets import QBoxLayout, QLabel, QLayout, QPushButton, QSizePolicy, QToolButton, QWidget

Box = TypeVar("Box", bound=QBoxLayout)
Margins = tuple[int, int, int, int]
NO_MARGINS: Margins = (0, 0, 0, 0)


def filled(
    box: Box,
    *parts: QWidget | QLayout | int | None,
    margins: Margins = NO_MARGINS,
    spacing: int | None = None,
) -> Box:
    """Put widgets and layouts into a box; a number is the stretch of the part before it, None is room.

    Without a spacing the style's own is used.
    """
    box.setContentsMargins(*margins)
    if spacing is not None:
        box.setSpacing(spacing)
    for part in parts:
        if isinstance(part, QLayout):
            box.addLayout(part)
        elif isinstance(part, QWidget):
            box.addWidget(part)
        elif part is None:
            box.addStretch(1)
        else:
            box.setStretch(box.count() - 1, part)
    return box


def plain_label(text: str = "", style: str = "", wraps: bool = False, shrinks: bool = False) -> QLabel:
    """Return a label that shows its text literally, in one of the looks of the style sheet ("hint", "warning").

    One that shrinks takes the room that there is, however long its text.
    """
    label = QLabel(text)
    label.setObjectName(style)
    label.setTextFormat(Qt.TextFormat.PlainText)
    label.setWordWrap(wraps)
    if shrinks:
        label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
    return label


Button = TypeVar("Button", QPushButton, QToolButton)
Clicked = Callable[[], object] | SignalInstance


def button(
    made: Button, clicked: Clicked | None = None, tip: str = "", name: str = "", text: str = ""
) -> Button:
    """Name a button, and have a click call a function without arguments, or emit a signal."""
    if text:
        made.setText(text)
    made.setObjectName(name)
    made.setToolTip(tip)
    if clicked is not None:
        call = clicked.emit if isinstance(clicked, SignalInstance) else clicked
        made.clicked.connect(lambda _=False: call())
    return made


def tool(icon: QIcon, clicked: Clicked | None = None, tip: str = "", name: str = "") -> QToolButton:
    """Return a button with a picture."""
    made = button(QToolButton(), clicked, tip, name)
    made.setIcon(icon)
    return made


def room_around(widget: QWidget) -> QRect:
    """Return the usable part of the screen that shows a widget, or its parent as long as it is hidden.

    QWidget.screen() must not be called: PySide makes the screen of the application a child of the widget, and with a
    widget that garbage collection finds the screen goes, after which Qt crashes anywhere.
    """
    place = widget if widget.isVisible() else widget.parentWidget() or widget
    middle = place.mapToGlobal(place.rect().center())
    return (QGuiApplication.screenAt(middle) or QGuiApplication.primaryScreen()).availableGeometry()
