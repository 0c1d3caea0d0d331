"""From points in the vehicle frame to pixels of a camera, clipped in space before they are projected."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from core.kernels import clip
from core.rays import lattice, rotate
from core.rig.model import Camera

Points = NDArray[np.float64]
NEAR_M = 0.05
"""Nothing nearer to the image plane than this is drawn."""
_MARGIN = 0.02


@dataclass(frozen=True)
class Projection:
    """A camera's view. Camera frame: x forward, y left, z up; pixels: x right, y down, of the native image."""

    camera: Camera

    def to_camera(self, points_m: Points) -> Points:
        """Points (..., 3) of the vehicle frame in the camera frame, metres."""
        offset = np.asarray(points_m, np.float64) - np.array(self.camera.position)
        turned: Points = offset @ self.camera.pose.rotation()
        return turned

    @cached_property
    def planes(self) -> Points:
        """Planes (5, 4) of what is drawn: the near plane, and a little more than the image on its four sides."""
        (left, top), (right, bottom) = self._corner_slopes()
        wide, high = _MARGIN * (left - right), _MARGIN * (top - bottom)
        return np.array(
            [
                [1.0, 0.0, 0.0, -NEAR_M],
                [left + wide, -1.0, 0.0, 0.0],
                [wide - right, 1.0, 0.0, 0.0],
                [top + high, 0.0, -1.0, 0.0],
                [high - bottom, 0.0, 1.0, 0.0],
            ]
        )

    def _corner_slopes(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """(y / x, z / x) of the upper left and the lower right corner of the image."""
        fx, fy, cx, cy = self.camera.intrinsics_px()
        width, height = self.camera.image
        return (cx / fx, cy / fy), ((cx - width) / fx, (cy - height) / fy)

    def pixels(self, points_m: Points) -> Points:
        """Pixels (n, 2) of points (n, 3) of the camera frame that lie within `planes`."""
        fx, fy, cx, cy = self.camera.intrinsics_px()
        x, y, z = points_m[:, 0], points_m[:, 1], points_m[:, 2]
        return np.stack([cx - fx * y / x, cy - fy * z / x], axis=1)

    def directions(self, columns: int, rows: int) -> Points:
        """Unit directions (rows * columns, 3) in the vehicle frame through a lattice of pixel centres."""
        coarse = self.camera.model_copy(update={"cast": (columns, rows)})
        return rotate(self.camera.pose.rotation(), lattice(coarse).directions())

    def polygons(self, corners_m: Points) -> list[Points]:
        """Convex polygons (n, k, 3) of the vehicle frame as pixels, (m, 2) each, empty where out of view."""
        inside = self.to_camera(corners_m)
        clipped = np.empty((len(inside), inside.shape[1] + len(self.planes), 3))
        counts = np.zeros(len(inside), np.int64)
        clip.clip_polygons(np.ascontiguousarray(inside), self.planes, clipped, counts)
        flat = np.concatenate([part[:count] for part, count in zip(clipped, counts, strict=True)] or [_NONE])
        return np.split(self.pixels(flat), np.cumsum(counts)[:-1])

    def lines(self, starts_m: Points, ends_m: Points) -> list[Points]:
        """Straight lines (n, 3) to (n, 3) of the vehicle frame as pixels, (m, 2) each; those in view alone."""
        a, b = self.to_camera(starts_m), self.to_camera(ends_m)
        low, high = np.zeros(len(a)), np.ones(len(a))
        for plane in self.planes:
            at_a, at_b = a @ plane[:3] + plane[3], b @ plane[:3] + plane[3]
            with np.errstate(divide="ignore", invalid="ignore"):
                cross = at_a / (at_a - at_b)
            low = np.where((at_a < 0.0) & (at_b >= 0.0), np.maximum(low, cross), low)
            high = np.where((at_a >= 0.0) & (at_b < 0.0), np.minimum(high, cross), high)
            high = np.where((at_a < 0.0) & (at_b < 0.0), -1.0, high)
        seen = np.flatnonzero(low < high)
        ends = np.stack([low[seen], high[seen]], axis=1)[:, :, None]
        parts = a[seen, None] + ends * (b - a)[seen, None]
        return list(self.pixels(parts.reshape(-1, 3)).reshape(-1, 2, 2))


_NONE = np.zeros((0, 3))
