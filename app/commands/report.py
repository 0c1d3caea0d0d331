"""`riglens report`: one page with everything about rigs, and the check of an earlier one."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import redirect_stderr, suppress
from dataclasses import replace
from io import StringIO
from multiprocessing.connection import Connection
from pathlib import Path, PurePath
from typing import Annotated, Any

from cyclopts import Group, Parameter

from riglens.app.background.report import PAGE, PDF, ReportJob, Tell, page_picture
from riglens.app.commands.options import RigArguments, SceneArguments, ScoreArguments, number
from riglens.app.commands.output import require_ending, require_outputs
from riglens.app.commands.running import guarded
from riglens.app.commands.tolerance import require_draws
from riglens.app.terminal.console import note, results, stage_bar
from riglens.app.terminal.loading import load_rigs
from riglens.core.errors import InputError
from riglens.core.files import write_file
from riglens.core.plain import to_text
from riglens.core.review.requirements import Requirements, requirements_in
from riglens.core.rig.library import use_libraries
from riglens.core.rig.model import Rig
from riglens.core.rig.ray_file import read_ray_rows
from riglens.core.rig.yaml.file import loads
from riglens.core.rig.yaml.nodes import read_text
from riglens.core.shown_text import visible
from riglens.core.vehicle.mesh_file import with_mesh_read
from riglens.evaluation.names import label_of
from riglens.evaluation.options import USUAL_DRAWS, SceneOptions, ScoreOptions
from riglens.rendering.system_libraries import require_system_libraries
from riglens.reporting.document import ReportDocument, document_of
from riglens.reporting.figures import (
    Labels,
    ReportPlan,
    WhyHere,
    differences,
    labels_of,
    report_of,
    report_profiles,
)
from riglens.reporting.page import report_page
from riglens.reporting.reading import (
    FIGURES_NAME,
    attached_figures,
    first_difference,
    form_of,
    inputs_of,
    read_report,
)

SHOWN = 20
REPORT = Group("Report", sort_key=5)


def report(
    rigs: Annotated[tuple[str, ...], Parameter(name="RIG", negative=())] = (),
    /,
    *,
    out: Annotated[Path | None, Parameter(group=REPORT, metavar="FILE.html|.pdf")] = None,
    verify: Annotated[Path | None, Parameter(group=REPORT, metavar="FILE.html|.pdf")] = None,
    meshes: Annotated[Path | None, Parameter(group=REPORT, metavar="DIR")] = None,
    requirements: Annotated[Path | None, Parameter(group=REPORT, metavar="FILE")] = None,
    draws: Annotated[int, number(REPORT)] = USUAL_DRAWS,
    seed: Annotated[int, number(REPORT)] = 0,
    project: Annotated[str | None, Parameter(group=REPORT, metavar="TEXT")] = None,
    revision: Annotated[str | None, Parameter(group=REPORT, metavar="TEXT")] = None,
    author: Annotated[str | None, Parameter(group=REPORT, metavar="TEXT")] = None,
    scene: SceneArguments = SceneArguments(),
    score: ScoreArguments = ScoreArguments(),
    reading: RigArguments = RigArguments(),
) -> int:
    """Write a page about one or more rigs that needs no network and no script, or check an earlier one.

    Parameters
    ----------
    rigs
        Rig files or preset names.
    out
        The page, or the same as a PDF.
    verify
        Recompute an earlier page or PDF, and report differences (exit code 1).
    meshes
        With --verify: folder with the mesh files and ray tables that the report names (the report's folder).
    requirements
        A file of requirements, as for `riglens check`.
    draws
        Draws of the tolerance; 0 for none.
    seed
        Seed of the draws.
    project
        The project, for the header.
    revision
        The revision of the rigs or of the report, for the header.
    author
        The author, for the header.
    """
    if verify is not None:
        if out is not None:
            raise InputError("cannot be combined with", "verify", "out")
        if rigs:
            raise InputError(f"brings its own rigs: leave out {' '.join(rigs)}", "verify")
        use_libraries(reading.libraries)
        return verified(verify, scene, score, meshes)
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
        _require_pango()
    require_draws(draws, seed, 0)
    loaded = load_rigs(rigs, score.solid(), reading.libraries, reading.housings)
    require_outputs((*rigs, *scene.files, *([requirements] if requirements else [])), out)
    labels = labels_of(project, revision, author)
    write_report(loaded, out, scene, score, requirements, (draws, seed), labels)
    results().print(f"wrote {visible(str(out))}", soft_wrap=True)
    return 0


def write_report(
    rigs: Sequence[Rig],
    out: Path,
    scene: SceneOptions,
    score: ScoreOptions,
    requirements: Path | None,
    draws_and_seed: tuple[int, int],
    labels: Labels,
) -> None:
    """Make the page or PDF of some rigs."""
    text = required = None
    if requirements is not None:
        text = read_text(requirements, "a file of requirements")
        required = _requirements(text, str(requirements), rigs)
        score = score.as_required(required.body, requirements)
    draws, seed = draws_and_seed
    plan = ReportPlan(tuple(rigs), scene, score, draws, seed, required, text, labels)
    with stage_bar("Making the report") as tell:
        document = document_of(plan, report_of(plan, tell))
    write_file(out, rendered(document, out.suffix.lower()))


def serve(pipe: Connection) -> None:
    """Make the report of a job of the window; the last message is what is wrong, empty for nothing."""
    job = pipe.recv()
    with redirect_stderr(StringIO()) as said:
        code = guarded(lambda: prepare(job, lambda share, stage: pipe.send((share, stage))), label_of)
    lines = said.getvalue().split("\n")
    last = next((line for line in reversed(lines) if line.strip()), "the process exited without a message")
    pipe.send(last.removeprefix("riglens: ") if code else "")


def prepare(job: ReportJob, tell: Tell) -> None:
    """Write page, PDF and pictures of its pages into the folder of a job of the window."""
    _require_pango()
    rigs = tuple(with_mesh_read(rig, job.folder, note) for rig in job.rigs)
    why = None if job.why is None else WhyHere.model_validate(job.why)
    plan = ReportPlan(rigs, job.scene, job.score, USUAL_DRAWS, 0, why=why)
    document = document_of(plan, report_of(plan, tell))
    tell(1.0, "Drawing the pages")
    pdf = rendered(document, ".pdf")
    write_file(job.folder / PAGE, rendered(document, ".html"))
    write_file(job.folder / PDF, pdf)
    from riglens.reporting.pdf import page_images  # Pango

    for page, image in enumerate(page_images(pdf), 1):
        image.save(page_picture(job.folder, page))


def _require_pango() -> None:
    """Raise MissingLibraries or InputError unless a PDF can be laid out."""
    require_system_libraries("pdf")
    try:
        import riglens.reporting.pdf  # noqa: F401
    except OSError as error:  # on systems whose packages are not checked
        raise InputError(
            f"a PDF needs the library Pango, a page (.html) does not: {str(error).split(chr(10))[0]}"
        ) from error


def rendered(document: ReportDocument, form: str) -> bytes:
    """Return the file of a report: .html, .pdf with figures and rigs attached, or .json for the figures alone.

    Equal documents give equal bytes on the same system.
    """
    figures = to_text(document.figures).encode("utf-8")
    if form == ".json":
        return figures
    if form == ".html":
        return report_page(document).encode("utf-8")
    from riglens.reporting.pdf import pdf_of  # Pango

    rigs = enumerate(document.figures["inputs"]["rigs"], 1)
    attached = {FIGURES_NAME: figures} | {f"rig{number}.yaml": text.encode("utf-8") for number, text in rigs}
    return pdf_of(report_page(document), attached)


def verified(path: Path, scene: SceneOptions, score: ScoreOptions, meshes: Path | None) -> int:
    """Recompute a report from its attachment; return 0 when it has the same figures and says the same, else 1."""
    content = read_report(path)
    attached = attached_figures(content, str(path))
    if form_of(content) == ".pdf":
        _require_pango()
    plan = _plan_of(attached, path, scene, score, meshes or path.parent)
    with stage_bar("Recomputing the figures") as tell:
        document = document_of(plan, report_of(plan, tell))
    _take_names(document.figures, attached)
    lines = differences(attached, document.figures)
    console = results()
    for line in lines[:SHOWN]:
        console.print(visible(line), soft_wrap=True, markup=False)
    if len(lines) > SHOWN:
        console.print(f"and {len(lines) - SHOWN} more", soft_wrap=True)
    place = first_difference(content, rendered(document, form_of(content)), str(path))
    if place is None:
        console.print("every figure is the same, and so is what the file says", soft_wrap=True)
        return 0
    figures = "" if lines else "every attached figure is the same, but their presentation "
    console.print(visible(f"{figures}differs, first at {place}"), soft_wrap=True, markup=False)
    return 1


def _requirements(text: str, where: str, rigs: Sequence[Rig]) -> Requirements:
    """Return requirements; InputError for unknown names, or for test objects that no report shows."""
    profiles, left_out = report_profiles()
    for one in requirements_in(text, where).blind_objects:
        if one.profile in left_out:
            raise InputError(f"{where}: profile '{one.profile}' is from memory and not used in reports")
    return requirements_in(text, where, rigs, profiles)


def _take_names(figures: dict[str, Any], attached: dict[str, Any]) -> None:
    """Call data as the report does: where they lie may differ; what they are is in their SHA-256."""
    figures["inputs"]["boxes"] = attached["inputs"]["boxes"]
    for part in ("evaluation", "targets"):
        with suppress(KeyError, TypeError):
            source = attached[part]["data"]["source"]
            if isinstance(source, str):
                figures[part]["data"]["source"] = source


def _plan_of(
    attached: dict[str, Any], path: Path, scene: SceneOptions, score: ScoreOptions, folder: Path
) -> ReportPlan:
    inputs = inputs_of(attached, str(path))
    rigs = tuple(
        loads(text, f"{path}: rig {n}", lambda file: read_ray_rows(folder / _named_below(file), file)).rig
        for n, text in enumerate(inputs.rigs, 1)
    )
    if not rigs:
        raise InputError(f"{path}: inputs.rigs: must name at least one rig")
    if inputs.boxes is not None and scene.boxes is None and scene.pog is None:
        name = visible(inputs.boxes)
        raise InputError(f"must name {name}, as {path} was made from it", "boxes")
    length, width, height = inputs.roi_m
    return ReportPlan(
        tuple(_with_mesh(rig, folder) for rig in rigs),
        replace(scene, voxel_m=inputs.voxel_m, roi_m=(length, width, height), tolerance_pp=None),
        ScoreOptions(inputs.method, inputs.reading, inputs.camera_weight, score.threads, inputs.body),
        inputs.draws,
        inputs.seed,
        None if inputs.requirements is None else _requirements(inputs.requirements, str(path), rigs),
        inputs.requirements,
        inputs.labels,
        inputs.why,
    )


def _named_below(file: str) -> str:
    """Return a path that stays below the folder: a report may name any file of this machine."""
    named = PurePath(file)
    is_elsewhere = named.is_absolute() or ".." in named.parts or file.startswith("~")
    return named.name if is_elsewhere else file


def _with_mesh(rig: Rig, folder: Path) -> Rig:
    """Return a report's rig with its mesh, read only from below a folder."""
    body = _named_below(rig.vehicle.body)
    if rig.vehicle.has_mesh_file and not (folder / body).is_file():
        raise InputError(
            f"{folder / body}: no such file; name the folder of the report's car bodies", other="meshes"
        )
    there = rig.model_copy(update={"vehicle": rig.vehicle.model_copy(update={"body": body})})
    return rig.with_body_mesh(with_mesh_read(there, folder, note).vehicle.body_mesh)
