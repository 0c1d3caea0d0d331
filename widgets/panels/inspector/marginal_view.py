"""What the rig loses without one sensor, per class: change of S-MS and of what is seen."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QPalette
from PySide6.QtWidgets import QGridLayout, QLabel, QWidget

from riglens.core.metric.scores import ClassScores, Scores
from riglens.core.scene.boxes import CLASSES
from riglens.widgets.panels.scores.text import NONE, change_text, column_of, exact_text
from riglens.widgets.panels.style import SPACING, numbers_font, tones

WAITING, NOT_COUNTED = "computed when the program is idle", "it does not count, so nothing is lost"
NOTE = (
    "Exact scores of the rig without this sensor, minus those of the rig as it is.\n"
    "What another sensor sees as well is not lost."
)
_SHOWN = ("s_ms", "seen")


def seen_entropy_nat(scores: Scores, class_name: str) -> float:
    """Return the entropy of a class, in nat, that any sensor sees."""
    found = scores.classes[class_name]
    return found.any_seen * found.h_total


def lost_share(now: Scores, without: Scores) -> float:
    """Return the share of the entropy of all classes, 0 to 1, that is seen now but not without the sensor."""
    total = sum(scores.h_total for scores in now.classes.values())
    lost = sum(seen_entropy_nat(now, name) - seen_entropy_nat(without, name) for name in now.classes)
    return lost / total if total else 0.0


def loss_tip(now: Scores, without: Scores) -> str:
    """Describe the loss per class, in `seen` and in S-MS."""
    lines = ["Without it, exactly:"]
    for name in CLASSES:
        parts = []
        for key in ("seen", "s_ms"):
            column = column_of(key)
            change = column.value(without.classes[name]) - column.value(now.classes[name])
            parts.append(f"{column.title} {change_text(change, column)}")
        lines.append(f"{name}: {', '.join(parts)}")
    return "\n".join(lines)


class MarginalView(QWidget):
    """A small table; numbers of an earlier rig are greyed."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(SPACING)
        grid.setVerticalSpacing(2)
        grid.setColumnMinimumWidth(0, 70)
        for place in (1, 2, 3):
            grid.setColumnStretch(place, 1)
        for place, title in enumerate(("S-MS", "seen", "seen, nat"), 1):
            grid.addWidget(_label(title, muted=True), 0, place)
        self._cells: dict[tuple[str, str], QLabel] = {}
        for row, name in enumerate(CLASSES, 1):
            grid.addWidget(QLabel(name), row, 0)
            for place, key in enumerate((*_SHOWN, "nat"), 1):
                self._cells[name, key] = _label(NONE)
                grid.addWidget(self._cells[name, key], row, place)
        self._note = QLabel(WAITING)
        self._note.setObjectName("hint")
        self._note.setTextFormat(Qt.TextFormat.PlainText)
        grid.addWidget(self._note, len(CLASSES) + 1, 0, 1, 4)
        self.setToolTip(NOTE)

    def show_loss(self, now: Scores, without: Scores) -> None:
        """Show exact scores of the rig with and without the sensor."""
        for name in CLASSES:
            with_it, without_it = now.classes[name], without.classes[name]
            for key in _SHOWN:
                column = column_of(key)
                change = column.value(without_it) - column.value(with_it)
                self._show(name, key, change_text(change, column), exact_text(column, change))
            self._show_nat(name, with_it, without_it)
        self._note.setText("10³ nat and percentage points of H(Ω)")
        self.set_stale(False)

    def _show_nat(self, name: str, with_it: ClassScores, without_it: ClassScores) -> None:
        nat = without_it.any_seen * without_it.h_total - with_it.any_seen * with_it.h_total
        self._show(name, "nat", change_text(nat, column_of("s_ms")), f"{nat!r} nat")

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
            _colour(cell, tones().muted if stale else tones().text)

    def text_of(self, class_name: str, key: str) -> str:
        """Return what stands in a cell; `key` is "s_ms", "seen" or "nat"."""
        return self._cells[class_name, key].text()

    @property
    def note(self) -> str:
        """The line under the table."""
        return self._note.text()

    def _show(self, name: str, key: str, text: str, exact: str) -> None:
        self._cells[name, key].setText(text)
        self._cells[name, key].setToolTip(exact)


def _label(text: str, muted: bool = False) -> QLabel:
    label = QLabel(text)
    label.setFont(numbers_font(label.font()))
    label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    if muted:
        label.setObjectName("hint")
    return label


def _colour(label: QLabel, colour: str) -> None:
    palette = label.palette()
    palette.setColor(QPalette.ColorRole.WindowText, QColor(colour))
    label.setPalette(palette)
