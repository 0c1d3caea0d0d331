"""Prepare the input and target of the picture detector: pictures of a rig's cameras, without LiDAR points.

Every pixel also says where its ray goes: its slope, where it would meet flat ground, and the focal length, so that one
net reads cameras of any lens and mount. No torch here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from riglens.core.detect.pillars import Target, target
from riglens.core.rig.model import Camera
from riglens.core.sensors.camera import cast_px, pixel_directions, project_px

Doubles = NDArray[np.float64]
Floats = NDArray[np.float32]
Ids = NDArray[np.int64]

FEATURES = 6
"""Figures of a pixel: red, green, blue, slope, log of the distance of flat ground, log of the focal length."""
FOCAL_PX, DISTANCE_M = 250.0, 15.0
"""Units of focal lengths and distances."""
LEAST_PX = 4
"""Objects with fewer cast pixels in a picture are not marked in it."""
_CELL_PX = 2
_DEPTH_SCALE, _ASIDE_CELLS = 3.0, 4.0
"""Scales of the two figures that are learned, so that their errors weigh alike."""
_NEAREST_M = 0.5


class Marks(NamedTuple):
    """Objects in one picture, m of them: cls (m,); peak (m, 2) row and column of the middle of what is visible, and
    column (m,) of the centre, cast pixels; distance_m (m,) of the centre from the camera along the ground."""

    cls: NDArray[np.uint8]
    peak: Floats
    column: Floats
    distance_m: Floats


@dataclass(frozen=True)
class Lenses:
    """Cameras of a rig, c of them, with the same number of pixels: rays (c, rows, columns, 3) and place_m (c, 3) in the
    vehicle frame, focal_px (c,) in cast pixels."""

    rays: Floats
    place_m: Doubles
    focal_px: Doubles

    @classmethod
    def of(cls, cameras: Sequence[Camera]) -> Self:
        """Return the lenses of a rig's cameras."""
        rays, focal_px = [], []
        for camera in cameras:
            columns, rows = camera.resolution
            pixels = cast_px(camera, np.arange(columns * rows))
            ahead = pixel_directions(camera, pixels) @ camera.pose.rotation().T
            rays.append(ahead.reshape(rows, columns, 3).astype(np.float32))
            focal_px.append(camera.intrinsics_px()[0] * columns / camera.image[0])
        place_m = np.array([camera.position for camera in cameras], np.float64)
        return cls(np.stack(rays), place_m, np.array(focal_px))

    @cached_property
    def figures(self) -> Floats:
        """Return what the pixels say of their rays, (c, rows, columns, 3)."""
        slope = self.rays[..., 2] / np.maximum(np.hypot(self.rays[..., 0], self.rays[..., 1]), 1e-6)
        height_m = self.place_m[:, 2, None, None]
        ground_m = height_m / np.maximum(-slope, 1e-3)
        near = np.clip(np.log(np.maximum(ground_m, 1e-3) / DISTANCE_M) / 2.0, -1.5, 1.5)
        focal = np.broadcast_to(2.0 * np.log(self.focal_px / FOCAL_PX)[:, None, None], slope.shape)
        return np.stack([np.clip(slope, -1.0, 1.0), near, focal], axis=-1).astype(np.float32)

    def located(self, camera: int, row: Ids, column: Doubles, distance_m: Doubles) -> Doubles:
        """Return places (k, 2) in the vehicle frame at distances (k,) along the rays through pixels of a camera, which
        may lie beside the picture."""
        ray = self.rays[camera, row].astype(np.float64)
        bearing = np.unwrap(np.arctan2(ray[..., 1], ray[..., 0]), axis=1)
        low = np.clip(np.floor(column).astype(np.int64), 0, bearing.shape[1] - 2)
        every = np.arange(len(row))
        start, end = bearing[every, low], bearing[every, low + 1]
        turn = start + (column - low) * (end - start)
        away = np.stack([np.cos(turn), np.sin(turn)], axis=1) * distance_m[:, None]
        return self.place_m[camera, :2] + away


@dataclass(frozen=True)
class Views:
    """Pictures of a rig in f frames: pixels (f, c, rows, columns, 3); mark_starts (f c + 1,) of the marks of each
    picture, m in all; the objects of each frame as in `Samples`, `points` being pixels."""

    frame: Ids
    pixels: NDArray[np.uint8]
    rays: Floats
    place_m: Doubles
    focal_px: Doubles
    mark_starts: Ids
    mark_cls: NDArray[np.uint8]
    mark_peak: Floats
    mark_column: Floats
    mark_distance_m: Floats
    object_starts: Ids
    cls: NDArray[np.uint8]
    centre_m: Doubles
    points: Ids

    def __len__(self) -> int:
        return len(self.frame)

    @cached_property
    def lenses(self) -> Lenses:
        """Return the cameras."""
        return Lenses(self.rays, self.place_m, self.focal_px)

    def image(self, frame: int, camera: int) -> Floats:
        """Return a picture as the net sees it, (rows, columns, FEATURES)."""
        colours = self.pixels[frame, camera].astype(np.float32) / 255.0 - 0.5
        return np.concatenate([colours, self.lenses.figures[camera]], axis=-1)

    def marks(self, frame: int, camera: int) -> Marks:
        """Return the objects in a picture."""
        place = frame * self.pixels.shape[1] + camera
        mine = slice(*self.mark_starts[place : place + 2])
        return Marks(
            self.mark_cls[mine], self.mark_peak[mine], self.mark_column[mine], self.mark_distance_m[mine]
        )


def marks_of(camera: Camera, pixels: Ids, bounds_px: Ids, cls: NDArray[np.uint8], centre_m: Doubles) -> Marks:
    """Return the marks of a picture from pixels (n,), bounds (n, 4), class and centre (n, 3) of the frame's objects."""
    local = (centre_m - np.array(camera.position)) @ camera.pose.rotation()
    chosen = (pixels >= LEAST_PX) & (local[:, 0] > _NEAREST_M)
    bounds, away = bounds_px[chosen], centre_m[chosen] - np.array(camera.position)
    peak = np.stack([bounds[:, 1] + bounds[:, 3] - 1, bounds[:, 0] + bounds[:, 2] - 1], axis=1) / 2.0
    column = project_px(camera, local[chosen])[:, 0] * camera.resolution[0] / camera.image[0] - 0.5
    column = np.clip(np.nan_to_num(column), -camera.resolution[0], 2 * camera.resolution[0])
    distance_m = np.hypot(away[:, 0], away[:, 1])
    return Marks(
        cls[chosen],
        peak.astype(np.float32),
        column.astype(np.float32),
        distance_m.astype(np.float32),
    )


def wanted_in(marks: Marks, focal_px: float, shape: tuple[int, int], mirrored: bool) -> Target:
    """Return the training target of a picture of (rows, columns) pixels; the two figures are the log of the distance
    over the focal length, and how far the centre lies aside of the cell."""
    rows, columns = shape
    peak, column = marks.peak, marks.column
    if mirrored:
        peak = np.stack([peak[:, 0], columns - 1 - peak[:, 1]], axis=1)
        column = columns - 1 - column
    corner = np.floor(peak / _CELL_PX).astype(np.int64)
    depth = np.log(marks.distance_m * FOCAL_PX / (focal_px * DISTANCE_M)) * _DEPTH_SCALE
    aside = (column / _CELL_PX - corner[:, 1]) / _ASIDE_CELLS
    return target(
        (rows // _CELL_PX, columns // _CELL_PX), marks.cls, corner, np.stack([depth, aside], axis=1)
    )


def places_of(lenses: Lenses, camera: int, cell: Ids, figures: Doubles) -> Doubles:
    """Return places (k, 2) in the vehicle frame of cells (k,) of a picture's answer with their two figures (k, 2)."""
    columns = lenses.rays.shape[2] // _CELL_PX
    row, column = np.divmod(cell, columns)
    distance_m = np.exp(figures[:, 0] / _DEPTH_SCALE) * DISTANCE_M * lenses.focal_px[camera] / FOCAL_PX
    aside = (column + figures[:, 1] * _ASIDE_CELLS) * _CELL_PX
    return lenses.located(camera, row * _CELL_PX + _CELL_PX // 2, aside, np.minimum(distance_m, 1e3))
