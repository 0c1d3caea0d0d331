"""What follows from a sensor's fields, in the words of a data sheet: rays, resolution, field of view, focal length."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from riglens.core.rig.model import Camera, EvenAngles, Lidar, Sensor
from riglens.core.sensing.camera import field_of_view_deg


def derived_rows(sensor: Sensor) -> list[tuple[str, str]]:
    """Captions and values, always the same captions for a kind of sensor."""
    return _lidar_rows(sensor) if isinstance(sensor, Lidar) else _camera_rows(sensor)


def _lidar_rows(lidar: Lidar) -> list[tuple[str, str]]:
    beams, turn = lidar.elevations(), lidar.azimuths()
    return [
        ("Rays", f"{lidar.ray_count:,}  =  {len(beams)} beams × {len(turn):,}"),
        ("Field of view", f"{_turn_deg(lidar):.4g}° × {np.ptp(beams):.4g}°"),
        ("Resolution", f"{_gaps(turn)} × {_gaps(beams)}"),
        ("Azimuth offsets", _offsets(lidar)),
    ]


def _offsets(lidar: Lidar) -> str:
    """How far beams fire beside the azimuth of the turn."""
    offsets = lidar.azimuth_offsets_deg
    return "none" if offsets is None else f"{min(offsets):.3g}° to {max(offsets):.3g}°, by beam"


def _turn_deg(lidar: Lidar) -> float:
    angles = lidar.azimuths_deg
    return angles.to - angles.from_ if isinstance(angles, EvenAngles) else max(angles) - min(angles)


def _gaps(angles_deg: NDArray[np.float64]) -> str:
    """The distance of neighbouring angles, or from the closest to the widest."""
    if len(angles_deg) < 2:
        return "–"
    gaps = np.diff(np.sort(angles_deg))
    low, high = f"{gaps.min():.3g}", f"{gaps.max():.3g}"
    return f"{low}°" if low == high else f"{low}–{high}°"


def _camera_rows(camera: Camera) -> list[tuple[str, str]]:
    fx, fy, _, _ = camera.intrinsics_px()
    width_px, _ = camera.image
    columns, rows = camera.cast
    wide, high = field_of_view_deg(camera)
    focal = f"{fx:.1f} px" if f"{fx:.1f}" == f"{fy:.1f}" else f"{fx:.1f} × {fy:.1f} px"
    return [
        ("Rays", f"{camera.ray_count:,}  =  {columns} × {rows}"),
        ("Field of view", f"{wide:.1f}° × {high:.1f}°"),
        ("Focal length", focal),
        ("Resolution", f"{_pixel_deg(fx):.3g}°/px, {_pixel_deg(fx * columns / width_px):.3g}°/ray"),
        ("Distortion", _distortion(camera)),
    ]


def _distortion(camera: Camera) -> str:
    """The lens model and its first coefficient."""
    lens = camera.distortion
    if lens is None:
        return "none"
    name = "Brown-Conrady" if lens.model == "brown_conrady" else "Kannala-Brandt"
    return f"{name}, k1 {lens.k1:.4g}"


def _pixel_deg(focal_px: float) -> float:
    """The angle of one pixel in the middle of the image."""
    return math.degrees(math.atan(1 / focal_px))
