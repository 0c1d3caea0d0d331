"""Scores estimated from a coarser grid: how much more or less is seen there than for a rig known exactly.

The shares that are seen depend on the voxel edge, so those of a coarser grid cannot be shown as they are, but
their ratio between two similar rigs depends on it less. For LiDARs larger voxels exaggerate it, because beams
that lie close together fall into the same voxels: half of the change came nearest in measurements.
"""

from __future__ import annotations

from riglens.core.metric.scores import ClassScores, KindScore, MetricSettings, Scores, s_mig, s_ms

LIDAR_POWER = 0.5
"""Of the ratio between two rigs on voxels twice as large, in the measurements of docs/voxel-choice.md."""


def estimated(
    coarse: Scores, coarse_known: Scores, exact_known: Scores, settings: MetricSettings
) -> Scores | None:
    """Scores of a rig from its coarse ones, and from the coarse and the exact ones of a known rig.

    `covered_voxels` stays empty. None when they cannot be estimated: where the known rig sees nothing of what
    this one sees there is no ratio, and the reading `hits` counts something else than what is seen.
    """
    if settings.reading == "hits":
        return None
    classes = {}
    for name, known in exact_known.classes.items():
        now, then = coarse.classes[name], coarse_known.classes[name]
        camera = _scaled(known.camera.seen, now.camera.seen, then.camera.seen)
        lidar = _scaled(known.lidar.seen, now.lidar.seen, then.lidar.seen, LIDAR_POWER)
        seen = _scaled(known.any_seen, now.any_seen, then.any_seen)
        if camera is None or lidar is None or seen is None:
            return None
        classes[name] = _class_scores(known.h_total, camera, lidar, max(seen, camera, lidar), settings)
    return Scores(classes, {})


def _scaled(known: float, now: float, then: float, power: float = 1.0) -> float | None:
    if then > 0.0:
        return min(known * float((now / then) ** power), 1.0)
    return None if now > 0.0 else known


def _class_scores(
    h_total: float, camera: float, lidar: float, seen: float, settings: MetricSettings
) -> ClassScores:
    kinds = [
        KindScore(s_mig(settings.reading, h_total * share, h_total * (1.0 - share)), share)
        for share in (camera, lidar)
    ]
    total = s_ms(kinds[0].s_mig, kinds[1].s_mig, settings.camera_weight)
    return ClassScores(h_total, kinds[0], kinds[1], seen, total)
