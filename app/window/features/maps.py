"""The map from above, and the selected sensor's view of one frame; both cost nothing while hidden."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt

from riglens.app.background.pictures import PictureRequest, SensorPicture, make_pictures
from riglens.app.window.docks import InSight
from riglens.app.window.feature import Feature
from riglens.app.window.features.frame import FrameView
from riglens.app.window.workbench import Workbench
from riglens.core.figures.registry import voxel_set_named
from riglens.core.rig.model import Rig, Sensor
from riglens.core.sensors.registry import kind_of
from riglens.core.shown_text import visible
from riglens.core.view.camera_picture import CameraPicture
from riglens.core.view.top_view import TopView
from riglens.evaluation.requests import LoadedScene, Result
from riglens.widgets.maps.lowest_items import Lowest
from riglens.widgets.maps.map_panel import MapPanel
from riglens.widgets.maps.map_view import MANY
from riglens.widgets.maps.sensor_view import SensorViewPanel

if TYPE_CHECKING:  # made by the thread of the engine, which loads the compiler
    from riglens.core.blind.zones import BlindMap

LOADING, COMPUTING = "Loading box data", "Computing coverage"
NO_DATA = "No box data are loaded: choose some in the Scene panel"
LOOKING = "Computing the ground around the car"

NOTHING_SELECTED = "Select a sensor to see its view"
NO_PICTURE = "{kind} have no picture"
NO_SENSORS = "The rig has no sensors: add one to see its view here"
WAITING = "Drawing the picture"
OFF = "Disabled: this sensor is not included in the scores."
FAILED = "Failed: this would be its view; no figure includes it."


class Map(Feature):
    """Dock of the map, which follows the scores, and its layer on the ground of the 3D view; idle while hidden."""

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.panel = MapPanel()
        self._top: TopView | None = None
        self._blind: BlindMap | None = None
        self.dock = bench.docks.add(
            "Map", self.panel, Qt.DockWidgetArea.RightDockWidgetArea, beside="Inspector"
        )
        self.in_sight = InSight(self.dock)
        self.in_sight.changed.connect(lambda _: self._set_source())
        self.panel.shown_chosen.connect(self._set_source)
        self.panel.map.sensor_clicked.connect(self.document.select)
        self.panel.map.place_clicked.connect(self.viewport.look_at)
        self.in_sight.follow(
            self._follow_rig,
            self.document.rig_changed, self.document.selection_changed, self.document.hidden_changed,
        )  # fmt: skip
        self.session.scene_changed.connect(self._follow_scene)
        bench.answers.answered.connect(self._follow_result)
        bench.answers.forgotten.connect(self._show_none)
        bench.recompute.load_ended.connect(self._on_load_ended, Qt.ConnectionType.QueuedConnection)
        self.remember("map/shown", lambda: self.panel.shown, self.panel.choose)
        self.remember("map/ground", self.panel.on_ground.isChecked, self.panel.on_ground.setChecked)
        self.panel.map.set_message(LOADING)

    def _set_source(self) -> None:
        """Set the coverage that the session computes for the map: none while the map is hidden."""
        self.session.look_at_map(self.panel.seen_by if self.in_sight else None)
        is_on_map = bool(self.in_sight) and self.panel.lowest is not None
        self.session.look_around(is_on_map or self.panel.ground is not None)
        self._show_top()
        self._show_lowest()

    def _follow_rig(self) -> None:
        document = self.document
        self.panel.map.set_rig(document.rig, document.hidden, frozenset(document.selection))

    def _follow_scene(self, scene: LoadedScene) -> None:
        self._top = self._blind = None
        self.panel.map.set_grid(scene.field.grid)
        self.panel.map.set_gap(scene.gap)
        self.panel.map.set_message(COMPUTING)

    def _follow_result(self, result: Result) -> None:
        top = result.top_view
        if top is not None:
            self._top = top
            self._show_top()
        self._blind = result.blind
        if result.blind is not None:
            self._show_lowest()
        self._name_class()

    def _show_none(self) -> None:
        """Show no map of the rig before."""
        self._top = self._blind = None
        self.panel.map.set_top_view(None)
        self.panel.map.set_message(COMPUTING)
        self._show_lowest()

    def _name_class(self) -> None:
        """Show the class of the map; lowest heights have none."""
        self.panel.set_class("" if self.panel.lowest is not None else self.session.heat.class_name)

    def _show_lowest(self) -> None:
        """Show the lowest visible height around the car, if the map is set to it."""
        lowest, found = self.panel.lowest, self._blind
        self._name_class()
        if lowest is not None:
            self.panel.map.set_message("" if found is not None else LOOKING)
        self.panel.map.set_lowest(None if lowest is None or found is None else Lowest(found, *lowest))
        self._show_ground()

    def _show_ground(self) -> None:
        """Show the same map on the ground of the 3D view, if that is enabled."""
        state, ground, shown = self.viewport.state, self.panel.ground, None
        if ground is not None and self._blind is not None:
            from riglens.evaluation.ground_map import ground_map  # the compiler, loaded by now

            shown = ground_map(self._blind, *ground)
        if shown is not state.ground_map:
            self.viewport.show_state(replace(state, ground_map=shown))

    def _show_top(self) -> None:
        """Show the coverage, unless the map shows something else."""
        if self._top is not None and self.panel.seen_by is not None:
            self.panel.map.set_top_view(self._top)
            self.panel.map.set_message(remark(self._top, self.document.working_rig))

    def _on_load_ended(self, problem: str) -> None:
        if problem and self._top is None:
            self.panel.map.set_message(NO_DATA)


def remark(top: TopView, rig: Rig) -> str:
    """Return the remark on a map that shows nothing, or nothing seen; empty for any other."""
    if top.is_empty:
        return f"This data set has no {MANY[top.class_name]}: nothing to see or to miss"
    on = [sensor.kind for sensor in rig.sensors if sensor.enabled]
    lack = voxel_set_named(top.seen_by).lacks(on)
    return f"{lack}: everything is blind" if lack else ""


class SensorView(Feature):
    """A dock that follows selection, rig and scene; it costs nothing while it is out of sight."""

    def __init__(self, bench: Workbench, frame: FrameView) -> None:
        super().__init__(bench)
        self.panel, self.pictures = SensorViewPanel(), make_pictures(self)
        self._no_scene = LOADING
        self._asked: PictureRequest | None = None
        self._is_answered = True
        self.dock = bench.docks.add(
            "Sensor view", self.panel, Qt.DockWidgetArea.RightDockWidgetArea, beside="Inspector"
        )
        self.in_sight = InSight(self.dock)
        self.panel.frame_chosen.connect(lambda _: self._ask())
        frame.frame_chosen.connect(self._follow_frame)
        self.serve(self.pictures, self._show, self._on_failed)
        self.in_sight.follow(
            self._ask,
            self.document.rig_changed, self.document.selection_changed, self.document.vehicle_changed,
        )  # fmt: skip
        self._shown: tuple[Sensor, str] | None = None
        self.document.failed_changed.connect(self._show_notes)
        self.session.scene_changed.connect(self._on_scene)
        bench.recompute.load_ended.connect(self._on_load_ended, Qt.ConnectionType.QueuedConnection)

    @property
    def is_current(self) -> bool:
        """Return whether the picture shown is the one requested last."""
        return self._is_answered

    def _follow_frame(self, number: int) -> None:
        """Show the frame that the 3D view shows."""
        self.panel.choose_frame(number)
        self._ask()

    def forget_scene(self) -> None:
        """Forget a request, which holds the scene before, also out of sight."""
        self._asked = None

    def _on_scene(self, scene: LoadedScene) -> None:
        has_boxes = scene.options.pog is None
        self.panel.set_frames(scene.field.data.frames if has_boxes else 0)
        self._ask()

    def _on_load_ended(self, problem: str) -> None:
        if problem:
            self._no_scene = NO_DATA
            self._ask()

    def _ask(self) -> None:
        """Request the picture of the selected sensor, or show why there is none."""
        if not self.in_sight:
            return
        sensor, scene = self.document.selected_sensor(), self.session.scene
        if sensor is None or scene is None:
            self._asked, self._is_answered = None, True
            has_sensors = bool(self.document.rig.sensors)
            why = self._no_scene if scene is None else NOTHING_SELECTED if has_sensors else NO_SENSORS
            self.panel.show_text(why)
            return
        request = PictureRequest(
            sensor, self.panel.chosen_frame, scene, self.viewport.state.vehicle, self.document.rig.obstacles
        )
        if request != self._asked:
            self._asked, self._is_answered = request, False
            if self.panel.page is self.panel.text:
                self.panel.show_text(WAITING)
            self.pictures.ask(request)

    def _show(self, request: PictureRequest, picture: SensorPicture) -> None:
        """Show a picture of the selected sensor; also one for an earlier pose, until the next arrives."""
        sensor = self.document.selected_sensor()
        if request is self._asked:
            self._is_answered = True
        if sensor is None or sensor.name != request.sensor.name or request.scene is not self.session.scene:
            return
        self.panel.set_title(visible(sensor.name))
        self._shown = request.sensor, picture.note
        self._show_notes()
        if picture.image is None:
            self.panel.show_text(NO_PICTURE.format(kind=kind_of(request.sensor).plural))
        elif isinstance(picture.image, CameraPicture):
            self.panel.show_camera(picture.image)
        else:
            grid = request.scene.field.grid
            self.panel.show_ranges(picture.image, math.hypot(grid.roi_m[0], grid.roi_m[1]) / 2)

    def _show_notes(self) -> None:
        """Show remarks below the picture, and whether its sensor is included in the scores."""
        if self._shown is not None:
            shown, about = self._shown
            off = "" if shown.enabled else OFF
            failed = FAILED if shown.name in self.document.failed else ""
            self.panel.set_note(" ".join(note for note in (about, off, failed) if note))

    def _on_failed(self, problem: str) -> None:
        self._asked, self._is_answered = None, True
        self.panel.show_text(problem)
