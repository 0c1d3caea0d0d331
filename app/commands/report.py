"""`riglens report`: one page with everything about rigs, and the check of an earlier one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter

from riglens.app.commands.options import LibraryArguments, SceneArguments, ScoreArguments, whole_number
from riglens.app.evaluation.options import USUAL_DRAWS
from riglens.core.errors import InputError

REPORT = Group("Report", sort_key=5)


def report(
    rigs: Annotated[tuple[str, ...], Parameter(name="RIG", negative=())] = (),
    /,
    *,
    out: Annotated[Path | None, Parameter(group=REPORT, metavar="FILE.html|.pdf")] = None,
    verify: Annotated[Path | None, Parameter(group=REPORT, metavar="FILE.html|.pdf")] = None,
    meshes: Annotated[Path | None, Parameter(group=REPORT, metavar="DIR")] = None,
    requirements: Annotated[Path | None, Parameter(group=REPORT, metavar="FILE")] = None,
    draws: Annotated[int, Parameter(converter=whole_number, group=REPORT, metavar="N")] = USUAL_DRAWS,
    seed: Annotated[int, Parameter(converter=whole_number, group=REPORT, metavar="N")] = 0,
    project: Annotated[str | None, Parameter(group=REPORT, metavar="TEXT")] = None,
    revision: Annotated[str | None, Parameter(group=REPORT, metavar="TEXT")] = None,
    author: Annotated[str | None, Parameter(group=REPORT, metavar="TEXT")] = None,
    scene: SceneArguments = SceneArguments(),
    score: ScoreArguments = ScoreArguments(),
    libraries: LibraryArguments = LibraryArguments(),
) -> int:
    """Write a page about one or more rigs that needs no network and no script, or check an earlier one.

    Parameters
    ----------
    rigs
        Rig files or preset names.
    out
        The page, or the same as a PDF.
    verify
        Make an earlier page or PDF again, and say where it differs (exit code 1).
    meshes
        With --verify: folder of the car bodies in mesh files that it names (its own folder).
    requirements
        A file of requirements, as for `riglens check`.
    draws
        Draws of the tolerance; 0 leaves it out.
    seed
        Of the draws.
    project
        The project, for the header.
    revision
        The revision of the rigs or of the report, for the header.
    author
        The author, for the header.
    """
    libraries.use()
    from riglens.app.commands import report_job
    from riglens.app.studies.report_figures import labels_of

    if (out is None) == (verify is None):
        raise InputError("report: give either rigs with --out FILE.html, or --verify FILE.html|.pdf")
    if verify is not None:
        if rigs:
            raise InputError(f"report: found rigs with --verify {verify}; it brings its own")
        return report_job.verify(verify, scene.options(), score.options(), meshes)
    assert out is not None
    if meshes is not None:
        raise InputError("--meshes belongs to --verify; leave it out, rigs say where their meshes are")
    if not rigs:
        raise InputError("report: found no rig; name one or more")
    asked = report_job.Asked(out, requirements, draws, seed, labels_of(project, revision, author))
    report_job.report(rigs, scene.options(), score.options(), asked)
    return 0
