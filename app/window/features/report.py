"""File > Report: one page about the rig and those in the Compare panel, made in the background."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices

from riglens.app.background.report import ReportJob, make_report
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.features.compare import Compare
from riglens.app.window.features.files import beside_rig
from riglens.app.window.features.propose import Propose
from riglens.app.window.status import TOLD_MS
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.files import require_writable
from riglens.core.rig.model import Rig
from riglens.core.vehicle.mesh_file import with_full_mesh_path
from riglens.evaluation.options import ReportOptions, SceneOptions, ScoreOptions
from riglens.evaluation.requests import fixed_options
from riglens.widgets.panels.dialogs.report import ReportChoice, ReportDialog

NO_DATA = "no box data are loaded: choose some in the Scene panel"


class Report(Feature):
    """Reports in the making, any number at a time; the strip in the status bar cancels one."""

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
        self.work: Callable[..., Path] = make_report
        self.show_file = show
        self.dialog: ReportDialog | None = None
        self._options: dict[str, str] = {}
        self.bind(report=bench.guarded(self.open))
        self.remember("report/options", lambda: dict(self._options), self._take_options)

    def _take_options(self, kept: dict[str, str]) -> None:
        self._options = {name: text for name, text in kept.items() if isinstance(text, str)}

    def _kept(self) -> list[Rig]:
        """Return the rigs of the Compare panel but the current one, under the names shown there."""
        rows = (row for row in self._compare.rows if row.origin != "current")
        return [row.rig.model_copy(update={"name": row.name}) for row in rows]

    def rigs(self, with_others: bool = True) -> tuple[Rig, ...]:
        """Return the rig, with others after the first of the Compare panel, which it is compared with, and before the
        rest there; each once."""
        kept, folder = self._kept() if with_others else [], self.document.folder
        rigs = (*kept[:1], self.document.rig, *kept[1:])
        return tuple(dict.fromkeys(with_full_mesh_path(rig, folder) for rig in rigs))

    def open(self) -> None:
        """Ask for file, contents and labels, with the labels of the last time."""
        if self.session.scene is None:
            raise InputError(NO_DATA)
        others = [rig.name for rig in self._kept()]
        suggestion = beside_rig(self.document, f"{self.document.rig.name} report", ".html").absolute()
        usual = ReportOptions()
        self.dialog = dialog = ReportDialog(
            suggestion, others, usual.draws, tuple(usual.labels), self.bench.window
        )
        dialog.recall(self._options)
        dialog.browse_wanted.connect(self._browse)
        dialog.wanted.connect(self._start)
        dialog.finished.connect(lambda _: self._on_closed())
        dialog.open()

    def _browse(self) -> None:
        if self.dialog is not None:
            chosen = self.bench.dialogs.save_report(self.dialog, self.dialog.choice.path)
            if chosen is not None:
                self.dialog.show_path(chosen)

    def _start(self, choice: ReportChoice) -> None:
        """Start a report unless its file cannot be written; edits meanwhile do not affect it."""
        scene, dialog = self.session.scene, self.dialog
        if scene is None or dialog is None:
            return
        labels: dict[str, Any] = {name: text or None for name, text in choice.labels.items()}
        try:
            holds = ReportOptions(draws=ReportOptions.draws if choice.tolerance else 0, **labels)
            require_writable(choice.path, self._read(fixed_options(scene)))
        except InputError as error:
            dialog.show_problem(str(error))
            return
        settings = self.session.settings
        job = ReportJob(
            self.rigs(choice.others),
            fixed_options(scene),
            ScoreOptions(settings.method, settings.reading, settings.camera_weight, body=settings.body),
            choice.path,
            holds,
            self._propose.why(),
        )
        self.bench.tasks.run("Report", partial(self.work, job), partial(self._on_written, choice.opens))
        dialog.accept()

    def _read(self, scene: SceneOptions) -> tuple[Path, ...]:
        """Return the files that a report is made from, which it must not replace."""
        own = () if self.document.path is None else (self.document.path,)
        return (*own, *map(Path, scene.files))

    def _on_written(self, opens: bool, path: Path) -> None:
        self.bench.status.showMessage(f"Report written: {path}", TOLD_MS)
        if opens:
            self.show_file(path)

    def _on_closed(self) -> None:
        dialog, self.dialog = self.dialog, None
        if dialog is not None:
            self._options = dialog.options
            dialog.deleteLater()


def show(path: Path) -> None:
    """Open a file with the system's program for it."""
    QDesktopServices.openUrl(QUrl.fromLocalFile(str(path)))
