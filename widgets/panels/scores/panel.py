"""Leading figures per class with the change against a baseline; full precision in tooltip and copy.

Estimates can be shown in their place for a moment: marked ≈, in italics, without changes and without a copy.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import (
    QAbstractButton,
    QCheckBox,
    QHBoxLayout,
    QLabel,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from riglens.core.figures.figure import Better, Figure
from riglens.core.figures.text import UNITS, in_sentence
from riglens.core.figures.values import Compared, FigureCells, Values, in_reading
from riglens.core.metric.scores import MAX_LAMBDA, MetricSettings, Reading
from riglens.widgets.panels.controls.building import button, filled
from riglens.widgets.panels.controls.scrolled import ElidedLabel
from riglens.widgets.panels.controls.style import MARGIN, SPACING, as_panel, plain_tip
from riglens.widgets.panels.fields.edits import NumberEdit
from riglens.widgets.panels.fields.form import ChoiceBox
from riglens.widgets.panels.scores.table import LAST_SAVED, ScoreTable
from riglens.widgets.panels.scores.text import (
    FIGURES_HELP,
    FIGURES_TITLE,
    FOUND_NOTE,
    NOT_COUNTED_NOTE,
    SIGN_NOTE,
    found_text,
)

if TYPE_CHECKING:  # loads the compiler
    from riglens.core.figures.evaluated import Need

READING_NOTES: dict[Reading, str] = {
    "covered": "S-MIG = −entropy of the voxels reached: the paper's equations.",
    "residual": "S-MIG = −entropy of the voxels not reached: grows with coverage.",
}
"""The readings to choose from; commands and studies have `hits`, too."""


class ScoresPanel(QWidget):
    """Scores of one evaluation next to those of the baseline. Outdated numbers are greyed."""

    settings_wanted = Signal(object)
    """Request for other MetricSettings."""
    help_wanted = Signal()
    """Request for help on the figures: their purpose, and when each misleads."""

    def __init__(self, settings: MetricSettings, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        as_panel(self)
        self._settings = settings
        self._is_stale = True
        self._baseline = LAST_SAVED
        self.table = ScoreTable()
        self.table.set_reading(settings.reading)
        self.table.forget("objects", NOT_COUNTED_NOTE)
        self._weight = NumberEdit(0.05)
        self._reading = ChoiceBox()
        self._details = QCheckBox("Paper details")
        self._details.setObjectName("paper_details")
        self._details.setToolTip(
            "Show the entropy seen, S-MIG of cameras and LiDARs, the weight λ and the reading of S-MIG."
        )
        self._details.toggled.connect(self._show_details)
        corner = self.table.findChild(QAbstractButton)  # between the headers, where the switch costs no row
        assert corner is not None
        filled(QHBoxLayout(corner), self._details, margins=(6, 0, 0, 0))
        self._below = self._controls()
        self._judgement = ElidedLabel()
        self._judgement.setObjectName("judgement")
        self._judgement.setContentsMargins(MARGIN, 4, MARGIN, 4)
        filled(QVBoxLayout(self), self._judgement, self.table, 1, self._below, spacing=0)
        self._show_details(False)

    def _controls(self) -> QWidget:
        self._weight.setObjectName("camera_weight")
        self._weight.setFixedWidth(64)
        self._weight.set_value(self._settings.camera_weight)
        self._weight.edited.connect(self._on_weight)
        self._reading.setObjectName("reading")
        for place, (reading, note) in enumerate(READING_NOTES.items()):
            self._reading.addItem(reading, reading)
            self._reading.setItemData(place, note, Qt.ItemDataRole.ToolTipRole)
        self._reading.setCurrentText(self._settings.reading)
        self._reading.activated.connect(lambda _: self._want(reading=self._reading.currentText()))
        self._found, self._note, below = ElidedLabel(), ElidedLabel(), QWidget()
        for label in (self._found, self._note):
            label.setObjectName("hint")
        self._note.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self._note.setContentsMargins(2 * SPACING, 0, 0, 0)
        self._found.setToolTip(FOUND_NOTE)
        self._of_paper = (QLabel("λ"), self._weight, QLabel("Reading"), self._reading)
        tip = f"<b>{FIGURES_TITLE}</b>{FIGURES_HELP}"
        which = button(QToolButton(), self.help_wanted, tip, "figures_help", "What do these mean?")
        filled(
            QHBoxLayout(below), *self._of_paper, self._found, self._note, 1, which,
            margins=(MARGIN, 5, MARGIN, 6), spacing=SPACING,
        )  # fmt: skip
        self._weight.setToolTip("Weight of the cameras in S-MS, 0.1 in the paper.")
        self._show_note()
        return below

    def minimumSizeHint(self) -> QSize:
        """Return the size of the sentence and the table alone: where space is short, the parts below it are hidden."""
        height = self.table.minimumHeight() + self._judgement.sizeHint().height()
        return QSize(super().minimumSizeHint().width(), height)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Hide the parts below the table where they would cost a row."""
        super().resizeEvent(event)
        needed = self.minimumSizeHint().height() + self._below.sizeHint().height()
        self._below.setVisible(event.size().height() >= needed)

    # ------------------------------------------------------------------ what is shown
    @property
    def has_details(self) -> bool:
        """Return whether S-MIG by kind, λ and reading are shown."""
        return self._details.isChecked()

    def set_details(self, shown: bool) -> None:
        """Show S-MIG by kind, λ and reading, or hide them."""
        self._details.setChecked(shown)

    def _show_details(self, shown: bool) -> None:
        self.table.set_details(shown)
        for widget in self._of_paper:
            widget.setVisible(shown)

    def show_settings(self, settings: MetricSettings) -> None:
        """Show reading and camera weight that scores are computed with."""
        self._settings = settings
        self.table.set_reading(settings.reading)
        self._weight.set_value(settings.camera_weight)
        self._reading.setCurrentText(settings.reading)
        self._show_note()

    def set_baseline(self, name: str | None) -> None:
        """Set the baseline of changes: a pinned rig of that name, or None for the last saved rig."""
        self._baseline = LAST_SAVED if name is None else name
        self.table.set_baseline(self._baseline)
        self._show_note()

    def show_figures(self, need: Need, found: Mapping[str, Compared]) -> None:
        """Show the figures that need the same evaluation, by key, and their change against the baseline."""
        if need == "voxels":
            self._is_stale = False
        self.table.show_figures(need, found)

    def show_found(self, found: FigureCells) -> None:
        """Show how many of 100 objects are found."""
        self._found.setText(found_text(found))
        self._found.setToolTip(plain_tip("\n".join(filter(None, (FOUND_NOTE, found.detector)))))
        self._found.setEnabled(not found.outside)

    def show_judgement(self, text: str) -> None:
        """Show the sentence that says whether the rig is better than the baseline."""
        self._judgement.setText(text)
        self._judgement.setToolTip(plain_tip(text))
        self._judgement.setEnabled(True)

    @property
    def judgement(self) -> str:
        """The sentence that says whether the rig is better than the baseline."""
        return self._judgement.text()

    def forget_counted(self, reason: str) -> None:
        """Show no number on objects, and the reason."""
        self._judgement.setText("")
        self.table.forget("objects", reason)
        self._found.setText("")

    def grey_counted(self) -> None:
        """Grey what is counted on objects."""
        self.table.grey("objects")
        self._found.setEnabled(False)
        self._judgement.setEnabled(False)

    def show_estimate(self, found: Values) -> None:
        """Show rough figures of voxels until the exact ones arrive; until then there is nothing to copy."""
        self._is_stale = True
        self.table.show_estimate(found)

    def show_pending(self) -> None:
        """Show no scores until there are some."""
        self._is_stale = True
        self.table.show_pending()

    def set_stale(self) -> None:
        """Grey the numbers: they belong to an earlier state."""
        if not self._is_stale:
            self._is_stale = True
            self.table.grey("voxels")

    @property
    def is_stale(self) -> bool:
        """Return whether the numbers are greyed."""
        return self._is_stale

    # ------------------------------------------------------------------ what the user does
    def _on_weight(self, value: float) -> None:
        if not 0.0 <= value <= MAX_LAMBDA:
            self._weight.mark(f"λ must be from 0 to {MAX_LAMBDA:,.0f} (got {value:g})")
            return
        self._want(camera_weight=value)

    def _want(self, **changes: Any) -> None:
        """Request other settings; then show those in use, whether or not the request was granted."""
        self.settings_wanted.emit(replace(self._settings, **changes))
        self.show_settings(self._settings)

    def _show_note(self) -> None:
        """Write from what changes count, and which way the leading figures are better."""
        shown = [one for one in self.table.shown if one.leads]
        ways = [
            f"{_listed(titles)}: {way} is better"
            for way in ("more", "less")
            if (titles := [in_sentence(one.title) for one in shown if _way(one) == way])
        ]
        for figure in (one for one in shown if one.of_paper):
            rises = in_reading(figure, self._settings.reading).better == "more"
            ways.append(
                f"{figure.title}, {UNITS[figure.unit]}: {'rises' if rises else 'falls'} as coverage grows"
            )
        self._note.setText(" · ".join([f"change against {self._baseline}", *ways]))
        self._note.setToolTip(SIGN_NOTE)

    @property
    def found(self) -> str:
        """Say how many of 100 objects are found."""
        return self._found.text()

    @property
    def note(self) -> str:
        """Write the line about unit, baseline and sign of S-MS."""
        return self._note.text()


def _way(figure: Figure) -> Better:
    """Return the direction of a figure in the note; what the paper's score does is said on its own."""
    return "neither" if figure.of_paper else figure.better


def _listed(titles: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(titles[:-1]), titles[-1])))
