"""From points in the vehicle frame to pixels of a camera, clipped in space before they are projected."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Camera, KannalaBrandt, rays_of
from riglens.core.sensing.rays import rotate
from riglens.core.sensors import lens
from riglens.core.sensors.camera import pixel_directions, project_px

Points = NDArray[np.float64]
NEAR_M = 0.05
"""Nothing nearer to the image plane than this is drawn."""
WIDEST_DEG = 89.0
"""Nothing farther from the optical axis than this is drawn: a polygon is cut by planes, and those end there."""
_MARGIN = 0.02
_SIDES = 24


@dataclass(frozen=True)
class Projection:
    """A camera's view. Camera frame: x forward, y left, z up; pixels: x right, y down, of the native image."""

    camera: Camera

    def to_camera(self, points_m: Points) -> Points:
        """Convert points (..., 3) from the vehicle frame to the camera frame, metres."""
        offset = np.asarray(points_m, np.float64) - np.array(self.camera.position)
        turned: Points = offset @ self.camera.pose.rotation()
        return turned

    @cached_property
    def planes(self) -> Points:
        """Return the planes (m, 4) of the drawn part: the near plane, and the sides of a pyramid around the image."""
        near = np.array([[1.0, 0.0, 0.0, -NEAR_M]])
        sides = self._image_sides() if self.camera.distortion is None else self._cone_sides()
        return np.concatenate([near, sides])

    def _image_sides(self) -> Points:
        """Return the sides of a pinhole's image, slightly widened."""
        fx, fy, cx, cy = self.camera.intrinsics_px()
        width, height = self.camera.image
        left, right, top, bottom = cx / fx, (cx - width) / fx, cy / fy, (cy - height) / fy
        wide, high = _MARGIN * (left - right), _MARGIN * (top - bottom)
        return np.array(
            [
                [left + wide, -1.0, 0.0, 0.0],
                [wide - right, 1.0, 0.0, 0.0],
                [top + high, 0.0, -1.0, 0.0],
                [high - bottom, 0.0, 1.0, 0.0],
            ]
        )

    def _cone_sides(self) -> Points:
        """Return a pyramid of many sides within the angle up to which a lens with distortion images anything."""
        angle = _widest_rad(_standing_nowhere(self.camera))
        turn = np.arange(_SIDES) * 2.0 * math.pi / _SIDES
        inner = math.atan(math.tan(angle) * math.cos(math.pi / _SIDES))
        across = math.cos(inner) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        return np.column_stack([np.full(_SIDES, math.sin(inner)), -across, np.zeros(_SIDES)])

    def directions(self, columns: int, rows: int) -> Points:
        """Return the unit directions (rows * columns, 3) in the vehicle frame through a lattice of pixels over the
        image; zero where the lens images nothing."""
        local = _lattice_directions(_standing_nowhere(self.camera), columns, rows)
        return rotate(self.camera.pose.rotation(), local)

    def polygons(self, corners_m: Points) -> list[Points]:
        """Return convex polygons (n, k, 3) of the vehicle frame as pixels, (m, 2) each, empty where out of view."""
        from riglens.core.kernels.rays import clip  # the compiler, only when a picture is computed

        inside = np.ascontiguousarray(self.to_camera(corners_m))
        clipped = np.empty((len(inside), inside.shape[1] + len(self.planes), 3))
        counts = np.zeros(len(inside), np.int64)
        clip.clip_polygons(inside, self.planes, clipped, counts)
        outlines = [part[:count] for part, count in zip(clipped, counts, strict=True)]
        if self.camera.distortion is not None:
            outlines = [_subdivided(np.concatenate([part, part[:1]]), 12)[:-1] for part in outlines]
        return self._pixels(outlines)

    def lines(self, starts_m: Points, ends_m: Points) -> list[Points]:
        """Project straight lines (n, 3) to (n, 3) of the vehicle frame to pixels, (m, 2) each; only those in view."""
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
        parts = list(a[seen, None] + ends * (b - a)[seen, None])
        return self._pixels(
            parts if self.camera.distortion is None else [_subdivided(part, 32) for part in parts]
        )

    def _pixels(self, parts: list[Points]) -> list[Points]:
        """Return pixels of paths (m, 3) in the camera frame, without the points that the lens does not image."""
        if not parts:
            return []
        pixels = project_px(self.camera, np.concatenate(parts))
        split = np.split(pixels, np.cumsum([len(part) for part in parts])[:-1])
        return [path[np.isfinite(path[:, 0])] for path in split]


def _standing_nowhere(camera: Camera) -> Camera:
    """Return the camera without name and pose: what stays the same during a drag."""
    return rays_of(camera).model_copy(update={"position": (0.0, 0.0, 0.0), "rpy_deg": (0.0, 0.0, 0.0)})


@lru_cache(maxsize=4)
def _lattice_directions(camera: Camera, columns: int, rows: int) -> Points:
    """Return the directions (rows * columns, 3) in the camera frame, zero for missing ones; slow for a lens with
    distortion."""
    width, height = camera.image
    x = (np.arange(columns) + 0.5) * width / columns
    y = (np.arange(rows) + 0.5) * height / rows
    return np.nan_to_num(pixel_directions(camera, np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)))


@lru_cache(maxsize=4)
def _widest_rad(camera: Camera) -> float:
    """Return the angle off the axis up to which a lens with distortion images anything that can be drawn."""
    distortion = camera.distortion
    assert distortion is not None
    limit = lens.radial_of(distortion).limit
    limit = limit if isinstance(distortion, KannalaBrandt) else math.atan(limit)
    border = pixel_directions(camera, _border_px(camera.image))
    used = float(np.arccos(np.clip(border[:, 0], -1.0, 1.0)).max())  # NaN where the lens has no direction
    reach = min(0.999 * limit, math.radians(WIDEST_DEG))
    return min(reach, 1.05 * used) if math.isfinite(used) else reach


def _subdivided(path: Points, pieces: int) -> Points:
    """Return a path (m, 3) with points between its own, evenly by angle as seen from the origin rather than by
    length."""
    rays = path / np.linalg.norm(path, axis=1, keepdims=True)
    share = np.arange(pieces)[:, None] / pieces
    steps = [start + share * (end - start) for start, end in pairwise(rays)]
    return np.concatenate([*steps, rays[-1:]])


def _border_px(image: tuple[int, int]) -> Points:
    """Return the points along the border of the image."""
    share = np.linspace(0.0, 1.0, 33)
    zero, one = np.zeros_like(share), np.ones_like(share)
    sides = [(share, zero), (share, one), (zero, share), (one, share)]
    return np.concatenate([np.stack(side, axis=1) for side in sides]) * np.array(image, np.float64)
