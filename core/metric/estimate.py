"""Estimate scores from a coarser grid: by the ratio of coverage there to that of a rig known exactly.

The shares that are seen depend on the voxel edge, so those of a coarser grid cannot be shown as they are, but
their ratio between two similar rigs depends on it less. For LiDARs larger voxels exaggerate it, because beams
that lie close together fall into the same voxels: half of the change came nearest in measurements.
"""

from __future__ import annotations

from collections.abc import Mapping

from riglens.core.metric.scores import ClassScores, KindScore, MetricSettings, Scores, s_mig, s_ms
from riglens.core.sensors.registry import kinds


def estimated(
    coarse: Scores, coarse_known: Scores, exact_known: Scores, settings: MetricSettings
) -> Scores | None:
    """Return scores of a rig from its coarse ones, and from the coarse and the exact ones of a known rig.

    `covered_voxels` stays empty. None when they cannot be estimated: where the known rig sees nothing of what
    this one sees there is no ratio, and the reading `hits` counts something else than what is seen.
    """
    if settings.reading == "hits":
        return None
    classes = {}
    for name, known in exact_known.classes.items():
        now, then = coarse.classes[name], coarse_known.classes[name]
        shares = {
            kind.name: _scaled(
                known.kinds[kind.name].seen,
                now.kinds[kind.name].seen,
                then.kinds[kind.name].seen,
                kind.coarse_power,
            )
            for kind in kinds()
        }
        given = {kind: share for kind, share in shares.items() if share is not None}
        seen = _scaled(known.any_seen, now.any_seen, then.any_seen)
        if len(given) < len(shares) or seen is None:
            return None
        classes[name] = _class_scores(known.h_total, given, max(seen, *given.values()), settings)
    return Scores(classes, {})


def _scaled(known: float, now: float, then: float, power: float = 1.0) -> float | None:
    if then > 0.0:
        return min(known * float((now / then) ** power), 1.0)
    return None if now > 0.0 else known


def _class_scores(
    h_total: float, shares: Mapping[str, float], seen: float, settings: MetricSettings
) -> ClassScores:
    found = {
        kind: KindScore(s_mig(settings.reading, h_total * share, h_total * (1.0 - share)), share)
        for kind, share in shares.items()
    }
    total = s_ms({kind: score.s_mig for kind, score in found.items()}, settings.camera_weight)
    return ClassScores(h_total, found, seen, total)
