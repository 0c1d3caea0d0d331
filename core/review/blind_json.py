"""Blind zones as plain data: areas in m², lengths in m, shares as fractions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from riglens.core.plain import to_plain
from riglens.core.review.blind import HEIGHTS_M, BlindMap, By, Hole
from riglens.core.review.profiles import ONLY_GEOMETRY
from riglens.core.review.verdicts import ObjectVerdict, ProfileVerdict
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.file import identity_of
from riglens.core.scene.sectors import SECTORS
from riglens.core.sensors.registry import shown_kinds

SHARE_WITHIN_M = 10.0
"""Distance within which the IIHS states the visible share of the ground (news of 26 June 2025); the height from which
ground counts as seen is our choice: the lowest of HEIGHTS_M."""


def share_seen(found: BlindMap, by: By = "any", k: int = 1) -> float:
    """Return the share of the ground within 10 m of the car on which an object of the least height is seen; more is
    better."""
    near = found.ground.counts & (found.ground.distance_m <= SHARE_WITHIN_M)
    unseen = found.unseen(HEIGHTS_M[0], by, k) & near
    return 1.0 - float(unseen.sum()) / max(1, int(near.sum()))


def blind_document(found: BlindMap, profiles: Sequence[ProfileVerdict]) -> dict[str, Any]:
    """Return the blind zones of a rig and its results for profiles."""
    settings = found.settings
    kinds = sorted(kind.name for kind in shown_kinds(sensor.kind for sensor in found.rig.sensors))
    return {
        "riglens": FORMAT_VERSION,
        "body": settings.body,
        "rig": identity_of(found.rig),
        "settings": {
            **to_plain(settings, "voxel_m", "width_m", "within_m", "bands_m"),
            "sectors": list(SECTORS),
            "heights_m": list(HEIGHTS_M),
        },
        "ground_m2": _rounded(found.ground_m2()),
        "zones": [_zone(found, by, k) for by in ("any", *kinds) for k in (1, 2)],
        "note": ONLY_GEOMETRY,
        "profiles": [_profile(verdict, found.rig) for verdict in profiles],
    }


def _zone(found: BlindMap, by: By, k: int) -> dict[str, Any]:
    return {
        "by": by,
        "sensors": k,
        "share_seen_10m": share_seen(found, by, k),
        "heights": [
            {
                "height_m": height,
                "unseen_m2": float(np.round(found.area_m2(height, by, k).sum(), 9)),
                "by_sector_and_band_m2": _rounded(found.area_m2(height, by, k)),
                "largest_hole": _hole(found.largest_hole(height, by, k)),
            }
            for height in HEIGHTS_M
        ],
    }


def _rounded(table: np.ndarray[Any, Any]) -> list[list[float]]:
    """Round areas, which are whole numbers of columns, to remove the rounding errors of sums."""
    rows: list[list[float]] = np.round(table, 9).tolist()
    return rows


def _hole(hole: Hole | None) -> Any:
    return None if hole is None else to_plain(replace(hole, area_m2=round(hole.area_m2, 9)))


def _profile(verdict: ProfileVerdict, rig: Rig) -> dict[str, Any]:
    return {
        **to_plain(
            verdict.profile, "name", "title", "source", "vehicles", "from_memory", "by", "rays", "share"
        ),
        "for_this_vehicle": verdict.profile.is_for(rig.vehicle),
        "passes": verdict.passes,
        "seen": len(verdict.objects) - len(verdict.failed),
        "objects": [_object(one) for one in verdict.objects],
    }


def _object(one: ObjectVerdict) -> dict[str, Any]:
    return {
        **to_plain(one.target, "name", "x_m", "y_m"),
        "diameter_m": 2.0 * one.target.radius_m,
        "height_m": one.target.height_m,
        "seen": one.is_seen,
        **to_plain(one, "rays", "share", "rays_by_sensor", "share_by_sensor"),
    }
