"""Every question the window asks in a dialog, in one object, so that tests and scripts can answer instead."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from itertools import count
from pathlib import Path
from typing import Literal

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog, QInputDialog, QMessageBox, QWidget

from riglens.core.formats.opening import ENDINGS
from riglens.widgets.panels.help.guide import Guide
from riglens.widgets.panels.help.shortcut_sheet import Group, ShortcutSheet

RIG_FILES = "Rig files (*.yaml *.yml);;All files (*)"
OPEN_FILES = (
    f"Rigs, also of other programs ({' '.join(f'*{ending}' for ending in (*ENDINGS, '.json.gz'))});;"
    "RigLens rigs (*.yaml *.yml);;All files (*)"
)
BOX_FILES = "Box tables (*.csv *.csv.gz *.parquet *.feather);;All files (*)"
MESH_FILES = "Meshes (*.glb *.gltf *.obj *.stl *.ply);;All files (*)"
PICTURES = "PNG pictures (*.png)"
TABLES = "CSV tables (*.csv)"
REQUIREMENTS = "Files of requirements (*.yaml *.yml);;All files (*)"
REPORTS = "Pages (*.html);;PDF (*.pdf)"
Unsaved = Literal["save", "discard", "cancel"]


class Dialogs:
    """Questions to the user in Qt's dialogs; None means that they changed their mind."""

    def open_rig(self, parent: QWidget, folder: Path | None) -> Path | None:
        """Ask for the rig file to open."""
        return _path(QFileDialog.getOpenFileName(parent, "Open a rig", str(folder or ""), OPEN_FILES)[0])

    def save_rig(self, parent: QWidget, suggestion: Path) -> Path | None:
        """Ask where to save the rig."""
        chosen = QFileDialog.getSaveFileName(parent, "Save the rig", str(suggestion), RIG_FILES)[0]
        return _with_suffix(_path(chosen), ".yaml")

    def export_rig(self, parent: QWidget, suggestion: Path, title: str, is_folder: bool) -> Path | None:
        """Ask where to write the rig in another format: a file, or a folder to make."""
        question = f"Name of the folder for {title}" if is_folder else f"Export as {title}"
        suffix = suggestion.suffix
        filter_ = "Folders (*)" if is_folder else f"Files (*{suffix});;All files (*)"
        chosen = _path(QFileDialog.getSaveFileName(parent, question, str(suggestion), filter_)[0])
        return chosen if is_folder else _with_suffix(chosen, suffix)

    def save_picture(self, parent: QWidget, suggestion: Path) -> Path | None:
        """Ask where to save the picture."""
        chosen = QFileDialog.getSaveFileName(parent, "Save the picture", str(suggestion), PICTURES)[0]
        return _with_suffix(_path(chosen), ".png")

    def save_table(self, parent: QWidget, suggestion: Path) -> Path | None:
        """Ask where to save a table."""
        chosen = QFileDialog.getSaveFileName(parent, "Save the table", str(suggestion), TABLES)[0]
        return _with_suffix(_path(chosen), ".csv")

    def save_report(self, parent: QWidget, suggestion: Path) -> Path | None:
        """Ask where to write the report."""
        chosen = QFileDialog.getSaveFileName(parent, "Write a report", str(suggestion), REPORTS)[0]
        return _with_suffix(_path(chosen), ".html")

    def requirements_file(self, parent: QWidget, folder: Path | None) -> Path | None:
        """Ask for the file of requirements to check against."""
        title = "Open a file of requirements"
        return _path(QFileDialog.getOpenFileName(parent, title, str(folder or ""), REQUIREMENTS)[0])

    def mesh_file(self, parent: QWidget, folder: Path | None) -> Path | None:
        """Ask for the mesh of the car's body."""
        return _path(QFileDialog.getOpenFileName(parent, "Open a mesh", str(folder or ""), MESH_FILES)[0])

    def box_file(self, parent: QWidget) -> Path | None:
        """Ask for the box table to score on."""
        return _path(QFileDialog.getOpenFileName(parent, "Open a box table", "", BOX_FILES)[0])

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
        box.open()


def _path(chosen: str) -> Path | None:
    return Path(chosen) if chosen else None


def _with_suffix(path: Path | None, suffix: str) -> Path | None:
    """Return the name with the usual ending if it has none."""
    return path.with_name(path.name + suffix) if path is not None and not path.suffix else path
