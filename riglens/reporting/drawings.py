"""Draw a rig for a report: plans, which need no script, and the data of the turning view."""

from __future__ import annotations

import base64
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PathCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.path import Path as MplPath
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from riglens.core.rig.model import Rig, Sensor
from riglens.core.sensing.body_ends import listed_ends
from riglens.core.sensing.rays import lattice, rotate
from riglens.core.sensors.registry import kind_of
from riglens.core.vehicle.body import body_parts
from riglens.core.vehicle.housings import car_of
from riglens.widgets.sensors.appearance import ray_colour
from riglens.widgets.theme import LIGHT

Points = NDArray[np.float64]
TONES = {
    "paint": (0.62, 0.66, 0.70, 1.0), "glass": (0.20, 0.25, 0.30, 1.0), "tyre": (0.12, 0.12, 0.13, 1.0),
    "lamp": (0.92, 0.92, 0.86, 1.0), "tail": (0.70, 0.16, 0.14, 1.0), "rim": (0.50, 0.52, 0.55, 1.0),
}  # fmt: skip
DARK = (0.22, 0.23, 0.25, 1.0)
RAYS_SHOWN, RAY_M, RAY_OPACITY = 150, 12.0, 0.22
WEDGE_M, CIRCLE_M = 1.5, 0.5
"""Drawn length of fields of view; those all around are circles."""
_SCALE = 62.0
_MASK_DPI, _MASK_SCALE, _AT_ONCE = 100, 0.8, 200
"""Outline of the car: pixels of the picture per pixel of the plan, and triangles filled together."""
MESH_CELLS = 160
_SAME, _DIGIT_WIDE, _LABEL_HIGH = 5.0, 7.0, 11.0
"""In a plan: so near to each other sensors are at one place; width of a digit and height of a line."""


class Label(NamedTuple):
    """Numbers of sensors at one place of a plan: where the text begins, and its base line."""

    left: float
    base: float
    text: str

    def meets(self, other: Label) -> bool:
        """Return whether two labels are drawn over each other."""
        apart_x = max(self.left - other.right, other.left - self.right)
        return max(apart_x, abs(self.base - other.base) - _LABEL_HIGH) < 0.0

    @property
    def right(self) -> float:
        """Return roughly where the text ends."""
        return self.left + _DIGIT_WIDE * len(self.text)


@dataclass(frozen=True)
class Plans:
    """Plans of the car and its sensors from above and from the left, side by side, for plans.svg, in its units.

    Lines and areas are texts of points, as SVG has them: wedges are (colour, points), an outline is all lines around
    and within the car from one side; dots are (x, y, colour, name); legend: colours and their meanings.
    """

    width: float
    height: float
    wedges: tuple[tuple[str, str], ...]
    ground: str
    outlines: tuple[str, ...]
    dots: tuple[tuple[float, float, str, str], ...]
    legend: tuple[tuple[str, str], ...]
    labels: tuple[Label, ...]


def plans(rig: Rig) -> Plans:
    """Lay out both plans of a rig."""
    triangles = np.concatenate([points[triangles] for _, points, triangles in _surfaces(rig)])
    spots = np.array([sensor.position for sensor in rig.sensors]).reshape(-1, 3)
    enabled = [sensor for sensor in rig.sensors if sensor.enabled]
    views = [_view(sensor) for sensor in enabled]
    every = np.concatenate([triangles.reshape(-1, 3), spots])
    low, high = every.min(axis=0) - 0.3, every.max(axis=0) + 0.3
    flat = np.concatenate([every, *views])[:, :2]
    low[:2], high[:2] = flat.min(axis=0) - 0.3, flat.max(axis=0) + 0.3
    low[2] = -0.2
    wide = float(high[1] - low[1]) * _SCALE, float(high[0] - low[0]) * _SCALE

    def above(place: Points) -> Points:
        return np.stack([high[1] - place[..., 1], high[0] - place[..., 0]], axis=-1) * _SCALE

    def beside(place: Points) -> Points:
        across = np.stack([high[0] - place[..., 0], high[2] - place[..., 2]], axis=-1) * _SCALE
        return np.asarray(across + np.array([wide[0] + 40.0, 0.0]))

    looks = (above, beside)
    return Plans(
        width=wide[0] + wide[1] + 40.0,
        height=max(float(high[0] - low[0]), float(high[2] - low[2])) * _SCALE,
        wedges=tuple(
            (ray_colour(s.kind, LIGHT), _path(above(view))) for s, view in zip(enabled, views, strict=True)
        ),
        ground=_path(beside(np.array([[high[0], 0.0, 0.0], [low[0], 0.0, 0.0]]))),
        outlines=tuple(_outline(look(triangles)) for look in looks),
        dots=tuple(
            (x, y, ray_colour(sensor.kind, LIGHT), sensor.name)
            for look in looks
            for sensor, (x, y) in zip(rig.sensors, look(spots).tolist(), strict=True)
        ),
        labels=tuple(label for look in looks for label in labels(look(spots))),
        legend=tuple(
            {
                kind.name: (ray_colour(kind.name, LIGHT), kind.title) for kind in map(kind_of, rig.sensors)
            }.values()
        ),
    )


def labels(places: Points) -> list[Label]:
    """Return a label for each of some places (n, 2) of a plan, one for those that are the same; none over another as
    long as there is room right, left, above or below. Sensors count from 1."""
    groups: list[tuple[tuple[float, float], list[int]]] = []
    for number, (x, y) in enumerate(places.tolist(), 1):
        near = next((held for (ax, ay), held in groups if math.hypot(x - ax, y - ay) < _SAME), None)
        if near is None:
            groups.append(((x, y), [number]))
        else:
            near.append(number)
    found: list[Label] = []
    dots = [Label(x - _DIGIT_WIDE / 2, y + 4.0, "o") for (x, y), _ in groups]
    for (x, y), numbers in groups:
        text = ", ".join(map(str, numbers))
        wide = _DIGIT_WIDE * len(text)
        rooms = [
            Label(x + dx, y + 4.0 + step * _LABEL_HIGH, text)
            for step in (0, -1, 1, -2, 2, -3, 3)
            for dx in (6.0, -6.0 - wide)
        ]
        free = (room for room in rooms if not any(room.meets(other) for other in (*found, *dots)))
        found.append(next(free, rooms[0]))
    return found


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


def _view(sensor: Sensor) -> Points:
    """Return the horizontal field of view of a sensor: a wedge (n, 3) that begins at it, or a circle."""
    wide = kind_of(sensor).view_deg(sensor)[0]
    is_round = wide >= 359.0
    half = math.radians((min(wide, 360.0) if math.isfinite(wide) else 180.0) / 2)
    turns = np.linspace(-half, half, 48)
    local = np.stack([np.cos(turns), np.sin(turns), np.zeros_like(turns)], axis=1)
    arc = np.array(sensor.position) + (CIRCLE_M if is_round else WEDGE_M) * local @ sensor.pose.rotation().T
    return np.asarray(arc if is_round else np.concatenate([[sensor.position], arc]))


def _path(points: Points) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())


def _surfaces(rig: Rig) -> list[tuple[str, Points, NDArray[np.int64]]]:
    """Return the materials, points and triangles of the car."""
    if rig.vehicle.body_mesh is not None:
        placed = rig.vehicle.body_mesh.coarse(MESH_CELLS).placed(rig.vehicle.mesh)
        return [("paint", placed.points.astype(np.float64), placed.triangles.astype(np.int64))]
    return [
        (part.material, part.surface.points.astype(np.float64), part.surface.triangles.astype(np.int64))
        for part in body_parts(rig.vehicle)
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
    stops = np.minimum(listed_ends(sensor, ahead, car_of(rig)), sensor.range_m[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        ground = np.where(ahead[:, 2] < 0.0, -origin[2] / ahead[:, 2], np.inf)
    reach = np.minimum(np.minimum(stops, RAY_M), np.maximum(ground, 0.0))
    ends = origin + ahead * reach[:, None]
    return np.stack([np.broadcast_to(origin, ends.shape), ends], axis=1).reshape(-1, 3)


def _text(values: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")
