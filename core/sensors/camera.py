"""Cameras: images of a pinhole or of a lens with distortion, as a mapping between pixels and directions.

Sensor frame: x along the view, y left, z up. Pixels: u to the right and v down from the upper left corner of the
native image; the centre of the first pixel is (0.5, 0.5).
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator
from pydantic.config import JsonDict

from riglens.core.kernels.runtime import codes
from riglens.core.sensors import lens
from riglens.core.sensors.base import Sensor
from riglens.core.sensors.kind import HitMeasure, Occlusion, Placement, SensorKind
from riglens.core.sensors.lattice import MAX_LISTED_RAYS, Lattice
from riglens.core.sensors.lens import Distortion
from riglens.core.sensors.mounting import outwards_rpy_deg

Doubles = NDArray[np.float64]
FieldOfView = Annotated[float, Field(allow_inf_nan=False, ge=0.001, le=179.9)]
FocalLength = Annotated[float, Field(allow_inf_nan=False, ge=1e-4, le=1e10)]
"""Focal length in pixels; every accepted field of view has one, whatever the image."""
PrincipalPoint = Annotated[float, Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
Pixels = Annotated[int, Field(ge=1, le=20_000)]
_PX: JsonDict = {"unit": "px"}


class Camera(Sensor):
    """Camera; casts a ray through the centre of every pixel, or of the image resized to `cast` (paper, eq. 3-5).

    Of an image with more than MAX_LISTED_RAYS pixels, every second pixel each way, or every third, and so on.
    A pinhole, or with `distortion` a lens that bends its rays as in `riglens.core.sensors.lens`.
    """

    kind: Literal["camera"] = "camera"
    image: Annotated[tuple[Pixels, Pixels], Field(description="width, height", json_schema_extra=_PX)] = (
        1600,
        900,
    )
    hfov_deg: Annotated[FieldOfView | None, Field(title="HFOV", description="horizontal field of view")] = (
        None
    )
    fx: Annotated[
        FocalLength | None, Field(description="focal length along the width", json_schema_extra=_PX)
    ] = None
    fy: Annotated[
        FocalLength | None, Field(description="focal length along the height", json_schema_extra=_PX)
    ] = None
    cx: Annotated[
        PrincipalPoint | None, Field(description="principal point from the left edge", json_schema_extra=_PX)
    ] = None
    cy: Annotated[
        PrincipalPoint | None, Field(description="principal point from the upper edge", json_schema_extra=_PX)
    ] = None
    distortion: Distortion | None = None
    cast: Annotated[
        tuple[Pixels, Pixels] | None,
        Field(
            title="Lattice",
            description="columns, rows of the ray lattice; never more than the image has pixels",
        ),
    ] = None

    @model_validator(mode="after")
    def _one_way_to_say_the_lens(self) -> Self:
        given = [value is not None for value in (self.fx, self.fy, self.cx, self.cy)]
        if (self.hfov_deg is None and not all(given)) or (self.hfov_deg is not None and any(given)):
            raise ValueError("give either hfov_deg or all of fx, fy, cx, cy")
        if self.cast is not None and (self.cast[0] > self.image[0] or self.cast[1] > self.image[1]):
            raise ValueError(f"cast {list(self.cast)} must not exceed the image {list(self.image)}")
        return self

    @model_validator(mode="after")
    def _distortion_has_a_matrix(self) -> Self:
        if self.distortion is not None and self.hfov_deg is not None:
            raise ValueError("distortion needs the lens as fx, fy, cx, cy in pixels, not as hfov_deg")
        if self.distortion is not None and self.ray_count > MAX_LISTED_RAYS:
            raise ValueError(f"distortion is limited to {MAX_LISTED_RAYS} rays (got {self.ray_count})")
        return self

    @model_validator(mode="after")
    def _image_has_a_ray(self) -> Self:
        """Refuse a lens without a direction for the pixel nearest its axis: all others lie beyond it, too."""
        if self.distortion is not None and np.isnan(directions(self, _nearest_axis(self))).any():
            raise ValueError(
                f"fx {self.fx:g} and fy {self.fy:g} px with this distortion leave no ray on the image; focal lengths "
                "are in pixels: divide millimetres by the size of a pixel"
            )
        return self

    def intrinsics_px(self) -> tuple[float, float, float, float]:
        """Return focal lengths and principal point (fx, fy, cx, cy) in pixels of the native image (paper, eq. 3)."""
        if self.hfov_deg is not None:
            width_px, height_px = self.image
            focal_px = (width_px / 2) / math.tan(math.radians(self.hfov_deg) / 2)
            return focal_px, focal_px, width_px / 2, height_px / 2
        assert self.fx is not None and self.fy is not None and self.cx is not None and self.cy is not None
        return self.fx, self.fy, self.cx, self.cy

    @property
    def resolution(self) -> tuple[int, int]:
        """Columns and rows of the rays cast."""
        width_px, height_px = self.image
        step = math.ceil(math.sqrt(width_px * height_px / MAX_LISTED_RAYS))
        return self.cast or (width_px // step, height_px // step)

    def finest(self) -> Self:
        """Return the camera with a ray for every pixel."""
        return self if self.cast is None else self.model_copy(update={"cast": None})


def _nearest_axis(camera: Camera) -> NDArray[np.int64]:
    """Return the number of the ray through the pixel nearest the principal point, (1,)."""
    _, _, *centre_px = camera.intrinsics_px()
    parts = zip(centre_px, camera.image, camera.resolution, strict=True)
    column, row = (min(max(math.floor(c * count / size), 0), count - 1) for c, size, count in parts)
    return np.array([row * camera.resolution[0] + column])


def image_lattice(camera: Camera) -> Lattice:
    """Return rays through pixel centres of the resized image, row by row (paper, eq. 3-5).

    w = (u + 1/2) w0 / u0, h = (v + 1/2) h0 / v0; (1, -(w - cx) / fx, -(h - cy) / fy), normalised.
    """
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    (width_px, height_px), (columns, rows) = camera.image, camera.resolution
    y = -((np.arange(columns) + 0.5) * width_px / columns - cx_px) / fx_px
    z = -((np.arange(rows) + 0.5) * height_px / rows - cy_px) / fy_px
    slopes = np.stack([z, np.zeros_like(z)], axis=1)
    return Lattice(codes.CAMERA, slopes, np.stack([y, np.zeros_like(y)], axis=1))


def cast_px(camera: Camera, rays: NDArray[np.int64]) -> Doubles:
    """Return native pixels (n, 2) through which the rays of those numbers are cast, row * columns + column (eq. 3)."""
    columns, rows = camera.resolution
    u = (rays % columns + 0.5) * camera.image[0] / columns
    return np.stack([u, (rays // columns + 0.5) * camera.image[1] / rows], axis=-1)


def pixel_directions(camera: Camera, pixels: Doubles) -> Doubles:
    """Return unit directions (n, 3) in the sensor frame of native pixels (n, 2); NaN for missing ones."""
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    x, y = (pixels[:, 0] - cx_px) / fx_px, (pixels[:, 1] - cy_px) / fy_px
    if camera.distortion is not None:
        right, down, ahead = lens.undistorted(camera.distortion, x, y).T
        return np.stack([ahead, -right, -down], axis=-1)
    norm = np.sqrt(1.0 + x * x + y * y)
    return np.stack([1.0 / norm, -x / norm, -y / norm], axis=-1)


def project_px(camera: Camera, points: Doubles) -> Doubles:
    """Return native pixels (n, 2) of points or directions (n, 3) in the sensor frame; NaN: not imaged by the lens.

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


def picture_slopes(camera: Camera) -> Doubles:
    """Return the least and greatest y / x, then z / x, of rays within the picture of a pinhole, (4,), in the sensor
    frame."""
    fx_px, fy_px, cx_px, cy_px = camera.intrinsics_px()
    width_px, height_px = camera.image
    return np.array([(cx_px - width_px) / fx_px, cx_px / fx_px, (cy_px - height_px) / fy_px, cy_px / fy_px])


def field_of_view_deg(camera: Camera) -> tuple[float, float]:
    """Return the angles in degrees that the image spans along its middle row and column; NaN: beyond the lens."""
    width_px, height_px = camera.image
    _, _, cx_px, cy_px = camera.intrinsics_px()
    edges = np.array([[0.0, cy_px], [width_px, cy_px], [cx_px, 0.0], [cx_px, height_px]])
    x, y, z = pixel_directions(camera, edges).T
    off_axis = np.degrees(np.arctan2(np.hypot(y, z), x))
    outwards = off_axis * np.sign([cx_px, width_px - cx_px, cy_px, height_px - cy_px])
    return float(outwards[0] + outwards[1]), float(outwards[2] + outwards[3])


def lattice(camera: Camera) -> Lattice | None:
    """Return its rays in rows and columns; None for a lens with distortion."""
    return image_lattice(camera) if camera.distortion is None else None


def directions(camera: Camera, rays: NDArray[np.int64]) -> Doubles:
    """Return directions in the sensor frame of rays by number, row * columns + column, (n, 3); NaN: the lens has
    none."""
    if camera.distortion is None:
        return image_lattice(camera).directions(rays)
    return pixel_directions(camera, cast_px(camera, rays))


def _summary(camera: Camera) -> list[tuple[str, str]]:
    fx, fy, _, _ = camera.intrinsics_px()
    width_px, _ = camera.image
    columns, rows = camera.resolution
    wide, high = field_of_view_deg(camera)
    focal = f"{fx:.1f} px" if f"{fx:.1f}" == f"{fy:.1f}" else f"{fx:.1f} × {fy:.1f} px"
    return [
        ("Rays", f"{camera.ray_count:,}  =  {columns} × {rows}"),
        (
            "Field of view",
            " × ".join("beyond the lens" if math.isnan(a) else f"{a:.1f}°" for a in (wide, high)),
        ),
        ("Focal length", focal),
        ("Resolution", f"{_pixel_deg(fx):.3g}°/px, {_pixel_deg(fx * columns / width_px):.3g}°/ray"),
        ("Distortion", _lens_text(camera)),
    ]


def _pixel_deg(focal_px: float) -> float:
    """Return the angle of one pixel in the middle of the image."""
    return math.degrees(math.atan(1 / focal_px))


def _lens_text(camera: Camera) -> str:
    """Return the lens model and its first coefficient."""
    bent = camera.distortion
    if bent is None:
        return "none"
    name = "Brown-Conrady" if bent.model == "brown_conrady" else "Kannala-Brandt"
    return f"{name}, k1 {bent.k1:.4g}"


def _brief(camera: Camera) -> str:
    return f"{field_of_view_deg(camera)[0]:.1f}°".replace(".0°", "°")


CAMERA = SensorKind(
    name="camera",
    title="camera",
    plural="cameras",
    model=Camera,
    lattice=lattice,
    directions=directions,
    view_deg=field_of_view_deg,
    brief=_brief,
    size=("pixels", lambda camera: f"{camera.image[0]} × {camera.image[1]}"),
    summary=_summary,
    occlusion=Occlusion(housing_radius_m=0.05, sees_through_glass=True),  # our choice
    # from below mirrors, and from tailgates and boot lids, as Tesla's above the number plate ("Model 3 Owner's Manual",
    # About Autopilot): our choice
    placement=Placement(
        above_roof_m=0.15,
        rpy_deg=outwards_rpy_deg,
        away_when_level=True,
        may_cover=("door mirror", "lid"),
    ),
    hits=HitMeasure("pixels", threshold=25, label="pixels of height", unit="px"),
    library_figures=("pixel_um", "lens"),
    score_weight="lambda",
)
