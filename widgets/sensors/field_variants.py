"""Fields of a sensor that can be given in several ways: which one is in use, and the same sensor given in another."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from riglens.core.plain import Frozen
from riglens.core.sensors.camera import Camera
from riglens.core.sensors.lens import BrownConrady, KannalaBrandt
from riglens.core.sensors.lidar import TURN, Lidar, LinearAngles
from riglens.core.sensors.registry import kind_of
from riglens.core.sensors.scan import RayTable, Scan, Swing


@dataclass(frozen=True)
class FieldVariant:
    """One variant; `fields` of the sensor are edited, or those of the `model` that the value then is; `note` says what
    cannot be edited."""

    title: str
    is_used: Callable[[Any], bool]
    given: Callable[[Any], Any]
    fields: tuple[str, ...] = ()
    model: type[Frozen] | None = None
    note: Callable[[Any], str] | None = None


@dataclass(frozen=True)
class FieldVariants:
    """Alternative ways to specify a property; `fields` of the sensor take part in it."""

    name: str
    title: str
    tip: str
    fields: tuple[str, ...]
    variants: tuple[FieldVariant, ...]


def _angles(field: str, title: str, tip: str) -> FieldVariants:
    def doubles(lidar: Lidar) -> tuple[float, ...]:
        return tuple(float(angle) for angle in kind_of(lidar).spelled_out[field](lidar))

    def evenly(lidar: Lidar) -> Lidar:
        angles = doubles(lidar)
        return lidar.replace(**{field: LinearAngles(from_=min(angles), to=max(angles), count=len(angles))})

    def is_even(lidar: Lidar) -> bool:
        return lidar.rays is None and isinstance(getattr(lidar, field), LinearAngles)

    def by_pattern(lidar: Lidar) -> Lidar:
        raise ValueError("choose a scan pattern under Rays")

    even = FieldVariant("evenly spaced", is_even, evenly, model=LinearAngles)
    listed = FieldVariant(
        "list",
        lambda lidar: lidar.rays is None and not is_even(lidar),
        lambda lidar: lidar.replace(**{field: doubles(lidar)}),
        (field,),
    )
    pattern = FieldVariant("scan pattern", lambda lidar: lidar.rays is not None, by_pattern)
    return FieldVariants(field, title, tip, (field,), (even, listed, pattern))


_PRISMS = Scan(
    points_per_s=1e5,
    integration_s=0.1,
    swings=(
        Swing(rate_hz=-121.5657, azimuth_deg=18.0, elevation_deg=18.0),
        Swing(rate_hz=77.743, azimuth_deg=17.0, elevation_deg=17.0),
    ),
)
"""Two prisms with the speeds of livox-mid-40-pattern."""


def _along_prisms(lidar: Lidar) -> Lidar:
    return lidar.replace(elevations_deg=None, azimuths_deg=TURN, azimuth_offsets_deg=None, rays=_PRISMS)


def _from_file(lidar: Lidar) -> Lidar:
    raise ValueError("write the name of the file into the rig file: rays: {file: pattern.csv}")


def _table_text(lidar: Lidar) -> str:
    table = lidar.rays
    assert isinstance(table, RayTable)
    within = "" if table.integration_s is None else f" of the first {table.integration_s:g} s"
    return f"{table.file}: {table.ray_count:,} rays{within}, SHA-256 {table.ray_rows().sha256}"


LIDAR_VARIANTS = (
    FieldVariants(
        "rays",
        "Rays",
        "beams that turn, or one by one along a scan pattern",
        ("rays",),
        (
            FieldVariant("beams and azimuths", lambda lidar: lidar.rays is None, Lidar.raster),
            FieldVariant("formula", lambda lidar: isinstance(lidar.rays, Scan), _along_prisms, model=Scan),
            FieldVariant(
                "table", lambda lidar: isinstance(lidar.rays, RayTable), _from_file, note=_table_text
            ),
        ),
    ),
    _angles("elevations_deg", "Elevations", "beam angles, both ends included"),
    _angles("azimuths_deg", "Azimuths", "angles of one turn, end excluded"),
)


def _by_focal_lengths(camera: Camera) -> Camera:
    fx, fy, cx, cy = camera.intrinsics_px()
    return camera.replace(hfov_deg=None, fx=fx, fy=fy, cx=cx, cy=cy)


def _by_field_of_view(camera: Camera) -> Camera:
    """Return the lens by its angle, which cannot express a principal point off the centre."""
    hfov_deg = 2 * math.degrees(math.atan(camera.image[0] / 2 / camera.intrinsics_px()[0]))
    return camera.replace(hfov_deg=hfov_deg, fx=None, fy=None, cx=None, cy=None)


def _bent_by(title: str, model: type[BrownConrady] | type[KannalaBrandt]) -> FieldVariant:
    return FieldVariant(
        title,
        lambda camera: isinstance(camera.distortion, model),
        lambda camera: _by_focal_lengths(camera).replace(distortion=model()),
        model=model,
    )


def _fewer_rays(camera: Camera) -> Camera:
    columns, rows = (min(most, pixels) for most, pixels in zip(_FEWER, camera.image, strict=True))
    return camera.replace(cast=(columns, rows))


_FEWER = (352, 128)
"""The ray lattice of the paper's cameras."""
_INTRINSICS = ("fx", "fy", "cx", "cy")
CAMERA_VARIANTS = (
    FieldVariants(
        "lens",
        "Lens by",
        "one field of view, or focal lengths and principal point in pixels",
        ("hfov_deg", *_INTRINSICS),
        (
            FieldVariant("field of view", lambda c: c.hfov_deg is not None, _by_field_of_view, ("hfov_deg",)),
            FieldVariant("focal lengths", lambda c: c.hfov_deg is None, _by_focal_lengths, _INTRINSICS),
        ),
    ),
    FieldVariants(
        "distortion",
        "Distortion",
        "OpenCV's models; needs focal lengths",
        ("distortion",),
        (
            FieldVariant(
                "none", lambda camera: camera.distortion is None, lambda c: c.replace(distortion=None)
            ),
            _bent_by("Brown-Conrady", BrownConrady),
            _bent_by("fisheye (Kannala-Brandt)", KannalaBrandt),
        ),
    ),
    FieldVariants(
        "cast",
        "Rays",
        "one per pixel, or a lattice of fewer rays as in the paper",
        ("cast",),
        (
            FieldVariant("every pixel", lambda camera: camera.cast is None, lambda c: c.replace(cast=None)),
            FieldVariant("fewer", lambda camera: camera.cast is not None, _fewer_rays, ("cast",)),
        ),
    ),
)
