"""`riglens check`: whether rigs meet the requirements of a file; exit code 1 when one does not."""

from __future__ import annotations

from datetime import date
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from riglens.app.commands.options import (
    BODY,
    SCORE,
    LibraryArguments,
    SceneArguments,
    Whole,
    check_json,
)
from riglens.app.evaluation.options import ScoreOptions


def check(
    rigs: Annotated[tuple[str, ...], Parameter(name="RIG", negative=())],
    /,
    *,
    requirements: Annotated[Path, Parameter(metavar="FILE")],
    profile: Annotated[tuple[Path, ...], Parameter(metavar="FILE", show_default=False)] = (),
    scene: SceneArguments = SceneArguments(),
    body: Annotated[Literal["ignored", "blocks"] | None, BODY] = None,
    threads: Annotated[Whole, Parameter(group=SCORE)] = None,
    libraries: LibraryArguments = LibraryArguments(),
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True, metavar="FILE|-")] = None,
    junit: Annotated[Path | None, Parameter(metavar="FILE")] = None,
    github: bool = False,
) -> int:
    """Check rigs against requirements: what they see, blind zones, redundancy, tolerance, mounts.

    Exit code 0 when all are met, 1 when one is not, is not shown or not applicable, 2 for bad input, 3 for a failure of
    the program.

    Parameters
    ----------
    rigs
        Rig files or preset names.
    requirements
        The file that says what is required.
    profile
        A file of blind zone profiles of your own, instead of those that ship; may be given many times.
    body
        Whether the car's own body is in the way of what traffic is seen with (as the file says; else as the rig says).
        Blind zones, test objects and mounts always have a solid car.
    threads
        Threads to use (all cores). The verdicts do not depend on it.
    json
        Also write the verdicts as JSON to a file; with - to standard output, instead of the table.
    junit
        Also write the verdicts as JUnit XML, which pipelines show as test results.
    github
        Also print what is not met as annotations of GitHub Actions.
    """
    check_json(json)
    libraries.use()
    score = ScoreOptions(threads=threads, body=body)
    from riglens.app.commands import check_job

    asked = check_job.Asked(requirements, profile, json, junit, github, date.today())
    return check_job.check(rigs, scene.options(), score, asked)
