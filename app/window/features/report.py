"""File > Report: one page about the rig and those in the Compare panel, made beside the window."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices

from riglens.app.background.report import ReportJob, make_report
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.compare import Compare
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.rig.model import Rig
from riglens.core.vehicle.mesh_file import with_full_mesh_path


class Report(Feature):
    """Any number at a time; the strip in the status bar stops one."""

    specs = (
        Spec(
            "report", "Report…",
            "One page, HTML or PDF, about this rig and those in the Compare panel, with all figures attached",
            menu="file/export",
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench, compare: Compare) -> None:
        super().__init__(bench)
        self._compare = compare
        self.work = make_report
        self.bind(report=bench.guarded(self.start))

    def rigs(self) -> tuple[Rig, ...]:
        """The rig and those in the Compare panel by the names they have there, each once."""
        kept = (
            row.rig.model_copy(update={"name": row.name})
            for row in self._compare.rows
            if row.origin != "current"
        )
        folder = None if self.document.path is None else self.document.path.parent
        return tuple(dict.fromkeys(with_full_mesh_path(rig, folder) for rig in (self.document.rig, *kept)))

    def start(self) -> None:
        """Ask for the file and begin."""
        scene = self.session.scene
        if scene is None:
            raise InputError("no box data are loaded: choose some in the Scene panel")
        folder = Path() if self.document.path is None else self.document.path.parent
        chosen = self.bench.dialogs.save_report(self.bench.window, folder / "report.html")
        if chosen is None:
            return
        job = ReportJob(self.rigs(), scene.options, self.session.settings, chosen)
        self.bench.tasks.run("Report", lambda progress: self.work(job, progress), done=self._show)

    def _show(self, path: Path) -> None:
        self.bench.notes.show_message(f"Report written: {path}", choices={"Show": partial(show, path)})


def show(path: Path) -> None:
    """Open a file with the system's program for it."""
    QDesktopServices.openUrl(QUrl.fromLocalFile(str(path)))
