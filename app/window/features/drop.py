"""Files dropped on the window: a rig is opened, traffic is loaded, a mesh becomes the body of the car."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QEvent, QMimeData, QObject, QTimer
from PySide6.QtGui import QDropEvent

from riglens.app.window.feature import Feature
from riglens.app.window.features.car import Car
from riglens.app.window.features.files import Files
from riglens.app.window.features.scene_data import SceneData
from riglens.app.window.workbench import Workbench
from riglens.core.vehicle.mesh_file import SUFFIXES

RIGS = (".yaml", ".yml", ".json", ".json.gz", ".urdf", ".toml")
TABLES = (".csv", ".csv.gz", ".parquet", ".feather")
POGS = (".npz",)
ACCEPTED = (
    "drop rigs (.yaml, .json, .urdf, .toml), box tables (.csv, .csv.gz, .parquet, .feather), "
    "stored POGs (.npz), box folders and meshes (.glb, .gltf, .obj, .ply, .stl)"
)


class Drop(Feature):
    """Accept local files from a file manager, anywhere on the window where no widget takes them."""

    def __init__(self, bench: Workbench, files: Files, scene_data: SceneData, car: Car) -> None:
        super().__init__(bench)
        self._files, self._scene_data, self._car = files, scene_data, car
        bench.window.setAcceptDrops(True)
        bench.window.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Accept dragged files; their kind is checked when they are dropped."""
        if isinstance(event, QDropEvent) and local_paths(event.mimeData()):
            event.acceptProposedAction()
            if event.type() == QEvent.Type.Drop:
                paths = local_paths(event.mimeData())
                QTimer.singleShot(
                    0, self, lambda: self.take(paths)
                )  # a question must not hold up the file manager
            return True
        return super().eventFilter(watched, event)

    def take(self, paths: list[Path]) -> None:
        """Open the first rig, load the first traffic and take the first mesh among some files."""
        kinds = [_kind(path) for path in paths]
        unknown = [path.name for path, kind in zip(paths, kinds, strict=True) if kind == ""]
        if unknown:
            self.bench.report_error(f"{unknown[0]}: cannot be opened; {ACCEPTED}")
        if "rig" in kinds:
            self._files.open_path(paths[kinds.index("rig")])
        traffic = [path for path, kind in zip(paths, kinds, strict=True) if kind in ("boxes", "pog")]
        if traffic:
            load = self.bench.guarded(self._scene_data.load_path)
            load(traffic[0], _kind(traffic[0]) == "pog")
        if "mesh" in kinds:
            self._car.take_mesh(paths[kinds.index("mesh")])


def local_paths(data: QMimeData) -> list[Path]:
    """Return the dropped files that are on this machine."""
    return [Path(url.toLocalFile()) for url in data.urls() if url.isLocalFile() and url.toLocalFile()]


def _kind(path: Path) -> str:
    """Return the kind of a dropped path by its name: "rig", "boxes", "pog", "mesh", or "" for anything else."""
    name = path.name.lower()
    if path.is_dir() or name.endswith(TABLES):
        return "boxes"
    if name.endswith(RIGS):
        return "rig"
    if name.endswith(SUFFIXES):
        return "mesh"
    return "pog" if name.endswith(POGS) else ""
