"""`riglens card`: up to which distance a rig gets enough points or pixels onto one road user."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter

from riglens.app.commands.options import (
    SCORE,
    LibraryArguments,
    SolidBody,
    Whole,
    check_json,
    whole_number,
)
from riglens.app.evaluation.options import ScoreOptions, require_solid

LOOK = Group("Look", sort_key=20)
STOP = Group("Stop", sort_key=21)


def card(
    rig: Annotated[str, Parameter(name="RIG")],
    *,
    min_points: Annotated[int, Parameter(converter=whole_number, group=LOOK, metavar="N")] = 5,
    min_height: Annotated[float, Parameter(group=LOOK, metavar="PX")] = 25.0,
    directions: Annotated[int, Parameter(converter=whole_number, group=LOOK, metavar="N")] = 8,
    to: Annotated[float, Parameter(group=LOOK, metavar="M")] = 150.0,
    reaction: Annotated[float, Parameter(group=STOP, metavar="S")] = 1.0,
    deceleration: Annotated[float, Parameter(group=STOP, metavar="MPS2")] = 5.0,
    threads: Annotated[Whole, Parameter(group=SCORE)] = None,
    body: SolidBody = None,
    libraries: LibraryArguments = LibraryArguments(),
    csv: Annotated[Path | None, Parameter(metavar="FILE.csv")] = None,
    chart: Annotated[Path | None, Parameter(metavar="FILE.png|.svg")] = None,
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True, metavar="FILE|-")] = None,
) -> None:
    """Say up to which distance a rig gets enough onto one road user in the open, beside stopping distances. The car is
    solid.

    Parameters
    ----------
    rig
        Rig file or preset name.
    min_points
        So many LiDAR points are enough.
    min_height
        So many native pixels of height in a camera are enough.
    directions
        So many directions around the car, the first one ahead.
    to
        Look up to this distance, in metres.
    reaction
        Time until the car brakes, in seconds (our choice).
    deceleration
        How hard it brakes, in m/s2 (our choice).
    threads
        Threads to use (all cores). The figures do not depend on it.
    csv
        Also write the card as a table.
    chart
        Also draw it: distance by direction.
    json
        Also write it as JSON to a file; with - to standard output, instead of the table.
    """
    check_json(json)
    libraries.use()
    require_solid(body)
    score = ScoreOptions(threads=threads)
    from riglens.app.commands import card_job
    from riglens.core.targets.card import CardPlan, around

    plan = CardPlan(
        min_points,
        min_height,
        around(directions),
        to,
        reaction_s=reaction,
        deceleration_mps2=deceleration,
    )
    card_job.card(rig, plan, score, card_job.Files(csv, chart, json))
