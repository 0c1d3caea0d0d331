"""The form with every field of a sensor, made from the fields of its model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QFormLayout, QLabel, QWidget

from riglens.core.geometry import Pose
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Camera, Sensor
from riglens.core.sensors.registry import AnyKind
from riglens.core.shown_text import visible_lines
from riglens.core.vehicle.placing import FAR_M
from riglens.widgets.panels.controls.building import plain_label
from riglens.widgets.panels.controls.scrolled import ElidedLabel, breakable
from riglens.widgets.panels.controls.style import numbers_font, plain_tip
from riglens.widgets.panels.fields.edits import NumberEdit, TextEdit
from riglens.widgets.panels.fields.form import ChoiceBox, Form, read, write
from riglens.widgets.panels.fields.model_rows import ModelRows, is_editable, titles_of
from riglens.widgets.panels.fields.quantity import DEGREES, METRES, Unit
from riglens.widgets.panels.inspector.marginal_view import MarginalView
from riglens.widgets.panels.inspector.pose_tools import PairLine, PoseTools
from riglens.widgets.panels.sensors.rows import derived_rows, model_note, modified_note
from riglens.widgets.sensors.appearance import appearance_of
from riglens.widgets.sensors.field_variants import FieldVariants

STEP_M, STEP_DEG = 0.05, 1.0
POSE_TIP = (
    "x forward, y left, z up from the ground under the middle of the car; positive pitch "
    "tilts down, positive yaw turns left."
)
PLACE_TIP = (
    f"A sensor more than {FAR_M:g} m off every surface of the car needs a bracket (our choice); one inside "
    "the body sees out only through glass, or where Solid car is off."
)
_NO_MODEL, MODIFIED = "none", ", modified"
_WIDEST = "Points a second"
"""The widest caption of all kinds: fields stay where they are when a sensor of another kind is selected."""
LOCKED_NOTE = "{names} locked: unlock in the list to edit."
SEVERAL_NOTE = "{count} selected: a number sets all of them; += 0.1 or -= 0.1 changes each."
OF_KIND_NOTE = "Model and {part} apply to the {kinds} among them."


class SensorForm(Form):
    """Form of a sensor: common fields, the fields of its kind, derived figures, and its contribution."""

    edited = Signal(object)
    """Edited sensors, a dict by their previous names."""
    unlink_wanted = Signal()
    """The mirror pair is to be dissolved."""
    units_chosen = Signal(object)
    """The Unit in which lengths or angles are to be shown."""

    def __init__(self, kind: AnyKind, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._taken: frozenset[str] = frozenset()
        self._cameras: tuple[Camera, ...] = ()
        self._locked: tuple[str, ...] = ()
        self._marked: int | None = None
        self._kind, self._look = kind, appearance_of(kind.name)
        self.words = titles_of(kind.model)
        self._state = plain_label(style="state", wraps=True)
        self.add_wide(self._state)
        self._add_identity()
        self._add_pair()
        self._add_pose()
        self._add_fields()
        self._add_derived()
        self._grid.setColumnMinimumWidth(0, self.fontMetrics().horizontalAdvance(_WIDEST))
        self.close_form()

    def set_taken_names(self, names: frozenset[str]) -> None:
        """Set the names of the other sensors, which this one cannot take."""
        self._taken = names

    def set_cameras(self, cameras: Sequence[Camera]) -> None:
        """Set the cameras of the rig, whose overlaps are shown."""
        self._cameras = tuple(cameras)

    def _add_identity(self) -> None:
        self._name = name = TextEdit()
        name.setAccessibleName("Name")
        self.add_row("Name", [name])
        self.bind_edit(name, read(("name",)), self._write_name, "name")
        model = self._model = ChoiceBox()
        model.addItem(_NO_MODEL, None)
        for entry in default_library().entries(self._kind.name):
            model.addItem(entry.title, entry.name)
            model.setItemData(model.count() - 1, plain_tip(entry.origin()), Qt.ItemDataRole.ToolTipRole)
        model.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        model.setMinimumContentsLength(8)
        self.add_row("Model", [model], "Choose a model to fill in the fields below.")
        self.bind_choice(model, read(("model",)), _write_model, "model")
        enabled = QCheckBox("include in scores")
        self.add_row("Enabled", [enabled])
        self.bind_check(enabled, read(("enabled",)), write(("enabled",)), "enabled")
        self.share(name, enabled)

    def _show_model(self, sensor: Sensor) -> None:
        """Show next to the model whether the sensor differs from the library."""
        index = self._model.currentIndex()
        marked = index if index >= 0 and modified_note(sensor) else None
        if marked != self._marked:
            if self._marked is not None:
                title = self._model.itemText(self._marked)
                self._model.setItemText(self._marked, title.removesuffix(MODIFIED))
            if marked is not None:
                self._model.setItemText(marked, self._model.itemText(marked) + MODIFIED)
            self._marked = marked
        self._model.setToolTip(plain_tip(model_note(sensor)))

    def _add_pair(self) -> None:
        """Add the row of the mirror pair."""
        self._pair = PairLine()
        self._pair.unlink.clicked.connect(self.unlink_wanted)
        self.add_row("Mirror pair", [self._pair])
        self.set_partner(None)

    def set_partner(self, name: str | None) -> None:
        """Set the other sensor of the mirror pair, None without one."""
        self._pair.show_partner(name)

    def _write_name(self, sensor: Sensor, name: str) -> Sensor:
        if name in self._taken:
            raise ValueError(f"'{name}' is used by another sensor; names must be unique")
        return sensor.replace(name=name)

    def _add_pose(self) -> None:
        """Add the pose: position on the left, rotation on the right."""
        self.tools = PoseTools()
        self.share(self.tools)
        self.tools.posed.connect(self._take_poses)
        self.tools.refused.connect(self.show_problem)
        self.tools.units_chosen.connect(self.units_chosen)
        self.add_wide(self.tools)
        self.add_problem_line()
        positions: list[QWidget] = []
        angles: list[QWidget] = []
        for place, (axis, angle) in enumerate(zip("xyz", ("roll", "pitch", "yaw"), strict=True)):
            along, about = NumberEdit(STEP_M, METRES), NumberEdit(STEP_DEG, DEGREES)
            caption = QLabel(angle)
            caption.setMinimumWidth(36)
            caption.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            self.add_row(axis, [along, caption, about], POSE_TIP)
            for edit, name, field in ((along, axis, "position"), (about, angle, "rpy_deg")):
                edit.setAccessibleName(name)
                path = (field, place)
                self.bind_edit(edit, read(path), write(path), name, path)
                self.share(edit)
            positions.append(along)
            angles.append(about)
        for before, after in pairwise([*positions, *angles]):
            self.setTabOrder(before, after)  # the position as a whole, then the rotation
        self._place = ElidedLabel()  # one line that keeps its room: fields below stay where they are
        self._place.setObjectName("warning")
        self.add_wide(self._place)
        self.show_place("")

    def show_place(self, problem: str) -> None:
        """Show the problem with the sensor's place, nothing when it is empty."""
        self._place.setText(visible_lines(problem).replace("\n", "; "))
        self._place.setToolTip(plain_tip("\n".join(filter(None, (problem, PLACE_TIP)))))

    @property
    def place(self) -> str:
        """Return the problem with the place."""
        return self._place.text()

    def _take_poses(self, posed: Callable[[str, Pose], Pose]) -> None:
        """Take other poses as one change."""
        self._try(self.tools, lambda sensor, pose: sensor.with_pose(pose(sensor.name, sensor.pose)), posed)

    def deliver(self, before: Sequence[Any], after: Sequence[Any]) -> None:
        """Emit changed sensors by their previous names."""
        self.edited.emit({old.name: new for old, new in zip(before, after, strict=True)})

    def _add_fields(self) -> None:
        """Add the fields of the kind in the order of its model, then the range."""
        self.add_heading(self._look.heading)
        model, variants = (
            self._kind.model,
            {field: variants for variants in self._look.variants for field in variants.fields},
        )
        self._rows = ModelRows(self)
        added: list[FieldVariants] = []
        for name in (name for name in model.model_fields if name not in Sensor.model_fields):
            if name not in variants:
                if is_editable(model.model_fields[name]):  # else it is for the rig file alone
                    self._rows.add(model, name)
            elif variants[name] not in added:
                self._rows.add_variants(model, variants[name])
                added.append(variants[name])
        ModelRows(self, is_shared=True).add(model, "range_m")
        self._rows.add(model, "blocked")

    def _add_derived(self) -> None:
        """Add the derived figures, and the loss without the sensor."""
        self._derived_heading = self.add_heading("Derived")
        self._derived = DerivedRows()
        self.add_wide(self._derived)
        self._loss_heading = self.add_heading("The rig without it")
        self.marginal = MarginalView()
        self.add_wide(self.marginal)

    def show_subject(self, subject: Any) -> None:
        """Show a sensor with what follows from its fields."""
        super().show_subject(subject)
        self.tools.set_pose(subject.pose)
        self._rows.show_ways(subject)
        self._derived.show_rows(derived_rows(subject, self._cameras))
        self._show_model(subject)
        self._show_state()

    def set_locked(self, names: tuple[str, ...]) -> None:
        """Make every field read only because these of the sensors shown are locked, or editable again."""
        self._locked = names
        self.set_fields_enabled(not names)
        self.tools.set_editable(not names)
        self._show_state()

    def _show_state(self) -> None:
        """Show the special state of the subject: several, or locked."""
        if self.subject is None:
            return
        is_alone = not self.beside
        self._name.setEnabled(is_alone and not self._locked)
        self.tools.set_alone(is_alone)
        name = breakable(self.subject.name)
        self._derived_heading.setText("Derived" if is_alone else f"Derived, {name}")
        self._loss_heading.setText(f"The rig without {'it' if is_alone else name}")
        notes = [] if is_alone else [self._several_note()]
        if self._locked:
            notes.append(LOCKED_NOTE.format(names=", ".join(self._locked)))
        self._state.setText(breakable("\n".join(notes)))
        self._state.setVisible(bool(notes))

    def _several_note(self) -> str:
        note = SEVERAL_NOTE.format(count=len(self.beside) + 1)
        own = sum(isinstance(other, type(self.subject)) for other in self.beside) + 1
        if own == len(self.beside) + 1:
            return note
        kinds = self._kind.title if own == 1 else f"{own} {self._kind.plural}"
        return f"{note} {OF_KIND_NOTE.format(part=self._look.heading.lower(), kinds=kinds)}"

    def show_units(self, *units: Unit) -> None:
        """Show lengths and angles in these units."""
        self.set_units(*units)
        self.tools.show_units(*units)


class DerivedRows(QWidget):
    """Captions and values that follow from the fields of a sensor."""

    def __init__(self) -> None:
        super().__init__()
        self._form = QFormLayout(self)
        self._form.setContentsMargins(0, 0, 0, 0)
        self._form.setLabelAlignment(Qt.AlignmentFlag.AlignLeft)
        self._values: dict[str, QLabel] = {}

    def show_rows(self, rows: Sequence[tuple[str, str]]) -> None:
        """Show values; the captions are the same for all sensors of a kind."""
        for caption, text in rows:
            if caption not in self._values:
                value = self._values[caption] = QLabel()
                value.setFont(numbers_font(value.font()))
                value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
                value.setObjectName(caption)
                value.setWordWrap(True)
                self._form.addRow(caption, value)
            self._values[caption].setText(breakable(text))


def _write_model(sensor: Sensor, model: str | None) -> Sensor:
    """Return the sensor with the fields of a library model; without a model it keeps its fields."""
    if model == sensor.model:
        return sensor
    if model is None:
        return sensor.replace(model=None)
    return default_library().entry(model).sensor(sensor.name, sensor.pose).replace(enabled=sensor.enabled)
