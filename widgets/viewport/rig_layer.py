"""Draw the sensors of a rig in the scene: their bodies, lines between mirror pairs, and rays of enabled ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pyvista as pv
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.geometry import Pose
from riglens.core.rig.model import Sensor
from riglens.core.vehicle.housings import with_housings
from riglens.core.vehicle.solid import solid_of
from riglens.widgets.drawing.actors import hidden, plain_actor, show_mesh
from riglens.widgets.drawing.camera import OrbitCamera, Size
from riglens.widgets.gizmo.drag import Handle
from riglens.widgets.sensors.appearance import ray_colour
from riglens.widgets.sensors.bodies import FAILED_OPACITY, PLACED_OPACITY, WORST_OPACITY, Mark, SensorLayer
from riglens.widgets.sensors.fills import FillsLayer
from riglens.widgets.sensors.footprints import FootprintsLayer
from riglens.widgets.sensors.rays import RaysLayer
from riglens.widgets.theme import LINKED_COLOUR, Palette
from riglens.widgets.viewport.scene_state import SceneState

_LINK_PX = 1.5


class RigLayer:
    """Bodies and fans of all sensors that are not hidden; the selected one has the dense fan."""

    def __init__(
        self, renderer: vtkRenderer, rays: vtkRenderer, haze: vtkRenderer, awaits_footprints: bool
    ) -> None:
        self._footprints = FootprintsLayer(renderer, haze, awaits_footprints)
        self._sensors, self._fills, self._rays = SensorLayer(renderer), FillsLayer(rays), RaysLayer(rays)
        self._ghosts, self._placed = SensorLayer(renderer), SensorLayer(renderer)
        self._links = hidden(renderer, plain_actor(pv.PolyData(), color=LINKED_COLOUR, lighting=False))
        self.set_line_width(1.0)

    def set_line_width(self, width_px: float) -> None:
        """Set the width of the rays, for pictures of higher resolution."""
        self._rays.set_line_width(width_px)
        self._footprints.set_line_width(width_px)
        self._links.prop.line_width = _LINK_PX * width_px

    def show_bodies(self, state: SceneState, hovered: str | Handle | None) -> None:
        """Draw exactly the sensors of a state; the one under the mouse is highlighted."""
        pairs = [pair for pair in state.pairs if any(state.is_selected(name) for name in pair)]
        marks: dict[str, Mark] = dict.fromkeys((name for pair in pairs for name in pair), "linked")
        if isinstance(hovered, str):
            marks[hovered] = "hovered"
        marks.update({sensor.name: "selected" for sensor in state.shown if state.is_selected(sensor.name)})
        faint = dict.fromkeys(state.failed, FAILED_OPACITY)
        self._sensors.set_sensors(state.shown, marks, state.palette, faint)
        self._show_links([pair for pair in state.pairs if pair in pairs or hovered in pair], state)

    def _show_links(self, pairs: list[tuple[str, str]], state: SceneState) -> None:
        """Draw a line between the two sensors of each pair."""
        places_m = np.array([state.rig.sensor(name).position for pair in pairs for name in pair])
        show_mesh(self._links, pv.line_segments_from_points(places_m) if pairs else None)

    def show_fans(self, state: SceneState, quick: bool, others: bool = True) -> None:
        """Rebuild the rays, fewer while something moves; those of sensors that are not selected only with `others`."""
        look, grid, enabled = state.ray_look, state.grid, state.enabled
        selected = next((sensor for sensor in enabled if sensor.name == state.selected), None)
        rest = [sensor for sensor in enabled if sensor is not selected]
        palette, solid = state.palette, None
        if state.solid_body is not None:
            solid = with_housings(solid_of(state.solid_body), state.rig.obstacles)
        is_ground, is_frusta = state.shows_footprints, look.fill == "frusta"
        if others:
            strokes = look.of_others(len(rest), quick)
            shown = rest if look.shown and look.of_all else ()
            self._rays.show(shown, False, grid, palette, strokes, solid, look.lattice)
            self._fills.show(rest if is_frusta else (), False, grid, palette)
            self._footprints.show(
                rest if is_ground else (), False, selected is not None, palette, look.px_per_m, solid, quick
            )
        if selected is not None and not state.show_selection:
            palette = replace(palette, selected=ray_colour(selected.kind, palette))
        chosen = [] if selected is None else [selected]
        strokes = look.of_selected(quick)
        self._rays.show(chosen if look.shown else (), True, grid, palette, strokes, solid, look.lattice)
        self._fills.show(chosen if is_frusta else (), True, grid, palette)
        self._footprints.show(chosen if is_ground else (), True, True, palette, look.px_per_m, solid, quick)

    @property
    def lacks_footprints(self) -> bool:
        """Return whether a footprint is coarse or left out."""
        return self._footprints.lacks_any

    @property
    def haze(self) -> object:
        """Return the fills that are drawn as haze; another object where they change."""
        return self._footprints.haze

    def arrange(self, camera: OrbitCamera, size: Size, pixel_ratio: float) -> None:
        """Fit the rays to the viewing direction."""
        self._rays.arrange(camera, size, pixel_ratio)

    def set_pose(self, name: str, pose: Pose) -> None:
        """Move the body of a shown sensor."""
        self._sensors.set_pose(name, pose)

    def show_ghosts(self, state: SceneState) -> None:
        """Show the sensors of the worst draw next to those of the rig."""
        _show_alike(self._ghosts, state.ghosts, "worst", WORST_OPACITY, state.palette)

    def set_ghost(self, sensor: Sensor | None, palette: Palette) -> None:
        """Show where a sensor that is not in the rig would be placed, or None."""
        sensors = [] if sensor is None else [sensor]
        _show_alike(self._placed, sensors, "selected", PLACED_OPACITY, palette)


def _show_alike(
    layer: SensorLayer, sensors: Sequence[Sensor], mark: Mark, opacity: float, palette: Palette
) -> None:
    names = [sensor.name for sensor in sensors]
    layer.set_sensors(sensors, dict.fromkeys(names, mark), palette, dict.fromkeys(names, opacity))
