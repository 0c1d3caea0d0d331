"""Housings of sensors: a spinning puck, a solid-state box with its window, a camera with its lens in front.

Shapes are at the sensor's origin in its own frame (x forward, z up), metres. A library model with known
dimensions has its true size; others are somewhat larger than life. Each is one mesh with an `rgb` point array.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer

from riglens.core.geometry import Pose, Vec3
from riglens.core.rig.library import Cylinder, body_of
from riglens.core.rig.model import Sensor
from riglens.core.vehicle.surface import lathe, rounded_box
from riglens.widgets.drawing.actors import rgba_actor
from riglens.widgets.drawing.surface import appended, drawn
from riglens.widgets.sensors.appearance import Shape, appearance_of, colour_of
from riglens.widgets.theme import LINKED_COLOUR, WORST_COLOUR, Palette, mix, rgb

Mark = Literal["", "hovered", "selected", "linked", "worst"]
LIDAR_RADIUS_M = 0.105
PICK_RADIUS_M = 0.12
_DARK = "#14161a"
_LENS = "#2b4a7d"
_OFF = "#808890"
_BOXES: dict[Shape, tuple[Vec3, Vec3]] = {
    "puck": ((-LIDAR_RADIUS_M, -LIDAR_RADIUS_M, -0.085), (LIDAR_RADIUS_M, LIDAR_RADIUS_M, 0.080)),
    "box": ((-0.120, -0.095, -0.055), (0.010, 0.095, 0.055)),
    "lens": ((-0.130, -0.065, -0.050), (0.061, 0.065, 0.067)),
}


@dataclass(frozen=True)
class SensorBody:
    """Shape and size of a sensor; `scale` is along x, y and z of the shape at its usual size."""

    shape: Shape
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def box_m(self) -> NDArray[np.float64]:
        """Return lowest and highest corner (2, 3) in the sensor's own frame, metres."""
        return np.array(_BOXES[self.shape]) * self.scale


def sensor_body(sensor: Sensor) -> SensorBody:
    """Return the body of a sensor, in its true size when the library knows it."""
    look, known = appearance_of(sensor.kind), body_of(sensor.model)
    if known is None:
        return SensorBody(look.shape(sensor), (look.scale,) * 3)
    if isinstance(known, Cylinder):
        shape: Shape = "puck"
        size_m = (known.diameter, known.diameter, known.height)
    else:
        shape = look.cuboid
        size_m = (known.length, known.width, known.height)
    x, y, z = np.array(size_m) / np.ptp(np.array(_BOXES[shape]), axis=0)
    return SensorBody(shape, (float(x), float(y), float(z)))


def sensor_mesh(
    body: SensorBody, colour: str, palette: Palette, mark: Mark = "", enabled: bool = True
) -> pv.PolyData:
    """Return the mesh of a body with an `rgb` uint8 point array; selected or hovered ones are highlighted."""
    if not enabled:
        colour = mix(colour, _OFF, 0.85)
    if mark == "selected":
        colour = palette.selected
    elif mark in ("linked", "worst"):
        colour = LINKED_COLOUR if mark == "linked" else WORST_COLOUR
    elif mark == "hovered":
        colour = mix(colour, "#ffffff", 0.55)
    mesh = _shape(body.shape, colour).copy()
    mesh.points = np.asarray(mesh.points) * body.scale
    return mesh


@lru_cache(maxsize=16)
def _shape(shape: Shape, colour: str) -> pv.PolyData:
    """Return the unscaled mesh, to be copied: the cameras of a rig differ only in their poses."""
    return {"puck": _puck, "box": _solid_state, "lens": _camera}[shape](colour)


def _puck(colour: str) -> pv.PolyData:
    """Return a spinning LiDAR: base, dark window ring, cap and a forward mark; the origin is in the window's middle."""
    r = LIDAR_RADIUS_M
    base = [(0.0, -0.085), (0.94 * r, -0.085), (r, -0.075), (r, -0.040), (0.95 * r, -0.036)]
    window = [(0.95 * r, -0.036), (0.90 * r, 0.036)]
    cap = [(0.93 * r, 0.036), (0.97 * r, 0.042), (0.96 * r, 0.062), (0.85 * r, 0.074), (0.0, 0.080)]
    nose = pv.Cube(center=(r, 0.0, -0.058), x_length=0.03, y_length=0.05, z_length=0.026)
    parts = [
        _tinted(_upright(base), colour), _tinted(_upright(window), _DARK),
        _tinted(_upright(cap), mix(colour, "#ffffff", 0.15)), _tinted(nose, mix(colour, "#000000", 0.25)),
    ]  # fmt: skip
    return appended(parts)


def _solid_state(colour: str) -> pv.PolyData:
    """Return a LiDAR that looks one way: a flat box with cooling fins behind and a wide dark window in front."""
    low, high = np.array(_BOXES["box"])
    body = drawn(rounded_box(low, high - [0.012, 0.0, 0.0], 0.012))
    window = pv.Cube(center=(0.002, 0.0, 0.0), x_length=0.016, y_length=0.165, z_length=0.082)
    fins = [
        pv.Cube(center=(-0.075, 0.0, z), x_length=0.07, y_length=0.196, z_length=0.006)
        for z in (-0.03, -0.01, 0.01, 0.03)
    ]
    parts = [_tinted(body, colour), _tinted(window, _DARK)]
    return appended([*parts, *(_tinted(fin, mix(colour, "#000000", 0.35)) for fin in fins)])


def _camera(colour: str) -> pv.PolyData:
    """Return a camera: body behind the origin, lens barrel with dark glass ahead; a small fin marks its top."""
    body = pv.Cube(center=(-0.070, 0.0, 0.0), x_length=0.12, y_length=0.13, z_length=0.10)
    fin = pv.Cube(center=(-0.07, 0.0, 0.058), x_length=0.08, y_length=0.03, z_length=0.018)
    barrel = [(0.052, -0.02), (0.052, 0.035), (0.060, 0.040), (0.060, 0.060), (0.048, 0.060)]
    glass = [(0.048, 0.052), (0.030, 0.058), (0.0, 0.061)]
    parts = [
        _tinted(body, colour), _tinted(fin, mix(colour, "#ffffff", 0.35)),
        _tinted(_forward(barrel), _DARK), _tinted(_forward(glass), _LENS),
    ]  # fmt: skip
    return appended(parts)


def _upright(profile: list[tuple[float, float]]) -> pv.PolyData:
    """Return a lathe about z from (radius, z) pairs."""
    return drawn(lathe(np.array(profile), 28)).rotate_x(90, inplace=False)


def _forward(profile: list[tuple[float, float]]) -> pv.PolyData:
    """Return a lathe about x from (radius, x) pairs."""
    return drawn(lathe(np.array(profile), 24)).rotate_z(-90, inplace=False)


def _tinted(mesh: pv.PolyData, colour: str) -> pv.PolyData:
    flat: pv.PolyData = pv.PolyData(mesh.points, mesh.faces).compute_normals(
        cell_normals=False, split_vertices=True, feature_angle=50, auto_orient_normals=False
    )
    flat["rgb"] = np.tile((np.array(rgb(colour)) * 255).astype(np.uint8), (flat.n_points, 1))
    return flat


_OFF_OPACITY, FAILED_OPACITY, PLACED_OPACITY, WORST_OPACITY = 0.45, 0.3, 0.65, 0.6


class SensorLayer:
    """Pucks, boxes and camera bodies by sensor name."""

    def __init__(self, renderer: vtkRenderer) -> None:
        self._renderer = renderer
        self._actors: dict[str, pv.Actor] = {}
        self._looks: dict[str, tuple[object, ...]] = {}
        self._poses: dict[str, Pose] = {}

    def set_sensors(
        self,
        sensors: Sequence[Sensor],
        marks: Mapping[str, Mark],
        palette: Palette,
        faint: Mapping[str, float],
    ) -> None:
        """Show exactly these sensors; those named in `marks` are highlighted, `faint` gives the opacity of ghosts."""
        for gone in self._actors.keys() - {sensor.name for sensor in sensors}:
            self._renderer.RemoveActor(self._actors.pop(gone))
            del self._looks[gone], self._poses[gone]
        for sensor in sensors:
            opacity = faint.get(sensor.name, 1.0 if sensor.enabled else _OFF_OPACITY)
            self._set_look(sensor, marks.get(sensor.name, ""), palette, opacity)
            self.set_pose(sensor.name, sensor.pose)

    def set_pose(self, name: str, pose: Pose) -> None:
        """Move a shown sensor; one that is already there is left alone."""
        if name in self._actors and self._poses.get(name) != pose:
            self._poses[name] = pose
            self._actors[name].user_matrix = pose.vehicle_SE3_sensor()

    def _set_look(self, sensor: Sensor, mark: Mark, palette: Palette, opacity: float) -> None:
        body, colour = sensor_body(sensor), colour_of(sensor.kind)
        look = (body, mark, sensor.enabled, opacity, colour, palette.selected)
        if self._looks.get(sensor.name) == look:
            return
        mesh = sensor_mesh(body, colour, palette, mark, sensor.enabled)
        if sensor.name in self._actors:
            self._actors[sensor.name].mapper.SetInputData(mesh)
        else:
            self._actors[sensor.name] = self._new_actor(mesh)
        self._actors[sensor.name].prop.opacity = opacity
        self._looks[sensor.name] = look

    def _new_actor(self, mesh: pv.PolyData) -> pv.Actor:
        actor = rgba_actor(mesh, "rgb")
        prop = actor.prop
        prop.lighting, prop.interpolation = True, "Phong"
        prop.ambient, prop.diffuse, prop.specular, prop.specular_power = 0.4, 0.6, 0.3, 25.0
        self._renderer.AddActor(actor)
        return actor
