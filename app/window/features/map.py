"""The map from above: which part of the uncertain space over each spot is seen, and where the rig is blind."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt

from riglens.app.evaluation.requests import LoadedScene, Result
from riglens.app.window.feature import Feature
from riglens.app.window.features.heat import Heat
from riglens.app.window.in_sight import InSight
from riglens.core.rig.model import Rig
from riglens.core.scene.top_view import SeenBy, TopView
from riglens.widgets.maps.map_panel import MapPanel
from riglens.widgets.maps.map_view import MANY

if TYPE_CHECKING:
    from riglens.app.window.main_window import MainWindow

LOADING = "Box data are being loaded"
NO_DATA = "No box data are loaded: choose some in the Scene panel"
OFF = {"any": "No sensor", "lidar": "No LiDAR", "camera": "No camera"}


class Map(Feature):
    """A dock that follows the scores; it costs nothing while it is out of sight."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.panel = MapPanel()
        self._top: TopView | None = None
        self.dock = window.add_dock(
            "Map", self.panel, Qt.DockWidgetArea.RightDockWidgetArea, beside="Inspector"
        )
        self.in_sight = InSight(self.dock)
        self.in_sight.changed.connect(self._on_sight)
        self.panel.seen_by_chosen.connect(lambda _: window.settings_changed.emit())
        self.panel.map.sensor_clicked.connect(self.document.select)
        self.panel.map.place_clicked.connect(self.viewport.look_at)
        window.rig_shown.connect(self._follow_rig)
        window.scene_shown.connect(self._follow_scene)
        window.result_shown.connect(self._follow_result)
        window.recompute.load_ended.connect(self._on_load_ended, Qt.ConnectionType.QueuedConnection)
        self.panel.map.set_message(LOADING)

    @property
    def seen_by(self) -> SeenBy | None:
        """What evaluations have to add up for the map, None while nobody looks at it."""
        return self.panel.seen_by if self.in_sight else None

    def _on_sight(self, is_seen: bool) -> None:
        if is_seen:
            self.window.settings_changed.emit()

    def _follow_rig(self) -> None:
        document = self.document
        self.panel.map.set_rig(document.rig, document.hidden, document.selected)

    def _follow_scene(self, scene: LoadedScene) -> None:
        self._top = None
        self.panel.map.set_grid(scene.field.grid)

    def _follow_result(self, result: Result) -> None:
        top = result.top_view
        if top is not None:
            self._top = top
            self.panel.map.set_top_view(top)
            self.panel.map.set_message(remark(top, result.request.rig))
        self.panel.set_class(self.window.feature(Heat).class_name)

    def _on_load_ended(self, problem: str) -> None:
        if problem and self._top is None:
            self.panel.map.set_message(NO_DATA)


def remark(top: TopView, rig: Rig) -> str:
    """What has to be said about a map that shows nothing, or nothing seen; empty for any other."""
    if top.is_empty:
        return f"This data set has no {MANY[top.class_name]}: there is nothing to see or to miss"
    kinds = {sensor.kind for sensor in rig.sensors if sensor.enabled}
    if not (kinds if top.seen_by == "any" else kinds & {top.seen_by}):
        return f"{OFF[top.seen_by]} is switched on: all of it is blind"
    return ""
