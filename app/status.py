"""The status bar: whether the numbers are exact, the time of the last edit, and what they are computed on."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLabel, QProgressBar, QPushButton, QStatusBar, QWidget

from app.scenario import short_source
from app.scoring import Approximation, LoadedScene, Result

UPDATING = "updating…"
COARSE_NOTE = (
    "An exact answer takes longer than a frame here.\nScores marked ≈ are estimated on larger voxels; "
    "the exact ones replace them as soon as the mouse rests."
)


class StatusBar(QStatusBar):
    """State on the left, scene on the right, and a progress bar with Cancel while data are loaded."""

    cancelled = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setSizeGripEnabled(False)
        self.state, self.time, self.scene = QLabel(UPDATING), QLabel(), QLabel()
        self._is_coarse = False
        self._progress = QProgressBar()
        self._progress.setRange(0, 1000)
        self._progress.setFixedWidth(160)
        self._progress.setFormat("loading boxes %p %")
        self._cancel = QPushButton("Cancel")
        self._cancel.setObjectName("cancel_load")
        self._cancel.clicked.connect(self.cancelled)
        self.state.setMinimumWidth(80)
        self.addWidget(self.state)
        self.addWidget(self.time)
        for widget in (self._progress, self._cancel, self.scene):
            self.addPermanentWidget(widget)
        self.hide_progress()

    def show_progress(self, fraction: float) -> None:
        """Show how much of a load is done, 0 to 1."""
        self._progress.setValue(round(1000 * fraction))
        self._progress.show()
        self._cancel.show()

    def hide_progress(self) -> None:
        """The load is over."""
        self._progress.hide()
        self._cancel.hide()

    @property
    def shows_progress(self) -> bool:
        """Whether a load is under way."""
        return not self._progress.isHidden()

    def set_updating(self) -> None:
        """The numbers shown are of an earlier state; coarse ones are said to be so until the next are there."""
        if not self._is_coarse:
            self.state.setText(UPDATING)

    def show_approximation(self, first: Approximation) -> None:
        """Say that the numbers are coarse, and that this is not the end."""
        self._is_coarse = True
        self.state.setText(f"coarse (δ {first.voxel_m:g} m), exact follows")
        self.state.setToolTip(COARSE_NOTE)
        self.time.setText(f"coarse answer {first.elapsed_ms:.1f} ms")

    def show_result(self, result: Result, is_current: bool) -> None:
        """Say how long the evaluation took."""
        self._is_coarse = False
        self.state.setText("exact" if is_current else UPDATING)
        evaluation = result.evaluation
        self.state.setToolTip(f"method {evaluation.settings.method}, {evaluation.threads} threads")
        self.time.setText(f"last edit {evaluation.elapsed_ms:.1f} ms")

    def show_scene(self, scene: LoadedScene) -> None:
        """Say what the scores are computed on."""
        field = scene.field
        self.scene.setText(scene_line(scene))
        boxes = ", ".join(f"{count:,} {name}" for name, count in field.data.boxes.items())
        unmapped = (
            f"; {field.data.unmapped.total():,} boxes of other classes do not count"
            if field.data.unmapped
            else ""
        )
        self.scene.setToolTip(f"{field.data.source}\n{boxes}{unmapped}")


def scene_line(scene: LoadedScene) -> str:
    """Voxel edge, informative voxels, data set and frames in one line."""
    field = scene.field
    return (
        f"δ {field.grid.voxel_m:g} m  ·  {count_text(field.index.count)} informative voxels  ·  "
        f"{short_source(field.data)}  ·  T = {field.data.frames:,} frames"
    )


def count_text(count: int) -> str:
    """A count with three digits and a unit."""
    for size, unit in ((1_000_000, " M"), (1_000, " k")):
        if count >= size:
            return f"{count / size:.3g}{unit}"
    return str(count)
