"""Evaluate rigs for every figure, each from scratch, so that their times can be compared."""

from __future__ import annotations

from collections.abc import Sequence

from riglens.core.engine.engine import evaluate_from_scratch
from riglens.core.engine.warm_up import tiny_field
from riglens.core.figures.evaluated import Evaluated, EvaluationSettings
from riglens.core.metric.entropy import EntropyField
from riglens.core.monitor import SILENT, Monitor
from riglens.core.rig.model import Rig
from riglens.core.targets.engine import TargetEngine, warm_up
from riglens.core.targets.traffic import Traffic


def evaluated_rigs(
    rigs: Sequence[Rig],
    field: EntropyField,
    traffic: Traffic | None,
    settings: EvaluationSettings,
    sample: int | None = None,
    threads: int | None = None,
    monitor: Monitor = SILENT,
    with_seen: bool = False,
) -> list[Evaluated]:
    """Return what is known of rigs, in their order: of voxels and, where there is traffic, of the objects in `sample`
    frames (all). Kernels of these rigs are loaded before, on a tiny field, so that no time includes it."""
    list(evaluate_from_scratch(tiny_field(), rigs, settings.metric, threads, with_seen))
    found = evaluate_from_scratch(field, rigs, settings.metric, threads, with_seen)
    if traffic is not None:
        warm_up(threads)
    evaluated = list[Evaluated]()
    with monitor.stage("Casting rays") as progress:
        for rig, voxels in zip(rigs, found, strict=True):
            objects = None
            if traffic is not None:
                objects = TargetEngine(traffic, threads).evaluate(rig, settings.targets, sample)
            evaluated.append(Evaluated(rig, settings, field, voxels, objects))
            progress(len(evaluated) / len(rigs))
    return evaluated
