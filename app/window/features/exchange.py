"""Rigs of other programs: read in the background, written from the File menu, with a report to read each time."""

from __future__ import annotations

from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QMenu

from riglens.app.window.actions import menu_button
from riglens.app.window.feature import Feature
from riglens.app.window.features.files import Files, file_name
from riglens.core.rig.formats.report import KINDS, Kind, Report
from riglens.core.rig.model import Rig
from riglens.core.rig.opening import OpenedRig, open_rig_file

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow
    from riglens.core.rig.formats.base import Format

HEADINGS: dict[Kind, str] = {
    "read": "Read",
    "written": "Written",
    "converted": "Converted",
    "approximated": "Approximated",
    "ignored": "Left out",
}


class Exchange(Feature):
    """Reads and writes rigs in the formats of other programs."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.menu = QMenu("Export as", window)
        self.menu.setToolTipsVisible(True)
        self.menu.aboutToShow.connect(self._fill)
        window.places.add_to_menu("file/export", self.menu)
        button = menu_button("export", "export", "Export the rig for another program", self.menu)
        window.places.add_to_toolbar("export", button)
        window.feature(Files).foreign_chosen.connect(self.read)

    def _fill(self) -> None:
        """List the formats, the first time that somebody looks."""
        from riglens.core.rig.formats.exchange import FORMATS, WRITABLE

        if not self.menu.isEmpty():
            return
        for name in WRITABLE:
            if name != "riglens":
                format_ = FORMATS[name]
                action = self.menu.addAction(f"{format_.title}…", partial(self.export, format_))
                action.setObjectName(f"export_{name}")
                action.setToolTip("Makes a folder" if format_.is_folder else "Makes a file")

    def read(self, path: Path) -> None:
        """Read the rig of another program in the background; then it is shown, and the report on it."""
        self.window.tasks.run(f"Reading {path.name}", lambda _: open_rig_file(path), done=self._show)

    def _show(self, opened: OpenedRig) -> None:
        path = opened.file.path if opened.file is not None else None
        self.document.show(opened.rig, opened.file, path)
        self.show_report(opened.report)

    def rig_of(self, path: Path) -> Rig:
        """The rig of a file to compare with; a report is shown where it comes from another program."""
        opened = open_rig_file(path)
        self.show_report(opened.report)
        return opened.rig

    def export(self, format_: Format) -> None:
        """Ask where, and write the rig in that format."""
        ending = "" if format_.is_folder else (format_.endings or (".json",))[0]
        suggestion = Path(file_name(self.document.rig.name, ending))
        path = self.window.dialogs.export_rig(self.window, suggestion, format_.title, format_.is_folder)
        if path is not None:
            self.window.guarded(self._write)(path, format_)

    def _write(self, path: Path, format_: Format) -> None:
        from riglens.core.rig.formats.exchange import write_rig

        self.show_report(write_rig(self.document.rig, path, format_.name).report)

    def show_report(self, report: Report | None) -> None:
        """What became of everything, to read; nothing for RigLens' own files."""
        if report is not None:
            self.window.dialogs.show_text(self.window, report.title, report_html(report))


def report_html(report: Report) -> str:
    """The remarks under a heading for each kind."""
    parts = []
    for kind in KINDS:
        remarks = report.of_kind(kind)
        if remarks:
            lines = "".join(f"<li>{escape(remark.sentence())}</li>" for remark in remarks)
            parts.append(f"<p><b>{HEADINGS[kind]}</b></p><ul>{lines}</ul>")
    return "".join(parts)
