"""Share of objects' silhouettes inside a camera's picture: what an object loses at the edge of the picture."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.objects import truncation as kernel
from riglens.core.kernels.objects.box_frames import Beams, FrameBoxes
from riglens.core.rig.model import Camera
from riglens.core.sensors.camera import pixel_directions, project_px

Doubles = NDArray[np.float64]
Ids = NDArray[np.int64]
_DIRECTIONS = 1 << 18
"""Room for directions, 6 MiB."""
_NEVER = 2.0


def shares_in_picture(camera: Camera, boxes: FrameBoxes, beams: Beams, objects: Ids) -> Doubles:
    """Return the share of the silhouette of each object (k,), by its number among the boxes, that lies inside the
    picture, as solid angle; blocked sectors are not part of it."""
    if camera.distortion is None and not camera.blocked:
        share = np.empty(len(objects))
        nothing = np.empty((0, 3))
        kernel.silhouettes(
            boxes, beams, objects, _edges(camera), 0.0, share, np.empty(len(objects), np.int64), nothing
        )
        return share
    found, directions = list[Doubles](), np.empty((_DIRECTIONS, 3))
    safe_cos = _NEVER if camera.blocked else _safe_cos(camera)
    while len(objects):
        share, hits = np.empty(len(objects)), np.zeros(len(objects), np.int64)
        done = kernel.silhouettes(boxes, beams, objects, np.empty(0), safe_cos, share, hits, directions)
        crossing = np.flatnonzero(share[:done] == kernel.UNKNOWN)
        if len(crossing):
            numbers = hits[crossing]
            inside = _is_shown(camera, directions[: numbers.sum()])
            share[crossing] = np.add.reduceat(inside, np.cumsum(numbers) - numbers, dtype=np.int64) / numbers
        found.append(share[:done])
        objects = objects[done:]
    return np.concatenate([np.zeros(0), *found])


def _edges(camera: Camera) -> Doubles:
    """Return the least and greatest slope to the left, then upwards, of the picture of a pinhole."""
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    width_px, height_px = camera.image
    return np.array([(cx_px - width_px) / fx_px, cx_px / fx_px, (cy_px - height_px) / fy_px, cy_px / fy_px])


def _safe_cos(camera: Camera) -> float:
    """Return the cosine of the half angle of a cone around the view that the picture of a lens holds."""
    width_px, height_px = camera.image
    u, v = (np.linspace(0.0, size, 64) for size in (width_px, height_px))
    sides = [np.column_stack([u, np.full(64, end)]) for end in (0.0, height_px)] + [
        np.column_stack([np.full(64, end), v]) for end in (0.0, width_px)
    ]
    ahead = pixel_directions(camera, np.concatenate(sides))[:, 0]
    if np.isnan(ahead).any():
        return _NEVER  # the lens ends somewhere inside the picture
    return float(np.cos(np.arccos(ahead.max()) * 0.98))  # between two of the pixels it is no nearer than that


def _is_shown(camera: Camera, directions: Doubles) -> NDArray[np.bool_]:
    """Return whether directions (m, 3) in the sensor frame fall on the picture, (m,)."""
    pixels = project_px(camera, directions)
    with np.errstate(invalid="ignore"):
        inside = ((pixels >= 0.0) & (pixels <= np.array(camera.image))).all(axis=1)
    return np.asarray(inside & ~camera.blocked_rays(directions) if camera.blocked else inside)
