"""Parts of a heatmap that take about equally long to draw, so that nobody has to wait for all of it. No Qt, no VTK."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from riglens.widgets.viewport.camera import OrbitCamera, Size

SLANTED = 1.25
"""Squares that face the eye are drawn larger by this than a cell is wide, or gaps would show at a slant."""
SMALLEST_PX, LARGEST_PX = 1.0, 96.0
PART_PX = 4e6
"""Blended pixels of a part: about 20 ms on two cores without a graphics card."""
_POINT_PX = 20.0
"""A cell takes as long as so many pixels before the first one of it is drawn."""


def cell_scale_px(cell_m: float, camera: OrbitCamera, size: Size) -> float:
    """Edge of a cell's square in pixels: of a parallel view, else of a cell one metre in front of the eye."""
    at_1m = cell_m * size[1] / 2 / math.tan(math.radians(camera.view_angle_deg) / 2)
    return at_1m / camera.distance_m if camera.parallel else SLANTED * at_1m


def in_parts(
    centres_m: NDArray[np.float32],
    order: NDArray[np.int64],
    cell_m: float,
    camera: OrbitCamera,
    size: Size,
    part_px: float = PART_PX,
) -> list[NDArray[np.int64]]:
    """Cut `order` (k,), rows of `centres_m` (n, 3), into parts of about `part_px` pixels each."""
    right, down, depth_m = camera.project(centres_m.astype(np.float64), size).T
    in_view = (
        (depth_m > 0.0) & (np.abs(2 * right - size[0]) < size[0]) & (np.abs(2 * down - size[1]) < size[1])
    )
    edge_px = cell_scale_px(cell_m, camera, size) / (1.0 if camera.parallel else np.maximum(depth_m, 1e-3))
    pixels = _POINT_PX + in_view * np.clip(edge_px, SMALLEST_PX, LARGEST_PX) ** 2
    total_px = np.cumsum(pixels[order])
    cuts = np.arange(part_px, total_px[-1] if len(order) else 0.0, part_px)
    return [part for part in np.split(order, np.searchsorted(total_px, cuts)) if len(part)]
