"""Detection range of a rig as plain data: JSON, and lines of a table; distances in metres, speeds in km/h."""

from __future__ import annotations

import math
from typing import Any

from riglens.core.rig.model import FORMAT_VERSION
from riglens.core.rig.yaml.file import identity_of
from riglens.core.sensors.registry import kinds
from riglens.core.targets.detection_range import SIZES_M, DetectionRange, RangeRow, Reach


def range_document(ranges: DetectionRange) -> dict[str, Any]:
    """Return the detection range as plain data; null: still enough at the farthest distance, 0: never enough."""
    plan = ranges.plan
    return {
        "riglens": FORMAT_VERSION,
        **plan.settings.as_dict(),
        "min_points": plan.min_points,
        "min_height_px": plan.min_height_px,
        "to_m": plan.to_m,
        "sizes_m": {name: list(size) for name, size in SIZES_M.items()},
        "beam_gap_deg": ranges.gap_deg,
        "stopping": {
            "reaction_s": plan.reaction_s,
            "deceleration_mps2": plan.deceleration_mps2,
            "distances": [{"speed_kmh": v, "distance_m": plan.stopping_m(v)} for v in plan.speeds_kmh],
        },
        "rigs": [
            {
                **identity_of(ranges.rig),
                "rows": [_row(ranges, row) for row in ranges.rows],
            }
        ],
    }


def _row(ranges: DetectionRange, row: RangeRow) -> dict[str, Any]:
    found: dict[str, Any] = {"class": row.cls, "heading_deg": row.heading_deg, "bearing_deg": row.bearing_deg}
    for name, reach in row.reaches.items():
        found[name] = _reach(reach)
        speed = ranges.stops_from_kmh(row, reach)
        if speed is not None:
            found[name]["stops_from_kmh"] = _finite(speed)
    return found


def _reach(reach: Reach) -> dict[str, Any]:
    first = {"min": reach.least_m, "median": reach.median_m, "max": reach.most_m}
    return {
        "enough_from_m": reach.from_m if reach.most_m > 0.0 else None,
        "first_below_m": {name: _finite(value) for name, value in first.items()},
    }


def _finite(value: float) -> float | None:
    return None if math.isinf(value) else value


def range_lines(ranges: DetectionRange) -> list[dict[str, object]]:
    """Return a line per class, heading, bearing and kind of sensor; empty: still enough at the farthest distance."""
    lines: list[dict[str, object]] = []
    for row in ranges.rows:
        for kind in (kind for kind in kinds() if kind.name in row.reaches):
            reach = row.reaches[kind.name]
            speed = ranges.stops_from_kmh(row, reach)
            lines.append(
                {
                    "rig": ranges.rig.name,
                    "class": row.cls,
                    "heading_deg": row.heading_deg,
                    "bearing_deg": row.bearing_deg,
                    "kind": kind.name,
                    "threshold": ranges.plan.enough(kind),
                    "enough_from_m": reach.from_m if reach.most_m > 0.0 else "",
                    "first_below_min_m": _cell(reach.least_m),
                    "first_below_median_m": _cell(reach.median_m),
                    "first_below_max_m": _cell(reach.most_m),
                    "stops_from_kmh": "" if speed is None else _cell(speed),
                }
            )
    return lines


def _cell(value: float) -> object:
    return "" if math.isinf(value) else round(value, 3)
