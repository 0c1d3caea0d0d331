"""From the sums of covered entropy, in fixed point, to the scores of every class."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from riglens.core.kernels.runtime.codes import VOXELS
from riglens.core.metric.entropy import EntropyField, nats
from riglens.core.metric.scores import ClassScores, KindScore, MetricSettings, Scores, s_mig, s_ms
from riglens.core.scene.boxes import CLASSES
from riglens.core.sensors.registry import kind_names


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
    kinds: dict[str, KindScore] = {}
    for row, name in enumerate(kind_names()):
        seen_q = int(sums_q[row, cls])
        hit_q = int(hits_q[row, cls]) if hits_q is not None else 0
        magnitude = s_mig(settings.reading, nats(seen_q), nats(total_q - seen_q), nats(hit_q))
        kinds[name] = KindScore(magnitude, _share(seen_q, total_q))
    total = s_ms({name: kind.s_mig for name, kind in kinds.items()}, settings.camera_weight)
    return ClassScores(nats(total_q), kinds, _share(int(sums_q[-1, cls]), total_q), total)


def score(
    field: EntropyField,
    sums_q: NDArray[np.int64],
    settings: MetricSettings,
    hits_q: NDArray[Any] | None = None,
) -> Scores:
    """Return scores from covered sums int64 (kinds + 1, 4): a row for each kind of sensor, then one for any sensor;
    columns three classes, then voxels.

    hits_q (kinds, 3) are the sums with multiplicity, needed for the `hits` reading only.
    """
    classes = {name: _class_scores(field, c, sums_q, settings, hits_q) for c, name in enumerate(CLASSES)}
    covered = {name: int(sums_q[row, VOXELS]) for row, name in enumerate((*kind_names(), "any"))}
    return Scores(classes, covered)
