"""The rays of CARLA's LiDAR, described alike in both of its formats."""

from __future__ import annotations

import math

from riglens.core.formats.ray_export import (
    FULL_TURN_DEG,
    report_symmetric,
    report_uneven,
    turn_ends_deg,
)
from riglens.core.formats.report import Notes
from riglens.core.rig.model import Lidar

TURNS_PER_SECOND = 10.0
FARTHEST_M = 1000.0
_MOST_AZIMUTHS = 36_000


def azimuth_count(points_per_second: float, turns_per_second: float, channels: int) -> int:
    """Return the azimuths of one turn: the points of a second, shared among turns and beams."""
    return max(1, min(_MOST_AZIMUTHS, round(points_per_second / (turns_per_second * channels))))


def rays_to_write(lidar: Lidar, notes: Notes) -> dict[str, float]:
    """Return CARLA's attributes for the rays of a LiDAR; what they cannot express is reported."""
    beams, turn = lidar.elevations(), lidar.azimuths()
    report_uneven(lidar, "CARLA", notes)
    span_deg = _span_deg(lidar, notes)
    low_m, high_m = lidar.range_m
    if low_m > 0.0:
        notes.ignored(f"smallest range {low_m:g} m: CARLA has none", lidar.name)
    if math.isinf(high_m):
        notes.approximated(f"no largest range: {FARTHEST_M:g} m is written", lidar.name)
    if lidar.model is not None:
        notes.ignored("model name: the format cannot express it", lidar.name)
    notes.written("pose and rays", lidar.name)
    return {
        "channels": len(beams),
        "lower_fov": float(beams.min()),
        "upper_fov": float(beams.max()),
        "range": FARTHEST_M if math.isinf(high_m) else high_m,
        "rotation_frequency": TURNS_PER_SECOND,
        "points_per_second": round(len(turn) * len(beams) * TURNS_PER_SECOND),
        **({} if span_deg == 360.0 else {"horizontal_fov": span_deg}),
    }


def _span_deg(lidar: Lidar, notes: Notes) -> float:
    """Return how wide the LiDAR sees; CARLA's fan is symmetric about the x axis."""
    low_deg, high_deg = turn_ends_deg(lidar)
    span_deg = high_deg - low_deg
    if span_deg < FULL_TURN_DEG:
        report_symmetric("azimuths", (low_deg, high_deg), span_deg, lidar, notes)
    return span_deg if span_deg > 0.0 else 1.0
