"""`riglens evaluate`: scores of rigs."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from riglens.app.commands.options import Libraries, Scene, Score, check_json


def evaluate(
    *rigs: Annotated[str, Parameter(name="RIG", required=True)],
    scene: Scene = Scene(),
    libraries: Libraries = Libraries(),
    score: Score = Score(),
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
    from riglens.app.commands import jobs

    jobs.evaluate(rigs, options, metric, json)
