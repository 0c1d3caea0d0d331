"""Scores as plain data: every figure in full precision."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from riglens.core.engine.engine import Evaluation
from riglens.core.metric.entropy import EntropyField
from riglens.core.metric.scores import Body, ClassScores, MetricSettings, common_body
from riglens.core.plain import to_plain
from riglens.core.rig.model import FORMAT_VERSION
from riglens.core.rig.yaml.file import identity_of
from riglens.core.scene.boxes import CLASSES
from riglens.core.scene.survey import notes_on
from riglens.core.sensors.registry import shown_kinds


def evaluation_document(
    field: EntropyField, settings: MetricSettings, evaluations: Sequence[Evaluation]
) -> dict[str, Any]:
    """Return scores of some rigs on one scene as plain data; entropies in nats, `seen` as a fraction.

    `body` is null where rigs differ; each rig then has its own.
    """
    grid, data = field.grid, field.data
    body = common_body(evaluation.settings.body for evaluation in evaluations)
    return {
        "riglens": FORMAT_VERSION,
        "grid": {
            **to_plain(grid, "voxel_m", "shape", "origin_m"),
            "informative_voxels": int(field.index.count),
        },
        "data": {
            "source": data.short_source,
            "frames": data.frames,
            "boxes": {name: data.boxes.get(name, 0) for name in CLASSES},
            "sha256": data.sha256,
            "notes": notes_on(data),
        },
        "method": settings.method,
        "reading": settings.reading,
        "lambda": settings.camera_weight,
        "body": body,
        "rigs": [_rig(evaluation, body) for evaluation in evaluations],
    }


def _rig(evaluation: Evaluation, body: Body | None) -> dict[str, Any]:
    return {
        **identity_of(evaluation.rig),
        **({} if body else {"body": evaluation.settings.body}),
        "elapsed_ms": evaluation.elapsed_ms,
        **score_figures(evaluation),
    }


def score_figures(evaluation: Evaluation) -> dict[str, Any]:
    """Return the scores of a rig as plain data."""
    scores = evaluation.scores
    kinds = sorted(kind.name for kind in shown_kinds(sensor.kind for sensor in evaluation.rig.sensors))
    return {
        "covered_voxels": {kind: int(scores.covered_voxels[kind]) for kind in (*kinds, "any")},
        "classes": {name: _class(scores.classes[name], kinds) for name in CLASSES},
    }


def _class(scores: ClassScores, kinds: Sequence[str]) -> dict[str, Any]:
    return {
        "h_total": scores.h_total,
        **{kind: to_plain(scores.kinds[kind]) for kind in kinds},
        "any": {"seen": scores.any_seen},
        "s_ms": scores.s_ms,
    }
