"""A few sliders and boxes under each other that say how something is drawn."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QGridLayout, QLabel, QPushButton, QSlider, QWidget

from riglens.widgets.panels.style import MARGIN, SPACING, as_panel

_CAPTION_PX, _SLIDER_PX, _VALUE_PX = 68, 150, 104


class LookPanel(QWidget):
    """Rows of caption, slider and value; a subclass adds them and says what they mean.

    Panels that stand under each other have their columns in the same places.
    """

    look_changed = Signal(object)

    def __init__(self, title: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(MARGIN + 4, MARGIN, MARGIN + 4, MARGIN)
        self._grid.setHorizontalSpacing(SPACING + 4)
        self._grid.setVerticalSpacing(SPACING)
        self._grid.setColumnMinimumWidth(0, _CAPTION_PX)
        heading = QLabel(title)
        heading.setObjectName("heading")
        heading.setIndent(0)
        self._grid.addWidget(heading, 0, 0, 1, 3)

    def reset(self) -> None:
        """Draw as at first."""
        raise NotImplementedError

    def add_slider(self, caption: str, tip: str, low: int, high: int) -> QSlider:
        """A slider of whole steps; `say` writes the value beside it."""
        slider, label, value = QSlider(Qt.Orientation.Horizontal), QLabel(caption), QLabel()
        slider.setRange(low, high)
        slider.setFixedWidth(_SLIDER_PX)
        slider.setObjectName(caption)
        slider.setAccessibleName(caption)
        slider.valueChanged.connect(self._on_changed)
        value.setMinimumWidth(_VALUE_PX)
        value.setObjectName(f"{caption} value")
        row = self._grid.rowCount()
        for column, widget in enumerate((label, slider, value)):
            widget.setToolTip(tip)
            self._grid.addWidget(widget, row, column)
        return slider

    def add_box(self, caption: str, tip: str) -> QCheckBox:
        """A box to tick."""
        box = QCheckBox(caption)
        box.setToolTip(tip)
        box.toggled.connect(self._on_changed)
        self._grid.addWidget(box, self._grid.rowCount(), 0, 1, 3)
        return box

    def add_reset(self) -> None:
        """A button that goes back to how it is drawn at first."""
        button = QPushButton("Reset")
        button.setObjectName("reset_look")
        button.clicked.connect(self.reset)
        self._grid.addWidget(button, self._grid.rowCount(), 2)

    def say(self, texts: dict[str, str]) -> None:
        """The values beside the sliders, by caption."""
        for caption, text in texts.items():
            label = self.findChild(QLabel, f"{caption} value")
            assert label is not None
            label.setText(text)

    def _on_changed(self, _: object = None) -> None:
        raise NotImplementedError
