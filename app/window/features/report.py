"""File > Report: one page about the rig and those in the Compare panel, made beside the window and seen before it is
written."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices

from riglens.app.background.report import ReportJob, draw_report, make_report, print_report
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.compare import Compare
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.files import atomic_write
from riglens.core.rig.model import Rig
from riglens.core.vehicle.mesh_file import with_full_mesh_path
from riglens.widgets.panels.dialogs.report import ReportDialog


class Report(Feature):
    """Any number at a time; the strip in the status bar stops one. Each is kept in a folder of its own until it is put
    away."""

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
        self.work, self.draw, self.print, self.show_file = make_report, draw_report, print_report, show
        self.dialogs: dict[Path, ReportDialog] = {}
        """The previews that are open, by their pages."""
        self.bind(report=bench.guarded(self.start))
        bench.closing.connect(self._clear)

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
        """Begin; what is shown meanwhile may be edited."""
        scene = self.session.scene
        if scene is None:
            raise InputError("no box data are loaded: choose some in the Scene panel")
        page = Path(tempfile.mkdtemp(prefix="riglens-report-")) / "report.html"
        job = ReportJob(self.rigs(), scene.options, self.session.settings, page)
        self.bench.tasks.run(
            "Report",
            lambda progress: self.draw(self.work(job, progress), progress),
            done=partial(self._preview, page),
            ended=lambda: self._forget_unseen(page),
        )

    def _preview(self, page: Path, pictures: Sequence[Path]) -> None:
        """Show what was made."""
        dialog = ReportDialog(pictures, self.bench.window)
        self.dialogs[page] = dialog
        dialog.browser_wanted.connect(lambda: self.show_file(page))
        dialog.save_wanted.connect(self.bench.guarded(partial(self._save, page)))
        dialog.finished.connect(lambda _: self._forget(page))
        dialog.show()

    def _save(self, page: Path, suffix: str) -> None:
        folder = Path() if self.document.path is None else self.document.path.parent
        chosen = self.bench.dialogs.save_report(self.bench.window, folder / f"report{suffix}")
        if chosen is None:
            return
        if chosen.suffix.lower() == ".pdf":
            self.bench.tasks.run("PDF", lambda progress: self.print(page, chosen, progress), done=self._say)
            return
        with open(page, "rb") as made, atomic_write(chosen) as stream:
            shutil.copyfileobj(made, stream)
        self._say(chosen)

    def _say(self, path: Path) -> None:
        self.bench.notes.show_message(
            f"Report written: {path}", choices={"Show": partial(self.show_file, path)}
        )

    def _forget_unseen(self, page: Path) -> None:
        if page not in self.dialogs:
            self._forget(page)

    def _forget(self, page: Path) -> None:
        """Remove the folder of a page that was put away; a browser has read it by then."""
        self.dialogs.pop(page, None)
        shutil.rmtree(page.parent, ignore_errors=True)

    def _clear(self) -> None:
        for page, dialog in list(self.dialogs.items()):
            dialog.close()
            self._forget(page)


def show(path: Path) -> None:
    """Open a file with the system's program for it."""
    QDesktopServices.openUrl(QUrl.fromLocalFile(str(path)))
