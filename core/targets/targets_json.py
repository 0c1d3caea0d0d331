"""Return rigs' figures for objects as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from riglens.core.metric.scores import Body, common_body
from riglens.core.plain import to_plain
from riglens.core.rig.model import FORMAT_VERSION
from riglens.core.rig.yaml.file import identity_of
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.survey import notes_on
from riglens.core.targets.scores import ClassTargets, Predicted, Row, TargetScores, sectors_of
from riglens.core.targets.traffic import Traffic


def targets_document(traffic: Traffic, scores: Sequence[TargetScores]) -> dict[str, Any]:
    """Return figures of some rigs, at least one, in the same traffic and with the same settings; shares as fractions.

    `body` is null where rigs differ, and then said of each.
    """
    first, data = scores[0], traffic.data
    body = common_body(one.settings.body for one in scores)
    objects = np.bincount(traffic.cls[first.objects.box], minlength=len(CLASSES))
    return {
        "riglens": FORMAT_VERSION,
        **(first.settings.as_dict() | {"body": body}),
        "within_m": traffic.within_m,
        "surroundings": "block" if traffic.surroundings_sha256 else "ignored",
        "data": {
            "source": data.source,
            "frames": data.frames,
            "frames_used": first.frames_used,
            "objects": {name: int(number) for name, number in zip(CLASSES, objects, strict=True)},
            "sha256": data.sha256,
            "surroundings_sha256": traffic.surroundings_sha256,
            "notes": notes_on(data),
        },
        "calibration": to_plain(first.calibration),
        "recall_calibration": to_plain(recall) if (recall := first.settings.recall) else None,
        "rigs": [_rig(traffic, one, body) for one in scores],
    }


def _rig(traffic: Traffic, scores: TargetScores, body: Body | None) -> dict[str, Any]:
    return {
        **identity_of(scores.rig),
        **({} if body else {"body": scores.settings.body}),
        "elapsed_ms": scores.elapsed_ms,
        **_with_sectors(target_figures(scores), sectors_of(traffic, scores)),
    }


def _with_sectors(figures: dict[str, Any], sectors: Mapping[str, Mapping[str, Row]]) -> dict[str, Any]:
    """Return figures with those by sector beside the rings of each class."""
    classes = {
        name: found | {"sectors": [{"sector": sector} | _part(row) for sector, row in sectors[name].items()]}
        for name, found in figures["classes"].items()
    }
    return figures | {"classes": classes}


def target_figures(scores: TargetScores) -> dict[str, Any]:
    """Return a rig's figures for objects as plain data."""
    return {
        "predicted_mean": _predicted(scores.predicted_mean),
        "predicted_outside": scores.predicted_outside,
        "found_outside": scores.found_outside,
        "classes": {name: _class(scores.classes[name]) for name in CLASSES},
    }


def _class(found: ClassTargets) -> dict[str, Any]:
    total = found.total
    return {
        "objects": total.objects,
        "predicted": _predicted(total.predicted),
        "found": _predicted(total.found),
        "lidar": {
            "on_target": total.on_target.value,
            "on_target_se": total.on_target.se,
            "share_1": total.share_1.value,
            "share_1_se": total.share_1.se,
            "share_5": total.share_5.value,
            "share_5_se": total.share_5.se,
            "share_min_points": total.share_n.value,
            "share_min_points_se": total.share_n.se,
            "median_points": total.median_points,
        },
        "camera": {
            "visible": total.visible.value,
            "visible_se": total.visible.se,
            "share_25px": total.share_25px.value,
            "share_25px_se": total.share_25px.se,
            "median_height_px": total.median_height_px,
        },
        **_by_kind(total),
        "both": total.both.value,
        "both_se": total.both.se,
        "neither": total.neither.value,
        "neither_se": total.neither.se,
        "rings": [{"from_m": ring.from_m, "to_m": ring.to_m} | _part(ring) for ring in found.rings],
    }


def _by_kind(row: Row) -> dict[str, Any]:
    return {kind: {"share": share.value, "share_se": share.se} for kind, share in row.by_kind.items()}


def _predicted(found: Predicted | None) -> dict[str, Any] | None:
    return None if found is None else to_plain(found, "value", "se", "sample_se", "objects")


def _part(row: Row) -> dict[str, Any]:
    return {
        "objects": row.objects,
        "predicted": _predicted(row.predicted),
        "found": _predicted(row.found),
        "on_target": row.on_target.value,
        "on_target_se": row.on_target.se,
        "share_5": row.share_5.value,
        "share_min_points": row.share_n.value,
        "median_points": row.median_points,
        "visible": row.visible.value,
        "share_25px": row.share_25px.value,
        **_by_kind(row),
        "both": row.both.value,
        "neither": row.neither.value,
    }
