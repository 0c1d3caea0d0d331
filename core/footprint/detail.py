"""Measure how finely a camera resolves places and objects: pixels per metre and degree, the lens in millimetres.

Pixels per metre are those of an upright board. For a pinhole it is parallel to the image, f / depth wherever it is in
the picture, as EN 62676-4 counts them; for a lens with distortion it faces the camera, and the direction counts in
which the lens resolves least. Both agree where the distortion is zero: off the axis a pinhole resolves more along the
radius than across it, and f / depth across.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.library import default_library
from riglens.core.sensors import lens
from riglens.core.sensors.camera import Camera, project_px
from riglens.core.targets.detection_range import SIZES_M

Points = NDArray[np.float64]
DISTANCES_M = (10.0, 30.0, 50.0, 100.0)
"""Distances along the optical axis at which objects are measured in pixels."""
MEASURED = ("pedestrian", "car")


@dataclass(frozen=True)
class PixelsOn:
    """Size in the picture of an object seen from behind on the optical axis, in pixels; NaN: beyond the lens."""

    cls: str
    distance_m: float
    width_px: float
    height_px: float


def px_per_m(camera: Camera, local_m: Points) -> Points:
    """Return pixels per metre at places (n, 3) in the sensor frame, along the image's width; NaN: not imaged."""
    focal_px = camera.intrinsics_px()[0]
    optical = np.stack([-local_m[:, 1], -local_m[:, 2], local_m[:, 0]], axis=-1)
    if camera.distortion is not None:
        return focal_px * lens.least_scale(camera.distortion, optical)
    with np.errstate(divide="ignore"):
        return np.where(optical[:, 2] > 0.0, focal_px / optical[:, 2], np.nan)


def px_per_deg(camera: Camera, local_m: Points) -> Points:
    """Return pixels per degree at places (n, 3) in the sensor frame; NaN: not imaged."""
    return np.asarray(px_per_m(camera, local_m) * np.linalg.norm(local_m, axis=1) * math.pi / 180.0)


def in_image(camera: Camera, local_m: Points) -> NDArray[np.bool_]:
    """Return whether places (n, 3) in the sensor frame are in the picture."""
    pixels = project_px(camera, local_m)
    with np.errstate(invalid="ignore"):
        inside = ((pixels >= 0.0) & (pixels <= camera.image)).all(axis=1)
    return np.asarray(inside & ~camera.blocked_rays(local_m))


def pixels_on(camera: Camera, cls: str, distances_m: tuple[float, ...] = DISTANCES_M) -> tuple[PixelsOn, ...]:
    """Return the size in pixels of an object of a class whose middle lies on the optical axis."""
    _, width_m, height_m = SIZES_M[cls]
    ends_m = np.array([[0, width_m, 0], [0, -width_m, 0], [0, 0, height_m], [0, 0, -height_m]]) / 2.0
    found = []
    for distance_m in distances_m:
        px = project_px(camera, ends_m + np.array([distance_m, 0.0, 0.0]))
        wide, high = px[1, 0] - px[0, 0], px[3, 1] - px[2, 1]
        found.append(PixelsOn(cls, distance_m, float(wide), float(high)))
    return tuple(found)


def pixel_um(camera: Camera) -> float | None:
    """Return the edge of a pixel by the sensor library, in micrometres; None without a model that says it."""
    known = {entry.name: entry.pixel_um for entry in default_library().entries(camera.kind)}
    return known.get(camera.model or "")


def focal_mm(camera: Camera) -> float | None:
    """Return the focal length in millimetres, or None if the pixel size is unknown."""
    pitch_um = pixel_um(camera)
    return None if pitch_um is None else camera.intrinsics_px()[0] * pitch_um / 1000.0
