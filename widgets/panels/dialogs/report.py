"""Ask where a report goes and what it holds, before it is made."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QFormLayout,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from riglens.widgets.panels.controls.building import button, filled, plain_label
from riglens.widgets.panels.controls.style import MARGIN, SPACING, plain_tip
from riglens.widgets.panels.fields.form import ChoiceBox

FORMATS = {".html": "HTML page", ".pdf": "PDF"}
REPLACES = "The file exists and will be replaced."
_FILE_PX = 380


@dataclass(frozen=True)
class ReportChoice:
    """Choice in the dialog; `labels` are the words of the header, by field."""

    path: Path
    others: bool
    tolerance: bool
    labels: Mapping[str, str]
    opens: bool


class ReportDialog(QDialog):
    """File, contents and labels of a report; writes nothing itself."""

    wanted = Signal(object)
    """A ReportChoice is to be made into a report."""
    browse_wanted = Signal()

    def __init__(
        self, suggestion: Path, others: Sequence[str], draws: int, labels: Sequence[str], parent: QWidget
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Report")
        self.path = QLineEdit(str(suggestion))
        self.path.setMinimumWidth(_FILE_PX)
        self.path.textChanged.connect(self._on_path)
        self.format = ChoiceBox()
        for suffix, title in FORMATS.items():
            self.format.addItem(title, suffix)
        self.format.activated.connect(lambda _: self._change_suffix(self.format.currentData()))
        rigs = f"{len(others)} rig{'s' if len(others) > 1 else ''}" if others else "rigs"
        self.others = QCheckBox(f"Comparison with {rigs} of the Compare panel")
        self.others.setToolTip(plain_tip(", ".join(others) or "The Compare panel holds no other rig."))
        self.others.setEnabled(bool(others))
        self.others.setChecked(bool(others))
        self.tolerance = QCheckBox(f"Tolerance of mounts, {draws} draws")
        self.tolerance.setToolTip("Spread of the figures under mount errors; takes the most time.")
        self.tolerance.setChecked(True)
        self.labels = {name: QLineEdit() for name in labels}
        self.opens = QCheckBox("Open it once written")
        self.opens.setChecked(True)
        self.note = plain_label(style="hint", wraps=True)
        self.make = button(QPushButton("Create"), self._on_create, name="create")
        self.make.setDefault(True)
        self._build()
        self._on_path()

    def _build(self) -> None:
        browse = button(QPushButton("Browse…"), self.browse_wanted, name="browse")
        browse.setAutoDefault(False)
        cancel = button(QPushButton("Cancel"), self.reject, name="cancel")
        cancel.setAutoDefault(False)
        form = QFormLayout()
        form.setHorizontalSpacing(2 * MARGIN)
        form.addRow("File", filled(QHBoxLayout(), self.path, 1, browse, spacing=SPACING))
        form.addRow("Format", self.format)
        form.addRow("Contents", filled(QVBoxLayout(), self.others, self.tolerance, spacing=SPACING))
        for name, edit in self.labels.items():
            form.addRow(name.capitalize(), edit)
        form.addRow("", self.opens)
        buttons = filled(QHBoxLayout(), self.note, 1, cancel, self.make, spacing=SPACING)
        filled(QVBoxLayout(self), form, buttons, margins=(2 * MARGIN,) * 4, spacing=2 * SPACING)

    @property
    def choice(self) -> ReportChoice:
        """Return the choice."""
        labels = {name: edit.text().strip() for name, edit in self.labels.items()}
        return ReportChoice(
            Path(self.path.text().strip()), self.others.isChecked(), self.tolerance.isChecked(), labels,
            self.opens.isChecked(),
        )  # fmt: skip

    def recall(self, options: Mapping[str, str]) -> None:
        """Fill in what was chosen the last time: labels, and the format."""
        for name, edit in self.labels.items():
            edit.setText(options.get(name, ""))
        if options.get("format") in FORMATS:
            self._change_suffix(options["format"])

    @property
    def options(self) -> dict[str, str]:
        """Return labels and format."""
        return {**self.choice.labels, "format": self.format.currentData()}

    def show_path(self, path: Path) -> None:
        """Show a file that was chosen elsewhere."""
        self.path.setText(str(path))

    def show_problem(self, text: str) -> None:
        """Show why a report cannot be made."""
        self.note.setObjectName("warning")
        self.note.setText(text)
        self.note.style().polish(self.note)

    def _change_suffix(self, suffix: str) -> None:
        path = self.choice.path
        if path.name:
            self.path.setText(str(path.with_suffix(suffix)))
        self.format.setCurrentIndex(self.format.findData(suffix))

    def _on_path(self) -> None:
        """Follow the ending of the file, and say that it exists."""
        path = self.choice.path
        place = self.format.findData(path.suffix.lower())
        if place >= 0:
            self.format.setCurrentIndex(place)
        self.note.setObjectName("hint")
        self.note.setText(REPLACES if path.is_file() else "")
        self.note.style().polish(self.note)
        self.make.setEnabled(bool(path.name))

    def _on_create(self) -> None:
        if self.choice.path.suffix.lower() not in FORMATS:
            self.show_path(Path(f"{self.choice.path}{self.format.currentData()}"))
        self.wanted.emit(self.choice)
