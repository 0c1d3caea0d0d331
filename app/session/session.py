"""Hold the state that decides what is computed and shown: rig, traffic, metric and display choices.

No widgets here. Panels show a session and send it the user's requests; features read it; its `request` is computed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from riglens.app.session.document import Document
from riglens.core.figures.heatmaps import OFF, HeatMap
from riglens.core.figures.registry import heat_map_named
from riglens.core.metric.scores import Body, MetricSettings
from riglens.core.rig.model import Rig
from riglens.core.scene.boxes import CLASSES
from riglens.core.targets.settings import TargetSettings
from riglens.evaluation.known_body import known_body
from riglens.evaluation.requests import EvaluationRequest, LoadedScene

if TYPE_CHECKING:  # loaded with the first scene
    from riglens.core.metric.voxel import Voxel
    from riglens.core.rig.body_mesh import BodyMesh
    from riglens.core.view.top_view import SeenBy


@dataclass(frozen=True)
class HeatChoice:
    """Key of the heatmap, or OFF, and its traffic class; the map from above shows the same class."""

    mode: str = "unseen"
    class_name: str = CLASSES[0]

    @property
    def map(self) -> HeatMap | None:
        """Return the heatmap, None for none."""
        return heat_map_named(self.mode)


class Session(QObject):
    """State of the session. A setter emits its change once, and nothing when the value is the same.

    Changes of the rig itself are emitted by `document`.
    """

    request_changed = Signal()
    """`request` may have changed; emitted after the signal of the change."""
    settings_changed = Signal()
    """Method, reading, camera weight of the metric, or whether the car's body blocks."""
    targets_changed = Signal()
    """Settings for counting points on objects."""
    heat_changed = Signal()
    baseline_changed = Signal()
    """Changes of the scores are counted from another rig."""
    voxel_changed = Signal()
    scene_changed = Signal(object)
    """A LoadedScene took the place of the one before; scores on it follow."""

    def __init__(self, document: Document, settings: MetricSettings, body: Body | None = None) -> None:
        super().__init__()
        self.document = document
        self._settings = settings
        self._targets = TargetSettings()
        self._heat = HeatChoice()
        self._pinned: Rig | None = None
        self._told_baseline = document.saved_rig
        self._voxel: Voxel | None = None
        self._map_source: SeenBy | None = None
        self._looks_around = False
        self._scene: LoadedScene | None = None
        self._body: Body | None = body
        self._meshes: dict[str, BodyMesh] = {}
        self._told_body = self.body
        document.rig_changed.connect(self._emit_body)
        document.rig_changed.connect(self.request_changed)
        document.failed_changed.connect(self.request_changed)
        document.file_changed.connect(self._emit_baseline)

    # ------------------------------------------------------------------ what it is
    @property
    def settings(self) -> MetricSettings:
        """Return method, reading and camera weight of the metric, and the body where one was given for all rigs."""
        return replace(self._settings, body=self._body)

    @property
    def body(self) -> Body:
        """Return whether the car's body blocks: as given for all rigs, else as set in the rig.

        A body in a mesh file is ignored as long as the file has not been read.
        """
        return known_body(self.rig, self._body)

    @property
    def body_wanted(self) -> Body:
        """Return the requested body, whether or not its mesh has been read."""
        return self._body or self.document.rig.body

    @property
    def solid_body(self) -> Body:
        """The body of blind zones, test objects and ranges: solid, as soon as a mesh has been read."""
        return known_body(self.rig, "blocks")

    @property
    def rig(self) -> Rig:
        """The rig of the document with the mesh of its body."""
        return self.with_mesh(self.document.rig)

    @property
    def working_rig(self) -> Rig:
        """The rig that figures are of: without what has failed, with the mesh of its body."""
        return self.with_mesh(self.document.working_rig)

    def with_mesh(self, rig: Rig) -> Rig:
        """Return a rig with the mesh of its body as it was read last; the same rig where there is no other to add."""
        mesh = self._meshes.get(rig.vehicle.body)
        return rig if mesh is rig.vehicle.body_mesh else rig.with_body_mesh(mesh)

    @property
    def targets(self) -> TargetSettings:
        """Return the settings for counting points on objects."""
        return self._targets

    @property
    def heat(self) -> HeatChoice:
        """Return the mode and class of the heatmap."""
        return self._heat

    @property
    def pinned(self) -> Rig | None:
        """The rig that was pinned as the baseline, None when the last saved one is the baseline."""
        return self._pinned

    @property
    def baseline(self) -> Rig:
        """The rig that changes of the scores are counted from: the pinned one, else the one last saved or opened."""
        return self.document.saved_rig if self._pinned is None else self._pinned

    @property
    def voxel(self) -> Voxel | None:
        """The voxel to explain, None when none is picked."""
        return self._voxel

    @property
    def scene(self) -> LoadedScene | None:
        """The traffic that was loaded last, None before the first."""
        return self._scene

    def request(self) -> EvaluationRequest:
        """Return the request for the current state."""
        document, heat = self.document, self._heat
        mode = heat.mode if heat.map is not None and heat.map.needs == "voxels" else OFF
        return EvaluationRequest(
            document.revision, self.working_rig, self.with_mesh(self.baseline), self.settings, mode, heat.class_name,
            document.is_dragging, self._map_source, self._voxel, self._looks_around,
        )  # fmt: skip

    # ------------------------------------------------------------------ what the user wants
    def set_body(self, body: Body | None) -> None:
        """Set the body mode of every car, instead of that of each rig; None for that of each rig."""
        if body != self._body:
            self._body = body
            self._told_body = self.body
            self.settings_changed.emit()
            self.request_changed.emit()

    def take_mesh(self, body: str, mesh: BodyMesh | None) -> None:
        """Take the mesh of the vehicle's body `body`, None when there is none, or none that can be read."""
        known = self.rig.vehicle.body_mesh
        self._meshes.pop(body, None)
        if mesh is not None:
            self._meshes[body] = mesh
        self._emit_body()
        if self.rig.vehicle.body_mesh is not known:
            self.request_changed.emit()

    def _emit_body(self) -> None:
        """Emit a change of the current rig's body; the caller emits that of the request."""
        if self.body != self._told_body:
            self._told_body = self.body
            self.settings_changed.emit()

    def set_settings(self, settings: MetricSettings) -> None:
        """Score by another method, reading or camera weight; the setting of the body stays the same."""
        settings = replace(settings, body=self._settings.body)
        if settings != self._settings:
            self._settings = settings
            self.settings_changed.emit()
            self.request_changed.emit()

    def set_targets(self, targets: TargetSettings) -> None:
        """Set how points on objects are counted."""
        if targets != self._targets:
            self._targets = targets
            self.targets_changed.emit()

    def set_heat(self, heat: HeatChoice) -> None:
        """Change the content of the heatmap."""
        if heat != self._heat:
            self._heat = heat
            self.heat_changed.emit()
            self.request_changed.emit()

    def pin(self, rig: Rig | None) -> None:
        """Make a rig the baseline, or with None the last saved one again."""
        if rig != self._pinned:
            self._pinned = rig
            self._emit_baseline(is_other_pin=True)

    def _emit_baseline(self, is_other_pin: bool = False) -> None:
        """Emit a change of the baseline; a pin is also emitted when it equals the last saved rig."""
        if is_other_pin or self.baseline != self._told_baseline:
            self._told_baseline = self.baseline
            self.baseline_changed.emit()
            self.request_changed.emit()

    def pick(self, voxel: Voxel | None) -> None:
        """Request the explanation of a voxel, or none."""
        if voxel != self._voxel:
            self._voxel = voxel
            self.voxel_changed.emit()
            self.request_changed.emit()

    def look_at_map(self, source: SeenBy | None) -> None:
        """Set the coverage that the map adds up; None when no view shows it, which needs no new result."""
        if source != self._map_source:
            self._map_source = source
            if source is not None:
                self.request_changed.emit()

    def look_around(self, is_wanted: bool) -> None:
        """Set whether blind zones are wanted; that none are needs no new result."""
        before, self._looks_around = self._looks_around, is_wanted
        if is_wanted and not before:
            self.request_changed.emit()

    def show_scene(self, scene: LoadedScene) -> None:
        """Switch to other traffic; the picked voxel of another grid is dropped."""
        before, self._scene = self._scene, scene
        if before is not None and before.field.grid != scene.field.grid:
            self.pick(None)
        self.scene_changed.emit(scene)
