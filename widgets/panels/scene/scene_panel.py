"""Choose the traffic that the rig is scored on: box data set, its origin, voxel edge and region of interest."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QPushButton, QWidget

from riglens.core.errors import InputError
from riglens.core.geometry import Vec3
from riglens.core.scene.grid import DEFAULT_ROI_M, DEFAULT_VOXEL_M, VoxelGrid
from riglens.core.study.voxel_choice import LADDER_M, ladder_grids
from riglens.widgets.panels.controls.building import button, plain_label
from riglens.widgets.panels.controls.style import MARGIN, plain_tip
from riglens.widgets.panels.fields.edits import IntegerEdit, NumberEdit
from riglens.widgets.panels.fields.form import ChoiceBox, Form, read, reason_of, write
from riglens.widgets.panels.fields.quantity import full_number, parse_number

AUTO = "Auto"
VOXEL_TIP = (
    "Edge of a voxel; smaller is finer and slower. Auto tries "
    + ", ".join(f"{edge:g}" for edge in LADDER_M)
    + " m and picks the coarsest with the same coverage as the finest."
)


@dataclass(frozen=True)
class SceneChoice:
    """Choice of a scene; `boxes` None is the bundled scenario, `frames` None counts those of the data set.

    `find_ground` puts the ground of box data at z = 0.

    `voxel_m` None chooses it by the scores. A stored POG (`pog`) fixes boxes and grid: it can only be replaced
    by other boxes.
    """

    boxes: Path | None = None
    origin_m: Vec3 = (0.0, 0.0, 0.0)
    frames: int | None = None
    find_ground: bool = False
    voxel_m: float | None = DEFAULT_VOXEL_M
    roi_m: Vec3 = DEFAULT_ROI_M
    pog: Path | None = None

    def replace(self, **changes: object) -> SceneChoice:
        """Return the choice with some fields changed; raise InputError when they do not agree, or a POG fixes them."""
        changed: SceneChoice = replace(self, **changes)  # type: ignore[arg-type]
        if changed.pog is not None and changed != self:
            raise InputError(
                f"{changed.pog.name} is a stored POG with voxels of {self.voxel_m:g} m; "
                "choose a box data set to change this"
            )
        if changed.voxel_m is None:
            ladder_grids(changed.roi_m)
        else:
            VoxelGrid(changed.voxel_m, changed.roi_m)
        return changed


class ScenePanel(Form):
    """Fields for a SceneChoice; loading takes time, so it waits for the button."""

    load_wanted = Signal(object)
    """The SceneChoice to load."""
    file_wanted = Signal()
    folder_wanted = Signal()
    """Request to choose a file or a folder of boxes; answer with `choose_boxes`."""

    def __init__(self, choice: SceneChoice, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._loaded = choice
        self._is_nothing_loaded = False
        self._add_data()
        self._add_grid()
        self._load = button(QPushButton("Load"), lambda: self.load_wanted.emit(self.choice), name="load")
        self._hint, self._picked = (plain_label(style="hint", wraps=True) for _ in range(2))
        self._picked.hide()
        for widget in (self._load, self._hint, self._picked):
            self.add_wide(widget)
        self.close_form()
        self.changed.connect(self.show_subject)
        self.show_subject(choice)

    @property
    def choice(self) -> SceneChoice:
        """The choice that the fields show."""
        subject = self.subject
        assert isinstance(subject, SceneChoice)
        return subject

    def choose_boxes(self, boxes: Path | None, origin_m: Vec3 = (0.0, 0.0, 0.0)) -> None:
        """Take another data set with its own origin; settings of the old one are dropped."""
        self.show_subject(
            self.choice.replace(boxes=boxes, origin_m=origin_m, frames=None, find_ground=False, pog=None)
        )

    def set_loaded(self, choice: SceneChoice, summary: str, picked: str = "", tried: str = "") -> None:
        """Show the current data, and why their voxel edge was chosen: a sentence, and the edges tried."""
        is_untouched = self.choice == self._loaded
        self._loaded, self._is_nothing_loaded = choice, False
        self._hint.setText(summary)
        self._picked.setText(picked)
        self._picked.setToolTip(plain_tip(tried))
        self._picked.setVisible(bool(picked))
        self.show_subject(choice if is_untouched else self.choice)

    def set_nothing_loaded(self) -> None:
        """Show that no data are loaded; the same ones can be tried again."""
        self._is_nothing_loaded = True
        self._hint.setText("No box data in use.")
        self.show_subject(self.choice)

    # ------------------------------------------------------------------ fields
    def _add_data(self) -> None:
        self.add_heading("Box data set")
        self._name = plain_label(style="boxes")
        self.add_row("Data", [self._name])
        buttons = []
        for text, tip, slot in (
            ("File…", "CSV, CSV.gz or Parquet table, or annotations.feather.", self.file_wanted.emit),
            (
                "Folder…",
                "Folder of nuScenes, Argoverse 2, KITTI, ONCE, ZOD, DAIR-V2X, OPV2V or CARLA, or of tables.",
                self.folder_wanted.emit,
            ),
            ("Bundled", "The bundled simulated town.", lambda: self.choose_boxes(None)),
        ):
            made = button(QPushButton(text), slot, tip)
            made.setStyleSheet("padding: 1px 3px")  # three of them beside each other in a narrow panel
            made.setMinimumWidth(made.fontMetrics().horizontalAdvance(text) + MARGIN)
            buttons.append(made)
        self.add_row("", buttons)
        tip = "Origin of the data set in the vehicle frame, m (nuScenes ego: -1.35 0 0)."
        self._add_triple("Origin (m)", "origin_m", "xyz", tip)
        ground = QCheckBox("Put at z = 0")
        ground.setAccessibleName("Ground")
        ground.setObjectName("find_ground")
        self.add_row(
            "Ground", [ground], "Estimate the ground from the bottoms of near boxes, and put it at z = 0."
        )
        self.bind_check(ground, lambda c: c.find_ground, _write_ground, "find_ground")
        frames = IntegerEdit(is_optional=True)
        frames.setPlaceholderText("as in the data")
        frames.setAccessibleName("Frames")
        self.add_row(
            "Frames", [frames], "Number of frames, if frames without boxes leave no trace in the data."
        )
        self.bind_edit(frames, lambda c: c.frames, _write_frames, "frames")

    def _add_triple(self, caption: str, field: str, parts: str, tip: str) -> None:
        edits = [NumberEdit(0.1) for _ in parts]
        for place, (part, edit) in enumerate(zip(parts, edits, strict=True)):
            edit.setAccessibleName(f"{caption} {part}")
            self.bind_edit(edit, read((field, place)), write((field, place)), f"{field}.{part}")
        self.add_row(caption, edits, tip)

    def _add_grid(self) -> None:
        self.add_heading("Grid")
        voxel = ChoiceBox()
        voxel.setEditable(True)
        voxel.setObjectName("voxel_m")
        voxel.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        voxel.addItems([AUTO, *(full_number(edge) for edge in LADDER_M)])
        line = voxel.lineEdit()
        assert line is not None
        line.editingFinished.connect(self._take_voxel)
        voxel.activated.connect(lambda _: self._take_voxel())
        self._voxel = voxel
        self.add_row("Voxel δ (m)", [voxel], VOXEL_TIP)
        self._add_triple("Region (m)", "roi_m", "LWH", "Length, width and height of the region of interest.")

    def _take_voxel(self) -> None:
        text = self._voxel.currentText().strip()
        try:
            voxel_m = None if text.lower() == AUTO.lower() else parse_number(text)
            self.show_subject(self.choice.replace(voxel_m=voxel_m))
        except (InputError, ValueError) as error:
            self.show_problem(f"Voxel: {reason_of(error)}")

    def show_subject(self, subject: SceneChoice) -> None:
        """Show a choice; enable the button when it differs from the current one, or chooses the voxel edge."""
        super().show_subject(subject)
        path = subject.pog or subject.boxes
        self._name.setText(path.name if path else "Bundled town")
        self._name.setToolTip(plain_tip(str(path or "The bundled simulated town.")))
        self._voxel.setCurrentText(AUTO if subject.voxel_m is None else full_number(subject.voxel_m))
        is_other = subject != self._loaded or subject.voxel_m is None
        self._load.setEnabled(is_other or self._is_nothing_loaded)
        self._load.setDefault(self._load.isEnabled())


def _write_ground(choice: SceneChoice, find_ground: bool) -> SceneChoice:
    if find_ground and choice.boxes is None:
        raise InputError("applies to a box data set, not to the bundled town or a stored POG")
    return choice.replace(find_ground=find_ground)


def _write_frames(choice: SceneChoice, frames: int | None) -> SceneChoice:
    if frames is not None and frames < 1:
        raise InputError(f"must be an integer ≥ 1 (got {frames})")
    return choice.replace(frames=frames)
