"""From the sums of covered entropy, in fixed point, to the scores of every class."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.runtime.codes import ANY, VOXELS
from riglens.core.metric.entropy import EntropyField, nats
from riglens.core.metric.scores import ClassScores, KindScore, MetricSettings, Scores, s_mig, s_ms
from riglens.core.scene.boxes import CLASSES

KINDS = ("camera", "lidar")
"""Kinds of sensor, in the order of the sums' rows CAMERAS and LIDARS."""


def _share(part_q: int, total_q: int) -> float:
    return part_q / total_q if total_q else 0.0


def _class_scores(
    field: EntropyField,
    cls: int,
    sums_q: NDArray[np.int64],
    settings: MetricSettings,
    hits_q: NDArray[Any] | None,
) -> ClassScores:
    total_q = field.totals_q[cls]
    kinds = []
    for kind in range(len(KINDS)):
        seen_q = int(sums_q[kind, cls])
        hit_q = int(hits_q[kind, cls]) if hits_q is not None else 0
        magnitude = s_mig(settings.reading, nats(seen_q), nats(total_q - seen_q), nats(hit_q))
        kinds.append(KindScore(magnitude, _share(seen_q, total_q)))
    camera, lidar = kinds
    total = s_ms(camera.s_mig, lidar.s_mig, settings.camera_weight)
    return ClassScores(nats(total_q), camera, lidar, _share(int(sums_q[ANY, cls]), total_q), total)


def score(
    field: EntropyField,
    sums_q: NDArray[np.int64],
    settings: MetricSettings,
    hits_q: NDArray[Any] | None = None,
) -> Scores:
    """Scores from covered sums int64 (3, 4): rows cameras, LiDARs, any; columns three classes, then voxels.

    hits_q (2, 3) are the sums with multiplicity, needed for the `hits` reading only.
    """
    classes = {name: _class_scores(field, c, sums_q, settings, hits_q) for c, name in enumerate(CLASSES)}
    covered = {name: int(sums_q[row, VOXELS]) for row, name in enumerate((*KINDS, "any"))}
    return Scores(classes, covered)
