"""`riglens evaluate`: the figures of rigs, those that lead first, then objects in full and the paper's scores."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from riglens.app.commands.options import (
    COUNT,
    CountArguments,
    EverythingArguments,
    JsonFigures,
    RigArguments,
    RigNames,
    ScoreArguments,
    Surroundings,
    command,
)
from riglens.core.errors import InputError
from riglens.evaluation.options import CountOptions, SceneOptions, ScoreOptions


@command
def evaluate(
    *rigs: RigNames,
    targets: Annotated[bool | None, Parameter(group=COUNT, negative="--no-targets")] = None,
    scene: EverythingArguments = SceneOptions(),
    surroundings: Surroundings = None,
    by: Annotated[Literal["ring", "sector"], Parameter(group=COUNT)] = "ring",
    count: CountArguments = CountOptions(),
    objects: Annotated[Path | None, Parameter(group=COUNT, metavar="FILE.csv|.parquet")] = None,
    reading: RigArguments = RigArguments(),
    score: ScoreArguments = ScoreOptions(),
    json: JsonFigures = None,
) -> None:
    """Evaluate one or more rigs: the leading figures, points and pixels on objects, and the paper's scores.

    Parameters
    ----------
    targets
        Also print every figure of objects. They are counted anyway, unless the traffic is a stored POG.
    by
        Parts of the table of objects, for one rig: rings of 10 m of distance, or sectors of 45° around the car.
    objects
        Also write one row per object to a table; for one rig.
    """
    # --help needs nothing of this
    from riglens.app.commands.output import deliver, require_outputs
    from riglens.app.terminal.console import TERMINAL
    from riglens.app.terminal.figures import print_leading
    from riglens.app.terminal.objects import print_objects, write_objects
    from riglens.app.terminal.scores import print_scene, print_scores
    from riglens.core.figures.documents import evaluation_document
    from riglens.core.figures.evaluated import EvaluationSettings
    from riglens.evaluation.loading import load_rigs, load_scene, load_traffic, note_mounts
    from riglens.evaluation.scenario import settings_of
    from riglens.jobs.evaluating import evaluated_rigs

    with_objects = scene.pog is None if targets is None else targets
    _require_fitting(with_objects, len(rigs), scene, count, surroundings=surroundings, by=by, objects=objects)
    loaded = load_rigs(rigs, score, TERMINAL, reading.libraries, reading.housings)
    require_outputs((*rigs, *scene.files), json, objects)
    settings = EvaluationSettings(settings_of(score), count.settings(score.body))
    _, field = load_scene(scene, TERMINAL, loaded, score)
    traffic = load_traffic(scene.surrounded(surroundings), count.within_m, TERMINAL) if with_objects else None
    note_mounts(loaded, TERMINAL)
    found = evaluated_rigs(loaded, field, traffic, settings, count.sample, score.threads, TERMINAL)
    counted = [one.objects for one in found if one.objects is not None]
    if objects is not None:
        write_objects(objects, counted[0])

    def show() -> None:
        print_scene(field, loaded, score)
        print_leading(found)
        if counted and (targets or by != "ring"):
            print_objects(counted, by)
        print_scores([one.voxels for one in found if one.voxels is not None], score)

    deliver(evaluation_document(field, settings.metric, found), json, show)


def _require_fitting(
    with_objects: bool, rigs: int, scene: SceneOptions, count: CountOptions, **others: Any
) -> None:
    """Raise InputError for options of objects that do not fit the data, the number of rigs or each other."""
    from riglens.core.files import require_ending
    from riglens.core.targets.traffic import require_within

    given = [name for name, value in others.items() if value not in (None, "ring")]
    if with_objects:
        if scene.pog is not None:
            raise InputError("needs a box data set: a stored POG holds no objects", "targets")
        require_within(count.within_m)
        require_ending("objects", others["objects"], ".csv", ".parquet")
        for name in given:
            if name != "surroundings" and rigs > 1:
                raise InputError(f"is for one rig (got {rigs} rigs)", name)
        return
    given += ["occluders"] * (scene.occluders is not None)
    for name in (*(one.name for one in fields(count) if getattr(count, one.name) != one.default), *given):
        raise InputError("counts objects: leave out", name, "no_targets")
