"""Report to the user during work: the message bar, and progress with the time left."""

from __future__ import annotations

import time
from collections.abc import Callable

from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QPlainTextEdit,
    QProgressBar,
    QPushButton,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from riglens.core.figures.text import in_sentence
from riglens.core.shown_text import visible_lines
from riglens.widgets.panels.controls.building import button, filled, plain_label, tool
from riglens.widgets.panels.controls.icons import icon
from riglens.widgets.panels.controls.style import SPACING, numbers_font, plain_tip

DETAILS_PX = 150
Choices = dict[str, Callable[[], object]]


class MessageBar(QFrame):
    """One message at a time; hidden until `show_message`, closed by its button or by one of its choices."""

    def __init__(self, parent: QWidget | None = None, is_error: bool = True) -> None:
        super().__init__(parent)
        self.setObjectName("messageBar" if is_error else "noteBar")
        self._label = plain_label(wraps=True)
        self._label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._label.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self._choices = QHBoxLayout()
        self._details = QPlainTextEdit()
        self._details.setReadOnly(True)
        self._details.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        self._details.setFixedHeight(DETAILS_PX)
        self._toggle = button(QPushButton("Details"), name="details")
        self._toggle.setCheckable(True)
        self._toggle.toggled.connect(self._details.setVisible)
        tip = "Copy message and details, to report the problem."
        self._copy = button(QPushButton("Copy"), self._copy_all, tip, "copy_details")
        close = tool(icon("close"), self.clear, "Close this message.")
        close.setAutoRaise(True)
        self._build(close)
        self.hide()

    def _build(self, close: QToolButton) -> None:
        row = QHBoxLayout()
        row.addWidget(self._label, 1)
        row.addLayout(self._choices)
        for widget in (self._copy, self._toggle, close):
            row.addWidget(widget, 0, Qt.AlignmentFlag.AlignTop)
        filled(QVBoxLayout(self), row, self._details, margins=(12, 6, 6, 6))

    @property
    def message(self) -> str:
        """The text that is shown, empty when the bar is closed."""
        return self._label.text()

    @property
    def details(self) -> str:
        """Return the text behind Details, empty when there is none."""
        return self._details.toPlainText()

    def show_message(self, text: str, details: str = "", choices: Choices | None = None) -> None:
        """Show a message in place of the last one; `choices` are buttons, each closes the bar."""
        self.clear()
        self._label.setText(visible_lines(text))
        self._details.setPlainText(details)
        for widget in (self._toggle, self._copy):
            widget.setVisible(bool(details))
        for title, chosen in (choices or {}).items():
            made = button(QPushButton(title), self.clear, name=title)
            made.clicked.connect(lambda _=False, chosen=chosen: chosen())
            self._choices.addWidget(made)
        self.show()

    def clear(self) -> None:
        """Close the bar."""
        self._label.clear()
        self._details.clear()
        self._toggle.setChecked(False)
        self._details.hide()
        while (item := self._choices.takeAt(0)) is not None:
            widget = item.widget()
            if widget is not None:
                widget.hide()
                widget.deleteLater()
        self.hide()

    def _copy_all(self) -> None:
        QGuiApplication.clipboard().setText(f"{self.message}\n\n{self.details}")


WARM_UP_S, LEAST_SHARE = 1.0, 0.05
"""Time and share of the work before which a pace says nothing: the first steps read files and load code."""
RECENT = 0.3
"""Share of the newest estimate in the one shown: steady, yet quick to follow when the pace changes."""


class TimeLeft:
    """Estimator of the seconds left from fractions of the work done (0..1); None until there is a basis for it."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._begun_s = clock()
        self._end_s: float | None = None

    def note(self, fraction: float) -> None:
        """Record the share done; a smaller share than before starts again, as a second phase of the work does."""
        passed_s = self._clock() - self._begun_s
        if fraction <= 0.0:
            self._begun_s, self._end_s = self._clock(), None
        elif passed_s >= WARM_UP_S and fraction >= LEAST_SHARE:
            end_s = self._begun_s + passed_s / min(fraction, 1.0)
            self._end_s = end_s if self._end_s is None else RECENT * end_s + (1.0 - RECENT) * self._end_s

    @property
    def seconds(self) -> float | None:
        """Seconds left from now, never negative."""
        return None if self._end_s is None else max(0.0, self._end_s - self._clock())


def duration_text(seconds: float) -> str:
    """Return the seconds in one or two words, coarser the longer: "5 s", "3 min", "1 h 20 min"."""
    if seconds < 60:
        return f"{max(1, round(seconds))} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


PATIENCE_MS = 500
"""Work that finishes sooner is not worth a bar that flashes up."""
STEPS = 1000
LEAST_BAR_PX = 40


class ThinBar(QProgressBar):
    """Line that fills while something is computed and keeps its room: nothing moves when it appears."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("thin")
        self.setTextVisible(False)
        policy = self.sizePolicy()
        policy.setRetainSizeWhenHidden(True)
        self.setSizePolicy(policy)
        self.show_share(None)

    def show_share(self, share: float | None) -> None:
        """Show the share that is done, one that moves while it is 0, or nothing for None."""
        self.setRange(0, STEPS if share else 0)
        self.setValue(round(STEPS * (share or 0.0)))
        self.setVisible(share is not None)


class ProgressStrip(QWidget):
    """Hidden until the work has lasted half a second; emits `cancelled` when Cancel is pressed."""

    cancelled = Signal()

    def __init__(self, title: str, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._clock = clock
        self._title = self._stage = title
        self._time_left = TimeLeft(clock)
        self._patience = QTimer(self)
        self._patience.setSingleShot(True)
        self._patience.setInterval(PATIENCE_MS)
        self._patience.timeout.connect(self.show)
        self.bar, self.left, self.cancel = QProgressBar(), QLabel(), QPushButton("Cancel")
        self._build()
        self.hide()

    def _build(self) -> None:
        self.bar.setRange(0, STEPS)
        self.bar.setMinimumWidth(LEAST_BAR_PX)  # several strips share the status bar of a small window
        self.bar.setMaximumWidth(280)
        self.left.setFont(numbers_font(self.font()))
        self.left.setMinimumWidth(64)
        self.cancel.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.cancel.clicked.connect(self._on_cancel)
        filled(QHBoxLayout(self), self.bar, self.left, self.cancel, spacing=SPACING)

    @property
    def is_running(self) -> bool:
        """Return whether work is in progress, shown or not."""
        return self._patience.isActive() or not self.isHidden()

    def begin(self) -> None:
        """Record that the work starts, or starts again."""
        self._time_left, self._stage = TimeLeft(self._clock), self._title
        self.cancel.setEnabled(True)
        self.show_progress(0.0)
        if self.isHidden():
            self._patience.start()

    def name_stage(self, stage: str) -> None:
        """Show the current stage behind the title, which tells two strips apart; both are whole in the tooltip."""
        self._stage = f"{self._title}: {in_sentence(stage)}"
        self.bar.setToolTip(plain_tip(self._stage))

    def show_progress(self, fraction: float) -> None:
        """Record the share of the work done, 0..1."""
        self._time_left.note(fraction)
        seconds = self._time_left.seconds
        self.bar.setValue(round(STEPS * fraction))
        room_px = self.bar.width() - self.bar.fontMetrics().horizontalAdvance("   100 %  ")
        stage = self.bar.fontMetrics().elidedText(self._stage, Qt.TextElideMode.ElideRight, room_px)
        self.bar.setFormat(f"{stage}  %p %")  # Qt cuts both ends of a text that is too long
        self.left.setText("" if seconds is None else f"{duration_text(seconds)} left")

    def show_stage(self, title: str, note: str) -> None:
        """Record that the rest takes an unknown time: show the stage, not the progress."""
        self.bar.setValue(STEPS)
        self.bar.setFormat(title)
        self.left.setText(note)

    def end(self) -> None:
        """Record that the work has ended."""
        self._patience.stop()
        self.hide()

    def _on_cancel(self) -> None:
        self.cancel.setEnabled(False)
        self.left.setText("stopping…")
        self.cancelled.emit()
