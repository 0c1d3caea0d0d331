"""Reviews as plain data: areas in m², lengths in m, shares as fractions, entropies in nat, errors in mm and degrees."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import date
from typing import Any

import numpy as np

from riglens.core.blind.zones import HEIGHTS_M, BlindMap, By, Hole, share_seen
from riglens.core.figures.objects import ObjectFigure
from riglens.core.metric.entropy import EntropyField, nats
from riglens.core.metric.scores import Body
from riglens.core.plain import to_plain
from riglens.core.review.findings import Verdict
from riglens.core.review.mounts import USUAL_LIMITS, Mount, Violation, mounts_of, violations
from riglens.core.review.profiles import ONLY_GEOMETRY
from riglens.core.review.redundancy import COVERED, Coverage, Failure, What, lost_share, share
from riglens.core.review.requirements import Settings, size_text
from riglens.core.review.tolerance import ToleranceResult
from riglens.core.review.verdicts import ObjectVerdict, ProfileVerdict
from riglens.core.rig.model import FORMAT_VERSION, Rig
from riglens.core.rig.yaml.file import identity_of
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.sectors import SECTORS
from riglens.core.sensors.registry import shown_kinds
from riglens.core.shown_text import counted
from riglens.core.targets.counts import Counted
from riglens.core.targets.traffic import Traffic

SPREAD = ("nominal", "median", "p05", "p95", "worst", "worst_draw")


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
        "profiles": [_profile_document(verdict, found.rig) for verdict in profiles],
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


def _profile_document(verdict: ProfileVerdict, rig: Rig) -> dict[str, Any]:
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


def settings_document(
    settings: Settings, field: EntropyField | None, traffic: Traffic | None
) -> dict[str, Any]:
    """Return what verdicts on a rig depend on besides the rig: data, grid and settings; null: nothing needs it."""
    data = traffic.data if field is None and traffic is not None else None if field is None else field.data
    return {
        "data": None
        if data is None
        else {"source": data.short_source, "sha256": data.sha256, "frames": data.frames},
        "voxel_m": None if field is None else field.grid.voxel_m,
        "roi_m": None if field is None else list(field.grid.roi_m),
        **to_plain(settings, "min_points", "blind_voxel_m", "blind_width_m", "seed", "sample_frames"),
    }


def settings_text(settings: Mapping[str, Any]) -> str:
    """Return the settings of verdicts in one line."""
    parts, data = [], settings["data"]
    if settings["voxel_m"] is not None:
        parts.append(f"voxels of {size_text(settings['voxel_m'])} in {size_text(settings['roi_m'])}")
    if data is not None:
        digest = f"SHA-256 {data['sha256'][:12] or 'unknown'}"
        parts.append(f"data {data['source']}, {data['frames']:,} frames, {digest}")
    points = counted(settings["min_points"], "point")
    parts.append(
        f"ground in columns of {size_text(settings['blind_voxel_m'])}; {points} on a detected object"
    )
    parts.append(f"seed {settings['seed']}")
    return "; ".join(parts)


def check_document(
    rig: Rig,
    body: Body,
    verdicts: Sequence[Verdict],
    sources: Mapping[str, Any] | None = None,
    day: date | None = None,
) -> dict[str, Any]:
    """Return every verdict, and whether all requirements are met; waivers count on a given day, and not without one.

    sources: what the verdicts depend on besides the rig.
    """
    return {
        "riglens": FORMAT_VERSION,
        "body": body,
        "rig": identity_of(rig),
        **(sources or {}),
        "passes": all(verdict.holds_on(day) for verdict in verdicts),
        "verdicts": [_verdict(verdict, day) for verdict in verdicts],
    }


def _verdict(verdict: Verdict, day: date | None) -> dict[str, Any]:
    one, finding = verdict.item.requirement, verdict.finding
    return {
        "id": verdict.item.id,
        "section": verdict.item.section,
        "name": one.label,
        "why": one.why,
        "text": verdict.text,
        "found": finding.value,
        "relation": one.relation,
        "limit": one.accepted,
        "unit": one.unit,
        "status": verdict.status,
        "passes": verdict.passes,
        "bounds": None if finding.bounds is None else list(finding.bounds),
        "details": list(finding.details),
        "waived": None
        if one.waived is None
        else {
            "reason": one.waived.reason,
            "until": one.waived.until.isoformat(),
            "counts": verdict.is_waived_on(day),
        },
    }


def mounts_document(rig: Rig, mounts: Sequence[Mount], found: Sequence[Violation]) -> dict[str, Any]:
    """Return the mounts of a rig's enabled sensors; null: no body or no neighbour to measure to."""
    return {
        "riglens": FORMAT_VERSION,
        "rig": identity_of(rig),
        "mounts": [_mount(mount) for mount in mounts],
        "violations": to_plain(list(found)),
    }


def _mount(mount: Mount) -> dict[str, Any]:
    status = mount.status
    return {
        "name": mount.name,
        "height_m": mount.height_m,
        "gap_m": None if status.nearest_m is None else status.gap_m,
        "neighbour": mount.neighbour,
        "neighbour_m": None if mount.neighbour is None else mount.neighbour_m,
        "beyond_m": to_plain(mount.beyond_m),
        "materials": sorted(mount.materials),
        "zones": list(mount.zones),
    }


def _tried(found: Coverage) -> tuple[What, ...]:
    """Return what fails; half-blocked sensors only where they were tried."""
    halves = any(one.what == "half" for one in found.failures)
    return ("sensor", "pair", "group", "half") if halves else ("sensor", "pair", "group")


def coverage_document(found: Coverage, unit: str) -> dict[str, Any]:
    """Return a coverage by class; `unit` is that of `total`: nat or objects."""
    return {
        "unit": unit,
        "sectors": list(SECTORS),
        "classes": {name: _class_document(found, cls, unit) for cls, name in enumerate(CLASSES)},
        "failures": [_failure_document(found, failure) for failure in found.failures],
    }


def _class_document(found: Coverage, cls: int, unit: str) -> dict[str, Any]:
    total = int(found.total[:, cls].sum())
    covered = found.covered[:, :, cls]
    return {
        "total": nats(total) if unit == "nat" else total,
        "covered": {name: share(int(covered[:, k].sum()), total) for k, name in enumerate(COVERED)},
        "covered_by_sector": {
            name: [share(int(covered[s, k]), int(found.total[s, cls])) for s in range(len(SECTORS))]
            for k, name in enumerate(COVERED)
        },
        "worst": {what: _worst(found, what, cls, None) for what in _tried(found)},
        "worst_by_sector": {
            what: [_worst(found, what, cls, s) for s in range(len(SECTORS))] for what in _tried(found)
        },
    }


def _worst(found: Coverage, what: What, cls: int, sector: int | None) -> dict[str, Any] | None:
    failure = found.worst(what, cls, sector)
    if failure is None:
        return None
    return {"name": failure.name, "lost": lost_share(found, failure, cls, sector)}


def _failure_document(found: Coverage, failure: Failure) -> dict[str, Any]:
    return {
        "what": failure.what,
        "name": failure.name,
        "sensors": list(failure.members),
        "lost": {name: lost_share(found, failure, cls) for cls, name in enumerate(CLASSES)},
        "lost_by_sector": {
            name: [lost_share(found, failure, cls, s) for s in range(len(SECTORS))]
            for cls, name in enumerate(CLASSES)
        },
    }


def places_document(figure: ObjectFigure, now: Counted, before: Counted | None = None) -> dict[str, Any]:
    """Return a figure of objects by class, ring of distance and sector, with its change from a baseline in the same
    frames, and the shares of the class whose own value rose and fell; null: no object is there."""
    cells = figure.cells(now, before or now, "ring and sector")
    change = figure.values(now) - figure.values(before or now)
    whole = now.groups.parts("all")
    rose, fell = (whole.means((way * change > 0.0).astype(np.float64)).value for way in (1.0, -1.0))

    def table(values: np.ndarray[Any, Any]) -> Any:
        rows: list[list[float]] = values.reshape(-1, len(SECTORS)).tolist()
        return [[None if math.isnan(value) else value for value in row] for row in rows]

    return {
        "figure": figure.key,
        "rings_m": now.groups.edges_m.tolist(),
        "sectors": list(SECTORS),
        "classes": {
            name: {
                "objects": table(cells.objects[row + 1]),
                "value": table(cells.value[row + 1]),
                "change": table(cells.change[row + 1]),
                "rose": float(rose[row, 0]),
                "fell": float(fell[row, 0]),
            }
            for row, name in enumerate(CLASSES)
        },
    }


def tolerance_document(found: ToleranceResult, body: str) -> dict[str, Any]:
    """Return the tolerance of a rig under one profile; sample: the frames in which objects were counted for each draw,
    and the standard error of each worst draw's change from the rig as designed, whose figures are those of all frames.
    """
    frames, of_frames = found.frames
    return {
        "riglens": FORMAT_VERSION,
        "body": body,
        "rig": identity_of(found.rig),
        "profile": to_plain(found.profile),
        "draws": found.draws,
        "seed": found.seed,
        "figures": {name: to_plain(spread, *SPREAD) for name, spread in found.spreads.items()},
        "noise_floor": {name: to_plain(spread, *SPREAD) for name, spread in found.floor.items()},
        "sensitivities": to_plain(found.sensitivities),
        "sample": {
            "frames": frames,
            "of_frames": of_frames,
            "worst_se": {name: found.spreads[name].worst_se for name in found.of_objects},
        },
    }


def mounts_review_document(rig: Rig) -> dict[str, Any]:
    """Return the mounts of the enabled sensors and their violations of the usual limits, as plain data."""
    return {
        "riglens": FORMAT_VERSION,
        "rig": identity_of(rig),
        "gap_limit_m": USUAL_LIMITS.gap_m,
        "sensors": [_mount_plain(mount) for mount in mounts_of(rig)],
        "problems": [{"sensor": one.sensor, "text": one.text} for one in violations(rig, USUAL_LIMITS)],
    }


def _mount_plain(mount: Mount) -> dict[str, Any]:
    place = mount.status
    return {
        "name": mount.name,
        "height_m": mount.height_m,
        "gap_m": _finite(place.gap_m),
        "inside": place.inside,
        "below_ground": place.below_ground,
        "nearest_sensor": mount.neighbour,
        "nearest_sensor_m": _finite(mount.neighbour_m),
        "beyond_m": mount.beyond_m,
        "materials": sorted(mount.materials),
        "zones": list(mount.zones),
    }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
