"""Every question the window asks in a dialog, in one object, so that tests and scripts can answer instead."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from itertools import count
from pathlib import Path
from typing import Literal

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog, QInputDialog, QMessageBox, QWidget

from riglens.widgets.panels.help.guide import Guide
from riglens.widgets.panels.help.shortcut_sheet import Group, ShortcutSheet

RIG_FILES = "Rig files (*.yaml *.yml);;All files (*)"
BOX_FILES = "Box tables (*.csv *.csv.gz *.parquet *.feather);;All files (*)"
MESH_FILES = "Meshes (*.glb *.gltf *.obj *.stl *.ply);;All files (*)"
PICTURES = "PNG pictures (*.png)"
TABLES = "CSV tables (*.csv)"
REQUIREMENTS = "Files of requirements (*.yaml *.yml);;All files (*)"
REPORTS = "Pages (*.html);;PDF (*.pdf)"
Unsaved = Literal["save", "discard", "cancel"]


def rig_files() -> str:
    """Return the filter for files that hold a rig, of any program."""
    from riglens.core.formats.exchange import endings  # many formats: not while the window opens

    patterns = " ".join(f"*{ending}" for ending in (*endings(), ".json.gz"))
    return f"Rigs, also of other programs ({patterns});;RigLens rigs (*.yaml *.yml);;All files (*)"


class Dialogs:
    """Questions to the user in Qt's dialogs; None means that they changed their mind."""

    def open_rig(self, parent: QWidget, folder: Path | None) -> Path | None:
        """Ask for the rig file to open."""
        return _open(parent, "Open a rig", folder, rig_files())

    def save_rig(self, parent: QWidget, suggestion: Path) -> Path | None:
        """Ask where to save the rig."""
        return _save(parent, "Save the rig", suggestion, RIG_FILES, ".yaml")

    def export_rig(self, parent: QWidget, suggestion: Path, title: str, is_folder: bool) -> Path | None:
        """Ask where to write the rig in another format: a file, or a folder to make."""
        question = f"Name of the folder for {title}" if is_folder else f"Export as {title}"
        suffix = "" if is_folder else suggestion.suffix
        filter_ = "Folders (*)" if is_folder else f"Files (*{suffix});;All files (*)"
        return _save(parent, question, suggestion, filter_, suffix)

    def save_picture(self, parent: QWidget, suggestion: Path) -> Path | None:
        """Ask where to save the picture."""
        return _save(parent, "Save the picture", suggestion, PICTURES, ".png")

    def save_table(self, parent: QWidget, suggestion: Path) -> Path | None:
        """Ask where to save a table."""
        return _save(parent, "Save the table", suggestion, TABLES, ".csv")

    def save_report(self, parent: QWidget, suggestion: Path) -> Path | None:
        """Ask where to write the report."""
        return _save(parent, "Write a report", suggestion, REPORTS, ".html")

    def requirements_file(self, parent: QWidget, folder: Path | None) -> Path | None:
        """Ask for the file of requirements to check against."""
        return _open(parent, "Open a file of requirements", folder, REQUIREMENTS)

    def mesh_file(self, parent: QWidget, folder: Path | None) -> Path | None:
        """Ask for the mesh of the car's body."""
        return _open(parent, "Open a mesh", folder, MESH_FILES)

    def box_file(self, parent: QWidget) -> Path | None:
        """Ask for the box table to score on."""
        return _open(parent, "Open a box table", None, BOX_FILES)

    def box_folder(self, parent: QWidget) -> Path | None:
        """Ask for the folder of a box data set to score on."""
        return _path(QFileDialog.getExistingDirectory(parent, "Open a folder of boxes"))

    def unsaved(self, parent: QWidget, rig_name: str) -> Unsaved:
        """Ask whether to save unsaved changes."""
        button = QMessageBox.StandardButton
        answer = QMessageBox.question(
            parent,
            "Unsaved changes",
            f"<p>The rig '{escape(rig_name, quote=False)}' has changes that are not saved.</p>",
            button.Save | button.Discard | button.Cancel,
            button.Save,
        )
        if answer == button.Save:
            return "save"
        return "discard" if answer == button.Discard else "cancel"

    def view_name(self, parent: QWidget, known: Sequence[str]) -> str | None:
        """Ask for the name of a view to save: suggest a new one and offer the known ones."""
        new = next(name for number in count(1) if (name := f"View {number}") not in known)
        name, is_given = QInputDialog.getItem(
            parent, "Save view", "Name of this view", [new, *known], 0, True
        )
        return name if is_given else None

    def show_sheet(self, parent: QWidget, title: str, groups: Sequence[Group]) -> None:
        """Show keys and their actions."""
        ShortcutSheet(title, groups, parent).show()

    def show_guide(self, parent: QWidget, page: Path) -> None:
        """Show a page of the guide."""
        Guide(page, parent).show()

    def show_text(self, parent: QWidget, title: str, html: str, details: str = "") -> None:
        """Show a text; details in plain text unfold below it."""
        box = QMessageBox(parent)
        box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        box.setWindowTitle(title)
        box.setText(html)
        box.setDetailedText(details)
        box.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        box.setStandardButtons(QMessageBox.StandardButton.Close)
        box.setDefaultButton(QMessageBox.StandardButton.Close)
        box.open()


def _open(parent: QWidget, title: str, folder: Path | None, files: str) -> Path | None:
    return _path(QFileDialog.getOpenFileName(parent, title, str(folder or ""), files)[0])


def _save(parent: QWidget, title: str, suggestion: Path, files: str, suffix: str) -> Path | None:
    """Return the chosen name, with the usual ending if it has none."""
    path = _path(QFileDialog.getSaveFileName(parent, title, str(suggestion), files)[0])
    return path.with_name(path.name + suffix) if path is not None and not path.suffix else path


def _path(chosen: str) -> Path | None:
    return Path(chosen) if chosen else None
