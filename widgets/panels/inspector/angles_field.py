"""Rows for the angles of a LiDAR: evenly spaced ones or a list of them."""

from __future__ import annotations

from functools import partial
from typing import Any

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QLabel, QWidget

from riglens.core.rig.model import EvenAngles, Lidar
from riglens.widgets.panels.fields.edits import IntegerEdit, ListEdit, NumberEdit, ValueEdit
from riglens.widgets.panels.fields.form import ChoiceBox, Form
from riglens.widgets.panels.fields.quantity import DEGREES

EVEN, LIST = "evenly spaced", "list"


class AnglesField(QObject):
    """Rows of a LiDAR's form for one of its two angle fields, `elevations_deg` or `azimuths_deg`."""

    def __init__(self, form: Form, field: str, caption: str, tip: str) -> None:
        super().__init__(form)
        self._form, self._field = form, field
        self._way = ChoiceBox()
        for way in (EVEN, LIST):
            self._way.addItem(way, way)
        form.add_row(caption, [self._way], tip)
        form.bind_choice(self._way, self._read_way, self._write_way, f"{field}.way")
        self._even_row = self._add_even(form, caption)
        self._list_row = self._add_list(form, caption)

    def show_rows(self, lidar: Lidar) -> None:
        """Show the row that fits how the angles are given."""
        is_even = isinstance(self._angles(lidar), EvenAngles)
        self._form.show_row(self._even_row, is_even)
        self._form.show_row(self._list_row, not is_even)

    def _add_even(self, form: Form, caption: str) -> QWidget:
        edits: list[tuple[str, ValueEdit[Any]]] = [
            ("from_", NumberEdit(1.0, DEGREES)),
            ("to", NumberEdit(1.0, DEGREES)),
            ("count", IntegerEdit()),
        ]
        low, high, count = (edit for _, edit in edits)
        fields = [low, QLabel("to"), high, QLabel("×"), count]
        row = form.add_row("", fields, "from, to × number of angles")
        for part, edit in edits:
            edit.keep_room_for("-180")
            title = part.rstrip("_")
            edit.setAccessibleName(f"{caption} {title}")
            form.bind_edit(
                edit,
                partial(self._read_part, part),
                partial(self._write_part, part),
                f"{self._field}.{title}",
            )
        return row

    def _add_list(self, form: Form, caption: str) -> QWidget:
        edit = ListEdit(DEGREES)
        edit.setAccessibleName(caption)
        row = form.add_row("", [edit], "angles, separated by commas")
        form.bind_edit(edit, self._read_list, self._write_list, f"{self._field}.list")
        return row

    # ------------------------------------------------------------------ values
    def _angles(self, lidar: Lidar) -> EvenAngles | tuple[float, ...]:
        angles: EvenAngles | tuple[float, ...] = getattr(lidar, self._field)
        return angles

    def _doubles(self, lidar: Lidar) -> tuple[float, ...]:
        array = lidar.elevations() if self._field == "elevations_deg" else lidar.azimuths()
        return tuple(float(angle) for angle in array)

    def _read_way(self, lidar: Lidar) -> str:
        return EVEN if isinstance(self._angles(lidar), EvenAngles) else LIST

    def _write_way(self, lidar: Lidar, way: str) -> Lidar:
        if way == self._read_way(lidar):
            return lidar
        angles = self._doubles(lidar)
        even = EvenAngles.model_validate({"from": min(angles), "to": max(angles), "count": len(angles)})
        return lidar.replace(**{self._field: even if way == EVEN else angles})

    def _read_part(self, part: str, lidar: Lidar) -> Any:
        angles = self._angles(lidar)
        return getattr(angles, part) if isinstance(angles, EvenAngles) else None

    def _write_part(self, part: str, lidar: Lidar, value: float) -> Lidar:
        angles = self._angles(lidar)
        if not isinstance(angles, EvenAngles):
            raise ValueError("its angles are a list, choose 'evenly spaced' for all first")
        return lidar.replace(**{self._field: angles.replace(**{part: value})})

    def _read_list(self, lidar: Lidar) -> tuple[float, ...] | None:
        angles = self._angles(lidar)
        return None if isinstance(angles, EvenAngles) else angles

    def _write_list(self, lidar: Lidar, values: tuple[float, ...]) -> Lidar:
        if not values:
            raise ValueError("found no angle, accepted are numbers in degrees such as -15, 0, 15")
        return lidar.replace(**{self._field: values})
