"""Drawings of a rig for a report: plans, which need no script, and what the view that turns draws."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from riglens.core.rig.model import Camera, Rig
from riglens.core.sensing.body_ends import body_ends
from riglens.core.sensing.rays import sensor_rays
from riglens.core.sensors.camera import field_of_view_deg
from riglens.core.vehicle.body import body_parts
from riglens.core.vehicle.mesh import BodyMesh
from riglens.core.vehicle.solid import CarBody

Points = NDArray[np.float64]
TONES = {
    "paint": (0.62, 0.66, 0.70, 1.0), "glass": (0.20, 0.25, 0.30, 1.0), "tyre": (0.12, 0.12, 0.13, 1.0),
    "lamp": (0.92, 0.92, 0.86, 1.0), "tail": (0.70, 0.16, 0.14, 1.0), "rim": (0.50, 0.52, 0.55, 1.0),
}  # fmt: skip
DARK = (0.22, 0.23, 0.25, 1.0)
RAY_TONES = {"lidar": (0.16, 0.45, 0.85, 0.22), "camera": (0.80, 0.50, 0.10, 0.22)}
RAYS_SHOWN, RAY_M = 150, 12.0
_SCALE = 62.0
MESH_CELLS = 160
_SAME, _DIGIT_WIDE, _LABEL_HIGH = 5.0, 7.0, 11.0
"""In a plan: so near to each other sensors are at one place; width of a digit and height of a line."""


class Label(NamedTuple):
    """Numbers of sensors at one place of a plan: where the text begins, and its base line."""

    left: float
    base: float
    text: str

    def meets(self, other: Label) -> bool:
        """Whether two labels are drawn over each other."""
        apart_x = max(self.left - other.right, other.left - self.right)
        return max(apart_x, abs(self.base - other.base) - _LABEL_HIGH) < 0.0

    @property
    def right(self) -> float:
        """Where the text ends, nearly."""
        return self.left + _DIGIT_WIDE * len(self.text)


@dataclass(frozen=True)
class Plans:
    """The car and its sensors from above and from the left, side by side: what plans.svg draws, in its units.

    Lines and areas are texts of points, as SVG has them; dots are (x, y, kind, name).
    """

    width: float
    height: float
    wedges: tuple[str, ...]
    ground: str
    outlines: tuple[str, ...]
    dots: tuple[tuple[float, float, str, str], ...]
    labels: tuple[Label, ...]


def plans(rig: Rig, mesh: BodyMesh | None) -> Plans:
    """Lay out both plans of a rig."""
    corners = np.concatenate(
        [points[triangles].reshape(-1, 3) for _, points, triangles in _surfaces(rig, mesh)]
    )
    spots = np.array([sensor.position for sensor in rig.sensors]).reshape(-1, 3)
    every = np.concatenate([corners, spots])
    low, high = every.min(axis=0) - 0.9, every.max(axis=0) + 0.9
    low[2] = -0.2
    wide = float(high[1] - low[1]) * _SCALE, float(high[0] - low[0]) * _SCALE

    def above(place: Points) -> Points:
        return np.stack([high[1] - place[:, 1], high[0] - place[:, 0]], axis=1) * _SCALE

    def beside(place: Points) -> Points:
        across = np.stack([high[0] - place[:, 0], high[2] - place[:, 2]], axis=1) * _SCALE
        return np.asarray(across + np.array([wide[0] + 40.0, 0.0]))

    looks = (above, beside)
    return Plans(
        width=wide[0] + wide[1] + 40.0,
        height=max(float(high[0] - low[0]), float(high[2] - low[2])) * _SCALE,
        wedges=tuple(_wedge(sensor, above) for sensor in rig.cameras()),
        ground=_path(beside(np.array([[high[0], 0.0, 0.0], [low[0], 0.0, 0.0]]))),
        outlines=tuple(_hull(look(corners)) for look in looks),
        dots=tuple(
            (x, y, sensor.kind, sensor.name)
            for look in looks
            for sensor, (x, y) in zip(rig.sensors, look(spots).tolist(), strict=True)
        ),
        labels=tuple(label for look in looks for label in labels(look(spots))),
    )


def labels(places: Points) -> list[Label]:
    """A label for each of some places (n, 2) of a plan, one for those that are the same; none over another as long as
    there is room right, left, above or below. Sensors count from 1."""
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


def _hull(flat: Points) -> str:
    return _path(flat[ConvexHull(flat).vertices])


def _wedge(camera: Camera, above: Callable[[Points], Points]) -> str:
    """The horizontal field of view of a camera, to 1.5 m."""
    wide = field_of_view_deg(camera)[0]
    half = math.radians(min(wide if math.isfinite(wide) else 180.0, 358.0) / 2)
    turns = np.linspace(-half, half, 24)
    local = np.stack([np.cos(turns), np.sin(turns), np.zeros_like(turns)], axis=1)
    arc = np.array(camera.position) + 1.5 * local @ camera.pose.rotation().T
    return _path(above(np.concatenate([[camera.position], arc])))


def _path(points: Points) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())


def _surfaces(rig: Rig, mesh: BodyMesh | None) -> list[tuple[str, Points, NDArray[np.int64]]]:
    """Materials, points and triangles of the car."""
    if mesh is not None:
        placed = mesh.coarse(MESH_CELLS).placed(rig.vehicle.mesh)
        return [("paint", placed.points.astype(np.float64), placed.triangles.astype(np.int64))]
    return [
        (part.material, part.surface.points.astype(np.float64), part.surface.triangles.astype(np.int64))
        for part in body_parts(rig.vehicle)
    ]


def view_data(rig: Rig, mesh: BodyMesh | None) -> dict[str, Any]:
    """The car in 16 bits a coordinate, and some rays of each sensor up to the body, the ground or 12 m."""
    surfaces = _surfaces(rig, mesh)
    points = np.concatenate([points for _, points, _ in surfaces])
    low, size = points.min(axis=0), np.maximum(np.ptp(points, axis=0), 1e-9)
    steps = np.rint((points - low) / size * 65535.0).astype("<u2")
    parts, first = [], 0
    for material, own, triangles in surfaces:
        tone = TONES.get(material, TONES["paint"] if material == "panel" else DARK)
        parts.append({"tone": tone, "triangles": _text((triangles + first).astype("<u4"))})
        first += len(own)
    rays = [
        {"tone": RAY_TONES[sensor.kind], "ends": _text(_ends(rig, mesh, number).astype("<f4"))}
        for number, sensor in enumerate(rig.sensors)
        if sensor.enabled
    ]
    away = 2.1 * float(max(rig.vehicle.length, 3.0))
    return {
        "low": np.round(low, 6).tolist(), "size": np.round(size, 6).tolist(), "away": away, "points": _text(steps),
        "parts": parts, "rays": rays,
    }  # fmt: skip


def _ends(rig: Rig, mesh: BodyMesh | None, number: int) -> Points:
    """Where some rays of a sensor begin and end, (2 n, 3)."""
    sensor = rig.sensors[number]
    every = sensor_rays(sensor).directions
    stops = body_ends(sensor, CarBody(rig.vehicle, mesh).solid())
    chosen = np.unique(np.linspace(0, len(every) - 1, RAYS_SHOWN).astype(np.int64))
    ahead, origin = every[chosen], np.array(sensor.position)
    with np.errstate(divide="ignore", invalid="ignore"):
        ground = np.where(ahead[:, 2] < 0.0, -origin[2] / ahead[:, 2], np.inf)
    reach = np.minimum(np.minimum(stops[chosen], RAY_M), np.maximum(ground, 0.0))
    ends = origin + ahead * reach[:, None]
    return np.stack([np.broadcast_to(origin, ends.shape), ends], axis=1).reshape(-1, 3)


def _text(values: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")
