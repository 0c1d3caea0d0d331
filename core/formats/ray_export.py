"""Report the losses of a LiDAR in a format that has only even rays, or rays symmetric about its axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from riglens.core.formats.lens_export import SMALLEST_TOLD_DEG
from riglens.core.formats.report import Notes
from riglens.core.rig.model import Lidar, LinearAngles

Doubles = NDArray[np.float64]
FULL_TURN_DEG = 360.0


def turn_ends_deg(lidar: Lidar) -> tuple[float, float]:
    """Return the azimuths between which the LiDAR sweeps, in degrees; listed azimuths reach half a step farther."""
    if lidar.rays is not None or isinstance(lidar.azimuths_deg, LinearAngles):
        return lidar.turn_ends_deg
    listed = np.sort(lidar.azimuths())
    half_step = float(np.median(np.diff(listed))) / 2.0 if len(listed) > 1 else 0.0
    low, high = float(listed[0]) - half_step, float(listed[-1]) + half_step
    return (low, high) if high - low < FULL_TURN_DEG else (-FULL_TURN_DEG / 2.0, FULL_TURN_DEG / 2.0)


def report_uneven(lidar: Lidar, who: str, notes: Notes) -> None:
    """Report the difference of beams, azimuths and offsets from the evenly spaced ones of `who`."""
    if lidar.rays is not None:
        report_pattern(lidar, who, notes)
        return
    kinds = {"beams": lidar.elevations_deg, "azimuths": lidar.azimuths_deg}
    uneven = [kind for kind, angles in kinds.items() if not isinstance(angles, LinearAngles)]
    if uneven:
        off_deg = max(_off_even_deg(lidar.elevations()), _off_even_deg(lidar.azimuths()))
        notes.approximated(
            f"uneven angles: {who} spaces {' and '.join(uneven)} evenly, up to {off_deg:.2f} deg off",
            lidar.name,
        )
    if lidar.azimuth_offsets_deg is not None:
        most_deg = max(abs(offset) for offset in lidar.azimuth_offsets_deg)
        notes.ignored(f"azimuth offsets of beams: {who} has none; up to {most_deg:.2f} deg off", lidar.name)


def report_pattern(lidar: Lidar, who: str, notes: Notes) -> None:
    """Report the scan pattern of a LiDAR that has one, for which a format has no place."""
    if lidar.rays is not None:
        size = f"{lidar.elevations().size} × {lidar.azimuths().size} rays"
        notes.approximated(
            f"scan pattern: {who} has none; an even raster of {size} over its field of view", lidar.name
        )


def _off_even_deg(angles_deg: Doubles) -> float:
    """Return the largest difference in degrees between angles and as many even ones between their ends."""
    rising = np.sort(angles_deg)
    even = np.linspace(rising[0], rising[-1], len(rising))
    return float(np.abs(rising - even).max())


def report_symmetric(
    what: str, ends_deg: tuple[float, float], span_deg: float, lidar: Lidar, notes: Notes
) -> None:
    """Report a span that the format has symmetric about the sensor's axis, where the LiDAR's lies elsewhere."""
    half_deg = span_deg / 2.0
    off_deg = max(abs(ends_deg[0] + half_deg), abs(ends_deg[1] - half_deg))
    if off_deg >= SMALLEST_TOLD_DEG:
        notes.approximated(
            f"{what} {ends_deg[0]:g} to {ends_deg[1]:g} deg: written as ±{half_deg:g} deg, {off_deg:g} deg off",
            lidar.name,
        )
