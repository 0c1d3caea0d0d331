"""`riglens evaluate`: the figures of rigs, those that lead first, then objects in full and the paper's scores."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from riglens.app.commands.options import (
    COUNT,
    CountArguments,
    EverythingArguments,
    JsonFigures,
    Parts,
    RigArguments,
    RigNames,
    ScoreArguments,
    Surroundings,
    command,
)
from riglens.evaluation.options import SceneOptions, ScoreOptions

if TYPE_CHECKING:
    from riglens.core.rig.model import Rig


@command
def evaluate(
    *rigs: RigNames,
    targets: Annotated[bool | None, Parameter(group=COUNT, negative="--no-targets")] = None,
    scene: EverythingArguments = SceneOptions(),
    surroundings: Surroundings = None,
    by: Parts = "ring",
    count: CountArguments = CountArguments(),
    reading: RigArguments = RigArguments(),
    score: ScoreArguments = ScoreOptions(),
    json: JsonFigures = None,
) -> None:
    """Evaluate one or more rigs: the leading figures, points and pixels on objects, and the paper's scores.

    Parameters
    ----------
    rigs
        Rig files or preset names.
    targets
        Also print every figure of objects. They are counted anyway, unless the traffic is a stored POG.
    surroundings
        block: houses, walls and poles of the bundled scenario hide objects too (ignored).
    by
        Parts of the table of objects, for one rig: rings of 10 m of distance, or sectors of 45° around the car.
    """
    # --help needs nothing of this
    from riglens.app.commands.output import deliver
    from riglens.app.commands.targets import (
        count_hits,
        count_settings,
        require_count_outputs,
        require_countable,
    )
    from riglens.app.terminal.console import note
    from riglens.app.terminal.figures import evaluated_rigs, print_leading
    from riglens.app.terminal.loading import load_rigs, load_scene, load_traffic
    from riglens.app.terminal.scores import print_scene, print_scores, score_rigs
    from riglens.core.figures.documents import evaluation_document
    from riglens.evaluation.scenario import settings_of

    with_objects = scene.pog is None if targets is None else targets
    if not with_objects:
        count.require_unused(scene, surroundings, by)
    loaded = load_rigs(rigs, score, reading.libraries, reading.housings)
    require_count_outputs(count, loaded, (*rigs, *scene.files), json, by)
    how = None
    if with_objects:  # what is refused is refused in one line: before notes, and before the data are read
        require_countable(scene, count)
        how = count_settings(count, score)
    _, field = load_scene(scene, loaded, score)
    traffic = None if how is None else load_traffic(scene.surrounded(surroundings), count.within_m)
    for line in wrong_places(loaded):
        note(line)
    evaluations = score_rigs(loaded, field, score)
    found = None
    if how is not None and traffic is not None:
        found = count_hits(loaded, traffic, how, count, score)
    evaluated = evaluated_rigs(evaluations, [] if found is None else found.counted, field, score)
    document = evaluation_document(field, settings_of(score), evaluated)

    def show() -> None:
        print_scene(field, loaded, score)
        print_leading(evaluated)
        if found is not None and (targets or by != "ring"):
            found.show(by)
        print_scores(evaluations, score)

    deliver(document, json, show)


def wrong_places(rigs: Sequence[Rig]) -> Iterator[str]:
    """Yield one line for each sensor with an impossible mount; none for a body that was not read."""
    from riglens.core.vehicle.standing import mount_statuses, problems_in_short

    for rig in rigs:
        if not rig.vehicle.lacks_mesh:
            for line in problems_in_short(mount_statuses(rig)):
                yield f"{rig.name}: {line}"
