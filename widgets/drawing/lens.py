"""Pictures through the lens of a camera: a flat picture of the scene is drawn, and bent to the lens's own."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Camera
from riglens.core.sensors.camera import pixel_directions
from riglens.widgets.drawing.camera import OrbitCamera, Size, along, through

_LEAST_DEPTH, _MOST_PX = 0.25, 4096
"""Share of a direction along the view below which the flat picture would be too wide, and sides of that picture."""


class Bend(NamedTuple):
    """Flat picture to draw, and the places (h, w, 2) in it, right and down, of the pixels of the bent one; NaN: not
    imaged."""

    view: OrbitCamera
    size: Size
    places: NDArray[np.float64]

    def of(self, flat: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the bent picture (h, w, c) of a flat one, between four of its pixels each; black where not imaged."""
        height, width = flat.shape[:2]
        is_imaged = np.isfinite(self.places[..., :1])
        most = np.array([width - 1, height - 1])
        at = np.clip(np.where(is_imaged, self.places - 0.5, 0.0), 0.0, most)
        low = at.astype(np.intp)
        high, (right, down) = np.minimum(low + 1, most), np.moveaxis(at - low, -1, 0)[..., None]
        (x0, y0), (x1, y1) = np.moveaxis(low, -1, 0), np.moveaxis(high, -1, 0)
        upper = (1.0 - right) * flat[y0, x0] + right * flat[y0, x1]
        lower = (1.0 - right) * flat[y1, x0] + right * flat[y1, x1]
        image = np.round((1.0 - down) * upper + down * lower).astype(np.uint8)
        image[..., :3] *= is_imaged
        return np.asarray(image, np.uint8)


def bend_of(camera: Camera, size: Size, step: int = 1) -> Bend | None:
    """Return how a picture of a size is drawn through a camera's lens, roll and shift of its centre included; None of
    one too wide for a flat picture. The sides of the flat picture are multiples of `step`."""
    view = through(camera)
    if view is None:
        return None
    return _bent(camera, size, step, view, _world_directions(camera, size))


def bends_of(camera: Camera, size: Size, step: int = 1) -> tuple[Bend, ...]:
    """Return the flat pictures that make up one through a lens of any width: one, or the faces of a cube of which each
    pixel has the nearest; other pixels are not imaged."""
    whole = bend_of(camera, size, step)
    if whole is not None:
        return (whole,)
    rays, turned = _world_directions(camera, size), camera.pose.rotation()
    faces = np.array([turned[:, 0], turned[:, 1], -turned[:, 1], turned[:, 2], -turned[:, 2]])
    nearest = (rays @ faces.T).argmax(axis=1)
    places = tuple(np.where((nearest == n)[:, None], rays, np.nan) for n in range(len(faces)))
    return tuple(
        _bent(camera, size, step, along(camera, face, 90.0), seen)
        for face, seen in zip(faces, places, strict=True)
        if np.isfinite(seen).any()
    )


def _bent(camera: Camera, size: Size, step: int, view: OrbitCamera, rays: NDArray[np.float64]) -> Bend:
    """Return the bend of a view for the rays (n, 3) of a picture's pixels in the world, NaN for those left out."""
    right, up, forward = (rays @ np.array(view.axes()).T).T
    with np.errstate(all="ignore"):
        depth = np.where(forward > _LEAST_DEPTH, forward, np.nan)
        x, y = right / depth, up / depth
    wide, high = float(np.nanmax(np.abs(x))), float(np.nanmax(np.abs(y)))
    px = camera.intrinsics_px()[0] * size[0] / camera.image[0]
    px = min(px, _MOST_PX / (2.0 * max(wide, high)))
    flat = (math.ceil(2.0 * wide * px / step) * step, math.ceil(2.0 * high * px / step) * step)
    view = replace(view, view_angle_deg=2.0 * math.degrees(math.atan(flat[1] / 2.0 / px)))
    places = np.stack([flat[0] / 2.0 + px * x, flat[1] / 2.0 - px * y], axis=-1)
    return Bend(view, flat, places.reshape(size[1], size[0], 2))


def _world_directions(camera: Camera, size: Size) -> NDArray[np.float64]:
    """Return the directions (n, 3) of the pixels of a picture in the vehicle frame."""
    optics = camera.replace(name="optics", position=(0.0, 0.0, 0.0), rpy_deg=(0.0, 0.0, 0.0))
    return np.asarray(_directions(optics, size) @ camera.pose.rotation().T)


@lru_cache(maxsize=4)
def _directions(optics: Camera, size: Size) -> NDArray[np.float64]:
    """Return the directions (n, 3) of the pixels of a picture, row by row, in the sensor frame."""
    u, v = ((np.arange(most) + 0.5) * own / most for most, own in zip(size, optics.image, strict=True))
    return pixel_directions(optics, np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2))
