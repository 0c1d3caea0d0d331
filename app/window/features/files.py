"""Rig files: open, save, recent ones, and those of other programs; and the question about unsaved changes."""

from __future__ import annotations

from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal

from riglens.app.session.document import Document
from riglens.app.window.actions import Spec, menu_button
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.core.errors import InputError
from riglens.core.formats.report import KINDS, Kind, OpenedRig, Report
from riglens.core.rig.model import Rig
from riglens.core.rig.plausible import implausible
from riglens.core.rig.presets import PRESETS, preset
from riglens.core.sensing.kept import RAYS
from riglens.core.shown_text import visible
from riglens.core.vehicle.mesh_file import mesh_name, mesh_path
from riglens.widgets.panels.controls.menus import add_entry
from riglens.widgets.panels.controls.style import plain_tip

if TYPE_CHECKING:
    from riglens.core.formats.base import Format
    from riglens.core.formats.source import Source


class Files(Feature):
    """Commands that open and save the document."""

    foreign_chosen = Signal(object)
    """A file or folder (`Source`) that another program may have written was chosen to be opened."""

    specs = (
        Spec("new", "New", "Start with a car without sensors.", "Ctrl+N", "", "file/new"),
        Spec("open", "Open…", "Open a rig file.", "Ctrl+O", "open", "file/open", "file"),
        Spec("save", "Save", "Save the rig to its file.", "Ctrl+S", "save", "file/save", "file"),
        Spec("save_as", "Save as…", "Save the rig to another file.", "Ctrl+Shift+S", "", "file/save"),
        Spec("quit", "Quit", "Close the window.", "Ctrl+Q", "", "file/end"),
    )

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        presets = bench.places.add_submenu("file/new", "New from preset")
        for name, found in PRESETS.items():
            add_entry(presets, found.title, partial(self.open_preset, name))
        self.bind(new=self.new, open=self.open, save=self.save, save_as=self.save_as, quit=bench.window.close)
        for changed in (
            self.document.rig_settled, self.document.modified_changed, self.document.file_changed,
        ):  # fmt: skip
            changed.connect(self._update_title)
        self.document.opened.connect(RAYS.forget)  # rays of a rig that is no longer open
        self.document.opened.connect(self._show_doubts)
        self._doubts = ""
        self._update_title()
        self._show_doubts()

    def open(self) -> None:
        """Ask for a rig file, then about changes that would be lost, and open it."""
        path = self.bench.dialogs.open_rig(self.bench.window, self.document.folder)
        if path is not None and self.may_lose_changes():
            self._open(path)

    def _open(self, path: Path) -> None:
        """Open a rig file, or have one of another program read."""
        from riglens.core.formats.exchange import may_be_foreign  # many formats: not while the window opens
        from riglens.core.formats.source import Source

        source = Source(path)
        if may_be_foreign(source):
            self.foreign_chosen.emit(source)
        else:
            self.bench.guarded(self._show)(source)

    def _show_doubts(self) -> None:
        """Show over the view what is implausible about the rig that was opened, in place of what was about the last."""
        notes, before = self.bench.notes, self._doubts
        self._doubts = "\n".join(implausible(self.document.rig))
        if self._doubts:
            notes.show_message(self._doubts)
        elif before and notes.message == before:
            notes.clear()

    def _show(self, source: Source) -> None:
        from riglens.core.formats.exchange import read_rig

        opened = read_rig(source)
        self.document.show(opened.rig, opened.file, source.path)

    def open_path(self, path: Path) -> None:
        """Open a rig file that was chosen elsewhere."""
        if self.may_lose_changes():
            self._open(path)

    def new(self) -> None:
        """Start with a car without sensors."""
        if self.may_lose_changes():
            self.document.show(Rig(name="new rig"))

    def open_preset(self, name: str) -> None:
        """Open a built-in rig."""
        if self.may_lose_changes():
            self.document.show(preset(name))

    def save(self) -> bool:
        """Save to the document's file, asking where when it has none; whether it was saved."""
        return self._save_to(self.document.path) if self.document.path is not None else self.save_as()

    def save_as(self) -> bool:
        """Ask where to save; whether it was saved."""
        suggestion = self.document.path or Path(file_name(self.document.rig.name, ".yaml"))
        return self._save_to(self.bench.dialogs.save_rig(self.bench.window, suggestion))

    def _save_to(self, path: Path | None) -> bool:
        if path is None:
            return False
        try:
            self._take_mesh_along(path.parent)
            self.document.save(path)
        except InputError as error:
            self.bench.report_error(str(error))
            return False
        self.bench.errors.clear()
        return True

    def _take_mesh_along(self, folder: Path) -> None:
        """Make the path of the rig's mesh file valid from another folder."""
        path, rig = self.document.path, self.document.rig
        if path is None or not rig.vehicle.has_mesh_file:
            return
        body = mesh_name(mesh_path(rig.vehicle.body, path.parent), folder)
        is_same_place = path.parent.absolute() == folder.absolute()
        if not is_same_place and not Path(rig.vehicle.body).is_absolute():
            self.document.apply(rig.replace(vehicle=rig.vehicle.replace(body=body)), "rename the mesh")

    def may_lose_changes(self) -> bool:
        """Return whether the rig is saved, or the user does not mind."""
        self.viewport.cancel_drag()
        if not self.document.is_modified:
            return True
        answer = self.bench.dialogs.unsaved(self.bench.window, self.document.rig.name)
        return answer == "discard" or (answer == "save" and self.save())

    def _update_title(self) -> None:
        file = self.document.path.name if self.document.path is not None else "not saved yet"
        self.bench.window.setWindowTitle(visible(f"{self.document.rig.name}[*] ({file}) – RigLens"))
        self.bench.window.setWindowModified(self.document.is_modified)


def file_name(rig_name: str, suffix: str) -> str:
    """Return a rig's name as a file name: letters, digits and -_+. stay."""
    kept = "".join(c if c.isalnum() or c in "-_+." else "-" for c in rig_name).strip("-.")
    return (kept or "rig") + suffix


def beside_rig(document: Document, name: str, suffix: str) -> Path:
    """Return a file name for a result, in the folder of the rig's file if it has one."""
    return (document.folder or Path()) / file_name(name, suffix)


KEY = "files/recent"
MOST = 10


class Recent(Feature):
    """The list is shared by all windows; files that are gone stay in it, greyed, until it is cleared."""

    def __init__(self, bench: Workbench, files: Files) -> None:
        super().__init__(bench)
        self._files = files
        self.menu = bench.places.add_submenu("file/open", "Open recent")
        self.menu.aboutToShow.connect(self.fill)
        self.document.file_changed.connect(self._note)
        self._note()

    @property
    def paths(self) -> list[Path]:
        """The files, the last one first."""
        return [Path(name) for name in self.bench.kept.read(KEY, []) if isinstance(name, str) and name][:MOST]

    def _note(self) -> None:
        path = self.document.path
        if path is None:
            return
        self.bench.kept.sync()  # another window may have opened files too
        newest = path.absolute()
        names = [str(newest), *(str(other) for other in self.paths if other != newest)]
        self.bench.kept.write(KEY, names[:MOST])
        self.bench.kept.sync()

    def fill(self) -> None:
        """Fill the menu with the current list."""
        self.bench.kept.sync()
        self.menu.clear()
        for number, path in enumerate(self.paths, 1):
            title = f"{path.name}  –  {path.parent}".replace("&", "&&")
            action = add_entry(self.menu, f"&{number % 10}  {title}", partial(self._files.open_path, path))
            is_there = path.is_file()
            action.setEnabled(is_there)
            action.setToolTip(plain_tip(str(path) if is_there else f"{path} no longer exists"))
        self.menu.addSeparator()
        clear = add_entry(self.menu, "Clear list", self.clear)
        clear.setEnabled(bool(self.paths))

    def clear(self) -> None:
        """Forget all files."""
        self.bench.kept.write(KEY, [])
        self.bench.kept.sync()


HEADINGS: dict[Kind, str] = {
    "read": "Read",
    "written": "Written",
    "converted": "Converted",
    "approximated": "Approximated",
    "ignored": "Left out",
}


class Exchange(Feature):
    """Import and export of rigs in the formats of other programs."""

    def __init__(self, bench: Workbench, files: Files) -> None:
        super().__init__(bench)
        self.menu = bench.places.add_submenu("file/export", "Export as")
        self.menu.aboutToShow.connect(self._fill)
        button = menu_button("export", "export", "Export the rig for another program.", self.menu)
        bench.places.add_to_toolbar("export", button)
        files.foreign_chosen.connect(self.read)

    def _fill(self) -> None:
        """List the formats when the menu is first opened."""
        from riglens.core.formats.exchange import formats, writable

        if not self.menu.isEmpty():
            return
        for name in writable():
            if name != "riglens":
                format_ = formats()[name]
                action = add_entry(self.menu, f"{format_.title}…", partial(self.export, format_))
                action.setObjectName(f"export_{name}")
                action.setToolTip("Makes a folder" if format_.is_folder else "Makes a file")

    def read(self, source: Source) -> None:
        """Read the rig of another program in the background; then it is shown, and the report on it."""
        from riglens.core.formats.exchange import read_rig

        self.bench.tasks.run(f"Reading {source.path.name}", lambda _: read_rig(source), done=self._show)

    def _show(self, opened: OpenedRig) -> None:
        self.document.show(opened.rig)
        self.show_report(opened.report)

    def rig_of(self, path: Path) -> Rig:
        """Return the rig of a file to compare with; show a report if the file comes from another program."""
        from riglens.core.formats.exchange import read_rig

        opened = read_rig(path)
        if opened.file is None:
            self.show_report(opened.report)
        return opened.rig

    def export(self, format_: Format) -> None:
        """Ask where, and write the rig in that format."""
        ending = "" if format_.is_folder else (format_.endings or (".json",))[0]
        suggestion = beside_rig(self.document, self.document.rig.name, ending)
        path = self.bench.dialogs.export_rig(self.bench.window, suggestion, format_.title, format_.is_folder)
        if path is not None:
            self.bench.guarded(self._write)(path, format_)

    def _write(self, path: Path, format_: Format) -> None:
        from riglens.core.formats.exchange import write_rig

        self.show_report(write_rig(self.document.rig, path, format_.name).report)

    def show_report(self, report: Report | None) -> None:
        """Show the report of a conversion; nothing for RigLens' own files."""
        if report is not None:
            self.bench.dialogs.show_text(self.bench.window, report.title, report_html(report), report.text())


def report_html(report: Report) -> str:
    """Return the remarks under a heading for each kind."""
    parts = []
    for kind in KINDS:
        remarks = report.of_kind(kind)
        if remarks:
            lines = "".join(f"<li>{escape(remark.folded())}</li>" for remark in remarks)
            parts.append(f"<p><b>{HEADINGS[kind]}</b></p><ul>{lines}</ul>")
    return "".join(parts)
