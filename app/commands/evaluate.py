"""`riglens evaluate`: the figures of rigs, those that lead first, then objects in full and the paper's scores."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Annotated, Literal

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
    from riglens.core.files import require_ending
    from riglens.core.targets.traffic import require_within
    from riglens.evaluation.loading import load_rigs, load_scene, load_traffic, note_mounts
    from riglens.evaluation.scenario import settings_of
    from riglens.jobs.evaluating import evaluated_rigs

    with_objects = scene.pog is None if targets is None else targets
    if not with_objects:
        _require_unused(count, surroundings=surroundings, occluders=scene.occluders, by=by, objects=objects)
    loaded = load_rigs(rigs, score, TERMINAL, reading.libraries, reading.housings)
    require_ending("objects", objects, ".csv", ".parquet")
    for name in _said(objects=objects, by=by) if len(loaded) > 1 else []:
        raise InputError(f"is for one rig (got {len(loaded)} rigs)", name)
    require_outputs((*rigs, *scene.files), json, objects)
    if with_objects:  # what is refused is refused in one line: before notes, and before the data are read
        if scene.pog is not None:
            raise InputError("needs a box data set: a stored POG holds no objects", "targets")
        require_within(count.within_m)
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


def _require_unused(count: CountOptions, **others: object) -> None:
    """Raise InputError when an option was given that means nothing without objects."""
    said = [one.name for one in fields(count) if getattr(count, one.name) != one.default]
    for name in (*said, *_said(**others)):
        raise InputError("counts objects: leave out", name, "no_targets")


def _said(**options: object) -> list[str]:
    """Return the options of objects that were given."""
    return [name for name, value in options.items() if value not in (None, "ring")]
