"""The groups of LiDARs and cameras of the paper's Fig. 1 as one sheet, drawn without a display."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray

from riglens.core.rig.model import Camera, Rig
from riglens.core.rig.presets import PAPER_CAMERA_GROUPS, PAPER_LIDAR_GROUPS, preset
from riglens.core.sensors.camera import field_of_view_deg
from riglens.core.vehicle.body import body_parts
from riglens.widgets.sensors.appearance import ray_colour
from riglens.widgets.theme import LIGHT

Points = NDArray[np.float64]

YAW_DEG, PITCH_DEG = 38.0, 27.0
"""Direction to the eye: left of straight ahead, and above."""
_TONES = {
    "paint": (0.70, 0.73, 0.77),
    "panel": (0.70, 0.73, 0.77),
    "glass": (0.24, 0.29, 0.35),
    "rim": (0.55, 0.57, 0.60),
    "lamp": (0.93, 0.93, 0.88),
    "tail": (0.70, 0.16, 0.14),
}
_DARK = (0.20, 0.21, 0.23)
_RADIUS_M, _HEIGHT_M, _MAST_M, _SIDES = 0.06, 0.10, 0.012, 20
_UNDER_M = 0.12
"""The roof below a sensor is the highest point of the car within this distance of its axis."""
_WEDGE_M = 1.9
_DPI = 150


def sheet() -> Figure:
    """Return the sheet: LiDAR groups (a) to (d), camera groups (e) and (f), in the same view."""
    groups = (*PAPER_LIDAR_GROUPS, *PAPER_CAMERA_GROUPS)
    figure = Figure(figsize=(13.0, 8.0), dpi=_DPI, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(2, 3)
    ends = []
    for axes, letter, name in zip(panels.flat, "abcdef", groups, strict=True):
        rig = preset(name)
        ends.append(_draw(axes, rig))
        axes.set_title(f"({letter}) {name}: {_words(rig)}", fontsize=11)
    low, high = np.concatenate(ends).min(axis=0) - 0.1, np.concatenate(ends).max(axis=0) + 0.1
    for axes in panels.flat:
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes.axis("off")
    return figure


def _words(rig: Rig) -> str:
    cameras, lidars = rig.enabled_cameras(), rig.enabled_lidars()
    if lidars:
        heights = sorted({f"{one.position[2]:g}" for one in lidars})
        return f"{len(lidars)} LiDARs at {', '.join(heights)} m"
    degrees = sorted({round(field_of_view_deg(one)[0]) for one in cameras})
    return f"{len(cameras)} cameras of {' and '.join(f'{one}°' for one in degrees)}"


def _draw(axes: Axes, rig: Rig) -> Points:
    """Draw a rig; return where it ends in the picture, (2, 2)."""
    ahead, across, up = _view()
    looks = np.stack([across, up])
    faces, tones = _faces(rig, ahead)
    depth = np.array([float((face @ ahead).mean()) for face in faces])
    order = np.argsort(depth, kind="stable")  # what is near is drawn last
    shapes = [faces[place] @ looks.T for place in order]
    colours = [tones[place] for place in order]
    axes.add_collection(PolyCollection(shapes, facecolors=colours, edgecolors=colours, linewidths=0.2))
    wedges = [_wedge(camera) @ looks.T for camera in rig.enabled_cameras()]
    tone = to_rgb(ray_colour("camera", LIGHT))
    axes.add_collection(
        PolyCollection(wedges, facecolors=(*tone, 0.22), edgecolors=(*tone, 0.9), linewidths=0.8)
    )
    every = np.concatenate([*shapes, *wedges])
    return np.stack([every.min(axis=0), every.max(axis=0)])


def _view() -> tuple[Points, Points, Points]:
    """Return unit vectors to the eye, to the right of the picture, and up in it."""
    yaw, pitch = math.radians(YAW_DEG), math.radians(PITCH_DEG)
    ahead = np.array([math.cos(pitch) * math.cos(yaw), math.cos(pitch) * math.sin(yaw), math.sin(pitch)])
    across = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
    return ahead, across, np.cross(ahead, across)


def _faces(rig: Rig, ahead: Points) -> tuple[list[Points], list[tuple[float, float, float]]]:
    """Return the faces of the car and of its sensors that look at the eye, (n, 3) each, and their colours."""
    faces: list[Points] = []
    tones: list[tuple[float, float, float]] = []
    light = np.array([0.35, 0.25, 0.9])
    light /= np.linalg.norm(light)
    parts = [
        (surface.points.astype(np.float64)[surface.triangles], _TONES.get(material, _DARK))
        for material, surface in body_parts(rig.vehicle)
    ]
    car_m = np.concatenate([triangles.reshape(-1, 3) for triangles, _ in parts])
    for sensor in rig.sensors:
        x, y, z = sensor.position
        under = np.hypot(car_m[:, 0] - x, car_m[:, 1] - y) < _UNDER_M
        roof_m = float(car_m[under, 2].max(initial=0.0))
        parts.append((_cylinder(sensor.position, _MAST_M, roof_m, z), _DARK))
        housing = _cylinder(sensor.position, _RADIUS_M, z - _HEIGHT_M / 2, z + _HEIGHT_M / 2)
        parts.append((housing, to_rgb(ray_colour(sensor.kind, LIGHT))))
    for triangles, tone in parts:
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        length = np.linalg.norm(normals, axis=1)
        normals /= np.maximum(length, 1e-12)[:, None]
        bright = 0.55 + 0.45 * np.abs(normals @ light)
        kept = (normals @ ahead > 0.0) & (length > 0.0)
        faces += list(triangles[kept])
        tones += [tuple(np.clip(np.array(tone) * share, 0.0, 1.0)) for share in bright[kept]]
    return faces, tones


def _cylinder(place: tuple[float, float, float], radius_m: float, low_m: float, high_m: float) -> Points:
    """Return the triangles of an upright cylinder, (n, 3, 3), their outsides counterclockwise."""
    turns = np.linspace(0.0, 2.0 * np.pi, _SIDES, endpoint=False)
    ring = np.stack([np.cos(turns), np.sin(turns)], axis=1) * radius_m + np.array(place[:2])
    low, high = (np.column_stack([ring, np.full(_SIDES, z)]) for z in (low_m, high_m))
    after = np.roll(np.arange(_SIDES), -1)
    sides = [np.stack([low, low[after], high], axis=1), np.stack([low[after], high[after], high], axis=1)]
    top = np.broadcast_to([*place[:2], high_m], high.shape)
    return np.concatenate([*sides, np.stack([high, high[after], top], axis=1)])


def _wedge(camera: Camera) -> Points:
    """Return the level field of view of a camera, up to some metres, (n, 3)."""
    half = math.radians(field_of_view_deg(camera)[0]) / 2
    turns = math.radians(camera.rpy_deg[2]) + np.linspace(-half, half, 24)
    arc = np.stack([np.cos(turns), np.sin(turns), np.zeros(24)], axis=1) * _WEDGE_M
    return np.asarray(np.concatenate([np.zeros((1, 3)), arc]) + np.array(camera.position))
