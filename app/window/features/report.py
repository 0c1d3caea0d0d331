"""File > Report: one page about the rig and those in the Compare panel, made in the background and previewed before it
is written."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices

from riglens.app.background.report import PAGE, PDF, ReportJob, make_report
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.compare import Compare
from riglens.app.window.features.files import beside_rig
from riglens.app.window.features.propose import Propose
from riglens.app.window.status import TOLD_MS
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.files import atomic_write
from riglens.core.rig.model import Rig
from riglens.core.vehicle.mesh_file import with_full_mesh_path
from riglens.evaluation.options import ScoreOptions
from riglens.evaluation.requests import fixed_options
from riglens.widgets.panels.dialogs.report import ReportDialog


class Report(Feature):
    """Reports in the making, any number at a time; the strip in the status bar cancels one. Each has a temporary folder
    until it is closed."""

    specs = (
        Spec(
            "report", "Report…",
            "Write one page, HTML or PDF, about this rig and those in the Compare panel, with all figures attached.",
            menu="file/export",
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench, compare: Compare, propose: Propose) -> None:
        super().__init__(bench)
        self._compare, self._propose = compare, propose
        self.work, self.show_file = make_report, show
        self.dialogs: dict[Path, ReportDialog] = {}
        """The previews that are open, by the folders of their files."""
        self._folders = set[Path]()
        self.bind(report=bench.guarded(self.start))
        bench.closing.connect(self._clear)  # tasks have ended by then

    def rigs(self) -> tuple[Rig, ...]:
        """Return the rig after the first of the Compare panel, which it is compared with, and the others there, under
        the names shown there, each once."""
        kept = [
            row.rig.model_copy(update={"name": row.name})
            for row in self._compare.rows
            if row.origin != "current"
        ]
        folder, rigs = self.document.folder, (*kept[:1], self.document.rig, *kept[1:])
        return tuple(dict.fromkeys(with_full_mesh_path(rig, folder) for rig in rigs))

    def start(self) -> None:
        """Start a report; edits meanwhile do not affect it."""
        scene = self.session.scene
        if scene is None:
            raise InputError("no box data are loaded: choose some in the Scene panel")
        settings = self.session.settings
        score = ScoreOptions(settings.method, settings.reading, settings.camera_weight, body=settings.body)
        made = Path(tempfile.mkdtemp(prefix="riglens-report-"))
        self._folders.add(made)
        job = ReportJob(self.rigs(), fixed_options(scene), score, made, self._propose.why())
        self.bench.tasks.run(
            "Report",
            partial(self.work, job),
            done=partial(self._preview, made),
            ended=lambda: self._forget_unseen(made),
        )

    def _preview(self, made: Path, pictures: Sequence[Path]) -> None:
        """Show what was made."""
        dialog = ReportDialog(pictures, self.bench.window)
        self.dialogs[made] = dialog
        dialog.browser_wanted.connect(lambda: self.show_file(made / PAGE))
        dialog.save_wanted.connect(self.bench.guarded(partial(self._save, made)))
        dialog.finished.connect(lambda _: self._forget(made))
        dialog.show()

    def _save(self, made: Path, suffix: str) -> None:
        suggestion = beside_rig(self.document, "report", suffix)
        chosen = self.bench.dialogs.save_report(self.bench.window, suggestion)
        if chosen is None:
            return
        name = PDF if chosen.suffix.lower() == ".pdf" else PAGE
        with open(made / name, "rb") as source, atomic_write(chosen) as stream:
            shutil.copyfileobj(source, stream)
        self.bench.status.showMessage(f"Report written: {chosen}", TOLD_MS)

    def _forget_unseen(self, made: Path) -> None:
        if made not in self.dialogs:
            self._forget(made)

    def _forget(self, made: Path) -> None:
        """Remove the folder of a report that was put away; a browser has read it by then."""
        self.dialogs.pop(made, None)
        self._folders.discard(made)
        shutil.rmtree(made, ignore_errors=True)

    def _clear(self) -> None:
        for made in list(self._folders):
            if made in self.dialogs:
                self.dialogs[made].close()
            self._forget(made)


def show(path: Path) -> None:
    """Open a file with the system's program for it."""
    QDesktopServices.openUrl(QUrl.fromLocalFile(str(path)))
