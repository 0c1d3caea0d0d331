"""Show what the rig loses without one sensor, per class: change of the leading figures."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QGridLayout, QLabel, QWidget

from riglens.core.figures.values import Values
from riglens.core.scene.boxes import CLASSES
from riglens.core.shown_values import NONE
from riglens.widgets.panels.controls.building import plain_label
from riglens.widgets.panels.controls.style import numbers_font
from riglens.widgets.panels.sensors.losses import class_change, measures

WAITING, NOT_COUNTED = "computed between edits", "disabled: no loss"
FAILED = "failed: the scores are those without it"
UNITS = "percentage points of objects and of H(Ω), 10³ nat"
NOTE = (
    "Exact figures without this sensor, minus those of the current rig.\n"
    "Coverage that another sensor provides as well is not lost."
)


_GAP_PX = 4


class MarginalView(QWidget):
    """A small table; numbers of an earlier rig are greyed."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(_GAP_PX)
        grid.setVerticalSpacing(2)
        self._measures = measures()
        for place, one in enumerate(self._measures.values(), 1):
            grid.setColumnStretch(place, 1)
            grid.addWidget(_label(one.short, muted=True), 0, place)
        self._cells: dict[tuple[str, str], QLabel] = {}
        for row, name in enumerate(CLASSES, 1):
            grid.addWidget(QLabel(name), row, 0)
            for place, key in enumerate(self._measures, 1):
                self._cells[name, key] = _label(NONE)
                grid.addWidget(self._cells[name, key], row, place)
        self._note = plain_label(WAITING, "hint", wraps=True)
        grid.addWidget(self._note, len(CLASSES) + 1, 0, 1, 1 + len(self._measures))
        self.setToolTip(NOTE)

    def show_loss(self, now: Values, without: Values) -> None:
        """Show the known figures of the rig with and without the sensor."""
        for (name, key), cell in self._cells.items():
            short, text, exact = class_change(self._measures[key], name, now, without)
            cell.setText(short)
            cell.setToolTip(f"{text}\n{exact}")
        self._note.setText(UNITS)
        self.set_stale(False)

    def show_none(self, reason: str) -> None:
        """Show no numbers, and say why."""
        for cell in self._cells.values():
            cell.setText(NONE)
            cell.setToolTip("")
        self._note.setText(reason)
        self.set_stale(True)

    def set_stale(self, stale: bool) -> None:
        """Grey the numbers because the rig has changed, or show them as current."""
        for cell in self._cells.values():
            cell.setEnabled(not stale)

    def text_of(self, class_name: str, key: str) -> str:
        """Return the text of a cell."""
        return self._cells[class_name, key].text()

    @property
    def note(self) -> str:
        """The line under the table."""
        return self._note.text()


def _label(text: str, muted: bool = False) -> QLabel:
    label = plain_label(text, "hint" if muted else "", wraps=muted)
    label.setFont(numbers_font(label.font()))
    label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    return label
