"""The whole 3D scene on any pyvista plotter: the one drawing path of window, offscreen pictures and tests.

No Qt here. Methods change what is shown but draw nothing; `prepare` brings everything up to date for one
frame, and the owner of the plotter renders it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pyvista as pv

from riglens.core.geometry import Pose
from riglens.core.rig.model import Camera, Lidar, Vehicle
from riglens.core.scene.grid import VoxelGrid
from riglens.core.vehicle.mesh import BodyMesh
from riglens.core.vehicle.placing import placed_on
from riglens.widgets.car.layer import BodyLayer
from riglens.widgets.gizmo.drag import Handle, Space
from riglens.widgets.gizmo.handles import GizmoActors, GizmoMode
from riglens.widgets.heatmap.layer import HeatmapLayer
from riglens.widgets.heatmap.scale import HeatLook, HeatmapData
from riglens.widgets.sensors.ray_look import RayLook
from riglens.widgets.sensors.rig_layer import RigLayer
from riglens.widgets.sensors.sensor_shapes import sensor_body
from riglens.widgets.theme import DARK, Palette
from riglens.widgets.viewport.camera import OrbitCamera, Size, view_camera
from riglens.widgets.viewport.ground_layer import GroundLayer
from riglens.widgets.viewport.listener import Pixel
from riglens.widgets.viewport.marker_layer import Marker, MarkerLayer
from riglens.widgets.viewport.roi_layer import RoiLayer
from riglens.widgets.viewport.scene_state import SceneState, ShownRig
from riglens.widgets.viewport.stage import Stage
from riglens.widgets.viewport.under_mouse import UnderMouse
from riglens.widgets.viewport.words_layer import WordsLayer


class Scene:
    """A scene on a plotter; `pixel_ratio` scales lines, letters and handles for dense or large pictures."""

    def __init__(self, plotter: pv.BasePlotter, palette: Palette = DARK, pixel_ratio: float = 1.0) -> None:
        self._pixel_ratio = pixel_ratio
        self._state = SceneState(palette=palette)
        self._hovered: str | Handle | None = None
        self._quick = self._smooth = False
        self._stage = stage = Stage(plotter)
        self._ground, self._roi = GroundLayer(stage.backdrop, stage.main), RoiLayer(stage.main)
        self._body, self._rig = BodyLayer(stage.main, stage.backdrop), RigLayer(stage.main)
        self._heatmap = HeatmapLayer(stage.cells, stage.backdrop)
        self._marker, self._words = MarkerLayer(stage.overlay), WordsLayer(stage.overlay)
        self._gizmo = GizmoActors(stage.overlay, palette)
        self._rig.set_line_width(pixel_ratio)
        self._has_car = False
        self._redraw()

    @property
    def state(self) -> SceneState:
        """What is shown now."""
        return self._state

    @property
    def size(self) -> Size:
        """Width and height of the picture in pixels; of a closed plotter the last ones."""
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

    def apply(self, state: SceneState) -> None:
        """Show a whole state; InputError for an unknown vehicle body, but the rest is shown all the same."""
        self._state = replace(state, vehicle=self._state.vehicle, body_mesh=self._state.body_mesh)
        self._redraw()
        self.set_vehicle(state.vehicle, state.body_mesh)

    def set_palette(self, palette: Palette) -> None:
        """Change all colours (light or dark window)."""
        self._state = replace(self._state, palette=palette)
        self._redraw()
        if self._has_car:
            self._body.set_vehicle(self._state.vehicle, palette, self._state.body_mesh)

    def _redraw(self) -> None:
        """Bring all layers except the car in line with the state."""
        palette = self._state.palette
        self._stage.backdrop.set_background(palette.background, top=palette.background_top)
        self._gizmo.set_palette(palette)
        self.set_grid(self._state.grid)
        self._rig.show_bodies(self._state, self._hovered)
        self._heatmap.set_look(self._state.heat_look)
        self.set_heatmap(self._state.heatmap)
        self._words.show_caption(self._state)
        self._marker.set_marker(self._state.marker, palette)

    def set_vehicle(self, vehicle: Vehicle, mesh: BodyMesh | None = None) -> None:
        """Draw another car, from the mesh of its file if it has one.

        Raises InputError for an unknown body and keeps the car shown before.
        """
        self._body.set_vehicle(vehicle, self._state.palette, mesh)
        self._has_car = True
        self._state = replace(self._state, vehicle=vehicle, body_mesh=mesh)

    def _bring_car(self) -> None:
        """Draw the car of the state unless one was chosen: not before, a car is the dearest thing to build."""
        if not self._has_car:
            self.set_vehicle(self._state.vehicle)

    def set_grid(self, grid: VoxelGrid) -> None:
        """Show another region of interest: outline, ground, and where rays end."""
        self._ground.set_grid(grid, self._state.palette)
        self._roi.set_grid(grid, self._state.palette)
        self._state = replace(self._state, grid=grid)
        self._rig.show_fans(self._state, self._quick)

    def set_rig(self, shown: ShownRig) -> None:
        """Show a rig's sensors; the selected one gets the dense fan."""
        before = self._state
        self._state = replace(
            before, rig=shown.rig, hidden=shown.hidden, selected=shown.selected, fixed=shown.fixed
        )
        if replace(shown, fixed=before.fixed) == before.shown_rig:
            return
        self._rig.show_bodies(self._state, self._hovered)
        self._rig.show_fans(self._state, self._quick, others=before.other_fans_differ(self._state))

    def set_ray_look(self, look: RayLook) -> None:
        """Draw the same rays in another way: none, more or fewer, fainter or stronger."""
        self._state = replace(self._state, ray_look=look)
        self._rig.show_fans(self._state, self._quick)

    def preview(self, name: str, pose: Pose) -> None:
        """Move one sensor with its fan and gizmo, and nothing else."""
        rig = self._state.rig
        self._state = replace(self._state, rig=rig.with_sensor(name, rig.sensor(name).with_pose(pose)))
        self._rig.set_pose(name, pose)
        self._rig.show_fans(self._state, self._quick, others=name != self._state.selected)

    def set_heatmap(self, data: HeatmapData | None) -> None:
        """Show a heatmap with its colour bar, or none. Pass the same `centres_m` when only values change."""
        self._state = replace(self._state, heatmap=data)
        self._heatmap.set_data(data)
        self._words.show_legend(self._state)

    def set_heat_look(self, look: HeatLook) -> None:
        """Draw the same heatmap in another way: threshold, scale, opacity, slice."""
        self._state = replace(self._state, heat_look=look)
        self._heatmap.set_look(look)
        self._words.show_legend(self._state)

    def set_marker(self, marker: Marker | None) -> None:
        """Point out a cube, or none."""
        self._state = replace(self._state, marker=marker)
        self._marker.set_marker(marker, self._state.palette)

    @property
    def legend_texts(self) -> tuple[str, ...]:
        """What the legend of the heatmap says."""
        return self._words.legend_texts

    def set_gizmo(self, mode: GizmoMode, space: Space) -> None:
        """Choose arrows, rings or both, and whose axes they follow."""
        self._state = replace(self._state, gizmo_mode=mode, gizmo_space=space)

    def set_view(self, name: str, wide: bool = False) -> None:
        """Look from "iso", "top", "front", "left", "rear" (else InputError); `wide`: iso over all the ROI."""
        width, height = self.size
        vehicle = self._state.vehicle
        size_m = (vehicle.length, vehicle.height)
        self.set_camera(view_camera(name, self._state.grid, width / max(1, height), wide, size_m))

    def set_camera(self, camera: OrbitCamera) -> None:
        """Look through another camera."""
        self._state = replace(self._state, camera=camera)

    def frame(self, name: str) -> None:
        """Look at one sensor from near by, keeping the direction."""
        position = self._state.rig.sensor(name).position
        self.set_camera(replace(self._state.camera, focal_m=position, distance_m=5.0))

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
            self._body.set_quick(quick)
            self._ground.set_quick(quick)
            self._rig.show_fans(self._state, self._quick)

    @property
    def is_quick(self) -> bool:
        """Whether it is drawn as while something moves."""
        return self._quick

    def set_smooth(self, smooth: bool) -> None:
        """Smooth the edges of the frames to come: a filter that costs a third of a frame at rest."""
        self._smooth = smooth

    @property
    def is_smooth(self) -> bool:
        """Whether edges are smoothed."""
        return self._smooth

    def set_echo(self, text: str, pixel: Pixel = (0.0, 0.0)) -> None:
        """Show a few numbers beside a pixel, or no longer."""
        self._words.set_echo(text, pixel)

    def set_ghost(self, sensor: Lidar | Camera | None) -> None:
        """Show where a sensor that is not in the rig would come to stand, or no longer."""
        self._rig.set_ghost(sensor, self._state.palette)

    @property
    def under_mouse(self) -> UnderMouse:
        """What is where in the picture."""
        return UnderMouse(self._state, self.size, self._pixel_ratio)

    def pose_on_body(self, pixel: Pixel, sensor: Lidar | Camera) -> Pose | None:
        """The pose of a sensor that sits on the car under a pixel; None beside the car."""
        self._bring_car()
        hit = self._body.hit(self._state.camera.ray(pixel, self.size))
        return None if hit is None else placed_on(*hit, sensor.kind, sensor_body(sensor).box_m())

    def prepare(self) -> None:
        """Bring camera, heatmap and gizmo up to date for the next frame."""
        self._bring_car()
        state = self._state
        self._stage.set_coarse(self._quick)
        self._stage.set_camera(state.camera, 2.0 * float(np.linalg.norm(state.grid.roi_m)) + 20.0)
        self._ground.arrange(state.camera, self.size, self._pixel_ratio)
        self._heatmap.arrange(state.camera, self._stage.backdrop_size, self._quick)
        self._words.arrange(state, self._heatmap.drawn_cell_m, self.size, self._pixel_ratio)
        self._marker.arrange(state.camera, self.size, self._pixel_ratio)
        lit = self._hovered if isinstance(self._hovered, Handle) else None
        self._gizmo.arrange(self.under_mouse.gizmo(), state.gizmo_mode, state.camera, lit)
        self._stage.set_smooth(self._smooth)

    def draw_in_parts(self) -> Iterator[None]:
        """Draw what `prepare` has made ready, one part at a time, each of some ten milliseconds.

        The picture is whole at the end. Nothing may be changed until then, unless the rest is given up.
        """
        stage = self._stage
        stage.draw(stage.backdrop)
        yield
        stage.draw(stage.main)
        yield
        for _ in self._heatmap.parts(self._state.camera, self.size):
            stage.draw(stage.cells)
            yield
        stage.draw(stage.overlay)
