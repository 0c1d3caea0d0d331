"""`riglens check`: whether a rig meets the requirements of a file; exit code 1 when it does not."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from riglens.app.commands.options import (
    BODY,
    SCORE,
    LibraryArguments,
    Rig,
    SceneArguments,
    Whole,
    check_json,
)
from riglens.app.evaluation.options import ScoreOptions


def check(
    rig: Rig,
    /,
    *,
    requirements: Annotated[Path, Parameter(metavar="FILE")],
    profile: Annotated[tuple[Path, ...], Parameter(metavar="FILE", show_default=False)] = (),
    scene: SceneArguments = SceneArguments(),
    body: Annotated[Literal["ignored", "blocks"] | None, BODY] = None,
    threads: Annotated[Whole, Parameter(group=SCORE)] = None,
    libraries: LibraryArguments = LibraryArguments(),
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True, metavar="FILE|-")] = None,
) -> int:
    """Check a rig against requirements: what it sees, blind zones, redundancy, tolerance, mounts.

    Exit code 0 when all are met, 1 when one is not, 2 for bad input.

    Parameters
    ----------
    rig
        Rig file or preset name.
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
    """
    check_json(json)
    libraries.use()
    score = ScoreOptions(threads=threads, body=body)
    from riglens.app.commands import check_job

    return check_job.check(rig, scene.options(), score, check_job.Asked(requirements, profile, json))
