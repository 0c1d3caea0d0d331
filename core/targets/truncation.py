"""Share of objects' silhouettes inside a camera's picture: what an object loses at the edge of the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.in_threads import in_threads
from riglens.core.kernels.objects import truncation as kernel
from riglens.core.kernels.objects.box_frames import Beams, FrameBoxes
from riglens.core.rig.model import Camera
from riglens.core.sensors.camera import picture_slopes, pixel_directions, project_px

Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]
_DIRECTIONS = 1 << 18
"""Room for directions, 6 MiB."""
_NEVER = 2.0
_NO_EDGES = np.array([1.0, -1.0, 1.0, -1.0])
"""Slopes between which nothing lies."""
_WITHIN = 0.98
"""Share of what the pixels at the border of a picture hold that is certain: between two of these it is no nearer."""


def shares_in_picture(
    camera: Camera, boxes: FrameBoxes, beams: Beams, objects: Ids, workers: int = 1
) -> Doubles:
    """Return the share of the silhouette of each object (k,), by its number among the boxes, that lies inside the
    picture, as solid angle; blocked sectors are not part of it. Each worker takes some of the objects."""
    parts = np.array_split(objects, workers)
    return np.concatenate(in_threads(workers, lambda share: _shares(camera, boxes, beams, parts[share])))


def _shares(camera: Camera, boxes: FrameBoxes, beams: Beams, objects: Ids) -> Doubles:
    if camera.distortion is None and not camera.blocked:
        share = np.empty(len(objects))
        nothing = np.empty((0, 3))
        kernel.silhouettes(
            boxes,
            beams,
            objects,
            True,
            picture_slopes(camera),
            _NEVER,
            share,
            np.empty(len(objects), np.int64),
            nothing,
        )
        return share
    found, directions = list[Doubles](), np.empty((_DIRECTIONS, 3))
    safe_edges, safe_cos = (_NO_EDGES, _NEVER) if camera.blocked else _held(camera)
    while len(objects):
        share, hits = np.empty(len(objects)), np.zeros(len(objects), np.int64)
        done = kernel.silhouettes(boxes, beams, objects, False, safe_edges, safe_cos, share, hits, directions)
        crossing = np.flatnonzero(share[:done] == kernel.UNKNOWN)
        if len(crossing):
            numbers = hits[crossing]
            inside = _is_shown(camera, directions[: numbers.sum()])
            share[crossing] = np.add.reduceat(inside, np.cumsum(numbers) - numbers, dtype=np.int64) / numbers
        found.append(share[:done])
        objects = objects[done:]
    return np.concatenate([np.zeros(0), *found])


def _held(camera: Camera) -> tuple[Doubles, float]:
    """Return what the picture of a lens holds for certain: the least and greatest slopes of a rectangle, as
    `picture_slopes`, and the cosine of the half angle of a cone around the view."""
    width_px, height_px = camera.image
    u, v = (np.linspace(0.0, size, 64) for size in (width_px, height_px))
    sides = [np.column_stack([np.full(64, end), v]) for end in (width_px, 0.0)] + [
        np.column_stack([u, np.full(64, end)]) for end in (height_px, 0.0)
    ]
    border = np.array([pixel_directions(camera, side) for side in sides])
    if np.isnan(border).any():
        return _NO_EDGES, _NEVER  # the lens ends somewhere inside the picture
    safe_cos = float(np.cos(np.arccos(border[..., 0].max()) * _WITHIN))
    if border[..., 0].min() <= 0.0:
        return _NO_EDGES, safe_cos
    slopes = border[..., 1:] / border[..., :1]
    right, left, low, high = (
        slopes[0, :, 0].max(),
        slopes[1, :, 0].min(),
        slopes[2, :, 1].max(),
        slopes[3, :, 1].min(),
    )
    if not (right < 0.0 < left and low < 0.0 < high):
        return _NO_EDGES, safe_cos
    return np.array([right, left, low, high]) * _WITHIN, safe_cos


def _is_shown(camera: Camera, directions: Doubles) -> NDArray[np.bool_]:
    """Return whether directions (m, 3) in the sensor frame fall on the picture, (m,)."""
    pixels = project_px(camera, directions)
    with np.errstate(invalid="ignore"):
        inside = ((pixels >= 0.0) & (pixels <= np.array(camera.image))).all(axis=1)
    return np.asarray(inside & ~camera.blocked_rays(directions) if camera.blocked else inside)
