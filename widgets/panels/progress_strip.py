"""One piece of long work in the status bar: what it is, how far, how long yet, and Cancel."""

from __future__ import annotations

import time
from collections.abc import Callable

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QPushButton, QSizePolicy, QWidget

from riglens.widgets.panels.style import SPACING, numbers_font
from riglens.widgets.panels.time_left import TimeLeft, duration_text

PATIENCE_MS = 500
"""Work that is done sooner is not worth a bar that flashes up."""
STEPS = 1000


class ProgressStrip(QWidget):
    """Hidden until the work has gone on for half a second; `cancelled` once Cancel was pressed."""

    cancelled = Signal()

    def __init__(self, title: str, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._clock = clock
        self._title = title
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
        self.bar.setFixedWidth(190)
        self.left.setFont(numbers_font(self.font()))
        self.left.setMinimumWidth(64)
        self.cancel.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.cancel.clicked.connect(self._on_cancel)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(SPACING)
        for widget in (self.bar, self.left, self.cancel):
            row.addWidget(widget)

    @property
    def is_running(self) -> bool:
        """Whether the work goes on, shown or not."""
        return self._patience.isActive() or not self.isHidden()

    def begin(self) -> None:
        """The work starts, or starts anew."""
        self._time_left = TimeLeft(self._clock)
        self.cancel.setEnabled(True)
        self.show_progress(0.0)
        if self.isHidden():
            self._patience.start()

    def show_progress(self, fraction: float) -> None:
        """So much of the work is done, 0..1."""
        self._time_left.note(fraction)
        seconds = self._time_left.seconds
        self.bar.setValue(round(STEPS * fraction))
        self.bar.setFormat(f"{self._title}  %p %")
        self.left.setText("" if seconds is None else f"{duration_text(seconds)} left")

    def show_stage(self, title: str, note: str) -> None:
        """What is left takes a time that nobody knows: say what it is, not how far."""
        self.bar.setValue(STEPS)
        self.bar.setFormat(title)
        self.left.setText(note)

    def end(self) -> None:
        """The work is over."""
        self._patience.stop()
        self.hide()

    def _on_cancel(self) -> None:
        self.cancel.setEnabled(False)
        self.left.setText("stopping…")
        self.cancelled.emit()
