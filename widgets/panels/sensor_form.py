"""What the forms of LiDARs and cameras have in common: identity, pose, range, and what follows from them."""

from __future__ import annotations

from typing import Any, Literal

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel, QWidget

from riglens.core.geometry import Pose
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Sensor
from riglens.widgets.panels.derived import derived_rows
from riglens.widgets.panels.expression import DEGREES, METRES, Unit
from riglens.widgets.panels.form import ChoiceBox, Form, read_field, read_item, write_field, write_item
from riglens.widgets.panels.marginal_view import MarginalView
from riglens.widgets.panels.number_edit import NumberEdit, TextEdit
from riglens.widgets.panels.pose_tools import PoseTools
from riglens.widgets.panels.style import numbers_font
from riglens.widgets.panels.value_edit import ValueEdit

STEP_M, STEP_DEG = 0.05, 1.0
POSE_TIP = (
    "x forward, y left, z up from the ground under the middle of the car; "
    "positive pitch looks down, positive yaw turns left"
)
_NO_MODEL = "none"
_DERIVED = {
    "lidar": ("Rays", "Field of view", "Resolution", "Azimuth offsets"),
    "camera": ("Rays", "Field of view", "Focal length", "Resolution", "Distortion"),
}


LOCKED_NOTE = "Locked: unlock it in the list to edit it."
DISABLED_NOTE = "Disabled: it does not count in the scores."


class SensorForm(Form):
    """What every sensor has: name, kind, model, pose, range, whether it counts, and what it is worth."""

    units_chosen = Signal(object)
    """The Unit that lengths or angles shall be shown in."""

    def __init__(self, kind: Literal["lidar", "camera"], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._taken: frozenset[str] = frozenset()
        self._is_locked = False
        self._kind = kind
        self._state = QLabel()
        self._state.setObjectName("state")
        self._state.setWordWrap(True)
        self.add_wide(self._state)
        self._add_identity()
        self._add_pose()

    def set_taken_names(self, names: frozenset[str]) -> None:
        """Names of the other sensors, which this one cannot have."""
        self._taken = names

    def _add_identity(self) -> None:
        name = TextEdit()
        name.setAccessibleName("Name")
        self.add_row("Name", [name])
        self.bind_edit(name, read_field("name"), self._write_name, "name")
        model = ChoiceBox()
        model.addItem(_NO_MODEL, None)
        for entry in default_library().entries(self._kind):
            model.addItem(entry.title, entry.name)
            model.setItemData(model.count() - 1, entry.source, Qt.ItemDataRole.ToolTipRole)
        model.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        model.setMinimumContentsLength(8)
        self.add_row("Model", [model], "Choosing a model fills in the fields below")
        self.bind_choice(model, read_field("model"), _write_model, "model")
        enabled = QCheckBox("counts in the scores")
        self.add_row("Enabled", [enabled])
        self.bind_check(enabled, read_field("enabled"), write_field("enabled"), "enabled")

    def _write_name(self, sensor: Sensor, name: str) -> Sensor:
        if name in self._taken:
            raise ValueError(f"'{name}' is used by another sensor; names must be unique")
        return sensor.replace(name=name)

    def _add_pose(self) -> None:
        """Position on the left, rotation on the right."""
        self.tools = PoseTools()
        self.tools.pasted.connect(self._take_pose)
        self.tools.refused.connect(self.show_problem)
        self.tools.units_chosen.connect(self.units_chosen)
        self.add_wide(self.tools)
        for place, (axis, angle) in enumerate(zip("xyz", ("roll", "pitch", "yaw"), strict=True)):
            along, about = NumberEdit(STEP_M, METRES), NumberEdit(STEP_DEG, DEGREES)
            caption = QLabel(angle)
            caption.setMinimumWidth(36)
            caption.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            self.add_row(axis, [along, caption, about], POSE_TIP)
            for edit, name, field in ((along, axis, "position"), (about, angle, "rpy_deg")):
                edit.setAccessibleName(name)
                self.bind_edit(edit, read_item(field, place), write_item(field, place), name)

    def _take_pose(self, pose: Pose) -> None:
        """Another pose as one change."""
        self._try(self.tools, lambda sensor, value: sensor.with_pose(value), pose)

    def add_derived(self) -> None:
        """What follows from the fields, and what the rig would lose without the sensor."""
        self.add_heading("Derived")
        self._derived: dict[str, QLabel] = {}
        for caption in _DERIVED[self._kind]:
            value = QLabel()
            value.setFont(numbers_font(value.font()))
            value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            value.setObjectName(caption)
            self._derived[caption] = value
            self.add_row(caption, [value])
        self.add_heading("The rig without it")
        self.marginal = MarginalView()
        self.add_wide(self.marginal)

    def show_subject(self, subject: Any) -> None:
        """Show a sensor with what follows from its fields."""
        super().show_subject(subject)
        self.tools.set_pose(subject.pose)
        for caption, value in derived_rows(subject):
            self._derived[caption].setText(value)
        self._show_state()

    def set_locked(self, locked: bool) -> None:
        """Make every field read only, or editable again."""
        self._is_locked = locked
        self.set_fields_enabled(not locked)
        self.tools.set_editable(not locked)
        self._show_state()

    def _show_state(self) -> None:
        notes = [LOCKED_NOTE] if self._is_locked else []
        if self.subject is not None and not self.subject.enabled:
            notes.append(DISABLED_NOTE)
        self._state.setText("\n".join(notes))
        self._state.setVisible(bool(notes))

    def show_units(self, *units: Unit) -> None:
        """Show lengths and angles in these units."""
        self.set_units(*units)
        self.tools.show_units(*units)

    def add_pair(
        self, caption: str, edits: dict[str, ValueEdit[Any]], between: str, field: str, tip: str
    ) -> QWidget:
        """A row for the two items of a tuple with a sign between them; keys are the object names."""
        for place, (name, edit) in enumerate(edits.items()):
            edit.setAccessibleName(name.replace("_", " "))
            self.bind_edit(edit, read_item(field, place), write_item(field, place), name)
        first, second = edits.values()
        return self.add_row(caption, [first, QLabel(between), second], tip)

    def add_range(self) -> None:
        """Nearest and farthest distance that a ray covers."""
        self.add_pair(
            "Range",
            {"range_min": NumberEdit(0.5, METRES), "range_max": NumberEdit(5.0, METRES)},
            "to",
            "range_m",
            "from, to; ∞ or inf: up to the end of the region of interest",
        )


def _write_model(sensor: Sensor, model: str | None) -> Sensor:
    """The sensor with the fields of a library model; without a model it keeps its fields."""
    if model == sensor.model:
        return sensor
    if model is None:
        return sensor.replace(model=None)
    return default_library().entry(model).sensor(sensor.name, sensor.pose).replace(enabled=sensor.enabled)
