"""Search for a better rig, within a file of requirements if there is one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from riglens.core.errors import InputError
from riglens.core.monitor import Monitor
from riglens.core.optimise.objectives import objective_named
from riglens.core.optimise.results import OptimiseResult
from riglens.core.optimise.run import optimise
from riglens.core.review.mounts import SIDES, MountLimits, Overhang
from riglens.core.rig.model import Rig
from riglens.core.targets.traffic import Traffic
from riglens.evaluation.loading import load_scene, load_traffic
from riglens.evaluation.options import SceneOptions, ScoreOptions
from riglens.evaluation.search_options import HIGHEST_M, SearchOptions
from riglens.jobs.checking import CheckInputs, scene_for, unmet_by


def optimised(
    rig: Rig,
    search: SearchOptions,
    scene: SceneOptions,
    score: ScoreOptions,
    monitor: Monitor,
    *,
    within_m: float,
    requirements: Path | None = None,
    reference: Rig | None = None,
    check_boxes: Sequence[Path] = (),
) -> OptimiseResult:
    """Propose rigs for the objects of a scene within a distance, checked in its surroundings, or without them, and in
    further box data sets.

    requirements: each mount keeps their limits, and the whole rig is checked; reference: as in `Problem`.
    """
    rules = search.rules()
    asked = None if requirements is None else CheckInputs.of(requirements, (), [rig])
    if asked is not None and asked.required.mounts is not None:
        rules = _stricter(rules, asked.required.mounts)
    needs_voxels = objective_named(search.objective).figure.needs == "voxels"
    problem = search.problem(
        rig,
        load_traffic(scene, within_m, monitor),
        search.additions(rules),
        reference=reference,
        voxels=load_scene(scene, monitor)[1] if needs_voxels else None,
        checks=_other_traffic(scene, check_boxes, within_m, monitor),
    )
    if asked is not None:
        subject = scene_for(scene, [rig], score, asked, monitor)
        problem = replace(problem, unmet=lambda one: unmet_by(one, score, subject, asked))
    with monitor.stage("Casting, choosing, checking") as progress:
        return optimise(problem, score.threads, lambda step: progress(step.of_all))


def _stricter(rules: MountLimits, asked: MountLimits) -> MountLimits:
    """Return the limits that keep those of options and of a file; zones of the file replace the usual ones."""

    def least(of: str, *both: MountLimits | Overhang) -> float | None:
        return min((limit for limit in (getattr(one, of) for one in both) if limit is not None), default=None)

    (low, high), (lowest, highest) = (one.height_m or (-HIGHEST_M, HIGHEST_M) for one in (rules, asked))
    if low > highest:
        raise InputError(f"must be at most {highest:g} m, as the requirements say (got {low:g})", "lowest")
    sizes = ("gap_m", "length_m", "width_m", "total_height_m")
    return MountLimits(
        **{name: least(name, rules, asked) for name in sizes},
        height_m=(max(low, lowest), min(high, highest)),
        spacing_m=max(rules.spacing_m or 0.0, asked.spacing_m or 0.0),
        beyond_m=Overhang(**{side: least(side, rules.beyond_m, asked.beyond_m) for side in SIDES}),
        keep_out=asked.keep_out,
    )


def _other_traffic(
    scene: SceneOptions, more: Sequence[Path], within_m: float, monitor: Monitor
) -> dict[str, Traffic]:
    """Return other traffic by the name of its case: that of the bundled town with its surroundings, or without."""
    found = {}
    if scene.boxes is None:
        name = "surroundings ignored" if scene.surroundings else "surroundings block"
        found[name] = load_traffic(replace(scene, surroundings=not scene.surroundings), within_m, monitor)
    for path in more:
        found[path.stem] = load_traffic(
            replace(scene, boxes=path, surroundings=False, occluders=None), within_m, monitor
        )
    return found
