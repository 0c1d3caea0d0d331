"""`riglens report`: one page with everything about rigs, and the check of an earlier one."""

from __future__ import annotations

from contextlib import redirect_stderr
from io import StringIO
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter

from riglens.app.background.own_process import Tell
from riglens.app.background.report import ReportJob
from riglens.app.commands.options import (
    AnyRigs,
    RigArguments,
    SceneArguments,
    ScoreArguments,
    all_of,
    command,
)
from riglens.app.commands.output import require_outputs
from riglens.app.commands.running import guarded
from riglens.app.terminal.console import TERMINAL, note, results
from riglens.core.errors import InputError
from riglens.core.files import require_ending, write_file
from riglens.core.rig.library import use_libraries
from riglens.core.shown_text import visible
from riglens.core.vehicle.mesh_file import with_mesh_read
from riglens.evaluation.loading import load_rigs
from riglens.evaluation.names import label_of
from riglens.evaluation.options import ReportOptions, SceneOptions, ScoreOptions
from riglens.reporting.document import document_of
from riglens.reporting.figures import (
    Labels,
    ReportPlan,
    WhyHere,
    report_of,
)
from riglens.reporting.making import (
    Verified,
    portable,
    rendered,
    require_pango,
    verified,
    write_report,
)

SHOWN = 20
REPORT = Group("Report", sort_key=5)
ContentArguments = Annotated[ReportOptions, all_of(ReportOptions, REPORT)]


@command
def report(
    rigs: AnyRigs = (),
    /,
    *,
    out: Annotated[Path | None, Parameter(group=REPORT, metavar="FILE.html|.pdf")] = None,
    verify: Annotated[Path | None, Parameter(group=REPORT, metavar="FILE.html|.pdf")] = None,
    meshes: Annotated[Path | None, Parameter(group=REPORT, metavar="DIR")] = None,
    holds: ContentArguments = ReportOptions(),
    scene: SceneArguments = SceneOptions(),
    score: ScoreArguments = ScoreOptions(),
    reading: RigArguments = RigArguments(),
) -> int:
    """Write a page about one or more rigs that needs no network and no script, or check an earlier one.

    Parameters
    ----------
    out
        The page, or the same as a PDF.
    verify
        Recompute an earlier page or PDF, and report differences (exit code 1).
    meshes
        With --verify: folder with the mesh files and ray tables that the report names (the report's folder).
    """
    if verify is not None:
        if out is not None:
            raise InputError("cannot be combined with", "verify", "out")
        if rigs:
            raise InputError(f"brings its own rigs: leave out {' '.join(rigs)}", "verify")
        use_libraries(reading.libraries)
        return _print_verified(verified(verify, scene, score, meshes, TERMINAL))
    if out is None:
        raise InputError("report: name rigs and --out FILE.html, or --verify FILE.html|.pdf")
    if meshes is not None:
        raise InputError(
            "applies to an earlier page only, as rigs name their meshes; specify it with",
            "meshes",
            "verify",
        )
    if not rigs:
        raise InputError("report: no rig named; name one or more")
    require_ending("out", out, ".html", ".pdf")
    if out.suffix.lower() == ".pdf":
        require_pango()
    loaded = load_rigs(rigs, score.solid(), TERMINAL, reading.libraries, reading.housings)
    require_outputs((*rigs, *scene.files, *([holds.requirements] if holds.requirements else [])), out)
    write_report(loaded, out, scene, score, holds, TERMINAL, [Path(name).name for name in rigs])
    results().print(f"wrote {visible(str(out))}", soft_wrap=True)
    return 0


def _print_verified(found: Verified) -> int:
    """Print what differs; return the exit code."""
    console, lines = results(), found.lines
    for line in lines[:SHOWN]:
        console.print(visible(line), soft_wrap=True, markup=False)
    if len(lines) > SHOWN:
        console.print(f"and {len(lines) - SHOWN} more", soft_wrap=True)
    if found.place is None:
        console.print("every figure is the same, and so is what the file says", soft_wrap=True)
        if found.given:
            given = f"taken as given, for no data confirm it: {'; '.join(found.given)}"
            console.print(visible(given), soft_wrap=True, markup=False)
        return 0
    figures = "" if lines else "every attached figure is the same, but their presentation "
    console.print(visible(f"{figures}differs, first at {found.place}"), soft_wrap=True, markup=False)
    return 1


def serve(pipe: Connection) -> None:
    """Make the report of a job of the window; the last message is what is wrong, empty for nothing."""
    job = pipe.recv()
    with redirect_stderr(StringIO()) as said:
        code = guarded(lambda: prepare(job, lambda share, stage: pipe.send((share, stage))), label_of)
    lines = said.getvalue().split("\n")
    last = next((line for line in reversed(lines) if line.strip()), "the process exited without a message")
    pipe.send(last.removeprefix("riglens: ") if code else "")


def prepare(job: ReportJob, tell: Tell) -> None:
    """Write the report of a job of the window."""
    if job.out.suffix.lower() == ".pdf":
        require_pango()
    rigs = tuple(with_mesh_read(rig, job.out.parent, note) for rig in job.rigs)
    why = None if job.why is None else WhyHere.model_validate(job.why)
    labels = Labels(**job.holds.labels)
    plan = ReportPlan(portable(rigs), job.scene, job.score, job.holds.draws, 0, labels=labels, why=why)
    document = document_of(plan, report_of(plan, tell, TERMINAL))
    tell(1.0, "Writing the report")
    write_file(job.out, rendered(document, job.out.suffix.lower()))
