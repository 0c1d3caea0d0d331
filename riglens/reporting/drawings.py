"""Draw a car for a report: its outlines, which need no script, and the data of the turning view."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PathCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.path import Path as MplPath
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from riglens.core.rig.model import Rig
from riglens.core.sensing.body_ends import barrier_of, listed_ends
from riglens.core.sensing.rays import lattice, rotate
from riglens.core.vehicle.body import body_parts
from riglens.core.vehicle.housings import car_of
from riglens.reporting.plans import UNITS_PER_M, CarShape
from riglens.widgets.sensors.appearance import ray_colour
from riglens.widgets.theme import LIGHT

Points = NDArray[np.float64]
TONES = {
    "paint": (0.62, 0.66, 0.70, 1.0), "glass": (0.20, 0.25, 0.30, 1.0), "tyre": (0.12, 0.12, 0.13, 1.0),
    "lamp": (0.92, 0.92, 0.86, 1.0), "tail": (0.70, 0.16, 0.14, 1.0), "rim": (0.50, 0.52, 0.55, 1.0),
}  # fmt: skip
DARK = (0.22, 0.23, 0.25, 1.0)
RAYS_SHOWN, RAY_M, RAY_OPACITY = 100, 5.0, 0.16
_MASK_DPI, _MASK_SCALE, _AT_ONCE = 100, 0.8, 200
"""Outline of the car: pixels of the picture per pixel of the plan, and triangles filled together."""
MESH_CELLS = 160


def car_shape(rig: Rig) -> CarShape:
    """Return the outlines of a rig's car."""
    triangles = np.concatenate([points[triangles] for _, points, triangles in _surfaces(rig)]) * UNITS_PER_M
    x, y, z = triangles[..., 0], triangles[..., 1], triangles[..., 2]
    return CarShape(_outline(np.stack([-y, -x], axis=-1)), _outline(np.stack([-x, -z], axis=-1)))


def _outline(triangles: Points) -> str:
    """Return the lines around what triangles (n, 3, 2) of a plan cover, holes too, as the path of an SVG."""
    low = triangles.min(axis=(0, 1)) - 3.0
    pixels = (triangles - low) * _MASK_SCALE
    one, other = pixels[:, 1] - pixels[:, 0], pixels[:, 2] - pixels[:, 0]
    is_reversed = one[:, 0] * other[:, 1] < one[:, 1] * other[:, 0]
    pixels[is_reversed] = pixels[is_reversed, ::-1]  # all turn one way: together they fill what each covers
    rings = np.concatenate([pixels, pixels[:, :1]], axis=1)
    steps = [MplPath.MOVETO, MplPath.LINETO, MplPath.LINETO, MplPath.CLOSEPOLY]
    parts = [rings[first : first + _AT_ONCE] for first in range(0, len(rings), _AT_ONCE)]
    paths = [MplPath(part.reshape(-1, 2), np.tile(steps, len(part))) for part in parts]
    width, height = np.ceil(pixels.max(axis=(0, 1)) + 3.0)
    figure = Figure((width / _MASK_DPI, height / _MASK_DPI), dpi=_MASK_DPI)
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, width), ylim=(height, 0.0))
    axes.set_axis_off()
    axes.add_collection(PathCollection(paths, color="black", linewidth=0.0, snap=False))
    canvas.draw()  # type: ignore[no-untyped-call]
    colours = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
    ink = gaussian_filter(1.0 - colours[..., 0] / 255.0, 0.7)
    middles = np.arange(ink.shape[1]) + 0.5, np.arange(ink.shape[0]) + 0.5
    lines = axes.contour(*middles, ink, [0.5]).allsegs[0]
    return " ".join(f"M{_path(np.asarray(line) / _MASK_SCALE + low)}Z" for line in lines)


def _path(points: Points) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())


def _surfaces(rig: Rig) -> list[tuple[str, Points, NDArray[np.int64]]]:
    """Return the materials, points and triangles of the car."""
    if rig.vehicle.body_mesh is not None:
        placed = rig.vehicle.body_mesh.coarse(MESH_CELLS).placed(rig.vehicle.mesh)
        return [("paint", placed.points.astype(np.float64), placed.triangles.astype(np.int64))]
    return [
        (material, surface.points.astype(np.float64), surface.triangles.astype(np.int64))
        for material, surface in body_parts(rig.vehicle)
    ]


def view_data(rig: Rig) -> dict[str, Any]:
    """Return the car in 16 bits a coordinate, and some rays of each sensor up to the body, the ground or 12 m."""
    surfaces = _surfaces(rig)
    points = np.concatenate([points for _, points, _ in surfaces])
    low, size = points.min(axis=0), np.maximum(np.ptp(points, axis=0), 1e-9)
    steps = np.rint((points - low) / size * 65535.0).astype("<u2")
    parts, first = [], 0
    for material, own, triangles in surfaces:
        tone = TONES.get(material, TONES["paint"] if material == "panel" else DARK)
        parts.append({"tone": tone, "triangles": _text((triangles + first).astype("<u4"))})
        first += len(own)
    rays = [
        {
            "tone": (*to_rgb(ray_colour(sensor.kind, LIGHT)), RAY_OPACITY),
            "ends": _text(_ends(rig, number).astype("<f4")),
        }
        for number, sensor in enumerate(rig.sensors)
        if sensor.enabled
    ]
    away = 2.1 * float(max(rig.vehicle.length, 3.0))
    return {
        "low": np.round(low, 6).tolist(), "size": np.round(size, 6).tolist(), "away": away, "points": _text(steps),
        "parts": parts, "rays": rays,
    }  # fmt: skip


def _ends(rig: Rig, number: int) -> Points:
    """Return where some rays of a sensor begin and end, (2 n, 3)."""
    sensor = rig.sensors[number]
    rays = lattice(sensor)
    count = len(rays.rows) * len(rays.planes)  # 0 if the whole sensor is blocked
    chosen = np.unique(np.linspace(0, count - 1, min(count, RAYS_SHOWN)).astype(np.int64))
    ahead, origin = rotate(sensor.pose.rotation(), rays.directions(chosen)), np.array(sensor.position)
    stops = np.minimum(listed_ends(sensor, ahead, barrier_of(sensor, car_of(rig))), sensor.range_m[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        ground = np.where(ahead[:, 2] < 0.0, -origin[2] / ahead[:, 2], np.inf)
    reach = np.minimum(np.minimum(stops, RAY_M), np.maximum(ground, 0.0))
    ends = origin + ahead * reach[:, None]
    return np.stack([np.broadcast_to(origin, ends.shape), ends], axis=1).reshape(-1, 3)


def _text(values: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")
