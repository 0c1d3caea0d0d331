"""The whole 3D scene on any pyvista plotter: the one drawing path of window, offscreen pictures and tests.

No Qt here. Methods change what is shown but draw nothing; `prepare` brings everything up to date for one
frame, and the owner of the plotter renders it.
"""

from __future__ import annotations

import io
from dataclasses import dataclass, field, replace
from pathlib import Path

import matplotlib.image
import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow

from core.files import atomic_write
from core.geometry import Pose
from core.mesh import BodyMesh
from core.placing import placed_on
from core.rig.model import Camera, Lidar, Rig, Vehicle
from core.scene.grid import VoxelGrid
from widgets.gizmo.drag import Handle, Space
from widgets.gizmo.handles import GizmoActors, GizmoMode, GizmoPlace, hit_handle, place_gizmo
from widgets.theme import DARK, Palette
from widgets.viewport.body_layer import BodyLayer
from widgets.viewport.camera import OrbitCamera, Size, view_camera
from widgets.viewport.caption_layer import NO_CAPTION, Caption, CaptionLayer
from widgets.viewport.echo_layer import EchoLayer
from widgets.viewport.ground_layer import GroundLayer
from widgets.viewport.heat_pick import PickedCell, cell_at
from widgets.viewport.heat_scale import DEFAULT_LOOK, HeatLook, HeatmapData
from widgets.viewport.heatmap_layer import HeatmapLayer
from widgets.viewport.legend_layer import LegendLayer
from widgets.viewport.lights import set_lights
from widgets.viewport.marker_layer import Marker, MarkerLayer
from widgets.viewport.rays_layer import RaysLayer
from widgets.viewport.roi_layer import RoiLayer
from widgets.viewport.sensor_layer import SensorLayer
from widgets.viewport.sensor_shapes import PICK_RADIUS_M, Mark, sensor_body

SMOOTH_SAMPLES = 8
"""Samples per pixel of a picture with smooth edges."""
_PICK_PX = 9.0


@dataclass(frozen=True)
class SceneState:
    """Everything a scene shows; a picture of it can be made again anywhere, at any size."""

    vehicle: Vehicle = field(default_factory=Vehicle)
    body_mesh: BodyMesh | None = None
    rig: Rig = field(default_factory=Rig)
    hidden: frozenset[str] = frozenset()
    selected: str | None = None
    grid: VoxelGrid = field(default_factory=VoxelGrid)
    heatmap: HeatmapData | None = None
    heat_look: HeatLook = DEFAULT_LOOK
    show_legend: bool = True
    caption: Caption = NO_CAPTION
    marker: Marker | None = None
    camera: OrbitCamera = field(default_factory=OrbitCamera)
    gizmo_mode: GizmoMode = "both"
    gizmo_space: Space = "local"
    show_gizmo: bool = True
    show_rays: bool = True
    palette: Palette = DARK


class Scene:
    """A scene on a plotter; `pixel_ratio` scales lines, letters and handles for dense or large pictures."""

    def __init__(self, plotter: pv.BasePlotter, palette: Palette = DARK, pixel_ratio: float = 1.0) -> None:
        self._plotter = plotter
        self._pixel_ratio = pixel_ratio
        self._state = SceneState(palette=palette)
        self._hovered: str | Handle | None = None
        self._quick = False
        self._echo_at = ("", (0.0, 0.0))
        renderer = plotter.renderer
        self._last_size: Size = (1, 1)
        renderer.SetUseOIT(False)  # cells come in their order; weighted blending would cost another pass
        self._overlay = _overlay_renderer(plotter)
        self._ground, self._roi = GroundLayer(renderer), RoiLayer(renderer)
        self._body, self._sensors = BodyLayer(renderer), SensorLayer(renderer)
        self._rays, self._heatmap = RaysLayer(renderer), HeatmapLayer(renderer)
        self._legend, self._caption = LegendLayer(renderer), CaptionLayer(renderer)
        self._marker = MarkerLayer(self._overlay)
        self._gizmo, self._echo = GizmoActors(self._overlay, palette), EchoLayer(self._overlay)
        self._rays.set_line_width(pixel_ratio)
        set_lights(plotter)
        renderer.camera_set = True
        self._has_car = False
        self._redraw()

    @property
    def state(self) -> SceneState:
        """What is shown now."""
        return self._state

    @property
    def size(self) -> Size:
        """Width and height of the picture in pixels; of a closed plotter the last ones."""
        window = self._plotter.render_window
        if window is not None:
            width, height = window.GetSize()
            self._last_size = int(width), int(height)
        return self._last_size

    @property
    def pixel_ratio(self) -> float:
        """Pixels per logical pixel."""
        return self._pixel_ratio

    def set_pixel_ratio(self, pixel_ratio: float) -> None:
        """Follow a move to a screen of another density."""
        if pixel_ratio != self._pixel_ratio:
            self._pixel_ratio = pixel_ratio
            self._rays.set_line_width(pixel_ratio)

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
        self._plotter.renderer.set_background(palette.background, top=palette.background_top)
        self._gizmo.set_palette(palette)
        self.set_grid(self._state.grid)
        self._draw_sensors()
        self._heatmap.set_look(self._state.heat_look)
        self.set_heatmap(self._state.heatmap)
        self._caption.set_caption(self._state.caption, palette)
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
        self._draw_fans()

    def set_rig(self, rig: Rig, hidden: frozenset[str] = frozenset(), selected: str | None = None) -> None:
        """Show a rig's sensors except the hidden ones; the selected one gets the gizmo and the dense fan."""
        before = self._state
        self._state = replace(before, rig=rig, hidden=hidden, selected=selected)
        if (rig, hidden, selected) == (before.rig, before.hidden, before.selected):
            return
        self._draw_sensors()
        self._draw_fans(others=_others_differ(before, self._state))

    def preview(self, name: str, pose: Pose) -> None:
        """Move one sensor with its fan and gizmo, and nothing else."""
        rig = self._state.rig
        self._state = replace(self._state, rig=rig.with_sensor(name, rig.sensor(name).with_pose(pose)))
        self._sensors.set_pose(name, pose)
        self._draw_fans(others=name != self._state.selected)

    def set_heatmap(self, data: HeatmapData | None) -> None:
        """Show a heatmap with its colour bar, or none. Pass the same `centres_m` when only values change."""
        self._state = replace(self._state, heatmap=data)
        self._heatmap.set_data(data)
        self._draw_legend()

    def set_heat_look(self, look: HeatLook) -> None:
        """Draw the same heatmap in another way: threshold, scale, opacity, slice."""
        self._state = replace(self._state, heat_look=look)
        self._heatmap.set_look(look)
        self._draw_legend()

    def set_marker(self, marker: Marker | None) -> None:
        """Point out a cube, or none."""
        self._state = replace(self._state, marker=marker)
        self._marker.set_marker(marker, self._state.palette)

    def cell_at(self, pixel: tuple[float, float]) -> PickedCell | None:
        """The cell of the heatmap under a pixel, the nearest of those that are drawn."""
        state = self._state
        if state.heatmap is None:
            return None
        return cell_at(state.heatmap, state.heat_look, state.camera, self.size, pixel)

    @property
    def legend_texts(self) -> tuple[str, ...]:
        """What the legend of the heatmap says."""
        return self._legend.texts

    def _draw_legend(self) -> None:
        state = self._state
        shown = state.heatmap if state.show_legend else None
        self._legend.set_data(shown, state.heat_look, state.palette)

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
        self._draw_sensors()
        return True

    def set_quick(self, quick: bool) -> None:
        """Draw a coarser heatmap, fewer rays and large meshes with fewer triangles while something moves."""
        if quick != self._quick:
            self._quick = quick
            self._body.set_quick(quick)
            self._draw_fans()

    def set_samples(self, samples: int) -> None:
        """Draw with so many samples per pixel: 0 while something moves, SMOOTH_SAMPLES for smooth edges."""
        window = render_window(self._plotter)
        if window.GetMultiSamples() != samples:
            window.SetMultiSamples(samples)

    def set_echo(self, text: str, pixel: tuple[float, float] = (0.0, 0.0)) -> None:
        """Show a few numbers beside a pixel, or no longer."""
        self._echo_at = (text, pixel)

    def set_ghost(self, sensor: Lidar | Camera | None) -> None:
        """Show where a sensor that is not in the rig would come to stand, or no longer."""
        self._sensors.set_ghost(sensor, self._state.palette)

    def pose_on_body(self, pixel: tuple[float, float], sensor: Lidar | Camera) -> Pose | None:
        """The pose of a sensor that sits on the car under a pixel; None beside the car."""
        self._bring_car()
        hit = self._body.hit(self._state.camera.ray(pixel, self.size))
        return None if hit is None else placed_on(*hit, sensor.kind, sensor_body(sensor).box_m())

    def gizmo_place(self) -> GizmoPlace | None:
        """Where the gizmo is, or None when no visible sensor is selected."""
        state = self._state
        if not state.show_gizmo or state.selected is None or state.selected in state.hidden:
            return None
        sensor = next((s for s in state.rig.sensors if s.name == state.selected), None)
        if sensor is None:
            return None
        return place_gizmo(sensor.pose, state.gizmo_space, state.camera, self.size, self._pixel_ratio)

    def handle_at(self, pixel: tuple[float, float]) -> Handle | None:
        """The gizmo handle under a pixel."""
        place, state = self.gizmo_place(), self._state
        if place is None:
            return None
        return hit_handle(pixel, state.gizmo_mode, place, state.camera, self.size, self._pixel_ratio)

    def sensor_at(self, pixel: tuple[float, float]) -> str | None:
        """The sensor under a pixel; of several the one nearest to the viewer."""
        sensors, camera = self._shown(), self._state.camera
        if not sensors:
            return None
        places = np.array([sensor.position for sensor in sensors])
        seen = camera.project(places, self.size)
        radius = [PICK_RADIUS_M / camera.metres_per_pixel(place, self.size) for place in places]
        reach = np.maximum(_PICK_PX * self._pixel_ratio, radius)
        hit = np.flatnonzero((np.linalg.norm(seen[:, :2] - pixel, axis=1) <= reach) & (seen[:, 2] > 0.0))
        return sensors[hit[np.argmin(seen[hit, 2])]].name if len(hit) else None

    def prepare(self) -> None:
        """Bring camera, heatmap and gizmo up to date for the next frame."""
        self._bring_car()
        state = self._state
        self._apply_camera(state.camera)
        self._heatmap.arrange(state.camera, self.size, self._quick)
        self._legend.set_drawn(self._heatmap.drawn_cell_m)
        self._legend.place(self.size, self._pixel_ratio, crowded=bool(state.caption.table))
        self._caption.place(self.size, self._pixel_ratio)
        self._marker.arrange(state.camera, self.size, self._pixel_ratio)
        self._echo.show(*self._echo_at, self.size, self._pixel_ratio, state.palette)
        place = self.gizmo_place()
        if place is None:
            self._gizmo.hide()
        else:
            lit = self._hovered if isinstance(self._hovered, Handle) else None
            self._gizmo.show(state.gizmo_mode, place, state.camera, lit)

    def _apply_camera(self, orbit: OrbitCamera) -> None:
        camera = self._plotter.renderer.camera
        camera.SetPosition(*orbit.position_m())
        camera.SetFocalPoint(*orbit.focal_m)
        camera.SetViewUp(*orbit.axes()[1])
        camera.SetViewAngle(orbit.view_angle_deg)
        camera.SetParallelProjection(orbit.parallel)
        camera.SetParallelScale(orbit.half_height_m())
        reach = 2.0 * float(np.linalg.norm(self._state.grid.roi_m)) + 20.0
        near = -reach if orbit.parallel else max(0.05, 0.02 * orbit.distance_m)
        camera.SetClippingRange(near, orbit.distance_m + reach)
        self._overlay.SetActiveCamera(camera)

    def _shown(self) -> list[Lidar | Camera]:
        return [sensor for sensor in self._state.rig.sensors if sensor.name not in self._state.hidden]

    def _draw_sensors(self) -> None:
        marks: dict[str, Mark] = {self._hovered: "hovered"} if isinstance(self._hovered, str) else {}
        if self._state.selected is not None:
            marks[self._state.selected] = "selected"
        self._sensors.set_sensors(self._shown(), marks, self._state.palette)

    def _draw_fans(self, others: bool = True) -> None:
        state = self._state
        casting = [s for s in self._shown() if s.enabled] if state.show_rays else []
        selected = next((sensor for sensor in casting if sensor.name == state.selected), None)
        self._rays.set_selected(selected, state.grid, state.palette, self._quick)
        if others:
            rest = [sensor for sensor in casting if sensor is not selected]
            self._rays.set_others(rest, state.grid, state.palette)


def _others_differ(before: SceneState, after: SceneState) -> bool:
    """Whether any sensor beside the selected one changed, so that the sparse fans must be drawn anew."""
    if (before.hidden, before.selected) != (after.hidden, after.selected):
        return True
    old = [sensor for sensor in before.rig.sensors if sensor.name != after.selected]
    return old != [sensor for sensor in after.rig.sensors if sensor.name != after.selected]


def render_window(plotter: pv.BasePlotter) -> vtkRenderWindow:
    """The VTK window of an open plotter."""
    window = plotter.render_window
    if window is None:
        raise RuntimeError("the plotter is closed")
    return window


def _overlay_renderer(plotter: pv.BasePlotter) -> vtkRenderer:
    """A second renderer over the scene with a depth buffer of its own, for things that are never hidden."""
    window = render_window(plotter)
    overlay = vtkRenderer()
    window.SetNumberOfLayers(window.GetNumberOfLayers() + 1)
    overlay.SetLayer(window.GetNumberOfLayers() - 1)
    overlay.InteractiveOff()
    overlay.SetUseOIT(False)
    overlay.SetActiveCamera(plotter.renderer.camera)
    window.AddRenderer(overlay)
    return overlay


def render_still(
    state: SceneState,
    size: Size,
    scale: int = 1,
    path: Path | None = None,
    transparent: bool = False,
    view: str | None = None,
) -> NDArray[np.uint8]:
    """Draw a state offscreen with smooth edges: pixels (height * scale, width * scale, 3 or 4) uint8.

    `size` is width and height; `scale` enlarges everything alike. With `path` a PNG is written there. `view`
    picks a named view of the whole ROI (InputError for an unknown one), else the state's camera is kept.
    """
    plotter = pv.Plotter(off_screen=True, window_size=[size[0] * scale, size[1] * scale], lighting="none")
    try:
        render_window(plotter).SetMultiSamples(SMOOTH_SAMPLES)
        scene = Scene(plotter, state.palette, pixel_ratio=float(scale))
        scene.apply(state)
        if view is not None:
            scene.set_view(view, wide=True)
        if transparent:
            plotter.renderer.GradientBackgroundOff()
        scene.prepare()
        plotter.show(auto_close=False, interactive=False)
        image = np.asarray(plotter.screenshot(None, transparent_background=transparent, return_img=True))
        if path is not None:
            write_png(image, path)
        return image
    finally:
        plotter.close()


def png_of(image: NDArray[np.uint8]) -> bytes:
    """Pixels (h, w, 3 or 4) as a PNG file."""
    file = io.BytesIO()
    matplotlib.image.imsave(file, image, format="png")
    return file.getvalue()


def write_png(image: NDArray[np.uint8], path: Path) -> None:
    """Write pixels (h, w, 3 or 4) as a PNG, completely or not at all; InputError if it cannot be written."""
    with atomic_write(path) as file:
        file.write(png_of(image))
