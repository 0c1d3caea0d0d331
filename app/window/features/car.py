"""The car in the view follows the vehicle of the rig; the mesh of a file is read in the background."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from riglens.app.background.tasks import Task
from riglens.app.window.feature import Feature
from riglens.core.errors import InputError
from riglens.core.rig.model import Vehicle
from riglens.core.scene.boxes import Progress
from riglens.core.vehicle.mesh import BodyMesh
from riglens.core.vehicle.mesh_file import mesh_name, mesh_path, read_mesh

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow


class Car(Feature):
    """Shows the vehicle's body; one that cannot be shown leaves the last good one."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._shown: tuple[Vehicle, Path | None] | None = None
        self._read: tuple[Path, BodyMesh] | None = None
        self._task: Task | None = None
        window.rig_shown.connect(self._follow)
        self.document.file_changed.connect(self._follow)
        window.inspector.mesh_wanted.connect(self._choose_mesh)

    def _follow(self) -> None:
        """Show the vehicle when it, or the file that its mesh comes from, is another."""
        vehicle = self.document.rig.vehicle
        path = mesh_path(vehicle.body, self._folder()) if vehicle.has_mesh_file else None
        if (vehicle, path) == self._shown:
            return
        is_other_file = self._shown is None or path != self._shown[1]
        self._shown = vehicle, path
        if path is None or (self._read is not None and self._read[0] == path):
            self._show(vehicle)
        elif is_other_file:
            self._load(path)

    def _show(self, vehicle: Vehicle) -> None:
        mesh = self._read[1] if vehicle.has_mesh_file and self._read is not None else None
        try:
            self.viewport.set_vehicle(vehicle, mesh)
        except InputError as error:
            self.window.report_error(str(error))

    def _load(self, path: Path) -> None:
        if self._task is not None:
            self._task.cancel()

        def read(progress: Progress) -> tuple[Path, BodyMesh]:
            return path, read_mesh(path, lambda: progress(0.0))

        self._task = self.window.tasks.run(f"Reading {path.name}", read, self._on_read)

    def _on_read(self, found: tuple[Path, BodyMesh]) -> None:
        self._read = found
        if self._shown is not None and self._shown[1] == found[0]:
            self._show(self._shown[0])

    def _folder(self) -> Path | None:
        return self.document.path.parent if self.document.path is not None else None

    def _choose_mesh(self) -> None:
        """Ask for a mesh file."""
        path = self.window.dialogs.mesh_file(self.window, self._folder())
        if path is not None:
            self.take_mesh(path)

    def take_mesh(self, path: Path) -> None:
        """Make a mesh file the body of the car."""
        rig = self.document.rig
        vehicle = rig.vehicle.replace(body=mesh_name(path, self._folder()))
        self.window.guarded(self.document.apply)(rig.replace(vehicle=vehicle), "another body")
