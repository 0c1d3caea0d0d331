"""Everything a scene shows, as one frozen value: a picture of it can be made again anywhere, at any size."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace

from riglens.core.footprint.ground import has_footprint
from riglens.core.geometry import Pose, Vec3
from riglens.core.rig.groups import Poses, centre_m
from riglens.core.rig.model import Rig, Sensor, Vehicle
from riglens.core.scene.grid import VoxelGrid
from riglens.core.scene.streets import StreetView
from riglens.core.vehicle.placing import FREE, PlacingRules
from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.drawing.camera import OrbitCamera
from riglens.widgets.gizmo.drag import GizmoMode, Space
from riglens.widgets.heatmap.scale import DEFAULT_LOOK, HeatLook
from riglens.widgets.sensors.ray_look import DEFAULT_RAYS, RayLook
from riglens.widgets.theme import DARK, Palette
from riglens.widgets.traffic.frame import ShownFrame
from riglens.widgets.viewport.ground_map import GroundMap
from riglens.widgets.viewport.masts import Mast, Stubs
from riglens.widgets.viewport.measured import Measured

_NEAR_M = 50.0


@dataclass(frozen=True)
class Caption:
    """Labels of a picture; empty ones are left out.

    `table` are rows of equal length: the first is the head, the first column names the rows, the rest are numbers.
    """

    title: str = ""
    subtitle: str = ""
    table: tuple[tuple[str, ...], ...] = ()
    note: str = ""


NO_CAPTION = Caption()


@dataclass(frozen=True)
class Marker:
    """A cube to point out: its centre and edge, metres."""

    centre_m: Vec3
    edge_m: float


@dataclass(frozen=True)
class Post:
    """Test object to mark, an upright cylinder on the ground, metres; whether the rig sees it."""

    x_m: float
    y_m: float
    radius_m: float
    height_m: float
    is_seen: bool


@dataclass(frozen=True)
class SceneState:
    """State of the scene: content, camera and colours.

    The sensor named `selected` is shown with its rays and handles, those `also_selected` in the same colour, those
    that have `failed` as ghosts without rays, the `hidden` ones not at all. Those in `fixed` cannot be dragged: they
    get no handles. A plain box is drawn of a vehicle whose mesh file has not been read. Rays end at the `solid_body`,
    where there is one. Without `show_selection` the selected sensor has the colour of its kind, but still the rays of
    a selected one. `skin_gain` colours the car by values at spots on its skin, in place of the heatmap. `ghosts` are
    sensors that are not in the rig, to be seen beside those that are. With `snap` drags end on round numbers, 0.05 m
    and 5 degrees; `placing` says how sensors are put on the car. Without `streets` it stands on a plain road.
    """

    vehicle: Vehicle = field(default_factory=Vehicle)
    solid_body: Vehicle | None = None
    rig: Rig = field(default_factory=Rig)
    hidden: frozenset[str] = frozenset()
    failed: frozenset[str] = frozenset()
    fixed: frozenset[str] = frozenset()
    selected: str | None = None
    also_selected: frozenset[str] = frozenset()
    grid: VoxelGrid = field(default_factory=VoxelGrid)
    heatmap: HeatmapData | None = None
    heat_look: HeatLook = DEFAULT_LOOK
    skin_gain: HeatmapData | None = None
    show_legend: bool = True
    caption: Caption = NO_CAPTION
    marker: Marker | None = None
    post: Post | None = None
    measured: Measured | None = None
    masts: tuple[Mast, ...] = ()
    stubs: Stubs | None = None
    ghosts: tuple[Sensor, ...] = ()
    traffic: ShownFrame | None = None
    streets: StreetView | None = None
    ground_map: GroundMap | None = None
    camera: OrbitCamera = field(default_factory=OrbitCamera)
    gizmo_mode: GizmoMode = "both"
    gizmo_space: Space = "local"
    show_gizmo: bool = True
    snap: bool = False
    placing: PlacingRules = FREE
    show_ground: bool = True
    show_selection: bool = True
    ray_look: RayLook = DEFAULT_RAYS
    palette: Palette = DARK

    def changed(self, after: SceneState) -> frozenset[str]:
        """Return the names of the fields in which another state differs from this one."""
        return frozenset(name for name in ALL_FIELDS if getattr(self, name) != getattr(after, name))

    @property
    def legend_data(self) -> HeatmapData | None:
        """Return the subject of the legend: the values on the skin, else the heatmap."""
        return self.heatmap if self.skin_gain is None else self.skin_gain

    @property
    def shows_footprints(self) -> bool:
        """Return whether footprints are drawn: not on a map of the ground."""
        return self.ray_look.fill == "ground" and self.ground_map is None

    @property
    def footprints_of(self) -> tuple[Sensor, ...]:
        """The sensors whose footprints are drawn."""
        return tuple(filter(has_footprint, self.enabled)) if self.shows_footprints else ()

    @property
    def shown(self) -> list[Sensor]:
        """The sensors that are not hidden."""
        return [sensor for sensor in self.rig.sensors if sensor.name not in self.hidden]

    def is_selected(self, name: str) -> bool:
        """Return whether a sensor is selected, alone or with others."""
        return self.show_selection and (name == self.selected or name in self.also_selected)

    @property
    def selected_sensor(self) -> Sensor | None:
        """The selected sensor, None when there is none or when it is hidden."""
        return next((sensor for sensor in self.shown if sensor.name == self.selected), None)

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """The mirror pairs of which both sensors are shown."""
        return [
            (sensor.mirror_of, sensor.name)
            for sensor in self.shown
            if sensor.mirror_of is not None and sensor.mirror_of not in self.hidden
        ]

    @property
    def held_poses(self) -> Poses:
        """Return the poses of all selected sensors, the current one last: a drag moves all of them."""
        names = self.also_selected | {self.selected}
        chosen = [sensor for sensor in self.rig.sensors if sensor.name in names]
        chosen.sort(key=lambda sensor: sensor.name == self.selected)
        return {sensor.name: sensor.pose for sensor in chosen}

    @property
    def frame_pose(self) -> Pose | None:
        """Return the pose that is moved: of the selected sensor, or the centre of several, turned like the current one.

        Along the car's axes the centre is not turned. None when the current sensor is not shown.
        """
        sensor, poses = self.selected_sensor, self.held_poses
        if sensor is None or len(poses) == 1:
            return None if sensor is None else sensor.pose
        rpy_deg = sensor.rpy_deg if self.gizmo_space == "local" else (0.0, 0.0, 0.0)
        return Pose(centre_m(pose.position_m for pose in poses.values()), rpy_deg)

    @property
    def gizmo_pose(self) -> Pose | None:
        """Return the pose of the gizmo; None also when one of the selected sensors cannot be moved."""
        return self.frame_pose if self.show_gizmo and not self.held_poses.keys() & self.fixed else None

    @property
    def far_away(self) -> tuple[str, ...]:
        """The shown sensors that are too far from the car for a picture of both."""
        reach_m = max(_NEAR_M, math.hypot(*self.grid.roi_m))
        return tuple(sensor.name for sensor in self.shown if math.hypot(*sensor.position) > reach_m)

    @property
    def enabled(self) -> list[Sensor]:
        """The sensors that are switched on and work, of those that are not hidden."""
        return [sensor for sensor in self.shown if sensor.enabled and sensor.name not in self.failed]

    def seen_by(self, camera: str, view: OrbitCamera) -> SceneState:
        """Return the scene as a camera's picture shows it, along its view: with its own bands selected, without what
        the window adds for editing."""
        return replace(
            self, camera=view, selected=camera, also_selected=frozenset(), show_selection=True, caption=NO_CAPTION,
            show_legend=False, show_gizmo=False, ray_look=replace(self.ray_look, shown=False), masts=(), stubs=None,
            ghosts=(), marker=None, measured=None, gizmo_mode="both", gizmo_space="local", snap=False,
        )  # fmt: skip

    def other_fans_differ(self, after: SceneState) -> bool:
        """Return whether the rays of any unselected sensor must be redrawn to show another state."""
        if (self.hidden, self.failed, self.selected) != (after.hidden, after.failed, after.selected):
            return True
        if self.solid_body != after.solid_body or self.rig.obstacles != after.rig.obstacles:
            return True
        old = [sensor for sensor in self.rig.sensors if sensor.name != after.selected]
        return old != [sensor for sensor in after.rig.sensors if sensor.name != after.selected]


ALL_FIELDS = frozenset(field.name for field in fields(SceneState))
"""Names of all fields of a state."""
