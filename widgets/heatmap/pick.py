"""Pick the heatmap cell under the mouse: of those drawn there, the one nearest to the eye. No Qt, no VTK."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.view.heatmap_data import HeatmapData
from riglens.widgets.drawing.camera import OrbitCamera, Points, Size, ViewRay
from riglens.widgets.heatmap.scale import HeatLook, in_slice, strength

CAR_CENTRE_M = (0.0, 0.0, 1.4)
CAR_RADII_M = (3.2, 1.8, 2.1)
"""Cells between the eye and this ellipsoid around the car are drawn almost clear."""
CLEAR_BEFORE = (-0.7, 0.3)
CLEAR_BESIDE = (0.9, 1.5)
_LEAST_REACH_PX = 3.0


@dataclass(frozen=True)
class PickedCell:
    """A cell of the heatmap: its number, centre (3,) and edge in metres, and the view ray that met it."""

    row: int
    centre_m: Points
    cell_m: float
    ray: ViewRay


def cell_at(
    data: HeatmapData, look: HeatLook, camera: OrbitCamera, size: Size, pixel: tuple[float, float]
) -> PickedCell | None:
    """Return the nearest cell whose square, as drawn at rest, covers a pixel; None when there is none.

    Of a heatmap on the ground it is the strongest of those above the place under the pixel.
    """
    rows = in_slice(look, data.centres_m[:, 2])
    rows = rows[(strength(data, data.values, data.weights, look.log) > look.threshold)[rows]]
    centres_m = data.centres_m[rows].astype(np.float64)
    if not len(rows):
        return None
    if look.draped:
        return _above_ground(data, rows, look, camera.ray(pixel, size))
    seen = camera.project(centres_m, size)
    depth = np.full(len(rows), camera.distance_m) if camera.parallel else np.maximum(seen[:, 2], 1e-6)
    half_px = data.cell_m * size[1] / 4 / np.tan(np.radians(camera.view_angle_deg) / 2) / depth
    reach = np.maximum(half_px, _LEAST_REACH_PX)
    hit = np.flatnonzero((np.abs(seen[:, :2] - pixel).max(axis=1) <= reach) & (seen[:, 2] > 0.0))
    hit = hit[~is_clear(centres_m[hit], eye_m(camera))]
    if not len(hit):
        return None
    nearest = hit[np.argmin(seen[hit, 2])]
    return PickedCell(int(rows[nearest]), centres_m[nearest], data.cell_m, camera.ray(pixel, size))


def _above_ground(
    data: HeatmapData, rows: NDArray[np.int64], look: HeatLook, ray: ViewRay
) -> PickedCell | None:
    """Return the strongest of some cells above where a view ray meets the ground."""
    fall = float(ray.direction[2])
    if fall >= 0.0:
        return None
    place = (ray.origin_m - ray.origin_m[2] / fall * ray.direction)[:2]
    centres_m = data.centres_m[rows].astype(np.float64)
    over = rows[(np.abs(centres_m[:, :2] - place) <= data.cell_m / 2).all(axis=1)]
    if not len(over):
        return None
    strongest = int(over[np.argmax(strength(data, data.values, data.weights, look.log)[over])])
    return PickedCell(strongest, data.centres_m[strongest].astype(np.float64), data.cell_m, ray)


def eye_m(camera: OrbitCamera, far_m: float = 1e4) -> Points:
    """Return the position of the viewer, (3,) metres; of a parallel view far away."""
    distance_m = far_m if camera.parallel else camera.distance_m
    return np.asarray(camera.focal_m - distance_m * camera.axes()[2])


def is_clear(points_m: Points, eye: Points) -> np.ndarray:
    """Return whether cells are drawn almost clear, (n,): those inside the cone from the eye to the car, and in front of
    it."""
    to_cell = (points_m - eye) / CAR_RADII_M
    to_car = (np.array(CAR_CENTRE_M) - eye) / CAR_RADII_M
    far = np.linalg.norm(to_car)
    along = to_cell @ (to_car / far)
    beside = np.linalg.norm(to_cell - along[:, None] * (to_car / far), axis=1) * far / np.maximum(along, 1e-6)
    return np.asarray((along < far + np.mean(CLEAR_BEFORE)) & (beside < np.mean(CLEAR_BESIDE)))
