"""Every field of the selected sensor, or of the rig and its vehicle when none is selected."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import PurePath
from typing import Any

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QComboBox, QPushButton, QScrollArea, QStackedWidget, QWidget

from riglens.core.figures.values import Values
from riglens.core.geometry import Pose
from riglens.core.rig.edits import partner_of
from riglens.core.rig.model import PARAMETRIC_BODIES, MeshPlacement, Rig, Vehicle
from riglens.core.sensors.registry import AnyKind, kind_of, shown_kinds
from riglens.core.vehicle.profile import reference_vehicle
from riglens.core.vehicle.standing import MountStatus
from riglens.widgets.panels.controls.building import button, plain_label
from riglens.widgets.panels.controls.scrolled import breakable, scrolled
from riglens.widgets.panels.controls.style import plain_tip
from riglens.widgets.panels.fields.edits import TextEdit
from riglens.widgets.panels.fields.form import ChoiceBox, Form
from riglens.widgets.panels.fields.model_rows import ModelRows
from riglens.widgets.panels.fields.quantity import DEGREES, METRES, Unit
from riglens.widgets.panels.inspector.sensor_forms import SensorForm

_NAMED = 3
"""Largest number of sensors that are named; of more, the number is shown."""
_SIZES = ("length", "width", "height", "rear_axle_x")


def with_body(rig: Rig, body: str) -> Rig:
    """Return the rig on another body; sizes that are still those of the old body become those of the new one."""
    vehicle, changes = rig.vehicle, {"body": body}
    if vehicle.body in PARAMETRIC_BODIES and body in PARAMETRIC_BODIES:
        old, new = reference_vehicle(vehicle.body), reference_vehicle(body)
        changes |= {
            name: getattr(new, name) for name in _SIZES if getattr(vehicle, name) == getattr(old, name)
        }
    return rig.replace(vehicle=vehicle.replace(**changes))


class MeshRows:
    """Scale, rotation and offset of the mesh, on a form over a rig; shown only while the body is a mesh file."""

    def __init__(self, form: Form) -> None:
        self._form, rows = form, ModelRows(form)
        self.size = plain_label(style="mesh_size", wraps=True)
        tip = "Scale the mesh to the length of the vehicle."
        self.fit = button(QPushButton("Fit to length"), tip=tip, name="mesh_fit")
        fields = [rows.add(MeshPlacement, name, ("vehicle", "mesh")) for name in MeshPlacement.model_fields]
        tip = "Length × width × height of the mesh in the vehicle frame."
        self._rows = [*fields, form.add_row("Mesh size", [self.size, self.fit], tip)]

    def show_for(self, vehicle: Vehicle) -> None:
        """Show the rows when the vehicle has a mesh file."""
        for row in self._rows:
            self._form.show_row(row, vehicle.has_mesh_file)


class Inspector(QStackedWidget):
    """Inspector that follows rig and selection; emits the user's changes, always as a validated copy."""

    sensors_edited = Signal(object)
    """Edited sensors, a dict by their previous names."""
    rig_edited = Signal(object)
    unlink_wanted = Signal()
    """The mirror pair of the sensor shown is to be dissolved."""
    mesh_wanted = Signal()
    """Request to choose a mesh file for the body."""
    fit_wanted = Signal()
    """Request to scale the mesh to the length of the vehicle."""
    units_changed = Signal(object)
    """The Units in which lengths and angles are shown from now on, as a tuple."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._rig_form = RigForm()
        self._form_of: dict[str, SensorForm] = {}
        self._shown: tuple[str, ...] = ()
        self._loss_of: str | None = None
        self._saved: Rig | None = None
        self._locked: frozenset[str] = frozenset()
        self._problems: Mapping[str, str] = {}
        self._units: tuple[Unit, ...] = (METRES, DEGREES)
        self.addWidget(_in_dock(self._rig_form))
        self._rig_form.changed.connect(self.rig_edited)
        self._rig_form.mesh_wanted.connect(self.mesh_wanted)
        self._rig_form.mesh_rows.fit.clicked.connect(self.fit_wanted)

    def _form_for(self, kind: AnyKind) -> SensorForm:
        """Return the form of a kind of sensor, made when the first sensor of the kind is shown."""
        if kind.name not in self._form_of:
            form = self._form_of[kind.name] = SensorForm(kind)
            self.addWidget(_in_dock(form))
            form.edited.connect(self.sensors_edited)
            form.unlink_wanted.connect(self.unlink_wanted)
            form.units_chosen.connect(self._choose_unit)
            form.show_units(*self._units)
        return self._form_of[kind.name]

    @property
    def form(self) -> Form:
        """The form that is shown."""
        area = self.currentWidget()
        assert isinstance(area, QScrollArea)
        form = area.widget()
        assert isinstance(form, Form)
        return form

    @property
    def units(self) -> tuple[Unit, ...]:
        """The units in which lengths and angles are shown."""
        return self._units

    def set_units(self, units: tuple[Unit, ...]) -> None:
        """Show every length and angle in these units."""
        self._units = units
        self._rig_form.set_units(*units)
        for form in self._form_of.values():
            form.show_units(*units)

    def _choose_unit(self, chosen: Unit) -> None:
        self.set_units(tuple(chosen if chosen.quantity == unit.quantity else unit for unit in self._units))
        self.units_changed.emit(self._units)

    def set_mesh_size(self, text: str, can_fit: bool) -> None:
        """Show how large the mesh of the body is, or why it has no size; and whether it can be fitted."""
        self._rig_form.mesh_rows.size.setText(text)
        self._rig_form.mesh_rows.fit.setEnabled(can_fit)

    def set_saved(self, rig: Rig) -> None:
        """Set the rig as last saved, to which a pose can be reset."""
        self._saved = rig

    def set_locked(self, locked: frozenset[str]) -> None:
        """Set the names of the sensors that are read-only."""
        self._locked = locked
        for form in self._form_of.values():
            form.set_locked(tuple(name for name in self._shown if name in locked))

    @property
    def loss_of(self) -> str | None:
        """Return the sensor whose loss is shown, greyed or not; None when there is none."""
        return self._loss_of

    def show_loss(self, now: Values, without: Values) -> None:
        """Show exact figures with and without the current sensor."""
        self._loss_of = self._shown[-1] if self._shown else None
        for form in self._form_of.values():
            form.marginal.show_loss(now, without)

    def show_no_loss(self, reason: str) -> None:
        """Show why there are no figures without the sensor."""
        self._loss_of = None
        for form in self._form_of.values():
            form.marginal.show_none(reason)

    def set_loss_stale(self) -> None:
        """Grey the loss without the sensor: it belongs to an earlier rig."""
        for form in self._form_of.values():
            form.marginal.set_stale(True)

    def show_mount_statuses(self, stands: Mapping[str, MountStatus], problems: Mapping[str, str]) -> None:
        """Show the mounts of sensors, and the problems with their places, by name."""
        self._problems = problems
        self._rig_form.show_mount_statuses(stands)
        self._show_places()

    def _show_places(self) -> None:
        lines = [(name, self._problems[name]) for name in self._shown if name in self._problems]
        is_alone = len(self._shown) == 1
        text = "\n".join(problem if is_alone else f"{name}: {problem}" for name, problem in lines)
        for form in self._form_of.values():
            form.show_place(text)

    def set_rig(self, rig: Rig, selection: tuple[str, ...]) -> None:
        """Show the selected sensors on the form of the last of them, or the rig."""
        form: Form = self._rig_form
        subjects: list[Any] = [rig]
        if selection:
            subjects = [rig.sensor(name) for name in selection]
            sensor_form = self._form_for(kind_of(subjects[-1]))
            sensor_form.set_taken_names(frozenset(s.name for s in rig.sensors) - {selection[-1]})
            sensor_form.set_cameras(rig.enabled_cameras())
            sensor_form.tools.set_saved(self._saved_poses(selection))
            sensor_form.set_partner(partner_of(rig, selection[0]) if len(selection) == 1 else None)
            form = sensor_form
        if form is not self.form or selection != self._shown:
            self.form.forget_input()
            form.forget_input()
        self._shown = selection
        self.setCurrentIndex([self._rig_form, *self._form_of.values()].index(form))
        form.show_several(subjects)
        self._show_places()
        self.set_locked(self._locked)

    def _saved_poses(self, names: tuple[str, ...]) -> dict[str, Pose]:
        sensors = self._saved.sensors if self._saved is not None else ()
        return {sensor.name: sensor.pose for sensor in sensors if sensor.name in names}


class RigForm(Form):
    """Name of the rig, and body and size of the vehicle."""

    mesh_wanted = Signal()
    """Request to choose a mesh file."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        name = TextEdit()
        name.setAccessibleName("Rig")
        self.add_row("Rig", [name])
        self.bind_edit(name, lambda rig: rig.name, lambda rig, value: rig.replace(name=value), "rig_name")
        self.add_heading("Vehicle")
        self._add_body()
        for field in _SIZES:
            ModelRows(self).add(Vehicle, field, ("vehicle",))
        self._summary = plain_label(style="hint", wraps=True)
        self._places = plain_label(style="warning", wraps=True)
        self.add_wide(self._summary)
        self.add_wide(self._places)
        self.show_mount_statuses({})
        self.close_form()

    def show_mount_statuses(self, stands: Mapping[str, MountStatus]) -> None:
        """Show which sensors are off the car's surface."""
        text = places_text(stands)
        self._places.setText(breakable(text))
        self._places.setVisible(bool(text))

    def _add_body(self) -> None:
        body = self._body = ChoiceBox()
        for known in PARAMETRIC_BODIES:
            body.addItem(known, known)
        body.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        tip = "Use a glTF, OBJ, STL or PLY file as the body of the car."
        choose = button(QPushButton("Mesh…"), self.mesh_wanted, tip, "mesh")
        self.add_row("Body", [body, choose])
        self.bind_choice(body, lambda rig: rig.vehicle.body, with_body, "body")
        ModelRows(self).add(Rig, "housings")
        self.mesh_rows = MeshRows(self)

    def _show_body(self, body: str) -> None:
        """Show a mesh file by its name alone, with its path in the tooltip."""
        if body not in PARAMETRIC_BODIES:
            self._body.setItemText(self._body.currentIndex(), PurePath(body).name)
        self._body.setToolTip(plain_tip(body))

    def show_subject(self, subject: Rig) -> None:
        """Show a rig."""
        super().show_subject(subject)
        self.mesh_rows.show_for(subject.vehicle)
        self._show_body(subject.vehicle.body)
        rays = sum(sensor.ray_count for sensor in subject.sensors if sensor.enabled)
        shown = shown_kinds(sensor.kind for sensor in subject.sensors if sensor.enabled)
        counted = [(kind, len(subject.enabled_of(kind.model))) for kind in shown]
        *first, last = (f"{count} {kind.title if count == 1 else kind.plural}" for kind, count in counted)
        counts = f"{', '.join(first)} and {last}"
        self._summary.setText(
            f"{counts} count in the scores: {rays:,} rays.\n\nSelect a sensor in the list or in the view to edit it."
            if subject.sensors
            else "No sensors yet. Add one in the toolbar, or drag a model from the library onto the car."
        )


def places_text(stands: Mapping[str, MountStatus]) -> str:
    """Describe in a line each which sensors are off the body, inside it or in the ground; empty when none is."""
    off_m = {name: found.away_m for name, found in stands.items() if found.is_far}
    in_m = {name: found.gap_m for name, found in stands.items() if found.inside and not found.below_ground}
    below = [name for name, found in stands.items() if found.below_ground]
    lines = [
        f"{_who(off_m)}: {_span(off_m)} off the body, bracket needed" if off_m else "",
        f"{_who(in_m)}: {_span(in_m)} inside the body: behind a panel, or the car has another shape"
        if in_m
        else "",
        f"{_who(below)}: below the ground" if below else "",
    ]
    return "\n".join(filter(None, lines))


def _span(lengths_m: Mapping[str, float]) -> str:
    low, high = (f"{limit(lengths_m.values()):.2f}" for limit in (min, max))
    return f"{low} m" if low == high else f"{low} to {high} m"


def _who(names: Collection[str]) -> str:
    return ", ".join(names) if len(names) <= _NAMED else f"{len(names)} sensors"


def _in_dock(form: Form) -> QScrollArea:
    """Return a form that a dock shows in its full width if it can, and that scrolls if it cannot."""
    area = scrolled(form)
    bar_px = area.verticalScrollBar().sizeHint().width()
    area.setMinimumWidth(form.minimumSizeHint().width() + bar_px)
    return area
