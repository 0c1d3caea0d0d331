"""`riglens evaluate`: scores of rigs, and with --targets their hit coverage."""

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
    targets: Annotated[bool, Parameter(group=COUNT)] = False,
    scene: EverythingArguments = SceneOptions(),
    surroundings: Surroundings = None,
    by: Parts = "ring",
    count: CountArguments = CountArguments(),
    reading: RigArguments = RigArguments(),
    score: ScoreArguments = ScoreOptions(),
    json: JsonFigures = None,
) -> None:
    """Score one or more rigs, with --targets also their points and pixels on objects.

    Parameters
    ----------
    rigs
        Rig files or preset names.
    targets
        Also count points and pixels on the objects of the traffic, including occlusion: takes seconds more.
    surroundings
        block: houses, walls and poles of the bundled scenario hide objects too (ignored).
    by
        Parts of the table of objects, for one rig: rings of 10 m of distance, or sectors of 45° around the car.
    """
    # --help needs nothing of this
    from riglens.app.commands.output import deliver
    from riglens.app.commands.targets import count_hits, require_count_outputs
    from riglens.app.terminal.console import note
    from riglens.app.terminal.loading import load_rigs, load_scene
    from riglens.app.terminal.scores import print_scores, score_rigs
    from riglens.core.engine.evaluation_json import evaluation_document
    from riglens.evaluation.scenario import settings_of

    if not targets:
        count.require_unused(scene, surroundings, by)
    loaded = load_rigs(rigs, score, reading.libraries, reading.housings)
    require_count_outputs(count, loaded, (*rigs, *scene.files), json, by)
    _, field = load_scene(scene, loaded, score)
    for line in wrong_places(loaded):  # what is refused is refused in one line
        note(line)
    evaluations = score_rigs(loaded, field, score)
    document = evaluation_document(field, settings_of(score), evaluations)
    found = None
    if targets:
        found = count_hits(loaded, scene.surrounded(surroundings), count, score)
        document["targets"] = found.document()

    def show() -> None:
        print_scores(evaluations, field, score)
        if found is not None:
            found.show(by)

    deliver(document, json, show)


def wrong_places(rigs: Sequence[Rig]) -> Iterator[str]:
    """Yield one line for each sensor with an impossible mount; none for a body that was not read."""
    from riglens.core.vehicle.standing import mount_statuses, problems_in_short

    for rig in rigs:
        if not rig.vehicle.lacks_mesh:
            for line in problems_in_short(mount_statuses(rig)):
                yield f"{rig.name}: {line}"
