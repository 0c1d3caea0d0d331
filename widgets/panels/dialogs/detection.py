"""Starts and stops a study of detection, and shows its chart as it fills."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QHBoxLayout,
    QLabel,
    QProgressBar,
    QPushButton,
    QSpinBox,
    QTabWidget,
    QVBoxLayout,
    QWidget,
)

from riglens.widgets.panels.controls.style import MARGIN, SPACING
from riglens.widgets.panels.dialogs.picture import Preview

_STEPS = 1000


class DetectionDialog(QDialog):
    """Options, progress and two charts; does not compute anything. It may be closed while the study goes on."""

    start_wanted = Signal()
    stop_wanted = Signal()
    folder_wanted = Signal()

    def __init__(self, most_workers: int, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Study of detection")
        self.rigs, self.state = _text(""), _text("hint")
        self.quick = QCheckBox("Quick look")
        self.quick.setChecked(True)
        self.quick.setToolTip("One seed, 4 epochs, half of the frames; otherwise 3 seeds and 12 epochs")
        self.workers = QSpinBox()
        self.workers.setRange(1, most_workers)
        self.workers.setValue(max(1, most_workers // 2))
        self.workers.setToolTip("Processes of one thread each")
        self.start, self.stop = QPushButton("Start"), QPushButton("Stop")
        self.folder = QPushButton("Open folder")
        self.start.setDefault(True)
        for button in (self.stop, self.folder):
            button.setAutoDefault(False)
        self.bar = QProgressBar()
        self.bar.setRange(0, _STEPS)
        self.chart, self.pairs = Preview(), Preview()
        self.tabs = QTabWidget()
        self.tabs.addTab(self.chart, "AP over scores")
        self.tabs.addTab(self.pairs, "Pairs")
        self.start.clicked.connect(self.start_wanted)
        self.stop.clicked.connect(self.stop_wanted)
        self.folder.clicked.connect(self.folder_wanted)
        self.set_running(False)

    def build(self, wording: str) -> None:
        """Lay everything out below the words that say what the figures are."""
        said = _text("hint")
        said.setText(wording)
        choices, buttons, box = QHBoxLayout(), QHBoxLayout(), QVBoxLayout(self)
        choices.addWidget(self.quick)
        choices.addSpacing(2 * SPACING)
        choices.addWidget(QLabel("Processes"))
        choices.addWidget(self.workers)
        choices.addStretch()
        for button in (self.folder, self.stop, self.start):
            buttons.addWidget(button)
        choices.addLayout(buttons)
        box.setContentsMargins(MARGIN, MARGIN, MARGIN, MARGIN)
        box.setSpacing(SPACING)
        for widget in (said, self.rigs):
            box.addWidget(widget)
        box.addLayout(choices)
        box.addWidget(self.bar)
        box.addWidget(self.state)
        box.addWidget(self.tabs, 1)

    def set_running(self, is_running: bool) -> None:
        """A study goes on, or none does."""
        self.start.setEnabled(not is_running)
        self.stop.setEnabled(is_running)
        self.quick.setEnabled(not is_running)
        self.workers.setEnabled(not is_running)

    def show_share(self, share: float) -> None:
        """How much is done, 0 to 1."""
        self.bar.setValue(round(share * _STEPS))

    def show_charts(self, chart: bytes, pairs: bytes) -> None:
        """Show charts, PNG files; empty ones are left as they are."""
        for preview, png in ((self.chart, chart), (self.pairs, pairs)):
            if png:
                preview.show_png(png)


def _text(name: str) -> QLabel:
    label = QLabel()
    label.setObjectName(name)
    label.setTextFormat(Qt.TextFormat.PlainText)
    label.setWordWrap(True)
    return label
