"""Cameras as a mapping between pixels and directions, with or without lens distortion.

Sensor frame: x along the view, y left, z up. Pixels: u to the right and v down from the upper left corner of the
native image; the centre of the first pixel is (0.5, 0.5).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Camera
from riglens.core.sensing import lens

Doubles = NDArray[np.float64]


def cast_px(camera: Camera, rays: NDArray[np.int64]) -> Doubles:
    """Native pixels (n, 2) through which the rays of those numbers are cast, row * columns + column (eq. 3)."""
    columns, rows = camera.cast
    u = (rays % columns + 0.5) * camera.image[0] / columns
    return np.stack([u, (rays // columns + 0.5) * camera.image[1] / rows], axis=-1)


def pixel_directions(camera: Camera, pixels: Doubles) -> Doubles:
    """Unit directions (n, 3) in the sensor frame that fall on native pixels (n, 2); NaN where there is none."""
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    x, y = (pixels[:, 0] - cx_px) / fx_px, (pixels[:, 1] - cy_px) / fy_px
    if camera.distortion is not None:
        right, down, ahead = lens.undistorted(camera.distortion, x, y).T
        return np.stack([ahead, -right, -down], axis=-1)
    norm = np.sqrt(1.0 + x * x + y * y)
    return np.stack([1.0 / norm, -x / norm, -y / norm], axis=-1)


def project_px(camera: Camera, points: Doubles) -> Doubles:
    """Native pixels (n, 2) of points or directions (n, 3) in the sensor frame; NaN: not imaged by the lens.

    A point behind a pinhole is not imaged, nor one beyond the angle up to which a distortion grows; fisheyes see
    points behind them. Pixels may lie outside the image: compare them with `camera.image`.
    """
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    optical = np.stack([-points[:, 1], -points[:, 2], points[:, 0]], axis=-1)
    if camera.distortion is not None:
        plane = lens.distorted(camera.distortion, optical)
    else:
        depth = optical[:, 2:]
        with np.errstate(all="ignore"):
            plane = np.where(depth > 0.0, optical[:, :2] / depth, np.nan)
    return np.asarray(plane * np.array([fx_px, fy_px]) + np.array([cx_px, cy_px]))


def field_of_view_deg(camera: Camera) -> tuple[float, float]:
    """Angles in degrees that the image spans along its middle row and its middle column; NaN: beyond the lens."""
    width_px, height_px = camera.image
    _, _, cx_px, cy_px = camera.intrinsics_px()
    edges = np.array([[0.0, cy_px], [width_px, cy_px], [cx_px, 0.0], [cx_px, height_px]])
    x, y, z = pixel_directions(camera, edges).T
    off_axis = np.degrees(np.arctan2(np.hypot(y, z), x))
    outwards = off_axis * np.sign([cx_px, width_px - cx_px, cy_px, height_px - cy_px])
    return float(outwards[0] + outwards[1]), float(outwards[2] + outwards[3])
