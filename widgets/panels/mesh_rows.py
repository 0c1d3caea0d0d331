"""The rows of the vehicle's form that place a mesh file, and what choosing another body means."""

from __future__ import annotations

from typing import Any

from riglens.core.rig.model import Rig, Vehicle
from riglens.widgets.car.profiles import PROFILES, reference_vehicle
from riglens.widgets.panels.expression import DEGREES, METRES, NO_UNIT, Unit
from riglens.widgets.panels.form import Form
from riglens.widgets.panels.number_edit import NumberEdit

_SIZES = ("length", "width", "height", "rear_axle_x")
_TRIPLES: tuple[tuple[str, str, tuple[str, str, str], float, Unit, str], ...] = (
    ("rpy_deg", "Mesh turned", ("mesh_roll", "mesh_pitch", "mesh_yaw"), 5.0, DEGREES, "roll, pitch, yaw"),
    ("offset", "Mesh moved", ("mesh_x", "mesh_y", "mesh_z"), 0.05, METRES, "x, y, z, after scale and turn"),
)


def with_body(rig: Rig, body: str) -> Rig:
    """The rig on another body; sizes that are still those of the old body become those of the new one."""
    vehicle, changes = rig.vehicle, {"body": body}
    if vehicle.body in PROFILES and body in PROFILES:
        old, new = reference_vehicle(vehicle.body), reference_vehicle(body)
        changes |= {
            name: getattr(new, name) for name in _SIZES if getattr(vehicle, name) == getattr(old, name)
        }
    return rig.replace(vehicle=vehicle.replace(**changes))


class MeshRows:
    """Scale, turn and offset of the mesh, on a form over a rig; seen only while the body is a mesh file."""

    def __init__(self, form: Form) -> None:
        self._form = form
        scale = NumberEdit(0.1, NO_UNIT)
        scale.setAccessibleName("Mesh scale")
        self._rows = [form.add_row("Mesh scale", [scale], "0.001 for a mesh in millimetres")]
        form.bind_edit(
            scale,
            lambda rig: rig.vehicle.mesh.scale,
            lambda rig, value: _with_mesh(rig, scale=value),
            "mesh_scale",
        )
        for field, caption, names, step, unit, tip in _TRIPLES:
            edits = [NumberEdit(step, unit) for _ in names]
            self._rows.append(form.add_row(caption, edits, tip))
            for place, (name, edit) in enumerate(zip(names, edits, strict=True)):
                edit.setAccessibleName(f"{caption} {name.removeprefix('mesh_')}")
                self._bind(edit, field, place, name)

    def _bind(self, edit: NumberEdit, field: str, place: int, name: str) -> None:
        def read(rig: Rig) -> Any:
            return getattr(rig.vehicle.mesh, field)[place]

        def write(rig: Rig, value: float) -> Rig:
            items = getattr(rig.vehicle.mesh, field)
            return _with_mesh(rig, **{field: (*items[:place], value, *items[place + 1 :])})

        self._form.bind_edit(edit, read, write, name)

    def show_for(self, vehicle: Vehicle) -> None:
        """Show the rows when the vehicle has a mesh file."""
        for row in self._rows:
            self._form.show_row(row, vehicle.has_mesh_file)


def _with_mesh(rig: Rig, **changes: Any) -> Rig:
    mesh = rig.vehicle.mesh.replace(**changes)
    return rig.replace(vehicle=rig.vehicle.replace(mesh=mesh))
