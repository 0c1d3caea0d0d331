"""Form with every field of a camera."""

from __future__ import annotations

import math
from typing import Any

from PySide6.QtWidgets import QWidget

from riglens.core.rig.model import Camera
from riglens.widgets.panels.expression import DEGREES, PIXELS
from riglens.widgets.panels.form import ChoiceBox, read_field, write_field
from riglens.widgets.panels.number_edit import IntegerEdit, NumberEdit
from riglens.widgets.panels.sensor_form import SensorForm

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
        hfov.setAccessibleName("field of view")
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
