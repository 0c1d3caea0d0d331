"""Whole 3D scene on any pyvista plotter: the one drawing path of window, offscreen pictures and tests.

No Qt here. Methods change what is shown but draw nothing; `prepare` brings everything up to date for one
frame, and the owner of the plotter renders it.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from dataclasses import replace
from time import perf_counter

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from riglens.core.geometry import Pose, Vec3
from riglens.core.rig.groups import Poses
from riglens.core.rig.model import Sensor
from riglens.core.vehicle.placing import placed
from riglens.widgets.car.layer import BodyLayer
from riglens.widgets.drawing.camera import WIDEST_M, OrbitCamera, Pixel, Size, ViewRay, framed, view_camera
from riglens.widgets.drawing.label import Box
from riglens.widgets.drawing.stage import Stage
from riglens.widgets.drawing.standing import Clock, Standing
from riglens.widgets.gizmo.drag import SNAP_M, Handle
from riglens.widgets.gizmo.handles import GizmoActors
from riglens.widgets.heatmap.drape import DrapeLayer
from riglens.widgets.heatmap.layer import HeatmapLayer
from riglens.widgets.sensors.bodies import sensor_body
from riglens.widgets.theme import DARK, Palette
from riglens.widgets.traffic.layer import TrafficLayer
from riglens.widgets.viewport.gain_layer import GainLayer
from riglens.widgets.viewport.ground_layer import REACH_M, GroundLayer, GroundMapLayer, RoiLayer
from riglens.widgets.viewport.marker_layer import MarkerLayer, PostLayer
from riglens.widgets.viewport.mast_layer import MastLayer, StubsLayer
from riglens.widgets.viewport.measure_layer import MeasureLayer
from riglens.widgets.viewport.measured import BODY, GROUND, Place
from riglens.widgets.viewport.place_words import PlaceWordsLayer
from riglens.widgets.viewport.rig_layer import RigLayer
from riglens.widgets.viewport.scene_state import ALL_FIELDS, SceneState
from riglens.widgets.viewport.under_mouse import UnderMouse
from riglens.widgets.viewport.words_layer import WordsLayer

# What parts of the scene are made from, by the names of SceneState's fields.
_BODIES = {"rig", "hidden", "failed", "selected", "also_selected", "show_selection", "palette"}
_FANS = {"solid_body", "rig", "hidden", "failed", "selected", "show_selection", "palette"}
_ALL_FANS = {"grid", "ray_look", "palette", "ground_map"}
_HEAT = {"heatmap", "skin_gain"}
_KEY = {
    "rig",
    "hidden",
    "failed",
    "selected",
    "show_selection",
    "show_legend",
    "ray_look",
    "palette",
    "ground_map",
}
_BACKDROP = ("camera", "grid", "palette", "show_ground", "streets", "vehicle")
_CENTRE_PX = 8.0
"""So near to the middle plane a sensor that snaps is put on it."""


_BEHIND_M = 0.01
"""Distance in metres: what is farther behind the car's surface is hidden by it."""
_FAR_M = 300.0
"""Beyond this the ground is not measured: near the horizon a pixel is many metres."""


class DrawnScene:
    """A scene on a plotter; `pixel_ratio` scales lines, letters and handles for dense or large pictures.

    One that `awaits_footprints` draws coarse ones until others have found them, and called `update_footprints`.
    """

    def __init__(
        self,
        plotter: pv.BasePlotter,
        palette: Palette = DARK,
        pixel_ratio: float = 1.0,
        clock: Clock = perf_counter,
        awaits_footprints: bool = False,
    ) -> None:
        self._pixel_ratio = pixel_ratio
        self._state = SceneState(palette=palette)
        self._hovered: str | Handle | None = None
        self._quick = self._smooth = False
        self._covered: list[Box] = []
        self._stage = stage = Stage(plotter)
        self._haze: tuple[object, ...] = ()
        self._fans_due: bool | None = None
        self._cell_m: float | None = None
        self._ground, self._roi = GroundLayer(stage.backdrop), RoiLayer(stage.main)
        self._ground_map, self._post = GroundMapLayer(stage.main), PostLayer(stage.main)
        self._skin_gain = GainLayer(stage.main)
        # footprints lie below the drape, in this order
        self._rig = RigLayer(stage.main, stage.rays, stage.haze, awaits_footprints)
        self._drape = DrapeLayer(stage.main)
        self._standing = Standing(stage, clock, (self._ground_map.prop,), (self._drape.prop,))
        self._body = BodyLayer(stage.main, stage.backdrop)
        self._heatmap = HeatmapLayer(stage.cells, stage.haze)
        self._traffic = TrafficLayer(stage.main)
        self._traffic.set_pixel_ratio(pixel_ratio)
        self._masts, self._stubs = MastLayer(stage.main, stage.overlay), StubsLayer(stage.main)
        self._places = PlaceWordsLayer(stage.overlay)
        self._marker, self._words = MarkerLayer(stage.overlay), WordsLayer(stage.overlay)
        self._measure = MeasureLayer(stage.overlay)
        self._gizmo = GizmoActors(stage.overlay, palette)
        self._rig.set_line_width(pixel_ratio)
        self._ground.set_line_width(pixel_ratio)
        self._has_car = False
        self._update(ALL_FIELDS, self._state)

    @property
    def state(self) -> SceneState:
        """Return the state that is shown."""
        return self._state

    @property
    def size(self) -> Size:
        """Width and height of the picture in pixels; once the plotter is closed, the last ones."""
        return self._stage.size

    @property
    def pixel_ratio(self) -> float:
        """Pixels per logical pixel."""
        return self._pixel_ratio

    def set_pixel_ratio(self, pixel_ratio: float) -> None:
        """Follow a move to a screen of another density."""
        if pixel_ratio != self._pixel_ratio:
            self._pixel_ratio = pixel_ratio
            self._rig.set_line_width(pixel_ratio)
            self._ground.set_line_width(pixel_ratio)
            self._traffic.set_pixel_ratio(pixel_ratio)

    def show(self, state: SceneState) -> None:
        """Show a state; only layers that differ from the state shown before are rebuilt."""
        before, self._state = self._state, state
        changed = before.changed(state)
        self._update(changed, before)
        if "vehicle" in changed or ("palette" in changed and self._has_car):
            self._show_car()

    def _update(self, changed: frozenset[str], before: SceneState) -> None:
        """Bring all layers except the car in line with the state, of which these fields have `changed`."""
        for fields, show in self._parts():
            if changed & fields:
                show(self._state)
        if changed & (_FANS | _ALL_FANS):
            all_fans = bool(changed & _ALL_FANS) or before.other_fans_differ(self._state)
            self._expect_fans(all_fans)

    def _expect_fans(self, others: bool) -> None:
        """Have fans rebuilt for the next frame, those of sensors that are not selected only with `others`: edits may
        follow one another, and those of 60 sensors take longer than all else."""
        self._fans_due = others or bool(self._fans_due)

    def _parts(self) -> tuple[tuple[set[str], Callable[[SceneState], None]], ...]:
        """Return the fields that each part but car and rays is made from, and what makes it, in this order."""
        words = self._words
        return (
            ({"palette"}, self._show_palette),
            (
                {"palette", "streets", "show_ground"},
                lambda s: self._ground.show(s.palette, s.streets, s.show_ground),
            ),
            ({"grid", "palette"}, lambda s: self._roi.set_grid(s.grid, s.palette)),
            ({"heat_look"}, lambda s: self._roi.set_shown(not s.heat_look.draped)),
            (_BODIES, lambda s: self._rig.show_bodies(s, self._hovered)),
            ({"ghosts", "palette"}, self._rig.show_ghosts),
            ({*_BODIES, "masts"} - {"failed"}, self._masts.show),
            ({"rig", "hidden", "ray_look", "stubs"}, self._stubs.show),
            ({"heat_look"}, lambda s: self._heatmap.set_look(s.heat_look)),
            (_HEAT | {"heat_look", "palette", "ground_map"}, self._show_heat),
            ({"vehicle", "skin_gain"}, lambda s: self._skin_gain.show(s.vehicle, s.skin_gain)),
            ({*_HEAT, "heat_look", "show_legend", "palette"}, words.show_legend),
            ({"post"}, lambda s: self._post.show(s.post)),
            ({"ground_map"}, lambda s: self._ground_map.show(s.ground_map)),
            ({"ground_map", "show_legend", "palette"}, words.show_ground_key),
            (_KEY, words.show_key),
            ({"caption", "palette"}, words.show_caption),
            ({"traffic", "palette"}, lambda s: self._traffic.set_frame(s.traffic, s.palette)),
            ({"measured", "palette"}, lambda s: self._measure.show(s.measured, s.palette)),
            ({"marker", "palette"}, lambda s: self._marker.set_marker(s.marker, s.palette)),
        )

    def _show_heat(self, state: SceneState) -> None:
        """Show the heatmap as cells in space or on the ground; none where the car's skin is coloured."""
        shown, look = state.heatmap if state.skin_gain is None else None, state.heat_look
        self._heatmap.set_data(None if look.draped else shown)
        self._drape.show(shown if look.draped and state.ground_map is None else None, look, state.palette)

    def _show_palette(self, state: SceneState) -> None:
        self._stage.backdrop.set_background(state.palette.horizon, top=state.palette.background_top)
        self._gizmo.set_palette(state.palette)

    def _show_car(self) -> None:
        self._body.set_vehicle(self._state.vehicle, self._state.palette)
        self._has_car = True

    def _bring_car(self) -> None:
        """Build the default car unless one was chosen: only now, because nothing takes longer to build."""
        if not self._has_car:
            self._show_car()

    def preview(self, poses: Poses) -> None:
        """Move some sensors with their fans and the gizmo, and nothing else."""
        rig = self._state.rig
        for name, pose in poses.items():
            rig = rig.with_sensor(name, rig.sensor(name).with_pose(pose))
            self._rig.set_pose(name, pose)
        self._state = replace(self._state, rig=rig)
        self._masts.show(self._state)
        self._stubs.show(self._state)
        self._expect_fans(any(name != self._state.selected for name in poses))

    def set_view(self, name: str, wide: bool = False) -> None:
        """Look from "iso", "top", "front", "left", "rear", "right" (else InputError); `wide`: iso over all the ROI."""
        width, height = self.size
        vehicle = self._state.vehicle
        size_m = (vehicle.length, vehicle.height)
        camera = view_camera(name, self._state.grid, width / max(1, height), wide, size_m)
        is_flat = self._state.camera.orthographic
        self.set_camera(replace(camera, orthographic=is_flat, parallel=camera.parallel or is_flat))

    def set_camera(self, camera: OrbitCamera) -> None:
        """Look through another camera."""
        self._state = replace(self._state, camera=camera)

    def frame(self, names: tuple[str, ...] = ()) -> None:
        """Look at these sensors from close by, keeping the direction; without names, at the car with all of them.

        Sensors too far away would make the car a dot: they are left out, and of such a group the last is shown.
        """
        state = self._state
        places_m = np.array([state.rig.sensor(name).position for name in names])
        if not names:
            vehicle, far = state.vehicle, state.far_away
            x_m, y_m = vehicle.length / 2, vehicle.width / 2
            near = [sensor.position for sensor in state.shown if sensor.name not in far]
            places_m = np.array([(-x_m, -y_m, 0.0), (x_m, y_m, vehicle.height), *near])
        elif np.ptp(places_m, axis=0).max() > WIDEST_M:
            places_m = places_m[-1:]
        self.set_camera(framed(state.camera, places_m, self.size))

    def set_hovered(self, hovered: str | Handle | None) -> bool:
        """Highlight a sensor (by name) or a handle; True when that changed anything."""
        if hovered == self._hovered:
            return False
        self._hovered = hovered
        self._rig.show_bodies(self._state, self._hovered)
        return True

    def set_quick(self, quick: bool) -> None:
        """Draw a coarser heatmap, fewer rays and large meshes with fewer triangles while something moves."""
        if quick != self._quick:
            self._quick = quick
            self._standing.forget()
            self._body.set_quick(quick)
            self._expect_fans(True)

    @property
    def lacks_footprints(self) -> bool:
        """Return whether a footprint is coarse or left out."""
        return self._rig.lacks_footprints

    def update_footprints(self) -> bool:
        """Show footprints that have been found meanwhile; return whether any was lacking."""
        lacked = self.lacks_footprints
        if lacked:
            self._expect_fans(True)
        return lacked

    @property
    def is_quick(self) -> bool:
        """Return whether it is drawn the way it is while something moves."""
        return self._quick

    def set_smooth(self, smooth: bool) -> None:
        """Smooth the edges of later frames, with a filter that costs a third of a frame at rest."""
        self._smooth = smooth

    def set_covered(self, box: Box | None) -> None:
        """Keep labels off pixels that a widget over the view covers."""
        self._covered = [] if box is None else [box]

    def set_echo(self, text: str, pixel: Pixel = (0.0, 0.0)) -> None:
        """Show a few numbers next to a pixel, or hide them."""
        self._words.set_echo(text, pixel)

    def set_ghost(self, sensor: Sensor | None) -> None:
        """Show where a sensor that is not in the rig would be placed, or None."""
        self._rig.set_ghost(sensor, self._state.palette)

    @property
    def under_mouse(self) -> UnderMouse:
        """Return what is under each pixel of the picture."""
        return UnderMouse(self._state, self.size, self._pixel_ratio)

    def place_at(self, pixel: Pixel) -> Place | None:
        """Return the place to measure from under a pixel: a sensor's middle, else the car or the ground before it, or
        None."""
        name = self.under_mouse.sensor(pixel)
        if name is not None:
            return Place(self._state.rig.sensor(name).position, name, name)
        self._bring_car()
        ray = self._state.camera.ray(pixel, self.size)
        point, ground = self._body.point(ray), _on_ground(ray)
        if point is not None and (ground is None or _along(ray, point) <= _along(ray, ground)):
            return Place(_vec3(point), BODY)
        return None if ground is None else Place(_vec3(ground), GROUND)

    def _is_behind_car(self, place_m: NDArray[np.float64]) -> bool:
        """Return whether the car hides a place from the viewer."""
        camera = self._state.camera
        x, y, _ = camera.project(place_m[None], self.size)[0].tolist()
        ray = camera.ray((x, y), self.size)
        point = self._body.point(ray)
        return point is not None and _along(ray, point) < _along(ray, place_m) - _BEHIND_M

    def aim_at(self, pixel: Pixel | None) -> bool:
        """Stretch the measuring line to the place under a pixel, or release it; return whether that changed
        anything."""
        return self._measure.aim(None if pixel is None else self.place_at(pixel))

    def pose_on_body(
        self, pixel: Pixel, sensor: Sensor, snap: bool = False, other_way: bool = False
    ) -> Pose | None:
        """Return the pose of a sensor on the car under a pixel, on round places with `snap`; None off the car.

        The `other_way` it is tilted with the surface if the rules keep it upright, and upright if they do not.
        """
        self._bring_car()
        rules, ray = self._state.placing, self._state.camera.ray(pixel, self.size)
        rules = replace(rules, upright=rules.upright != other_way)
        hit = self._body.hit(ray)
        if snap and hit is not None:
            pixel_m = self._state.camera.metres_per_pixel(hit[0], self.size) * self._pixel_ratio
            rules = replace(rules, grid_m=SNAP_M, centre_m=_CENTRE_PX * pixel_m)
        body = (sensor.kind, sensor_body(sensor).box_m())
        return placed(
            lambda origin_m, direction: self._body.hit(ViewRay(origin_m, direction)),
            (ray.origin_m, ray.direction), body, rules,
        )  # fmt: skip

    def prepare(self) -> None:
        """Bring camera, heatmap and gizmo up to date for the next frame."""
        self._bring_car()
        state = self._state
        if self._fans_due is not None:
            self._rig.show_fans(state, self._quick, others=self._fans_due)
            self._fans_due = None
        self._set_coarse()
        reach_m = max(REACH_M, 2.0 * float(np.linalg.norm(state.grid.roi_m)))
        self._stage.set_camera(state.camera, reach_m + 20.0)
        if not (self._quick and self._standing.is_kept(self._place())):
            self._heatmap.arrange(state.camera, self._stage.haze_size, self._quick)
            self._haze, self._cell_m = self._wanted_haze(), self._heatmap.drawn_cell_m
        self._body.arrange(state.camera)
        for layer in (self._rig, self._marker, self._measure):
            layer.arrange(state.camera, self.size, self._pixel_ratio)
        self._words.arrange(state, self._cell_m, self.size, self._pixel_ratio)
        hovered = self._hovered if isinstance(self._hovered, str) else None
        taken = [
            *self._covered,
            *self._words.boxes(),
            *self._places.arrange_dots(state, self.size, self._pixel_ratio),
        ]
        self._masts.arrange(state.camera, self.size, self._pixel_ratio, self._is_behind_car, taken)
        taken += self._masts.boxes
        self._places.arrange(state, hovered, taken, self.size, self._pixel_ratio)
        self._stubs.set_line_width(self._pixel_ratio)
        lit = self._hovered if isinstance(self._hovered, Handle) else None
        self._gizmo.arrange(self.under_mouse.gizmo(), state.gizmo_mode, state.camera, lit)
        self._stage.set_smooth(self._smooth)

    def draw_moving(self) -> None:
        """Draw the state that `prepare` has prepared while something moves; the static part is not drawn again."""
        self._standing.draw(self._place(), self._haze)

    @property
    def haze_is_due(self) -> bool:
        """Return whether `draw_haze` is due: a new heatmap has arrived during motion, and has waited long enough."""
        return self._quick and self._standing.is_due(self._place(), self._wanted_haze())

    def draw_haze(self) -> Generator[None, None, bool]:
        """Draw the static part with the new heatmap, one part at a time.

        Frames in between are drawn over the picture before. Returns whether later ones are drawn over this one: not if
        meanwhile so much has changed that they need yet another.
        """
        haze = self._wanted_haze()
        if not (self._quick and self._standing.is_kept(self._place())):
            return False
        self._heatmap.arrange(self._state.camera, self._stage.haze_size, quick=True)
        cell_m = self._heatmap.drawn_cell_m
        self._set_coarse()
        is_whole = yield from self._standing.parts(haze)
        if is_whole:
            self._haze, self._cell_m = haze, cell_m
        return is_whole

    def _wanted_haze(self) -> tuple[object, ...]:
        return (self._state.legend_data, self._state.heat_look, self._state.ground_map, self._rig.haze)

    def _set_coarse(self) -> None:
        state = self._state
        self._stage.set_coarse(
            self._quick, [getattr(state, name) for name in _BACKDROP] + [self._pixel_ratio]
        )

    def _place(self) -> tuple[object, ...]:
        """Return everything that a picture depends on."""
        return (*(getattr(self._state, name) for name in _BACKDROP), self.size, self._pixel_ratio)

    def draw_in_parts(self) -> Iterator[None]:
        """Draw what `prepare` has made ready, one part at a time, each of some ten milliseconds.

        The picture is complete at the end. Nothing may change until then, unless the rest is abandoned.
        """
        stage = self._stage
        stage.draw(stage.backdrop)
        yield
        stage.draw(stage.main)
        yield
        for _ in self._heatmap.parts(self._state.camera, self.size):
            stage.draw(stage.cells)
            yield
        stage.draw(stage.rays, stage.overlay)


def _on_ground(ray: ViewRay) -> NDArray[np.float64] | None:
    """Return where a view ray meets the ground, z = 0, from above and not too far away; metres."""
    fall = float(ray.direction[2])
    if fall >= 0.0:
        return None
    point = ray.origin_m - ray.origin_m[2] / fall * ray.direction
    near = ray.origin_m[2] >= 0.0 and float(np.hypot(point[0], point[1])) <= _FAR_M
    return np.array([point[0], point[1], 0.0]) if near else None


def _along(ray: ViewRay, point_m: NDArray[np.float64]) -> float:
    return float((point_m - ray.origin_m) @ ray.direction)


def _vec3(point_m: NDArray[np.float64]) -> Vec3:
    x, y, z = (float(value) for value in point_m)
    return x, y, z
