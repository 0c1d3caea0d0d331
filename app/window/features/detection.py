"""Study > Study of detection: trains a small detector on the rigs at hand, beside the window, and shows its charts."""

from __future__ import annotations

import os
from pathlib import Path

from PySide6.QtCore import Qt, QUrl, Signal
from PySide6.QtGui import QDesktopServices

from riglens.app.background.detection import CHART, PAIRS, DetectionJob, study
from riglens.app.background.tasks import Task
from riglens.app.evaluation.requests import fixed_options
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.compare import Compare
from riglens.app.window.workbench import Workbench
from riglens.core.cache_folder import cache_folder
from riglens.core.errors import InputError
from riglens.core.rig.model import Rig
from riglens.core.shown_text import visible
from riglens.core.vehicle.mesh_file import with_full_mesh_path
from riglens.widgets.panels.dialogs.detection import DetectionDialog

WORDING = (
    "Simulated LiDAR, small detector trained here: compares rigs, does not predict the AP of your stack."
)
NO_LIDAR = "No rig with a LiDAR: add one, or take snapshots in the Compare panel."


class Detection(Feature):
    """One study at a time, of the rig and those in the Compare panel; what is done is kept and not done again."""

    told = Signal(str)
    """A piece is done; sent by the thread that follows the process."""
    specs = (
        Spec(
            "detection", "Study of detection…",
            "Simulate LiDARs of this rig and those in the Compare panel, train a small detector, and compare",
            menu="study/reports",
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench, compare: Compare) -> None:
        super().__init__(bench)
        self._compare = compare
        self.folder = cache_folder() / "detection"
        self.work = study
        self.dialog: DetectionDialog | None = None
        self._task: Task | None = None
        self._shown: tuple[float, ...] = ()
        self.bind(detection=self.open)
        self.told.connect(self._on_told, Qt.ConnectionType.QueuedConnection)

    def rigs(self) -> tuple[Rig, ...]:
        """The rig and those in the Compare panel that have LiDARs; the same one counts once."""
        kept = [
            row.rig.model_copy(update={"name": row.name})
            for row in self._compare.rows
            if row.origin != "current"
        ]
        by_lidars = {rig.lidars(): rig for rig in reversed([self.document.rig, *kept]) if rig.lidars()}
        folder = None if self.document.path is None else self.document.path.parent
        return tuple(with_full_mesh_path(rig, folder) for rig in reversed(by_lidars.values()))

    def open(self) -> None:
        """Show the dialog, with the chart of last time."""
        if self.dialog is None:
            self.dialog = DetectionDialog(os.cpu_count() or 1, self.bench.window)
            self.dialog.build(WORDING)
            self.dialog.start_wanted.connect(self.bench.guarded(self.start))
            self.dialog.stop_wanted.connect(self.stop)
            self.dialog.folder_wanted.connect(self._open_folder)
            self.document.rig_settled.connect(self._say_rigs)
        self._say_rigs()
        self._show_charts()
        self.dialog.show()
        self.dialog.raise_()

    def _say_rigs(self) -> None:
        if self.dialog is None or self._task is not None:
            return
        rigs = self.rigs()
        names = ", ".join(visible(rig.name) for rig in rigs)
        self.dialog.rigs.setText(f"Compares {names}" if rigs else NO_LIDAR)
        self.dialog.start.setEnabled(bool(rigs))

    def start(self) -> None:
        """Begin, or go on where it was stopped."""
        dialog, rigs, scene = self.dialog, self.rigs(), self.session.scene
        if dialog is None or self._task is not None or not rigs:
            return
        if scene is None:
            raise InputError("no box data are loaded: choose some in the Scene panel")
        self._say_rigs()
        job = DetectionJob(
            rigs,
            fixed_options(scene),
            self.session.settings.body,
            self.folder,
            dialog.quick.isChecked(),
            dialog.workers.value(),
        )
        dialog.set_running(True)
        dialog.state.setText("Sweeps are being simulated")
        dialog.show_share(0.0)
        self._task = self.bench.tasks.run(
            "Study of detection",
            lambda progress: self.work(job, progress, self.told.emit),
            done=self._on_done,
            ended=self._on_ended,
        )
        self._task.progressed.connect(dialog.show_share, Qt.ConnectionType.QueuedConnection)

    def stop(self) -> None:
        """Stop it; what is done is kept."""
        if self._task is not None:
            self._task.cancel()

    def _on_told(self, line: str) -> None:
        if self.dialog is not None:
            self.dialog.state.setText(visible(line))
            self._show_charts()

    def _on_done(self, _folder: Path) -> None:
        if self.dialog is not None:
            self.dialog.state.setText("Done")
            self._show_charts()

    def _on_ended(self) -> None:
        self._task = None
        if self.dialog is not None:
            if self.dialog.state.text() != "Done":
                self.dialog.state.setText("Stopped: Start goes on where it was")
            self.dialog.set_running(False)
            self._say_rigs()

    def _show_charts(self) -> None:
        """Read the charts when they are newer than what is shown."""
        files = (self.folder / CHART, self.folder / PAIRS)
        times = tuple(path.stat().st_mtime for path in files if path.exists())
        if self.dialog is not None and len(times) == len(files) and times != self._shown:
            self._shown = times
            self.dialog.show_charts(*(path.read_bytes() for path in files))

    def _open_folder(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        QDesktopServices.openUrl(QUrl.fromLocalFile(str(self.folder)))
