"""The status bar: whether the numbers are exact, one figure of the rig, and the data; the rest is in tooltips."""

from __future__ import annotations

from collections.abc import Collection

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QStatusBar, QWidget

from riglens.app.background.tasks import Task
from riglens.core.metric.scores import Body
from riglens.core.scene.survey import doubtful, doubts
from riglens.evaluation.names import label_with
from riglens.evaluation.requests import Approximation, LoadedScene, Result, failed_text
from riglens.widgets.panels.controls.messages import ProgressStrip
from riglens.widgets.panels.controls.scrolled import ElidedLabel
from riglens.widgets.panels.controls.style import plain_tip

UPDATING = "updating…"
TOLD_MS = 10_000
"""Duration of a message about something done."""
NO_DATA = "no box data, no scores"
COARSE_NOTE = (
    "Exact scores take too long for a drag here.\nScores marked ≈ are estimated on larger voxels; "
    "the exact ones replace them when the mouse rests."
)
ONE_WAY_NOTE = (
    "0° is ahead, positive is left. The data hold almost no boxes elsewhere,\nso the scores "
    "say nothing about sensors facing there."
)


BODY_WORDS: dict[Body, str] = {"blocks": "solid car", "ignored": "car lets rays pass"}
BODY_NOTES: dict[Body, str] = {
    "blocks": "Rays end at the car's own body.",
    "ignored": "Rays pass through the car's own body, as in the paper.",
}
FAILED_NOTE = "All figures, maps and colours are those of the rig without them; the rig itself is unchanged."
MESH_NOTE = ": its mesh file cannot be read, so nothing stops rays"


class StatusBar(QStatusBar):
    """State on the left, scene on the right, and a strip per piece of long work between them."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setSizeGripEnabled(False)
        self.state, self.figure, self.scene = ElidedLabel(UPDATING), ElidedLabel(), ElidedLabel()
        self.scene.setTextFormat(Qt.TextFormat.PlainText)
        self.body, self.failed, self.doubts = ElidedLabel(), ElidedLabel(), ElidedLabel()
        for warning in (self.failed, self.doubts):
            warning.setTextFormat(Qt.TextFormat.PlainText)
            warning.setObjectName("warning")
            warning.hide()
        self._is_coarse = False
        self._waiting = UPDATING
        self._last: Result | None = None
        self._time = ""
        self.state.setMinimumWidth(80)
        self.addWidget(self.state)
        self.addWidget(self.figure)
        self.addPermanentWidget(self.failed)
        self.addPermanentWidget(self.doubts)
        self.addPermanentWidget(self.body)
        self.addPermanentWidget(self.scene)
        self.messageChanged.connect(self._make_room)

    def _make_room(self, message: str) -> None:
        """Hide state and figure while a message is in their place, which Qt does only until the next layout."""
        for label in (self.state, self.figure):
            label.setVisible(not message)

    def add_strip(self, title: str) -> ProgressStrip:
        """Add room for the progress of one piece of work, to the left of those added before."""
        strip = ProgressStrip(title)
        self.insertPermanentWidget(2, strip)  # behind state and figure
        return strip

    def add_busy(self, words: str) -> ProgressStrip:
        """Show work of unknown length that cannot be cancelled."""
        strip = self.add_strip("")
        strip.bar.setRange(0, 0)
        strip.cancel.hide()
        strip.left.setText(words)
        return strip

    def show_task(self, task: Task) -> None:
        """Show the progress of a task until it ends, with a button to cancel it."""
        queued = Qt.ConnectionType.QueuedConnection
        strip = self.add_strip(task.title)
        strip.cancelled.connect(task.cancel)
        task.staged.connect(strip.name_stage, queued)
        task.progressed.connect(strip.show_progress, queued)
        task.ended.connect(strip.end, queued)
        task.ended.connect(strip.deleteLater, queued)
        strip.begin()

    def set_updating(self) -> None:
        """Mark the shown numbers as those of an earlier state; coarse ones stay marked until the next arrive."""
        if not self._is_coarse:
            self.state.setText(self._waiting)

    def set_no_data(self) -> None:
        """Show that there are no scores, because no box data are loaded."""
        self._waiting = NO_DATA
        self.set_updating()

    def show_approximation(self, first: Approximation) -> None:
        """Mark the numbers as coarse, with exact ones to follow."""
        self._is_coarse = True
        self.state.setText(f"coarse (δ {first.voxel_m:g} m), exact follows")
        self.state.setToolTip(f"{COARSE_NOTE}\nCoarse result: {duration_text(first.elapsed_ms)}")

    def show_result(self, result: Result, is_current: bool) -> None:
        """Show how long the evaluation took."""
        self.state.setText("exact" if is_current else UPDATING)
        evaluation = result.evaluation
        before, now = None if self._last is None else self._last.request, result.request
        if before is None or self._last is None or self._last.scene is not result.scene:
            self._time = f"First answer: {duration_text(evaluation.elapsed_ms)}"
        elif self._is_coarse or (before.rig, before.settings) != (now.rig, now.settings):
            self._time = f"Last edit: {duration_text(evaluation.elapsed_ms)}"
        self.state.setToolTip(f"{self._time}, {evaluation.threads} threads")
        self._last, self._is_coarse = result, False

    def show_figure(self, text: str, tip: str = "") -> None:
        """Show the leading figures of the rig, or none."""
        self.figure.setText(text)
        self.figure.setToolTip(plain_tip(tip))
        self.figure.setEnabled(True)

    def show_body(self, body: Body, is_mesh_missing: bool) -> None:
        """Say whether rays end at the car's own body."""
        self.body.setText(BODY_WORDS[body] + (" (no mesh)" if is_mesh_missing else ""))
        self.body.setToolTip(BODY_NOTES[body] + (MESH_NOTE if is_mesh_missing else ""))

    def show_failed(self, names: Collection[str]) -> None:
        """Show which sensors are marked as failed."""
        text = failed_text(names)
        self.failed.setText(text)
        self.failed.setToolTip(plain_tip(f"{text}\n{FAILED_NOTE}"))
        self.failed.setVisible(bool(text))

    def show_scene(self, scene: LoadedScene) -> None:
        """Show the inputs of the scores."""
        field = scene.field
        self._waiting = UPDATING
        gap = f"  ·  {scene.gap.words}" if scene.gap is not None else ""
        self.scene.setText(f"{field.data.short_source}  ·  {field.data.frames:,} frames{gap}")
        boxes = ", ".join(f"{count:,} {name}" for name, count in field.data.boxes.items())
        unmapped = (
            f"; {field.data.unmapped.total():,} boxes of other classes are not counted"
            if field.data.unmapped
            else ""
        )
        one_way = f"\n\n{scene.gap.words}: {ONE_WAY_NOTE}" if scene.gap is not None else ""
        self.scene.setToolTip(
            plain_tip(f"{field.data.source}\n{boxes}{unmapped}\n{scene_line(scene)}{one_way}")
        )
        self.doubts.setText("; ".join(doubt.fact for doubt in doubts(field.data)))
        self.doubts.setToolTip(plain_tip("\n".join(doubtful(field.data, label_with))))
        self.doubts.setVisible(bool(self.doubts.text()))


def scene_line(scene: LoadedScene) -> str:
    """Return voxel edge, informative voxels, data set and frames as one line."""
    field = scene.field
    return (
        f"δ {field.grid.voxel_m:g} m  ·  {count_text(field.index.count)} informative voxels  ·  "
        f"{field.data.short_source}  ·  T = {field.data.frames:,} frames"
        + (f"  ·  {scene.gap.words}" if scene.gap is not None else "")
    )


def duration_text(elapsed_ms: float) -> str:
    """Return milliseconds as text, in seconds from one second up."""
    return f"{elapsed_ms:.1f} ms" if elapsed_ms < 1000.0 else f"{elapsed_ms / 1000.0:.1f} s"


def count_text(count: int) -> str:
    """Return a count with three digits and a unit."""
    for size, unit in ((1_000_000, " M"), (1_000, " k")):
        if count >= size:
            return f"{count / size:.3g}{unit}"
    return str(count)
