"""Forms with every field of a LiDAR or a camera."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, Literal

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel, QWidget

from riglens.core.geometry import Pose
from riglens.core.rig.library import default_library
from riglens.core.rig.model import Camera, Lidar, Sensor
from riglens.core.vehicle.standing import FAR_M
from riglens.widgets.panels.controls.scrolled import breakable
from riglens.widgets.panels.controls.style import numbers_font, plain_tip
from riglens.widgets.panels.fields.edits import IntegerEdit, NumberEdit, TextEdit, ValueEdit
from riglens.widgets.panels.fields.form import ChoiceBox, Form, read_field, read_item, write_field, write_item
from riglens.widgets.panels.fields.quantity import DEGREES, METRES, PIXELS, Unit
from riglens.widgets.panels.inspector.angles_field import AnglesField
from riglens.widgets.panels.inspector.marginal_view import MarginalView
from riglens.widgets.panels.inspector.pose_tools import PairLine, PoseTools
from riglens.widgets.panels.sensors.rows import derived_rows, model_note, modified_note

STEP_M, STEP_DEG = 0.05, 1.0
POSE_TIP = (
    "x forward, y left, z up from the ground under the middle of the car; "
    "positive pitch looks down, positive yaw turns left"
)
PLACE_TIP = (
    f"A sensor more than {FAR_M:g} m off every surface of the car needs something to stand on (our choice); one inside "
    "the body sees only through what the switch Solid car lets it"
)
_NO_MODEL, MODIFIED = "none", ", modified"
_DERIVED = {
    "lidar": ("Rays", "Field of view", "Resolution", "Azimuth offsets"),
    "camera": ("Rays", "Field of view", "Focal length", "Resolution", "Distortion"),
}


_PARTS = {"range_min": "from", "range_max": "to"}
_WORDS = {
    "elevations_deg": "Elevations",
    "azimuths_deg": "Azimuths",
    "azimuth_offsets_deg": "Azimuth offsets",
    "range_m": "Range",
    "hfov_deg": "HFOV",
    "cast": "Rays cast",
}
LOCKED_NOTE = "{names} locked: unlock in the list to edit."
SEVERAL_NOTE = "{count} selected: a number sets all of them, += 0.1 or -= 0.1 changes each."
OF_KIND_NOTE = "Model and {part} are for the {kinds} among them."
DISABLED_NOTE = "Disabled: it does not count in the scores."


class SensorForm(Form):
    """What every sensor has: name, kind, model, pose, range, whether it counts, and what it contributes."""

    edited = Signal(object)
    """Sensors as the user wants them, a dict by the names that they had."""
    unlink_wanted = Signal()
    """The mirror pair is to be dissolved."""
    units_chosen = Signal(object)
    """The Unit in which lengths or angles are to be shown."""
    words = _WORDS

    def __init__(self, kind: Literal["lidar", "camera"], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._taken: frozenset[str] = frozenset()
        self._locked: tuple[str, ...] = ()
        self._marked: int | None = None
        self._kind = kind
        self._state = QLabel()
        self._state.setObjectName("state")
        self._state.setWordWrap(True)
        self._state.setTextFormat(Qt.TextFormat.PlainText)
        self.add_wide(self._state)
        self._add_identity()
        self._add_pair()
        self._add_pose()

    def set_taken_names(self, names: frozenset[str]) -> None:
        """Set the names of the other sensors, which this one cannot take."""
        self._taken = names

    def _add_identity(self) -> None:
        self._name = name = TextEdit()
        name.setAccessibleName("Name")
        self.add_row("Name", [name])
        self.bind_edit(name, read_field("name"), self._write_name, "name")
        model = self._model = ChoiceBox()
        model.addItem(_NO_MODEL, None)
        for entry in default_library().entries(self._kind):
            model.addItem(entry.title, entry.name)
            model.setItemData(model.count() - 1, plain_tip(entry.origin()), Qt.ItemDataRole.ToolTipRole)
        model.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        model.setMinimumContentsLength(8)
        self.add_row("Model", [model], "Choosing a model fills in the fields below")
        self.bind_choice(model, read_field("model"), _write_model, "model")
        enabled = QCheckBox("counts in the scores")
        self.add_row("Enabled", [enabled])
        self.bind_check(enabled, read_field("enabled"), write_field("enabled"), "enabled")
        self.share(name, enabled)

    def _show_model(self, sensor: Sensor) -> None:
        """Say behind the title of the model whether the sensor is still as the library has it."""
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
        """Add the row that says which sensor this one is linked to."""
        self._pair = PairLine()
        self._pair.unlink.clicked.connect(self.unlink_wanted)
        self._pair_row = self.add_row("Mirror pair", [self._pair])
        self.set_partner(None)

    def set_partner(self, name: str | None) -> None:
        """Set the other sensor of the mirror pair, None without one."""
        self._pair.show_partner(name)
        self.show_row(self._pair_row, name is not None)

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
                self.bind_edit(edit, read_item(field, place), write_item(field, place), name)
                self.share(edit)
            positions.append(along)
            angles.append(about)
        for before, after in pairwise([*positions, *angles]):
            self.setTabOrder(before, after)  # the position as a whole, then the rotation
        self._place = QLabel()
        self._place.setObjectName("warning")
        self._place.setWordWrap(True)
        self._place.setTextFormat(Qt.TextFormat.PlainText)
        self._place.setToolTip(PLACE_TIP)
        self.add_wide(self._place)
        self.show_place("")

    def show_place(self, problem: str) -> None:
        """Say what is wrong with the place of the sensor, nothing when it is empty."""
        self._place.setText(breakable(problem))
        self._place.setVisible(bool(problem))

    @property
    def place(self) -> str:
        """What is said to be wrong with the place."""
        return self._place.text()

    def _take_poses(self, posed: Callable[[str, Pose], Pose]) -> None:
        """Take other poses as one change."""
        self._try(self.tools, lambda sensor, pose: sensor.with_pose(pose(sensor.name, sensor.pose)), posed)

    def deliver(self, before: Sequence[Any], after: Sequence[Any]) -> None:
        """Tell of changed sensors by the names that they had."""
        self.edited.emit({old.name: new for old, new in zip(before, after, strict=True)})

    def add_derived(self) -> None:
        """Add what follows from the fields, and what the rig would lose without the sensor."""
        self._derived_heading = self.add_heading("Derived")
        self._derived: dict[str, QLabel] = {}
        for caption in _DERIVED[self._kind]:
            value = QLabel()
            value.setFont(numbers_font(value.font()))
            value.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            value.setObjectName(caption)
            value.setWordWrap(True)
            self._derived[caption] = value
            self.add_row(caption, [value])
        self._loss_heading = self.add_heading("The rig without it")
        self.marginal = MarginalView()
        self.add_wide(self.marginal)

    def show_subject(self, subject: Any) -> None:
        """Show a sensor with what follows from its fields."""
        super().show_subject(subject)
        self.tools.set_pose(subject.pose)
        for caption, value in derived_rows(subject):
            self._derived[caption].setText(value)
        self._show_model(subject)
        self._show_state()

    def set_locked(self, names: tuple[str, ...]) -> None:
        """Make every field read only because these of the sensors shown are locked, or editable again."""
        self._locked = names
        self.set_fields_enabled(not names)
        self.tools.set_editable(not names)
        self._show_state()

    def _show_state(self) -> None:
        """Say what is special about what is shown: several, locked or switched off."""
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
        if is_alone and not self.subject.enabled:
            notes.append(DISABLED_NOTE)
        self._state.setText(breakable("\n".join(notes)))
        self._state.setVisible(bool(notes))

    def _several_note(self) -> str:
        note = SEVERAL_NOTE.format(count=len(self.beside) + 1)
        own = sum(isinstance(other, type(self.subject)) for other in self.beside) + 1
        if own == len(self.beside) + 1:
            return note
        kind, part = ("LiDAR", "beams") if self._kind == "lidar" else ("camera", "lens")
        kinds = kind if own == 1 else f"{own} {kind}s"
        return f"{note} {OF_KIND_NOTE.format(part=part, kinds=kinds)}"

    def show_units(self, *units: Unit) -> None:
        """Show lengths and angles in these units."""
        self.set_units(*units)
        self.tools.show_units(*units)

    def add_pair(
        self, caption: str, edits: dict[str, ValueEdit[Any]], between: str, field: str, tip: str
    ) -> QWidget:
        """Add a row for the two items of a tuple with a sign between them; keys are the object names."""
        for place, (name, edit) in enumerate(edits.items()):
            edit.setAccessibleName(f"{caption} {_PARTS.get(name, name.split('_')[-1])}")
            self.bind_edit(edit, read_item(field, place), write_item(field, place), name)
        first, second = edits.values()
        return self.add_row(caption, [first, QLabel(between), second], tip)

    def add_range(self) -> None:
        """Add the nearest and farthest distance that a ray covers."""
        edits: dict[str, ValueEdit[Any]] = {
            "range_min": NumberEdit(0.5, METRES), "range_max": NumberEdit(5.0, METRES),
        }  # fmt: skip
        tip = "from, to; ∞ or inf: up to the end of the region of interest"
        self.add_pair("Range", edits, "to", "range_m", tip)
        self.share(*edits.values())


def _write_model(sensor: Sensor, model: str | None) -> Sensor:
    """Return the sensor with the fields of a library model; without a model it keeps its fields."""
    if model == sensor.model:
        return sensor
    if model is None:
        return sensor.replace(model=None)
    return default_library().entry(model).sensor(sensor.name, sensor.pose).replace(enabled=sensor.enabled)


class LidarForm(SensorForm):
    """Every field of a LiDAR."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("lidar", parent)
        self.add_heading("Beams")
        self._angles = (
            AnglesField(self, "elevations_deg", "Elevations", "beam angles, both ends included"),
            AnglesField(self, "azimuths_deg", "Azimuths", "angles of one turn; the end is left out"),
        )
        self.add_range()
        self.add_derived()
        self.close_form()

    def show_subject(self, subject: Lidar) -> None:
        """Show a LiDAR."""
        super().show_subject(subject)
        for angles in self._angles:
            angles.show_rows(subject)


FIELD_OF_VIEW, FOCAL_LENGTHS = "field of view", "focal lengths"


class CameraForm(SensorForm):
    """Every field of a camera."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("camera", parent)
        self.add_heading("Image and lens")
        self.add_pair(
            "Image",
            {"image_width": IntegerEdit(unit=PIXELS), "image_height": IntegerEdit(unit=PIXELS)},
            "×",
            "image",
            "width, height",
        )
        self._add_lens()
        self.add_pair(
            "Rays cast",
            {"cast_columns": IntegerEdit(), "cast_rows": IntegerEdit()},
            "×",
            "cast",
            "columns, rows of the ray lattice; never more than the image has pixels",
        )
        self.add_range()
        self.add_derived()
        self.close_form()

    def _add_lens(self) -> None:
        way = ChoiceBox()
        for text in (FIELD_OF_VIEW, FOCAL_LENGTHS):
            way.addItem(text, text)
        self.add_row("Lens by", [way], "one field of view, or focal lengths and principal point in pixels")
        self.bind_choice(way, _lens_way, _write_lens_way, "lens.way")
        hfov = NumberEdit(1.0, DEGREES)
        hfov.setAccessibleName("HFOV")
        self._hfov_row = self._add_optional(hfov, "hfov_deg", "HFOV", "horizontal field of view")
        self._focal_rows = [
            self._add_optional(NumberEdit(1.0, PIXELS), name, name, tip)
            for name, tip in (
                ("fx", "focal length along the width"),
                ("fy", "focal length along the height"),
                ("cx", "principal point from the left edge"),
                ("cy", "principal point from the upper edge"),
            )
        ]

    def _add_optional(self, edit: NumberEdit, field: str, caption: str, tip: str) -> QWidget:
        """Add a row for one number that may be absent."""
        edit.setAccessibleName(edit.accessibleName() or field)
        row = self.add_row(caption, [edit], tip)
        self.bind_edit(edit, read_field(field), write_field(field), field)
        return row

    def show_subject(self, subject: Camera) -> None:
        """Show a camera."""
        super().show_subject(subject)
        by_angle = subject.hfov_deg is not None
        self.show_row(self._hfov_row, by_angle)
        for row in self._focal_rows:
            self.show_row(row, not by_angle)


def _lens_way(camera: Camera) -> str:
    return FIELD_OF_VIEW if camera.hfov_deg is not None else FOCAL_LENGTHS


def _write_lens_way(camera: Camera, way: str) -> Any:
    """Return the same lens given the other way; a field of view cannot express an off-centre principal point."""
    if way == _lens_way(camera):
        return camera
    fx, fy, cx, cy = camera.intrinsics_px()
    if way == FOCAL_LENGTHS:
        return camera.replace(hfov_deg=None, fx=fx, fy=fy, cx=cx, cy=cy)
    hfov_deg = 2 * math.degrees(math.atan(camera.image[0] / 2 / fx))
    return camera.replace(hfov_deg=hfov_deg, fx=None, fy=None, cx=None, cy=None)
