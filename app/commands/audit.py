"""`riglens audit`: where the rays of each sensor go."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from riglens.app.commands.options import (
    SCORE,
    LibraryArguments,
    Rig,
    SceneArguments,
    SolidBody,
    Whole,
    check_json,
)
from riglens.app.evaluation.options import ScoreOptions, require_solid


def audit(
    rig: Rig,
    /,
    *,
    scene: SceneArguments = SceneArguments(),
    body: SolidBody = None,
    threads: Annotated[Whole, Parameter(group=SCORE)] = None,
    libraries: LibraryArguments = LibraryArguments(),
    json: Annotated[str | None, Parameter(allow_leading_hyphen=True, metavar="FILE|-")] = None,
) -> None:
    """Follow every ray of each sensor: into the solid car, past the region, into the ground, or to what it brings.

    Parameters
    ----------
    rig
        Rig file or preset name.
    threads
        Threads to use (all cores). The figures do not depend on it.
    json
        Also write the figures as JSON to a file; with - to standard output, instead of the table.
    """
    check_json(json)
    libraries.use()
    options = scene.options()
    require_solid(body)
    score = ScoreOptions(threads=threads, body="blocks")
    from riglens.app.commands import audit_job

    audit_job.audit(rig, options, score, json)
