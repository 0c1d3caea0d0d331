"""Where the rays of one sensor go, in six shares that add up to 100 %, and what the car's body costs it by class."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from riglens.core.scene.boxes import CLASSES
from riglens.widgets.panels.controls.style import SPACING, numbers_font, tones
from riglens.widgets.panels.scores.text import NONE

if TYPE_CHECKING:  # made by the engine's thread, which loads the compiler
    from riglens.core.engine.audit import SensorAudit

FATE_TITLES = {
    "brings_new": "brings new",
    "seen_by_others": "seen by others",
    "meets_nothing": "meets nothing",
    "ground": "ends at ground",
    "never_enters": "never enters",
    "hits_car": "hits the car",
}
"""Fates of rays from the best to the worst, by the keys of the audit."""
FATE_TIPS = {
    "brings_new": "Rays that meet places where traffic is uncertain and which no other sensor of the rig sees",
    "seen_by_others": "Rays that meet such places, but only ones that other sensors see as well",
    "meets_nothing": "Rays that leave the region without meeting such a place",
    "ground": "Rays that end at the ground without meeting one",
    "never_enters": "Rays that never enter the region",
    "hits_car": "Rays that end at the car's own body",
}
FATE_COLOURS = {
    "brings_new": "#149c8d", "seen_by_others": "#7fd6cb", "meets_nothing": "#9aa3ad", "ground": "#c9a97a",
    "never_enters": "#6b7280", "hits_car": "#f43f5e",
}  # fmt: skip
FOLLOW, FOLLOW_TIP = "Follow its rays", "Follow every ray of every sensor of the rig through the region, once"
ASKED, NOT_COUNTED = "Rays are being followed…", "it does not count: its rays go nowhere"
OUTDATED = "of the rig before the last change"


def percents(shares: dict[str, float]) -> dict[str, float]:
    """Return shares in percent with one decimal that add up to 100.0: the largest remainders are rounded up."""
    tenths = {name: int(1000.0 * share) for name, share in shares.items()}
    rest = sorted(shares, key=lambda name: tenths[name] - 1000.0 * shares[name])
    for name in rest[: round(1000.0 * sum(shares.values())) - sum(tenths.values())]:
        tenths[name] += 1
    return {name: tenth / 10.0 for name, tenth in tenths.items()}


class _Strip(QWidget):
    """The shares side by side, each in the colour of its fate."""

    def __init__(self) -> None:
        super().__init__()
        self.shares: dict[str, float] = {}
        self.setMinimumHeight(10)

    def sizeHint(self) -> QSize:
        """As high as a line of small type."""
        return QSize(120, 10)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Fill the width."""
        painter, left = QPainter(self), 0.0
        for name in FATE_TITLES:
            wide = self.shares.get(name, 0.0) * self.width()
            painter.fillRect(QRectF(left, 0.0, wide, self.height()), QColor(FATE_COLOURS[name]))
            left += wide
        painter.setPen(QColor(tones().border))
        painter.drawRect(self.rect().adjusted(0, 0, -1, -1))


class AuditView(QWidget):
    """A button that asks for the audit, and what it found; numbers of an earlier rig are greyed."""

    wanted = Signal()
    """The rays are to be followed."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._follow, self._note, self._strip = QPushButton(FOLLOW), QLabel(), _Strip()
        self._follow.setObjectName("follow_rays")
        self._follow.setToolTip(FOLLOW_TIP)
        self._follow.clicked.connect(lambda _: self.wanted.emit())
        self._note.setObjectName("hint")
        self._note.setTextFormat(Qt.TextFormat.PlainText)
        self._note.setWordWrap(True)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        line = QHBoxLayout()
        line.setSpacing(SPACING)
        line.addWidget(self._follow)
        line.addWidget(self._note, 1)
        column.addLayout(line)
        column.addWidget(self._strip)
        self._table = QWidget()
        column.addWidget(self._table)
        self._values = self._add_rows(QGridLayout(self._table))
        self._lost = QLabel()
        self._lost.setObjectName("hint")
        self._lost.setTextFormat(Qt.TextFormat.PlainText)
        self._lost.setWordWrap(True)
        column.addWidget(self._lost)
        self.show_none("")

    def _add_rows(self, grid: QGridLayout) -> dict[str, QLabel]:
        """A row for each fate: a swatch, its name and its share."""
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(SPACING)
        grid.setVerticalSpacing(2)
        grid.setColumnStretch(1, 1)
        values = {}
        for row, (name, title) in enumerate(FATE_TITLES.items()):
            caption, value = QLabel(title), QLabel(NONE)
            caption.setStyleSheet(f"border-left: 8px solid {FATE_COLOURS[name]}; padding-left: 4px;")
            value.setFont(numbers_font(value.font()))
            value.setTextFormat(Qt.TextFormat.PlainText)
            value.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            for label in (caption, value):
                label.setToolTip(FATE_TIPS[name])
            caption.setTextFormat(Qt.TextFormat.PlainText)
            grid.addWidget(caption, row, 0)
            grid.addWidget(value, row, 1)
            values[name] = value
        return values

    def show_audit(self, found: SensorAudit, body: str, is_current: bool) -> None:
        """Show where the rays of a sensor go."""
        shown = percents(found.shares)
        for name, value in self._values.items():
            value.setText(f"{shown[name]:.1f} %")
            value.setEnabled(is_current)
        self._strip.shares = dict(found.shares) if is_current else {}
        self._strip.update()
        self._note.setText(f"{found.rays:,} rays, body {body}" if is_current else OUTDATED)
        lost = ", ".join(f"{name} {100.0 * found.lost_share[name]:.2f}" for name in CLASSES)
        self._lost.setText(f"A solid body takes from it, in pp of H(Ω): {lost}")
        self._show_rows(True)

    def show_none(self, note: str) -> None:
        """Show no shares, and say why."""
        self._note.setText(note)
        self._show_rows(False)

    def _show_rows(self, shown: bool) -> None:
        for part in (self._strip, self._table, self._lost):
            part.setVisible(shown)

    @property
    def note(self) -> str:
        """What stands beside the button."""
        return self._note.text()

    def text_of(self, fate: str) -> str:
        """Return the share of a fate as it is shown."""
        return self._values[fate].text()
