"""Forms with every field of a LiDAR or a camera."""

from __future__ import annotations

import math
from typing import Any, Literal

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QCheckBox, QComboBox, QLabel, QWidget

from core.rig.library import default_library
from core.rig.model import Camera, Lidar
from widgets.panels.angles_field import AnglesField
from widgets.panels.form import ChoiceBox, Form, read_field, read_item, write_field, write_item
from widgets.panels.number_edit import IntegerEdit, NumberEdit, TextEdit, ValueEdit, thousands

STEP_M, STEP_DEG = 0.05, 1.0
POSE_TIP = (
    "x forward, y left, z up from the ground under the middle of the car; "
    "positive pitch looks down, positive yaw turns left"
)
FIELD_OF_VIEW, FOCAL_LENGTHS = "field of view", "focal lengths"
_NO_MODEL = "none"


class SensorForm(Form):
    """What every sensor has: name, kind, model, pose, range, and whether it counts."""

    def __init__(self, kind: Literal["lidar", "camera"], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._taken: frozenset[str] = frozenset()
        self._kind = kind
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

    def _write_name(self, sensor: Lidar | Camera, name: str) -> Any:
        if name in self._taken:
            raise ValueError(f"'{name}' is used by another sensor; names must be unique")
        return sensor.replace(name=name)

    def _add_pose(self) -> None:
        """Position on the left, rotation on the right."""
        self.add_heading("Position (m) and rotation (deg)")
        for place, (axis, angle) in enumerate(zip("xyz", ("roll", "pitch", "yaw"), strict=True)):
            along, about = NumberEdit(STEP_M), NumberEdit(STEP_DEG)
            caption = QLabel(angle)
            caption.setMinimumWidth(36)
            caption.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            self.add_row(axis, [along, caption, about], POSE_TIP)
            for edit, name, field in ((along, axis, "position"), (about, angle, "rpy_deg")):
                edit.setAccessibleName(name)
                self.bind_edit(edit, read_item(field, place), write_item(field, place), name)

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
            "Range (m)",
            {"range_min": NumberEdit(0.5), "range_max": NumberEdit(5.0)},
            "to",
            "range_m",
            "from, to in metres; ∞ or inf: up to the end of the region of interest",
        )


class LidarForm(SensorForm):
    """Every field of a LiDAR."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("lidar", parent)
        self.add_heading("Beams (deg)")
        self._angles = (
            AnglesField(self, "elevations_deg", "Elevations", "beam angles, both ends included"),
            AnglesField(self, "azimuths_deg", "Azimuths", "angles of one turn; the end is left out"),
        )
        self.add_range()
        self._summary = QLabel()
        self._summary.setObjectName("hint")
        self.add_wide(self._summary)
        self.close_form()

    def show_subject(self, subject: Lidar) -> None:
        """Show a LiDAR."""
        super().show_subject(subject)
        for angles in self._angles:
            angles.show_rows(subject)
        beams = len(subject.elevations())
        self._summary.setText(f"{beams} beams, {thousands(subject.ray_count)} rays")


class CameraForm(SensorForm):
    """Every field of a camera."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("camera", parent)
        self.add_heading("Image and lens")
        self.add_pair(
            "Image (px)",
            {"image_width": IntegerEdit(), "image_height": IntegerEdit()},
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
        self._summary = QLabel()
        self._summary.setObjectName("hint")
        self.add_wide(self._summary)
        self.close_form()

    def _add_lens(self) -> None:
        way = ChoiceBox()
        for text in (FIELD_OF_VIEW, FOCAL_LENGTHS):
            way.addItem(text, text)
        self.add_row("Lens by", [way], "one field of view, or focal lengths and principal point in pixels")
        self.bind_choice(way, _lens_way, _write_lens_way, "lens.way")
        hfov = NumberEdit(1.0)
        hfov.setAccessibleName("field of view")
        self._hfov_row = self._add_optional(hfov, "hfov_deg", "HFOV (deg)", "horizontal field of view")
        self._focal_rows = [
            self._add_optional(NumberEdit(1.0), name, f"{name} (px)", tip)
            for name, tip in (
                ("fx", "focal length along the width"),
                ("fy", "focal length along the height"),
                ("cx", "principal point from the left edge"),
                ("cy", "principal point from the upper edge"),
            )
        ]

    def _add_optional(self, edit: NumberEdit, field: str, caption: str, tip: str) -> QWidget:
        """A row for one number that can be absent."""
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
        fx, fy, _, _ = subject.intrinsics_px()
        wide, high = (
            2 * math.degrees(math.atan(size / 2 / f)) for size, f in zip(subject.image, (fx, fy), strict=True)
        )
        rays = thousands(subject.ray_count)
        self._summary.setText(f"{wide:.1f}° × {high:.1f}°, fx {fx:.1f} px, {rays} rays")


def _write_model(sensor: Lidar | Camera, model: str | None) -> Lidar | Camera:
    """The sensor with the fields of a library model; without a model it keeps its fields."""
    if model == sensor.model:
        return sensor
    if model is None:
        plain: Lidar | Camera = sensor.replace(model=None)
        return plain
    changed: Lidar | Camera = (
        default_library().entry(model).sensor(sensor.name, sensor.pose).replace(enabled=sensor.enabled)
    )
    return changed


def _lens_way(camera: Camera) -> str:
    return FIELD_OF_VIEW if camera.hfov_deg is not None else FOCAL_LENGTHS


def _write_lens_way(camera: Camera, way: str) -> Any:
    """The same lens said the other way; a field of view cannot say an off-centre principal point."""
    if way == _lens_way(camera):
        return camera
    fx, fy, cx, cy = camera.intrinsics_px()
    if way == FOCAL_LENGTHS:
        return camera.replace(hfov_deg=None, fx=fx, fy=fy, cx=cx, cy=cy)
    hfov_deg = 2 * math.degrees(math.atan(camera.image[0] / 2 / fx))
    return camera.replace(hfov_deg=hfov_deg, fx=None, fy=None, cx=None, cy=None)
