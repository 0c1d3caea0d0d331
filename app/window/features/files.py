"""Rig files: open, presets, save, and the question about changes that are not saved."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QMenu

from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.core.errors import InputError
from riglens.core.rig.model import Rig
from riglens.core.rig.presets import PRESETS, preset
from riglens.core.vehicle.mesh_file import mesh_name, mesh_path

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow


class Files(Feature):
    """Opens and saves the document."""

    foreign_chosen = Signal(object)
    """The path of a file or folder that another program may have written was chosen to be opened."""

    specs = (
        Spec("new", "New", "Start with a car without sensors", "Ctrl+N", "", "file/new"),
        Spec("open", "Open…", "Open a rig file", "Ctrl+O", "open", "file/open", "file"),
        Spec("save", "Save", "Save the rig to its file", "Ctrl+S", "save", "file/save", "file"),
        Spec("save_as", "Save as…", "Save the rig to another file", "Ctrl+Shift+S", "", "file/save"),
        Spec("quit", "Quit", "Close the window", "Ctrl+Q", "", "file/end"),
    )

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        window.places.add_to_menu("file/new", self._preset_menu())
        self.bind(new=self.new, open=self.open, save=self.save, save_as=self.save_as, quit=window.close)
        window.rig_shown.connect(self._update_title)
        self.document.file_changed.connect(self._update_title)

    def _preset_menu(self) -> QMenu:
        menu = QMenu("New from preset", self.window)
        for name in PRESETS:
            menu.addAction(name, partial(self.open_preset, name))
        return menu

    def open(self) -> None:
        """Ask for a rig file and open it."""
        if self.may_lose_changes():
            folder = self.document.path.parent if self.document.path is not None else None
            path = self.window.dialogs.open_rig(self.window, folder)
            if path is not None:
                self._open(path)

    def _open(self, path: Path) -> None:
        """Open a rig file, or have one of another program read."""
        from riglens.core.rig.formats.exchange import (
            may_be_foreign,  # many formats: not while the window opens
        )

        if may_be_foreign(path):
            self.foreign_chosen.emit(path)
        else:
            self.window.guarded(self.document.open)(path)

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
        return self._save_to(self.window.dialogs.save_rig(self.window, suggestion))

    def _save_to(self, path: Path | None) -> bool:
        if path is None:
            return False
        try:
            self._take_mesh_along(path.parent)
            self.document.save(path)
        except InputError as error:
            self.window.report_error(str(error))
            return False
        self.window.message_bar.clear()
        return True

    def _take_mesh_along(self, folder: Path) -> None:
        """Have the rig find its mesh file from another folder, too."""
        path, rig = self.document.path, self.document.rig
        if path is None or not rig.vehicle.has_mesh_file:
            return
        body = mesh_name(mesh_path(rig.vehicle.body, path.parent), folder)
        is_same_place = path.parent.absolute() == folder.absolute()
        if not is_same_place and not Path(rig.vehicle.body).is_absolute():
            self.document.apply(rig.replace(vehicle=rig.vehicle.replace(body=body)), "name the mesh anew")

    def may_lose_changes(self) -> bool:
        """Whether the rig is saved, or the user does not mind."""
        self.viewport.cancel_drag()
        if not self.document.is_modified:
            return True
        answer = self.window.dialogs.unsaved(self.window, self.document.rig.name)
        return answer == "discard" or (answer == "save" and self.save())

    def _update_title(self) -> None:
        file = self.document.path.name if self.document.path is not None else "not saved yet"
        self.window.setWindowTitle(f"{self.document.rig.name}[*] ({file}) – RigLens")
        self.window.setWindowModified(self.document.is_modified)


def file_name(rig_name: str, suffix: str) -> str:
    """A rig's name as a file name: letters, digits and -_+. stay."""
    kept = "".join(c if c.isalnum() or c in "-_+." else "-" for c in rig_name).strip("-.")
    return (kept or "rig") + suffix
