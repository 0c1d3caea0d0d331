"""`riglens [RIG]` and `riglens evaluate`: scores of rigs, in the window or in the terminal."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from riglens.app.commands.options import LibraryArguments, Rig, SceneArguments, ScoreArguments, check_json
from riglens.app.evaluation.options import DEFAULT_RIG


def window(
    rig: Rig = DEFAULT_RIG,
    /,
    *,
    scene: SceneArguments = SceneArguments(),
    score: ScoreArguments = ScoreArguments(),
    libraries: LibraryArguments = LibraryArguments(),
) -> int:
    """Open the window on RIG (nuScenes car). Without a display: the scores, and a picture, YAML and JSON in out/."""
    libraries.use()
    options, metric = scene.options(), score.options()
    from riglens.app.commands.start import start

    return start(rig, options, metric)


def evaluate(
    *rigs: Annotated[str, Parameter(name="RIG", required=True)],
    scene: SceneArguments = SceneArguments(),
    libraries: LibraryArguments = LibraryArguments(),
    score: ScoreArguments = ScoreArguments(),
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True, metavar="FILE|-")] = None,
) -> None:
    """Score one or more rigs.

    Parameters
    ----------
    rigs
        Rig files or preset names.
    json
        Also write the scores as JSON to a file; with - to standard output, instead of the table.
    """
    check_json(json)
    libraries.use()
    options, metric = scene.options(), score.options()
    from riglens.app.commands import scores_job

    scores_job.evaluate(rigs, options, metric, json)
