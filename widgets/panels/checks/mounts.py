"""List of violations of the sensors' mounts: one line each; a click selects the sensor."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QHBoxLayout,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from riglens.core.shown_text import visible
from riglens.widgets.panels.checks.panel import COMPUTING
from riglens.widgets.panels.controls.building import button, filled, plain_label
from riglens.widgets.panels.controls.style import MARGIN, as_panel

USUAL = "usual limits"
USUAL_TIP = (
    "Not inside the body or below the ground, at most 0.1 m off the skin, and not on glass, "
    "lamps, number plates, shut lines or doors (our choice)."
)
SENSOR = Qt.ItemDataRole.UserRole


class MountsPanel(QWidget):
    """Panel that shows violations and requests other limits; computes nothing itself."""

    chosen = Signal(str)
    """A line about this sensor was clicked."""
    file_wanted = Signal()
    usual_wanted = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self.head, self.source, self.lines = plain_label(COMPUTING), plain_label(style="hint"), QListWidget()
        self.lines.setWordWrap(True)
        self.lines.itemClicked.connect(self._choose)
        self.lines.itemActivated.connect(self._choose)
        tip = "Requirements file with a section 'mounts', as for riglens check."
        self.file = button(QPushButton("Load limits…"), self.file_wanted, tip)
        self.usual = button(QPushButton("Usual limits"), self.usual_wanted, f"<p>{USUAL_TIP}</p>")
        row = filled(QHBoxLayout(), self.head, self.source, 1, self.usual, self.file)
        filled(QVBoxLayout(self), row, self.lines, margins=(MARGIN, 4, MARGIN, 4))
        self.show_source(USUAL)

    def show_source(self, name: str) -> None:
        """Show the source of the limits."""
        self.source.setText(f"Checked against: {visible(name)}")
        self.source.setToolTip(f"<p>{USUAL_TIP}</p>" if name == USUAL else "")

    def show_lines(self, violations: Sequence[tuple[str, str]]) -> None:
        """Show violations by sensor; an unchanged list stays, with its selection."""
        count = len(violations)
        self.head.setText(
            f"{count} violation{'s' * (count != 1)}" if count else "Every mount is within the limits"
        )
        texts = [f"{visible(name)}: {visible(text)}" for name, text in violations]
        if texts == [self.lines.item(place).text() for place in range(self.lines.count())]:
            return
        self.lines.clear()
        for (name, _), text in zip(violations, texts, strict=True):
            item = QListWidgetItem(text, self.lines)
            item.setData(SENSOR, name)

    def _choose(self, item: QListWidgetItem) -> None:
        self.chosen.emit(item.data(SENSOR))
