"""`riglens tolerance`: what small errors of mounts and a car that pitches make of a rig's figures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter

from riglens.app.commands.options import (
    LibraryArguments,
    Rig,
    SceneArguments,
    ScoreArguments,
    Whole,
    check_json,
    whole_number,
)

DRAWING = Group("Tolerance", sort_key=15)


def tolerance(
    rig: Rig,
    /,
    *,
    profile: Annotated[str, Parameter(group=DRAWING, metavar="NAME")] = "assembly",
    draws: Annotated[int, Parameter(converter=whole_number, group=DRAWING, metavar="N")] = 256,
    seed: Annotated[int, Parameter(converter=whole_number, group=DRAWING, metavar="N")] = 0,
    sample: Annotated[Whole, Parameter(group=DRAWING, metavar="N")] = 100,
    sensitivities: Annotated[bool, Parameter(group=DRAWING, negative="--no-sensitivities")] = True,
    worst: Annotated[Path | None, Parameter(group=DRAWING, metavar="FILE.yaml")] = None,
    figure: Annotated[str, Parameter(group=DRAWING, metavar="NAME")] = "seen car",
    scene: SceneArguments = SceneArguments(),
    score: ScoreArguments = ScoreArguments(),
    libraries: LibraryArguments = LibraryArguments(),
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True, metavar="FILE|-")] = None,
) -> None:
    """Say how much a rig's figures spread under small errors of its mounts, or of how the car stands.

    Parameters
    ----------
    rig
        Rig file or preset name.
    profile
        Which errors: assembly, service, brackets, ride or load.
    draws
        So many draws; the sequence is balanced in powers of two.
    seed
        Of the draws; the same seed gives the same errors to rigs with the same sensors.
    sample
        Count road users in so many frames; 0 leaves them out.
    sensitivities
        Also say what each error does on its own.
    worst
        Also write the rig of the worst draw, to look at it beside the rig as designed.
    figure
        By which figure the worst draw is told, such as "seen car" or "on_target pedestrian".
    json
        Also write the figures as JSON to a file; with - to standard output, instead of the table.
    """
    check_json(json)
    libraries.use()
    from riglens.app.commands import tolerance_job

    asked = tolerance_job.Asked(profile, draws, seed, sample, sensitivities, worst, figure, json)
    tolerance_job.tolerance(rig, scene.options(), score.options(), asked)
