"""The body of the car: parametric, or a mesh file that is read in the background, asked about its unit, and fitted."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from riglens.app.background.tasks import Task
from riglens.app.window.actions import Spec
from riglens.app.window.feature import Feature
from riglens.app.window.workbench import Workbench
from riglens.core.rig.body_mesh import BodyMesh
from riglens.core.rig.model import Vehicle
from riglens.core.scene.boxes import Progress
from riglens.core.vehicle.mesh import (
    fitted_scale,
    is_car_size,
    mesh_size_m,
    size_text,
    unit_scales,
)
from riglens.core.vehicle.mesh_file import mesh_name, mesh_path, read_mesh
from riglens.widgets.panels.controls.messages import Choices

STAND_IN, READING = "missing: replaced by a plain box", "reading…"


class Car(Feature):
    """The vehicle's body in the view; a plain box replaces it until a mesh file is read, and where it cannot be."""

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self._shown: tuple[Vehicle, Path | None] | None = None
        self._read: tuple[Path, BodyMesh] | None = None
        self._task: Task | None = None
        self._question = ""
        self._is_reading = False
        self.document.vehicle_changed.connect(self._follow)
        self.document.file_changed.connect(self._follow)
        inspector = bench.panels.inspector
        inspector.mesh_wanted.connect(self._choose_mesh)
        inspector.fit_wanted.connect(self.fit_to_length)
        self._follow()

    @property
    def mesh(self) -> BodyMesh | None:
        """The mesh of the vehicle shown; None for a parametric body, and while there is none to show."""
        path = None if self._shown is None else self._shown[1]
        return self._read[1] if self._read is not None and self._read[0] == path else None

    def _follow(self) -> None:
        """Show the vehicle when it, or the file that its mesh comes from, is another."""
        vehicle = self.document.rig.vehicle
        path = mesh_path(vehicle.body, self.document.folder) if vehicle.has_mesh_file else None
        if (vehicle, path) == self._shown:
            return
        is_other_file = self._shown is None or path != self._shown[1]
        self._shown = vehicle, path
        was_asked = bool(self._question) and self.bench.notes.message == self._question
        if was_asked:
            self.bench.notes.clear()
        self._show(vehicle)
        if was_asked:
            self._ask_unit()
        if path is not None and is_other_file and self.mesh is None:
            self._load(path)

    def _show(self, vehicle: Vehicle) -> None:
        mesh = self.mesh
        self.viewport.show_state(replace(self.viewport.state, vehicle=vehicle.with_body_mesh(mesh)))
        self.session.take_mesh(vehicle.body, mesh)
        said = READING if self._is_reading else STAND_IN
        if mesh is not None:
            said = size_text(mesh_size_m(mesh, vehicle.mesh))
        self.bench.panels.inspector.set_mesh_size(said, can_fit=mesh is not None)

    def _load(self, path: Path) -> None:
        if self._task is not None:
            self._task.cancel()

        def read(progress: Progress) -> tuple[Path, BodyMesh]:
            return path, read_mesh(path, lambda: progress(0.0))

        inspector = self.bench.panels.inspector
        inspector.set_mesh_size(READING, can_fit=False)
        self._is_reading = True
        self._task = self.bench.tasks.run(
            f"Reading {path.name}", read, self._on_read, partial(self._on_ended, path)
        )

    def _on_ended(self, path: Path) -> None:
        """Say that a mesh is missing if reading has not brought it."""
        if self._shown is None or self._shown[1] != path:
            return
        self._is_reading = False
        if self.mesh is None:
            self.bench.panels.inspector.set_mesh_size(STAND_IN, can_fit=False)

    def _on_read(self, found: tuple[Path, BodyMesh]) -> None:
        if self._shown is None or self._shown[1] != found[0]:
            return
        self._read = found
        self._show(self._shown[0])
        self._ask_unit()

    # ------------------------------------------------------------------ unit and size
    def _ask_unit(self) -> None:
        """Ask which unit the file is in when the car would be none."""
        mesh, vehicle = self.mesh, self.document.rig.vehicle
        if mesh is None or is_car_size(size_m := mesh_size_m(mesh, vehicle.mesh)):
            return
        choices: Choices = {
            f"{unit.capitalize()}: {max(size_m) * scale / vehicle.mesh.scale:.2f} m": partial(
                self._scale, scale
            )
            for unit, scale in unit_scales(size_m, vehicle.mesh).items()
        }
        if fitted_scale(mesh, vehicle) is not None:
            choices[f"Fit to {vehicle.length:g} m"] = self.fit_to_length
        name = Path(vehicle.body).name
        self._question = f"{name}: the car would measure {size_text(size_m)}. Which unit does the file use?"
        self.bench.notes.show_message(self._question, choices=choices)

    def fit_to_length(self) -> None:
        """Scale the mesh so that it is as long as the vehicle."""
        scale = fitted_scale(self.mesh, self.document.rig.vehicle) if self.mesh is not None else None
        if scale is not None:
            self._scale(scale)

    def _scale(self, scale: float) -> None:
        rig = self.document.rig
        vehicle = rig.vehicle.replace(mesh=rig.vehicle.mesh.replace(scale=scale))
        self.bench.guarded(self.document.apply)(rig.replace(vehicle=vehicle), "scale of the mesh")

    # ------------------------------------------------------------------ choosing a file
    def _choose_mesh(self) -> None:
        """Ask for a mesh file."""
        path = self.bench.dialogs.mesh_file(self.bench.window, self.document.folder)
        if path is not None:
            self.take_mesh(path)

    def take_mesh(self, path: Path) -> None:
        """Make a mesh file the body of the car; the current one is read again."""
        rig = self.document.rig
        vehicle = rig.vehicle.replace(body=mesh_name(path, self.document.folder))
        if vehicle == rig.vehicle:
            self._read, self._shown = None, None
            self._follow()
            return
        self.bench.guarded(self.document.apply)(rig.replace(vehicle=vehicle), "another body")


class SolidCar(Feature):
    """Switch for self-occlusion: rays end at the car's own body; the state is shown in the status bar."""

    specs = (
        Spec(
            "solid_car", "Solid car",
            "Let rays end at the car's own body in the scores; off, they pass through it, as in the paper.",
            "B", "car",
            "scene/body", "heat", is_checkable=True,
        ),
    )  # fmt: skip

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.bind(solid_car=self._switch)
        self.session.settings_changed.connect(self._show)
        self.document.file_changed.connect(self._show)
        self.document.vehicle_changed.connect(self._show)
        self._show()

    def _switch(self) -> None:
        """Edit the rig; a mode given for all rigs at the start ends with it."""
        is_solid = self.session.body_wanted != "blocks"
        self.session.set_body(None)
        self.document.apply(self.document.rig.replace(self_occlusion=is_solid))
        self._show()

    def _show(self) -> None:
        session = self.session
        self.actions["solid_car"].setChecked(session.body_wanted == "blocks")
        self.bench.status.show_body(session.body, is_mesh_missing=session.body != session.body_wanted)
