"""Replace a camera's lens by the nearest one that a format can hold, and report the difference.

The field of view is always that of the lens. Angles are in degrees from the optical axis, positive outwards.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from riglens.core.formats.report import Notes
from riglens.core.rig.model import BrownConrady, Camera, KannalaBrandt
from riglens.core.sensors.camera import pixel_directions
from riglens.core.sensors.lens import Radial, radial_of

Doubles = NDArray[np.float64]
WIDEST_PINHOLE_DEG = 179.0
NARROWEST_DEG = 1e-3
FTHETA_COEFFICIENTS = 6
"""Coefficients of an f-theta polynomial that are written: up to the fifth power of the angle."""
SMALLEST_TOLD_DEG = 0.005
_HALVINGS = 60
_COLUMNS, _ROWS = 41, 31
_SAMPLES = 400


class Extent(NamedTuple):
    """Extent of the image along its middle row and its middle column, in degrees from the optical axis."""

    left_deg: float
    right_deg: float
    up_deg: float
    down_deg: float

    @property
    def wide_deg(self) -> float:
        """Horizontal field of view."""
        return max(self.left_deg + self.right_deg, NARROWEST_DEG)

    @property
    def high_deg(self) -> float:
        """Vertical field of view."""
        return max(self.up_deg + self.down_deg, NARROWEST_DEG)

    def words(self) -> str:
        """Return the field of view for a reader."""
        return f"{self.wide_deg:.1f} x {self.high_deg:.1f} deg"


def extent(camera: Camera) -> Extent:
    """Return the extent of the image; where the lens has no image at the edge, the extent of its image."""
    width_px, height_px = camera.image
    _, _, cx_px, cy_px = camera.intrinsics_px()
    centre = np.array([cx_px, cy_px])
    edges = np.array([[0.0, cy_px], [width_px, cy_px], [cx_px, 0.0], [cx_px, height_px]])
    reached = _reached(camera, centre, edges)
    x, y, z = pixel_directions(camera, reached).T
    off_axis = np.degrees(np.arctan2(np.hypot(y, z), x))
    outwards = np.sign([cx_px, width_px - cx_px, cy_px, height_px - cy_px])
    left, right, up, down = (float(angle) for angle in off_axis * outwards)
    return Extent(left, right, up, down)


def _reached(camera: Camera, centre: Doubles, edges: Doubles) -> Doubles:
    """Return the pixels (n, 2) farthest from the principal point, towards the edges, that have a direction."""

    def is_seen(shares: Doubles) -> NDArray[np.bool_]:
        pixels = centre + shares[:, None] * (edges - centre)
        return np.asarray(np.isfinite(pixel_directions(camera, pixels)).all(axis=1))

    low = np.zeros(len(edges))
    high = np.ones(len(edges))
    low = np.where(is_seen(high), 1.0, low)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        seen = is_seen(middle)
        low, high = np.where(seen, middle, low), np.where(seen, high, middle)
    return np.asarray(centre + low[:, None] * (edges - centre))


def most_off_deg(camera: Camera, written: Camera) -> float:
    """Return the largest angle in degrees between the rays of one pixel by both lenses, over the whole image."""
    columns, rows = (
        np.linspace(0.0, size, count) for size, count in zip(camera.image, (_COLUMNS, _ROWS), strict=True)
    )
    u, v = np.meshgrid(columns, rows)
    pixels = np.stack([u.ravel(), v.ravel()], axis=-1)
    apart = np.linalg.norm(pixel_directions(camera, pixels) - pixel_directions(written, pixels), axis=1)
    apart = apart[np.isfinite(apart)]
    return math.degrees(2.0 * math.asin(min(1.0, float(apart.max()) / 2.0))) if apart.size else 0.0


def centred_pinhole(camera: Camera) -> Camera:
    """Return the pinhole of one focal length, centred on the image, that is as wide as the lens, 179 degrees at most.

    A pinhole keeps its focal length fx.
    """
    if camera.distortion is None:
        hfov_deg = math.degrees(2.0 * math.atan(camera.image[0] / 2.0 / camera.intrinsics_px()[0]))
    else:
        hfov_deg = extent(camera).wide_deg
    hfov_deg = min(max(hfov_deg, NARROWEST_DEG), WIDEST_PINHOLE_DEG)
    return camera.replace(distortion=None, fx=None, fy=None, cx=None, cy=None, hfov_deg=hfov_deg)


def pinhole_with_edges(camera: Camera) -> Camera | None:
    """Return the pinhole whose image ends at the same four angles as the camera's; None if no pinhole can."""
    angles = extent(camera)
    if not all(abs(angle) < WIDEST_PINHOLE_DEG / 2.0 for angle in angles):
        return None
    left, right, up, down = (math.tan(math.radians(angle)) for angle in angles)
    if not (left + right > 0.0 and up + down > 0.0):
        return None
    fx_px, fy_px = camera.image[0] / (left + right), camera.image[1] / (up + down)
    return camera.replace(distortion=None, fx=fx_px, fy=fy_px, cx=fx_px * left, cy=fy_px * up)


def equidistant(camera: Camera) -> Camera:
    """Return the equidistant fisheye, centred on the image, that is as wide as the lens."""
    width_px, height_px = camera.image
    focal_px = width_px / math.radians(extent(camera).wide_deg)
    centre = {"cx": width_px / 2.0, "cy": height_px / 2.0}
    return camera.replace(hfov_deg=None, fx=focal_px, fy=focal_px, **centre, distortion=KannalaBrandt())


def report_lens(camera: Camera, written: Camera, what: str, notes: Notes) -> None:
    """Report how far the written lens differs from the camera's own; nothing when both are the same.

    what: the lens that the format has, such as "a pinhole in the middle of its image".
    """
    off_deg = most_off_deg(camera, written)
    own, other = extent(camera), extent(written)
    if camera.distortion is not None:
        notes.ignored(f"lens distortion: the format has no place for it; {_off(off_deg)}", camera.name)
    elif off_deg >= SMALLEST_TOLD_DEG:
        notes.approximated(f"the format has {what}: {_off(off_deg)}", camera.name)
    if max(abs(own.wide_deg - other.wide_deg), abs(own.high_deg - other.high_deg)) >= 0.05:
        notes.approximated(
            f"field of view {own.words()}: written as {other.words()}, that of {what}", camera.name
        )


def _off(off_deg: float) -> str:
    return f"rays are up to {off_deg:.2f} deg off"


def radial_only(camera: Camera) -> Camera:
    """Return the camera with k1, k2 and k3 alone; the nearest ones where the model has more radial terms."""
    found = camera.distortion
    assert isinstance(found, BrownConrady)
    k1, k2, k3 = found.k1, found.k2, found.k3
    if any((found.k4, found.k5, found.k6)):
        k1, k2, k3 = _nearest_radial(camera, found)
    return camera.replace(distortion=BrownConrady(k1=k1, k2=k2, k3=k3))


def _nearest_radial(camera: Camera, found: BrownConrady) -> tuple[float, float, float]:
    """Return k1, k2, k3 that come nearest to a rational model over the image, by least squares."""
    radial = radial_of(found.model_copy(update={"p1": 0.0, "p2": 0.0}))
    r = np.linspace(0.0, _farthest(camera, radial), _SAMPLES)[1:]
    powers = np.stack([r**3, r**5, r**7], axis=1)
    k1, k2, k3 = np.linalg.lstsq(powers, radial_of(found).value(r) - r, rcond=None)[0]
    return float(k1), float(k2), float(k3)


def _farthest(camera: Camera, radial: Radial) -> float:
    """Return the lens's input at the image's farthest corner: a radius at distance 1, or an angle in radians.

    If the lens does not reach the corner, return a value just below its limit.
    """
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    x = max(abs(cx_px), abs(camera.image[0] - cx_px)) / fx_px
    y = max(abs(cy_px), abs(camera.image[1] - cy_px)) / fy_px
    corner = float(radial.inverse(np.array([math.hypot(x, y)]))[0])
    return corner if math.isfinite(corner) else 0.999 * min(radial.limit, 100.0)


def ftheta_polynomial(camera: Camera) -> tuple[list[float], float]:
    """Return the coefficients, lowest first, from angles in radians to pixels along v, and their error in px.

    Kannala-Brandt lenses with k1 and k2 alone are such polynomials; others are fitted over the image.
    """
    found = camera.distortion
    assert isinstance(found, KannalaBrandt)
    fy_px = camera.intrinsics_px()[1]
    if not (found.k3 or found.k4):
        return [0.0, fy_px, 0.0, fy_px * found.k1, 0.0, fy_px * found.k2], 0.0
    radial = radial_of(found)
    angles = np.linspace(0.0, _farthest(camera, radial), _SAMPLES)
    distances = fy_px * radial.value(angles)
    powers = np.stack([angles**power for power in range(1, FTHETA_COEFFICIENTS)], axis=1)
    fitted, *_ = np.linalg.lstsq(powers, distances, rcond=None)
    return [0.0, *(float(part) for part in fitted)], float(np.abs(powers @ fitted - distances).max())
