"""The beams of a LiDAR from one of its sweeps: points that carry the index of their ring, as nuScenes keeps them.

A sweep is float32 x, y, z, intensity, ring in the LiDAR's own frame, little-endian, without a header. The elevation
of a ring is the median of its points'; points nearer than 2 m are the own car's.
Source: nuscenes-devkit, LidarPointCloud.from_file ("Loads from .bin file", five values per point).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np
from numpy.typing import NDArray

from riglens.core.errors import InputError
from riglens.core.files import open_regular

MAX_BYTES = 64_000_000
MAX_RINGS = 256
_VALUES = 5
_NEAR_M = 2.0
_LEAST_POINTS = 20
_MOST_SPREAD_DEG = 1.0
"""Elevations of one ring that lie further apart are not those of a beam that goes round."""


@dataclass(frozen=True)
class Rings:
    """Elevations of all rings with enough points, rising, degrees; `unmeasured` rings have too few of them."""

    elevations_deg: tuple[float, ...]
    unmeasured: int


def sweep_file(roots: tuple[Path, ...], said: object) -> Path | None:
    """Return the file that a table names, where it is inside one of the folders; None if it is not there."""
    if not isinstance(said, str) or not said.endswith(".bin") or len(said) > 500 or "\0" in said:
        return None
    relative = PurePosixPath(said)
    if relative.is_absolute() or ".." in relative.parts:
        return None
    for root in roots:
        found = (root / relative).resolve()
        if found.is_relative_to(root.resolve()) and found.is_file():
            return found
    return None


def rings_of(path: Path) -> Rings | str:
    """Return the rings of a sweep, or the reason why it has none."""
    try:
        with open_regular(path, "a sweep of points") as file:
            content = file.read(MAX_BYTES + 1)
    except (OSError, InputError):
        return "cannot be read"
    if len(content) > MAX_BYTES:
        return f"is larger than {MAX_BYTES // 1_000_000} MB"
    if not content or len(content) % (4 * _VALUES):
        return "does not hold five numbers for each point"
    points = np.frombuffer(content, "<f4").reshape(-1, _VALUES).astype(np.float64)
    points = points[np.isfinite(points).all(axis=1)]
    rings = points[:, 4]
    if not len(rings) or (rings != np.floor(rings)).any() or rings.min() < 0 or rings.max() >= MAX_RINGS:
        return f"has no ring index from 0 to {MAX_RINGS - 1}"
    return _elevations(points, rings.astype(np.int64))


def _elevations(points: NDArray[np.float64], rings: NDArray[np.int64]) -> Rings | str:
    flat_m = np.hypot(points[:, 0], points[:, 1])
    far = flat_m > _NEAR_M
    elevation_deg = np.degrees(np.arctan2(points[far, 2], flat_m[far]))
    order = np.lexsort((elevation_deg, rings[far]))
    starts = np.flatnonzero(np.diff(rings[far][order], prepend=-1))
    groups = [group for group in np.split(elevation_deg[order], starts[1:]) if len(group) >= _LEAST_POINTS]
    if len(groups) < 2:
        return "has too few points on its rings"
    spreads_deg = [float(np.subtract(*np.percentile(group, (75, 25)))) for group in groups]
    if np.median(spreads_deg) > _MOST_SPREAD_DEG:
        return "has rings that are not beams of one elevation each"
    medians = sorted(round(float(np.median(group)), 3) for group in groups)
    return Rings(tuple(medians), len(np.unique(rings)) - len(groups))
