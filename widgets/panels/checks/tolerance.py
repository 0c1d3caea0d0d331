"""Show the spread of scores under mount errors, next to the noise of the lattice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from PySide6.QtCore import QRectF, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from riglens.core.figures.registry import tolerated_figures
from riglens.core.figures.text import MINUS
from riglens.core.shown_text import visible
from riglens.widgets.panels.controls.building import button, filled, plain_label
from riglens.widgets.panels.controls.style import MARGIN, as_panel, numbers_font, plain_tip, tones
from riglens.widgets.panels.fields.form import ChoiceBox

BAR_PX, ROW_PX = 130, 18
LEGEND = "5 to 95 % of the draws, thin: noise floor, | median, ● worst"
WAITING = "measured between edits"
REQUIRE = "Requirements…"
REQUIRE_TIP = (
    "Requirements file, as for riglens check: shows how many draws are worse than its limits (tolerance, else the "
    "limit of the figure itself), the upper 95 % bound of that chance, and the verdict. Less is better."
)


@dataclass(frozen=True)
class Below:
    """A required limit of a figure, in percent; the share of draws below it with the bounds of the chance, 95 %
    confidence each, in percent; and the largest accepted chance, if given."""

    limit: float
    share: float
    low: float
    high: float
    at_most: float | None = None

    @property
    def verdict(self) -> str:
        """The verdict of `riglens check` on as many draws; empty where no chance is required."""
        if self.at_most is None:
            return ""
        return "met" if self.high <= self.at_most else "NOT MET" if self.low > self.at_most else "not shown"


@dataclass(frozen=True)
class Range:
    """Range of one figure, in percentage points relative to the rig as designed: draws from 5 to 95 %, their median and
    worst, and the 5 to 95 % of the noise floor; and its requirement, if any."""

    low: float
    high: float
    median: float
    worst: float
    floor_low: float
    floor_high: float
    below: Below | None = None

    @property
    def widest(self) -> float:
        """Largest distance from the rig as designed."""
        return max(abs(value) for value in (self.low, self.high, self.worst, self.floor_low, self.floor_high))

    @property
    def is_noise(self) -> bool:
        """Return whether the errors spread the figure no wider than the lattice does without them."""
        return self.high - self.low <= self.floor_high - self.floor_low


class RangeBar(QWidget):
    """One range on a scale that is the same for all classes; the line in the middle is the rig as designed."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setFixedSize(BAR_PX, ROW_PX)
        self._range: Range | None = None
        self._scale, self._is_stale = 1.0, False

    def show_range(self, found: Range | None, scale: float) -> None:
        """Show a range; `scale` are the percentage points at the ends of the bar."""
        self._range, self._scale, self._is_stale = found, scale, False
        self.update()

    def grey(self) -> None:
        """Grey out the range, which belongs to an earlier rig."""
        self._is_stale = True
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the floor as a thin bar over that of the draws."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle, high = BAR_PX / 2.0, ROW_PX / 2.0
        painter.setPen(QColor(tones().border))
        painter.drawLine(0, round(high), BAR_PX, round(high))
        if self._range is not None:
            found = self._range
            colour = QColor(tones().muted if self._is_stale else tones().accent)
            self._bar(painter, found.low, found.high, 9.0, colour)
            self._bar(painter, found.floor_low, found.floor_high, 3.0, QColor(tones().text))
            painter.setPen(QColor(tones().text))
            at = self._x(found.median)
            painter.drawLine(round(at), round(high - 7.0), round(at), round(high + 7.0))
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(QColor(tones().less))
            painter.drawEllipse(QRectF(self._x(found.worst) - 2.5, high - 2.5, 5.0, 5.0))
        painter.setPen(QColor(tones().muted))
        painter.drawLine(round(middle), 0, round(middle), ROW_PX)
        painter.end()

    def _bar(self, painter: QPainter, low: float, high: float, thick_px: float, colour: QColor) -> None:
        left, right = self._x(low), self._x(high)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(colour)
        painter.drawRect(QRectF(left, (ROW_PX - thick_px) / 2.0, max(1.0, right - left), thick_px))

    def _x(self, points: float) -> float:
        half = BAR_PX / 2.0 - 4.0
        return BAR_PX / 2.0 + half * max(-1.0, min(1.0, points / self._scale))


NO_PROFILE, NO_RANGES = "No tolerance", "Choose a tolerance to see how far the figures spread."
PROFILE_TIP = (
    "Spread of the figures under mount errors and pitch of the car,\nmeasured in the "
    "background between edits."
)


class TolerancePanel(QWidget):
    """A row for each class; which profile, which figure, and whether the worst draw is shown in the view, is chosen
    above."""

    profile_chosen = Signal(str)
    """Request for the tolerances of this profile; empty for none."""

    figure_chosen = Signal(str)
    """The figure of another key is to be shown."""
    ghost_wanted = Signal(bool)
    """Request to show the worst draw in the view, or to hide it."""
    requirements_wanted = Signal()
    """Request to choose a file of requirements, or to drop the current one."""

    def __init__(
        self, classes: Sequence[str], profiles: Sequence[str], parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        as_panel(self)
        self._profile = ChoiceBox()
        self._profile.setObjectName("tolerance")
        self._profile.setToolTip(PROFILE_TIP)
        for title, name in ((NO_PROFILE, ""), *((name, name) for name in profiles)):
            self._profile.addItem(title, name)
        self._profile.activated.connect(lambda _: self.profile_chosen.emit(self._profile.currentData()))
        self._head, self.ghost_note = plain_label(style="hint"), plain_label(style="hint")
        self._figure = ChoiceBox()
        # voxels first: they are known before objects are counted
        for figure in sorted(tolerated_figures(), key=lambda one: one.needs != "voxels"):
            self._figure.addItem(figure.title, figure.key)
        self._figure.activated.connect(lambda _: self.figure_chosen.emit(self.figure))
        self.worst = QCheckBox("Show worst case")
        self.worst.toggled.connect(self.ghost_wanted)
        self.required = button(QPushButton(REQUIRE), self.requirements_wanted, f"<p>{REQUIRE_TIP}</p>")
        self._rows = {name: (RangeBar(), QLabel("—")) for name in classes}
        self._below = {name: QLabel() for name in classes}
        rows = QGridLayout()
        rows.setHorizontalSpacing(8)
        rows.setVerticalSpacing(0)
        for place, (name, (bar, text)) in enumerate(self._rows.items()):
            text.setFont(numbers_font(text.font()))
            rows.addWidget(QLabel(name), place, 0)
            rows.addWidget(bar, place, 1)
            rows.addWidget(text, place, 2)
            self._below[name].setFont(numbers_font(text.font()))
            rows.addWidget(self._below[name], place, 3)
        rows.setColumnStretch(3, 1)
        choices = filled(
            QHBoxLayout(), self._profile, self._figure, self.worst, self.required, self.ghost_note, 1
        )
        filled(QVBoxLayout(self), choices, self._head, rows, None, margins=(MARGIN, 4, MARGIN, 2), spacing=3)
        self.setToolTip(LEGEND)

    def show_profile(self, name: str) -> None:
        """Show which profile is measured; with none, nothing is."""
        self._profile.setCurrentIndex(max(0, self._profile.findData(name)))
        if not name:
            self.grey(NO_RANGES)

    @property
    def figure(self) -> str:
        """Return the key of the figure that is shown."""
        return str(self._figure.currentData())

    def choose(self, figure: str) -> None:
        """Show another figure; ignore unknown ones."""
        place = self._figure.findData(figure)
        if place >= 0:
            self._figure.setCurrentIndex(place)

    def show_required(self, name: str) -> None:
        """Show the source of the requirements; empty: none."""
        self.required.setText(REQUIRE if not name else f"Without {visible(name)}")

    def show_ranges(self, ranges: dict[str, Range], head: str, tip: str) -> None:
        """Show ranges by class, and above them their rig and the number of draws."""
        self._head.setText(head)
        self.setToolTip(plain_tip(f"{LEGEND}\n{tip}"))
        scale = max((found.widest for found in ranges.values()), default=0.0) or 1.0
        for name, (bar, text) in self._rows.items():
            found = ranges.get(name)
            bar.show_range(found, scale)
            text.setText("—" if found is None else range_text(found))
            text.setEnabled(True)
            self._show_below(self._below[name], None if found is None else found.below)

    def _show_below(self, label: QLabel, below: Below | None) -> None:
        label.setEnabled(True)
        label.setText("" if below is None else below_text(below))
        is_met = below is None or below.verdict in ("", "met")
        label.setStyleSheet("" if is_met else f"color: {tones().less}")

    def grey(self, head: str) -> None:
        """Grey out results of an earlier rig."""
        self._head.setText(head)
        for bar, text in self._rows.values():
            bar.grey()
            text.setEnabled(False)
        for label in self._below.values():
            label.setEnabled(False)
            label.setStyleSheet("")


def range_text(found: Range) -> str:
    """Format the range relative to the rig as designed, or state that it is within the noise of the lattice."""
    digits = 2 if found.widest >= 0.1 else 3 if found.widest >= 0.01 else 4
    text = f"{points_text(found.low, digits)} … {points_text(found.high, digits)} pp"
    return f"{text}, within noise" if found.is_noise and found.widest else text


def below_text(below: Below) -> str:
    """Format the share of draws below a limit, the upper bound of the chance, and the verdict."""
    text = f"{below.share:.1f} % of draws < {below.limit:g} %, at most {below.high:.1f} %"
    return f"{text} (≤ {below.at_most:g} %): {below.verdict}" if below.at_most is not None else text


def points_text(points: float, digits: int = 2) -> str:
    """Return percentage points with a sign."""
    size = f"{abs(points):.{digits}f}"
    return size if float(size) == 0.0 else ("+" if points > 0.0 else MINUS) + size
